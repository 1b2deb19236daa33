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

}  // namespace
}  // namespace alder::testing
