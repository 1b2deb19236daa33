// Small scenes for renderer tests, made in code: quads, spheres, materials from graph documents, lamps, a camera.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "render/render.h"

namespace alder::testing {

using nlohmann::json;

inline std::shared_ptr<const Material> graph(const json& document) {
    Diagnostics d;
    auto m = build_material(document, {}, d);
    for (const Diagnostic& e : d.errors) ADD_FAILURE() << e.line();
    return m;
}
inline std::shared_ptr<const Material> surface_graph(const std::string& type, const json& params) {
    return graph({{"version", 1}, {"nodes", {{"s", {{"type", type}, {"params", params}}}}}, {"outputs", {{"surface", {{"node", "s"}}}}}});
}
inline std::shared_ptr<const Material> diffuse(float r, float g, float b) {
    return surface_graph("ShaderNodeBsdfDiffuse", {{"Color", {r, g, b, 1}}});
}
inline std::shared_ptr<const Material> emission(float strength, float r = 1, float g = 1, float b = 1) {
    return surface_graph("ShaderNodeEmission", {{"Color", {r, g, b, 1}}, {"Strength", strength}});
}
/// A world that depends on direction: the noise of a direction, times strength.
inline std::shared_ptr<const Material> noise_world(float strength) {
    return graph({{"version", 1},
                  {"nodes",
                   {{"n", {{"type", "ShaderNodeTexNoise"}, {"params", {{"Scale", 2.0}}}}},
                    {"b", {{"type", "ShaderNodeEmission"}, {"params", {{"Color", {{"node", "n"}, {"output", "Color"}}}, {"Strength", strength}}}}}}},
                  {"outputs", {{"surface", {{"node", "b"}}}}}});
}

inline std::shared_ptr<const Mesh> quad(Vec3f a, Vec3f b, Vec3f c, Vec3f d) {
    auto m = std::make_shared<Mesh>();
    m->positions = {a, b, c, d};
    m->triangles = {{0, 1, 2}, {0, 2, 3}};
    m->smooth = {0, 0};
    m->uv = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
    return m;
}
/// Square in the plane z = height, seen from above.
inline std::shared_ptr<const Mesh> floor_quad(float half, float height = 0) {
    return quad({-half, -half, height}, {half, -half, height}, {half, half, height}, {-half, half, height});
}
inline std::shared_ptr<const Mesh> sphere_mesh(float radius, int n, bool smooth) {
    auto m = std::make_shared<Mesh>();
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j < 2 * n; ++j) {
            const float theta = 3.14159265f * float(i) / float(n), phi = 3.14159265f * float(j) / float(n);
            const Vec3f d{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
            m->positions.push_back(d * radius);
            m->vertex_normals.push_back(d);
        }
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < 2 * n; ++j) {
            const uint32_t a = i * 2 * n + j, b = i * 2 * n + (j + 1) % (2 * n), c = a + 2 * n, d = b + 2 * n;
            if (i > 0) m->triangles.push_back({a, c, b});
            if (i + 1 < n) m->triangles.push_back({b, c, d});
        }
    m->smooth.assign(m->triangles.size(), smooth);
    return m;
}

inline Transform translation(float x, float y, float z) { return {{1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z}}; }
inline Transform scaling(float s) { return {{s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0}}; }
/// Local -Z turned to `direction`, at `position`.
inline Transform aimed(Vec3f position, Vec3f direction) {
    const Vec3f z = safe_normalize(-direction);
    const Vec3f x = safe_normalize(cross(std::abs(z.z) < 0.9f ? Vec3f(0, 0, 1) : Vec3f(0, 1, 0), z)), y = cross(z, x);
    return {{x.x, y.x, z.x, position.x, x.y, y.y, z.y, position.y, x.z, y.z, z.z, position.z}};
}

struct SceneKit {
    Scene scene;

    SceneKit() {
        scene.settings.width = scene.settings.height = 16;
        scene.settings.samples = 64;
        look_at({0, 0, 5}, {0, 0, 0});
    }
    uint32_t add_material(std::shared_ptr<const Material> m, std::string name = {}) {
        if (name.empty()) name = "m" + std::to_string(scene.materials.size());
        scene.materials.push_back({std::move(name), std::move(m), 0});
        return static_cast<uint32_t>(scene.materials.size() - 1);
    }
    Instance& add(std::shared_ptr<const Mesh> mesh, uint32_t material, Transform t = {}) {
        scene.meshes.push_back(std::move(mesh));
        Instance i;
        i.name = "object" + std::to_string(scene.instances.size());
        i.mesh = static_cast<uint32_t>(scene.meshes.size() - 1);
        i.object_to_world = t;
        i.materials = {material};
        scene.instances.push_back(i);
        return scene.instances.back();
    }
    Light& add_light(LightKind kind, float strength, Transform t) {
        Light l;
        l.kind = kind;
        l.strength = strength;
        l.to_world = t;
        scene.lights.push_back(l);
        return scene.lights.back();
    }
    void look_at(Vec3f from, Vec3f to, float fov_degrees = 10) {
        scene.camera.to_world = aimed(from, to - from);
        scene.camera.fov_x = fov_degrees * 3.14159265f / 180;
    }
    std::shared_ptr<const PreparedScene> prepare() const {
        Diagnostics d;
        auto p = prepare_scene(std::make_shared<Scene>(scene), {}, d);
        for (const Diagnostic& e : d.errors) ADD_FAILURE() << e.line();
        return p;
    }
    Image render(RenderRequest r = {}, RenderStats* stats = nullptr) const {
        RenderStats own;
        auto p = prepare();
        if (!p) return {};
        return alder::render(*p, r, stats ? *stats : own);
    }
};

/// Mean of a layer's first three channels over all pixels.
inline Vec3d mean(const Image& im, const std::string& layer = "") {
    Vec3d sum(0.0);
    const Layer* const l = im.find(layer);
    if (!l) {
        ADD_FAILURE() << "no layer \"" << layer << "\"";
        return sum;
    }
    for (size_t c = 0; c < 3; ++c) {
        const auto& plane = l->planes[std::min(c, l->planes.size() - 1)];
        for (const float x : plane) sum[int(c)] += x;
        sum[int(c)] /= double(plane.size());
    }
    return sum;
}

}  // namespace alder::testing
