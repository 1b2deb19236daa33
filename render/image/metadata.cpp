// What an image file says about itself.
#include "render/image/metadata.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace alder {
namespace {

using Matrix = std::array<double, 16>;   // column vectors: x' = m x

/// OpenEXR multiplies row vectors from the left: its matrices are the transposes of ours.
std::string matrix_text(const Matrix& m) {
    std::string text;
    for (int row = 0; row < 4; ++row) {
        for (int column = 0; column < 4; ++column) text += (text.empty() ? "" : " ") + number_text(float(m[size_t(column) * 4 + size_t(row)]));
    }
    return text;
}

/// World to a camera that looks along +Z with +X to the right and +Y up.
Matrix world_to_camera(const Camera& c) {
    Transform t = c.to_world;
    for (int column = 0; column < 3; ++column) {   // the scale of a camera has no meaning
        const float l = std::hypot(t.m[column], t.m[4 + column], t.m[8 + column]);
        for (int row = 0; row < 3 && l > 0; ++row) t.m[row * 4 + column] /= l;
    }
    const Transform i = t.inverse();
    Matrix m{};
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column) m[size_t(row * 4 + column)] = (row == 2 ? -1.0 : 1.0) * i.m[row * 4 + column];
    }
    m[15] = 1;
    return m;
}

/// Camera space to (0,0) at the upper left of the full frame, (1,1) at the lower right; depth 0 ... 1 between the clip planes.
Matrix camera_to_ndc(const Camera& c, int width, int height) {
    const bool orthographic = c.kind == Camera::Kind::Orthographic;
    const double larger = std::max(width, height), half = orthographic ? 0.5 * c.ortho_scale : std::tan(0.5 * c.fov_x);
    const double hx = half * width / larger, hy = half * height / larger, ox = 2 * half * c.shift_x, oy = 2 * half * c.shift_y;
    const double n = c.near_clip, f = std::max(double(c.far_clip), n * (1 + 1e-6) + 1e-12);
    if (orthographic) return {0.5 / hx, 0, 0, 0.5 - 0.5 * ox / hx, 0, -0.5 / hy, 0, 0.5 + 0.5 * oy / hy, 0, 0, 1 / (f - n), -n / (f - n), 0, 0, 0, 1};
    return {0.5 / hx, 0, 0.5 - 0.5 * ox / hx, 0, 0, -0.5 / hy, 0.5 + 0.5 * oy / hy, 0, 0, 0, f / (f - n), -n * f / (f - n), 0, 0, 1, 0};
}

Matrix product(const Matrix& a, const Matrix& b) {
    Matrix m{};
    for (size_t i = 0; i < 4; ++i)
        for (size_t j = 0; j < 4; ++j)
            for (size_t k = 0; k < 4; ++k) m[i * 4 + j] += a[i * 4 + k] * b[k * 4 + j];
    return m;
}

/// Enough, with the scene, to render the same image again.
std::string settings_text(const Image& image, const Scene& scene, const RenderRequest& request) {
    static constexpr const char* kFilters[] = {"box", "gaussian", "blackman_harris"};
    const RenderSettings& s = scene.settings;
    nlohmann::json j{{"camera", scene.camera.name},
                     {"resolution", {image.full_width, image.full_height}},
                     {"samples", request.samples > 0 ? request.samples : s.samples},
                     {"sample_offset", request.sample_offset},
                     {"seed", request.seed},
                     {"aovs", request.aovs},
                     {"max_bounces", s.max_bounces},
                     {"diffuse_bounces", s.diffuse_bounces},
                     {"glossy_bounces", s.glossy_bounces},
                     {"transmission_bounces", s.transmission_bounces},
                     {"transparent_bounces", s.transparent_bounces},
                     {"clamp_direct", s.clamp_direct},
                     {"clamp_indirect", s.clamp_indirect},
                     {"film_transparent", s.film_transparent},
                     {"filter", kFilters[int(s.filter)]},
                     {"filter_width", s.filter_width},
                     {"caustics_reflective", s.caustics_reflective},
                     {"caustics_refractive", s.caustics_refractive}};
    if (image.width != image.full_width || image.height != image.full_height) {
        j["crop"] = {image.crop_x, image.crop_y, image.crop_x + image.width, image.crop_y + image.height};
    }
    if (request.seconds > 0) j["seconds"] = request.seconds;
    if (request.target_error > 0) j["target_error"] = request.target_error;
    return j.dump();
}

}  // namespace

void add_metadata(Image& image, const Scene& scene, const RenderRequest& request) {
    const auto add = [&](const char* name, auto make) {
        if (!find_attribute(image, name)) image.attributes.emplace_back(name, make());
    };
    add("software", [] { return std::string("Alder " ALDER_VERSION); });
    add("alder/version", [] { return std::string(ALDER_VERSION); });
    add("alder/settings", [&] { return settings_text(image, scene, request); });
    const Matrix camera = world_to_camera(scene.camera);
    add("worldToCamera", [&] { return matrix_text(camera); });
    add("worldToNDC", [&] { return matrix_text(product(camera_to_ndc(scene.camera, image.full_width, image.full_height), camera)); });
}

}  // namespace alder
