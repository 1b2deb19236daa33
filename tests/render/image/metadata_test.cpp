// Metadata: matrices map points as the camera sees them, settings are complete, nothing that is there is replaced.
#include "render/image/metadata.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "render/camera.h"

namespace alder {
namespace {

Scene tilted_scene(Camera::Kind kind) {
    Scene s;
    s.camera.kind = kind;
    s.camera.to_world = {{0.8f, -0.36f, 0.48f, 3, 0.6f, 0.48f, -0.64f, -4, 0, 0.8f, 0.6f, 5}};
    s.camera.fov_x = 0.9f;
    s.camera.shift_x = 0.1f;
    s.camera.shift_y = -0.2f;
    s.camera.near_clip = 0.5f;
    s.camera.far_clip = 100;
    return s;
}

/// Row vector times the 16 numbers of an attribute, divided by w.
Vec3f project(const std::string& text, Vec3f p, double& w) {
    std::istringstream in(text);
    double m[16];
    for (double& x : m) in >> x;
    double r[4];
    for (int j = 0; j < 4; ++j) r[j] = p.x * m[j] + p.y * m[4 + j] + p.z * m[8 + j] + m[12 + j];
    w = r[3];
    return {float(r[0] / w), float(r[1] / w), float(r[2] / w)};
}

TEST(Metadata, points_along_a_camera_ray_project_to_its_pixel) {
    for (const auto kind : {Camera::Kind::Perspective, Camera::Kind::Orthographic}) {
        const Scene scene = tilted_scene(kind);
        Image image;
        image.width = image.full_width = 320;
        image.height = image.full_height = 180;
        add_metadata(image, scene, {});
        const CameraModel camera(scene.camera, 320, 180);
        for (const auto& [x, y] : {std::pair{10.f, 20.f}, {160.f, 90.f}, {300.f, 170.f}}) {
            const CameraRay ray = camera.ray(x, y, 0, 0);
            double w = 0;
            const Vec3f near_point = project(*find_attribute(image, "worldToNDC"), ray.origin, w);
            EXPECT_NEAR(near_point.x, x / 320, 1e-4f);
            EXPECT_NEAR(near_point.y, y / 180, 1e-4f);
            EXPECT_NEAR(near_point.z, 0, 1e-4f);
            const Vec3f far_point = project(*find_attribute(image, "worldToNDC"), ray.origin + ray.direction * ray.length, w);
            EXPECT_NEAR(far_point.x, x / 320, 1e-4f);
            EXPECT_NEAR(far_point.z, 1, 1e-4f);
            const Vec3f c = project(*find_attribute(image, "worldToCamera"), ray.origin + ray.direction, w);
            EXPECT_NEAR(c.z, camera.depth(ray.origin + ray.direction), 1e-4f);
        }
    }
}

TEST(Metadata, settings_say_what_was_asked_and_nothing_is_replaced) {
    Image image;
    image.width = 10;
    image.height = image.full_height = 20;
    image.full_width = 40;
    image.crop_x = 5;
    image.attributes = {{"software", "mine"}};
    RenderRequest request;
    request.samples = 77;
    request.aovs = {"shading"};
    add_metadata(image, tilted_scene(Camera::Kind::Perspective), request);
    EXPECT_EQ(*find_attribute(image, "software"), "mine");
    const nlohmann::json s = nlohmann::json::parse(*find_attribute(image, "alder/settings"));
    EXPECT_EQ(s["samples"], 77);
    EXPECT_EQ(s["aovs"], nlohmann::json({"shading"}));
    EXPECT_EQ(s["crop"], nlohmann::json({5, 0, 15, 20}));
    EXPECT_EQ(s["resolution"], nlohmann::json({40, 20}));
}

}  // namespace
}  // namespace alder
