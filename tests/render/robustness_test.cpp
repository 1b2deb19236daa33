// Bad numbers, extreme scales and degenerate geometry: no crash, no poisoned pixels, no light leaks.
#include <gtest/gtest.h>

#include <limits>

#include "tests/render/scene_kit.h"

namespace alder::testing {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();

void expect_finite(const Image& im, const std::string& what) {
    for (const Layer& l : im.layers)
        for (const auto& plane : l.planes)
            for (const float x : plane) ASSERT_TRUE(std::isfinite(x)) << what << ", layer " << l.name;
}

/// A closed white box lit from inside is 1/(1 - albedo) everywhere if nothing leaks and no ray meets the wall it leaves.
TEST(Scales, closed_room_is_tight_from_millimetres_to_kilometres) {
    for (const float scale : {1e-3f, 1.f, 1e3f, 1e5f})
        for (const float offset : {0.f, 1e3f}) {
            SceneKit kit;
            const uint32_t wall = kit.add_material(graph(
                {{"version", 1},
                 {"nodes",
                  {{"d", {{"type", "ShaderNodeBsdfDiffuse"}, {"params", {{"Color", {0.5, 0.5, 0.5, 1}}}}}},
                   {"e", {{"type", "ShaderNodeEmission"}, {"params", {{"Strength", 1.0}}}}},
                   {"a", {{"type", "ShaderNodeAddShader"}, {"params", {{"Shader", {{"node", "d"}}}, {"Shader_001", {{"node", "e"}}}}}}}}},
                 {"outputs", {{"surface", {{"node", "a"}}}}}}));
            const float x = offset * scale;
            kit.add(sphere_mesh(1, 16, false), wall, translation(x, 0, 0) * scaling(scale));
            kit.look_at({x, 0, 0}, {x + scale, 0.3f * scale, 0.2f * scale}, 60);
            kit.scene.camera.near_clip = 0;
            kit.scene.settings.max_bounces = kit.scene.settings.diffuse_bounces = 200;
            kit.scene.settings.samples = 64;
            const Image im = kit.render();
            EXPECT_NEAR(mean(im).x, 2, 0.02) << "scale " << scale << ", at " << x;
        }
}

/// Flat ground lit at grazing angles keeps its brightness: no self shadowing.
TEST(Scales, no_self_shadowing_at_grazing_light) {
    for (const float scale : {1e-3f, 1.f, 1e5f}) {
        SceneKit kit;
        kit.add(sphere_mesh(100, 8, false), kit.add_material(diffuse(1, 1, 1)), translation(0, 0, -95 * scale) * scaling(scale));
        kit.look_at({0, 0, 20 * scale}, {0, 0, 5 * scale}, 1);
        kit.scene.camera.near_clip = 0;
        // The cap around the pole has 16 flat triangles; the light is 0.5 degrees above those that face away most.
        kit.add_light(LightKind::Sun, 1, aimed({0, 0, 0}, {1, 0.02f, -0.25f}));
        kit.scene.settings.max_bounces = 0;
        const Image im = kit.render();
        int dark = 0;
        for (const float v : im.find("")->planes[0]) dark += v < 1e-4f;
        EXPECT_EQ(dark, 0) << "scale " << scale;
    }
}

TEST(BadNumbers, in_lamps_meshes_and_cameras) {
    for (const float bad : {kNan, kInf, -kInf, 1e38f, -1.f, 0.f}) {
        SceneKit kit;
        kit.add(floor_quad(10), kit.add_material(diffuse(0.5f, 0.5f, 0.5f)));
        auto broken = std::make_shared<Mesh>(*sphere_mesh(0.5f, 6, true));
        broken->positions[3].x = bad;
        broken->vertex_normals[5] = Vec3f(bad);
        kit.add(broken, 0, translation(0, 0, 1));
        kit.add(floor_quad(1, 1), 0, {{bad, 0, 0, 0, 0, bad, 0, 0, 0, 0, bad, bad}});
        for (const LightKind kind : {LightKind::Point, LightKind::Spot, LightKind::Sun, LightKind::Area}) {
            Light& l = kit.add_light(kind, bad, aimed({1, 1, 3}, {0, 0, -1}));
            l.radius = bad;
            l.angle = bad;
            l.size_x = bad;
            l.spread = bad;
            l.spot_angle = bad;
            Light& m = kit.add_light(kind, 1, {{bad, 0, 0, 0, 0, bad, 0, 0, 0, 0, bad, bad}});
            m.color = Vec3f(bad);
        }
        kit.scene.camera.aperture_radius = bad;
        kit.scene.camera.focus_distance = bad;
        kit.scene.camera.shift_x = bad;
        kit.scene.settings.samples = 4;
        kit.scene.settings.filter_width = bad;
        kit.scene.settings.clamp_direct = bad;
        RenderRequest r;
        r.aovs = {"shading", "data", "denoise", "quality", "light_groups"};
        expect_finite(kit.render(r), std::to_string(bad));
    }
}

/// A graph that makes NaN and infinity: those samples count as black and are counted, the rest of the image is untouched.
TEST(BadNumbers, in_materials_are_counted) {
    SceneKit kit;
    kit.scene.world.graph = emission(1);
    kit.add(floor_quad(10), kit.add_material(diffuse(0.5f, 0.5f, 0.5f)));
    // 1e38 * 1e38 as an emission strength.
    const auto infinite = graph({{"version", 1},
                                 {"nodes", {{"v", {{"type", "ShaderNodeValue"}, {"params", {{"value", 1e38}}}}},
                                            {"m", {{"type", "ShaderNodeMath"}, {"params", {{"operation", "MULTIPLY"}, {"Value", {{"node", "v"}}}, {"Value_001", {{"node", "v"}}}}}}},
                                            {"e", {{"type", "ShaderNodeEmission"}, {"params", {{"Strength", {{"node", "m"}}}}}}}}},
                                 {"outputs", {{"surface", {{"node", "e"}}}}}});
    ASSERT_TRUE(infinite);
    kit.add(floor_quad(0.2f, 1), kit.add_material(infinite));
    RenderStats stats;
    const Image im = kit.render({}, &stats);
    expect_finite(im, "infinite emission");
    EXPECT_GT(stats.nonfinite_samples, 0u);
    EXPECT_LT(stats.nonfinite_samples, stats.camera_rays);
}

TEST(Degenerate, empty_and_tiny_scenes) {
    SceneKit kit;
    EXPECT_EQ(mean(kit.render()).x, 0) << "nothing at all";
    kit.scene.world.graph = emission(1);
    EXPECT_EQ(mean(kit.render()).x, 1) << "only a world";
    auto empty = std::make_shared<Mesh>();
    kit.add(empty, kit.add_material(nullptr));
    EXPECT_EQ(mean(kit.render()).x, 1) << "a mesh without triangles";
    kit.add(floor_quad(10), 0);
    EXPECT_EQ(mean(kit.render()).x, 0) << "a material without a graph absorbs";
    auto line = std::make_shared<Mesh>();
    line->positions = {{0, 0, 1}, {1, 0, 1}, {2, 0, 1}, {0, 0, 1}};
    line->triangles = {{0, 1, 2}, {0, 0, 0}, {0, 3, 0}};
    kit.add(line, kit.add_material(emission(1)));
    expect_finite(kit.render(), "triangles without area that emit");
    kit.scene.settings.width = kit.scene.settings.height = 1;
    kit.scene.settings.samples = 1;
    expect_finite(kit.render(), "one pixel, one sample");
}

TEST(Degenerate, wrong_indices_are_refused_by_name) {
    SceneKit kit;
    auto bad = std::make_shared<Mesh>(*floor_quad(1));
    bad->triangles[1][2] = 99;
    kit.add(bad, kit.add_material(diffuse(1, 1, 1)));
    kit.scene.instances.push_back(kit.scene.instances[0]);
    kit.scene.instances[1].mesh = 7;
    kit.scene.instances.push_back(kit.scene.instances[0]);
    kit.scene.instances[2].materials = {3};
    Diagnostics d;
    EXPECT_FALSE(prepare_scene(std::make_shared<Scene>(kit.scene), {}, d));
    ASSERT_EQ(d.errors.size(), 3u);
    EXPECT_EQ(d.errors[0].pointer, "/meshes/0/triangles");
    EXPECT_EQ(d.errors[1].pointer, "/instances/1/mesh");
    EXPECT_EQ(d.errors[2].pointer, "/instances/2/materials");
}

}  // namespace
}  // namespace alder::testing
