// Cameras and pixel filters: where rays go, what the footprint is, and how filters spread samples.
#include "render/camera.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/filter.h"
#include "tests/render/scene_kit.h"

namespace alder::testing {
namespace {

TEST(Camera, perspective_rays_and_window_are_inverse) {
    for (const auto& [w, h] : {std::pair{64, 32}, std::pair{32, 64}}) {
        Camera c;
        c.to_world = aimed({1, 2, 3}, {0.3f, -1, -0.2f});
        c.fov_x = 1;
        c.shift_x = 0.1f;
        c.shift_y = -0.2f;
        const CameraModel m(c, w, h);
        for (const auto& [x, y] : {std::pair{0.f, 0.f}, std::pair{20.f, 7.5f}, std::pair{float(w), float(h)}}) {
            const CameraRay r = m.ray(x, y, 0.5f, 0.5f);
            EXPECT_NEAR(length(r.direction), 1, 1e-6);
            const Vec3f at = m.window(r.origin + r.direction * 7);
            EXPECT_NEAR(at.x, x / w, 1e-5);
            EXPECT_NEAR(at.y, 1 - y / h, 1e-5);
        }
        // The field of view is that of the larger side.
        Camera straight;
        straight.fov_x = 1;
        const CameraModel s(straight, w, h);
        const CameraRay edge = w > h ? s.ray(float(w), h / 2.f, 0, 0) : s.ray(w / 2.f, 0, 0, 0);
        EXPECT_NEAR(std::acos(-edge.direction.z), 0.5, 1e-5);
    }
}

TEST(Camera, looks_along_minus_z_with_y_up) {
    const CameraModel m(Camera{}, 10, 10);
    const CameraRay top_left = m.ray(0, 0, 0.5f, 0.5f);
    EXPECT_LT(top_left.direction.x, 0);
    EXPECT_GT(top_left.direction.y, 0);
    EXPECT_LT(top_left.direction.z, 0);
    EXPECT_NEAR(m.depth({0, 0, -3}), 3, 1e-6);
}

TEST(Camera, depth_of_field_meets_at_the_focus) {
    Camera c;
    c.aperture_radius = 0.5f;
    c.focus_distance = 4;
    c.near_clip = 0;
    const CameraModel m(c, 100, 100);
    const CameraRay center = m.ray(70, 20, 0.5f, 0.5f);
    const Vec3f focus = center.origin + center.direction * (4 / -center.direction.z);
    for (const auto& [u, v] : {std::pair{0.f, 0.f}, std::pair{0.9f, 0.3f}, std::pair{0.2f, 0.99f}}) {
        const CameraRay r = m.ray(70, 20, u, v);
        EXPECT_LE(std::hypot(r.origin.x, r.origin.y), 0.5f + 1e-5f);
        const Vec3f at = r.origin + r.direction * ((r.origin.z + 4) / -r.direction.z);
        EXPECT_NEAR(length(at - focus), 0, 1e-5);
    }
}

TEST(Camera, orthographic_width_and_clipping) {
    Camera c;
    c.kind = Camera::Kind::Orthographic;
    c.ortho_scale = 8;
    c.near_clip = 1;
    c.far_clip = 5;
    const CameraModel m(c, 80, 40);
    const CameraRay left = m.ray(0, 20, 0, 0), right = m.ray(80, 20, 0, 0);
    EXPECT_NEAR(right.origin.x - left.origin.x, 8, 1e-5);
    EXPECT_NEAR(left.origin.z, -1, 1e-6);
    EXPECT_NEAR(left.length, 4, 1e-5);
    EXPECT_NEAR(left.footprint, 0.1, 1e-6) << "a pixel's size";
}

/// The cone's growth is the mean distance of neighbouring pixels' directions.
TEST(Camera, spread_is_a_pixel) {
    Camera c;
    c.fov_x = 0.9f;
    const CameraModel m(c, 512, 256);
    for (const auto& [x, y] : {std::pair{256.f, 128.f}, std::pair{5.f, 250.f}}) {
        const CameraRay r = m.ray(x, y, 0, 0);
        const double expected = 0.5 * (length(m.ray(x + 1, y, 0, 0).direction - r.direction) + length(m.ray(x, y + 1, 0, 0).direction - r.direction));
        EXPECT_NEAR(r.spread / expected, 1, 0.01);
    }
}

TEST(Filter, moments) {
    const auto moments = [](RenderSettings::Filter kind, float width, double& mean, double& sd, double& largest) {
        const PixelFilter f(kind, width);
        double sum = 0, square = 0;
        largest = 0;
        const int n = 100000;
        for (int i = 0; i < n; ++i) {
            const double x = f.offset((i + 0.5f) / n);
            sum += x;
            square += x * x;
            largest = std::max(largest, std::abs(x));
        }
        mean = sum / n;
        sd = std::sqrt(square / n);
    };
    double mean, sd, largest;
    moments(RenderSettings::Filter::Box, 1, mean, sd, largest);
    EXPECT_NEAR(mean, 0, 1e-5);
    EXPECT_NEAR(sd, std::sqrt(1.0 / 12), 1e-4);
    EXPECT_LE(largest, 0.5);
    // Blender's Gaussian of width w: exp(-2 (6 x / 3w)^2), a deviation of w/4.
    moments(RenderSettings::Filter::Gaussian, 1.5f, mean, sd, largest);
    EXPECT_NEAR(mean, 0, 1e-4);
    EXPECT_NEAR(sd, 1.5 / 4, 3e-3);
    moments(RenderSettings::Filter::BlackmanHarris, 1.5f, mean, sd, largest);
    EXPECT_NEAR(mean, 0, 1e-4);
    EXPECT_LE(largest, 1.5);
    EXPECT_GT(sd, 0.3);
}

TEST(Camera, panoramas_and_window_are_inverse) {
    for (const auto kind : {Camera::Panorama::Equirectangular, Camera::Panorama::FisheyeEquidistant, Camera::Panorama::FisheyeEquisolid, Camera::Panorama::MirrorBall}) {
        Camera c;
        c.kind = Camera::Kind::Panoramic;
        c.panorama = kind;
        c.longitude_min = -2;
        c.latitude_max = 1;
        c.fisheye_fov = 3.5f;
        c.to_world = aimed({1, 2, 3}, {0.3f, -1, -0.2f});
        const CameraModel m(c, 64, 32);
        int seen = 0;
        for (float y = 0.5f; y < 32; y += 3)
            for (float x = 0.5f; x < 64; x += 5) {
                const CameraRay r = m.ray(x, y, 0.5f, 0.5f);
                if (r.length < 0) continue;
                ++seen;
                EXPECT_NEAR(length(r.direction), 1, 1e-5);
                const Vec3f p = r.origin + r.direction * 7, at = m.window(p);
                EXPECT_NEAR(at.x, x / 64, 1e-4) << int(kind) << " " << x << " " << y;
                EXPECT_NEAR(at.y, 1 - y / 32, 1e-4) << int(kind) << " " << x << " " << y;
                EXPECT_NEAR(m.depth(p), 7, 2e-3);
                EXPECT_GT(r.spread, 0);
            }
        EXPECT_GT(seen, 40) << int(kind);
    }
}

TEST(Camera, a_panorama_looks_ahead_in_the_middle_and_right_at_the_right) {
    Camera c;
    c.kind = Camera::Kind::Panoramic;
    const auto look = [&](float x, float y) { return CameraModel(c, 100, 100).ray(x, y, 0, 0).direction; };
    for (const auto kind : {Camera::Panorama::Equirectangular, Camera::Panorama::FisheyeEquidistant, Camera::Panorama::FisheyeEquisolid, Camera::Panorama::MirrorBall}) {
        c.panorama = kind;
        EXPECT_NEAR(look(50, 50).z, -1, 1e-5) << int(kind);
        EXPECT_GT(look(60, 50).x, 0.05) << int(kind);
        EXPECT_GT(look(50, 40).y, 0.05) << int(kind);
    }
    c.panorama = Camera::Panorama::Equirectangular;
    EXPECT_NEAR(look(75, 50).x, 1, 1e-5);
    EXPECT_NEAR(look(50, 0).y, 1, 1e-5);
    c.panorama = Camera::Panorama::FisheyeEquidistant;
    EXPECT_NEAR(look(100, 50).x, 1, 1e-5) << "180 degrees";
    EXPECT_NEAR(look(75, 50).x, std::sqrt(0.5f), 1e-5) << "angles grow with the radius";
    EXPECT_LT(CameraModel(c, 100, 100).ray(1, 1, 0, 0).length, 0) << "outside the circle";
    c.panorama = Camera::Panorama::FisheyeEquisolid;
    c.fisheye_lens = 10;
    c.sensor_width = c.sensor_height = 20;
    EXPECT_NEAR(std::acos(-look(100, 50).z), 2 * std::asin(0.5), 1e-4) << "r = 2 f sin(theta / 2)";
    c.panorama = Camera::Panorama::MirrorBall;
    EXPECT_NEAR(look(50 + 50 * std::sqrt(0.5f), 50).x, 1, 1e-4) << "the ball's side at 45 degrees";
}

TEST(Camera, a_bladed_aperture_is_a_polygon) {
    Camera c;
    c.aperture_radius = 1;
    c.focus_distance = 10;
    c.aperture_blades = 5;
    c.aperture_rotation = 0.4f;
    double sum = 0, area = 0, widest = 0;
    const CameraModel m(c, 100, 100);
    const int n = 300;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const CameraRay r = m.ray(50, 50, (i + 0.5f) / n, (j + 0.5f) / n);
            const Vec3f p = r.origin - r.direction * (r.origin.z / r.direction.z);
            for (int k = 0; k < 5; ++k) {  // inside every edge; their middles stand at the rotation and every fifth of a turn from it
                const float a = 0.4f + 2 * 3.14159265f * float(k) / 5;
                ASSERT_LE(p.x * std::cos(a) + p.y * std::sin(a), std::cos(3.14159265f / 5) + 1e-4);
            }
            sum += p.x + p.y;
            area += p.x * p.x + p.y * p.y;
            widest = std::max(widest, double(p.x * p.x + p.y * p.y));
        }
    EXPECT_NEAR(sum / (n * n), 0, 1e-3);
    EXPECT_NEAR(std::sqrt(widest), 1, 0.01) << "corners on the circle";
    // Mean square radius of a regular polygon: (1/6) (2 + cos(2 pi / n)) R^2.
    EXPECT_NEAR(area / (n * n), (2 + std::cos(2 * 3.14159265 / 5)) / 6, 2e-3);
    c.aperture_ratio = 2;
    const CameraModel squeezed(c, 100, 100);
    const CameraRay a = m.ray(50, 50, 0.3f, 0.9f), b = squeezed.ray(50, 50, 0.3f, 0.9f);
    const Vec3f pa = a.origin - a.direction * (a.origin.z / a.direction.z), pb = b.origin - b.direction * (b.origin.z / b.direction.z);
    EXPECT_NEAR(pb.x, pa.x / 2, 1e-4);
    EXPECT_NEAR(pb.y, pa.y, 1e-4);
}

TEST(Camera, exposure_scales_light_and_not_alpha) {
    SceneKit kit;
    kit.add(floor_quad(0.2f), kit.add_material(emission(0.5f)));
    kit.scene.settings.film_transparent = true;
    const Image plain = kit.render();
    kit.scene.settings.exposure = 4;
    const Image exposed = kit.render();
    EXPECT_NEAR(mean(exposed).x, 4 * mean(plain).x, 1e-5);
    EXPECT_EQ(exposed.layers[0].planes[3], plain.layers[0].planes[3]);
}

TEST(Camera, a_holdout_object_cuts_a_hole) {
    SceneKit kit;
    const uint32_t glow = kit.add_material(emission(1));
    kit.add(floor_quad(50), glow);
    kit.add(floor_quad(50, 1), glow).holdout = true;
    const Image im = kit.render();
    EXPECT_EQ(mean(im).x, 0);
    EXPECT_EQ(im.layers[0].planes[3][0], 0);
    // Lit by it all the same: only the camera sees the hole.
    kit.scene.instances[1].object_to_world = translation(0, 0, 20);
    kit.scene.instances[0].materials = {kit.add_material(diffuse(0.5f, 0.5f, 0.5f))};
    EXPECT_GT(mean(kit.render()).x, 0.3);
}

TEST(Camera, filter_glossy_blurs_only_what_is_behind_unlikely_scatterings) {
    SceneKit kit;
    kit.add(floor_quad(50), kit.add_material(surface_graph("ShaderNodeBsdfAnisotropic", {{"Color", {0.8, 0.8, 0.8, 1}}, {"Roughness", 0.05}})));
    kit.scene.world.graph = noise_world(1);
    kit.scene.settings.samples = 256;
    const Vec3d sharp = mean(kit.render());
    kit.scene.settings.filter_glossy = 1;
    EXPECT_EQ(mean(kit.render()).x, sharp.x) << "seen by the camera: as it is";
    // Behind a diffuse scattering.
    kit.add(quad({-0.5f, 0.5f, 8}, {0.5f, 0.5f, 8}, {0.5f, -0.5f, 8}, {-0.5f, -0.5f, 8}), kit.add_material(diffuse(0.5f, 0.5f, 0.5f)));
    kit.look_at({0, 0, 2}, {0, 0, 8}, 5);
    kit.scene.world.graph = emission(1);
    const double blurred = mean(kit.render()).x;
    kit.scene.settings.filter_glossy = 0;
    const double plain = mean(kit.render()).x;
    // Wide lobes lose what scatters more than once.
    EXPECT_LT(blurred / plain, 0.95);
    EXPECT_GT(blurred / plain, 0.6);
}

}  // namespace
}  // namespace alder::testing
