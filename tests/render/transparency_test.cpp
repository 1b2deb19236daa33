// Surfaces that let light through: alpha, holdout, transparent shadows, and materials swapped in a prepared scene.
#include <gtest/gtest.h>

#include "tests/render/scene_kit.h"

namespace alder::testing {
namespace {

std::shared_ptr<const Material> transparent(float r, float g, float b) {
    return surface_graph("ShaderNodeBsdfTransparent", {{"Color", {r, g, b, 1}}});
}
std::shared_ptr<const Material> half_transparent() {
    return graph({{"version", 1},
                  {"nodes",
                   {{"t", {{"type", "ShaderNodeBsdfTransparent"}, {"params", json::object()}}},
                    {"d", {{"type", "ShaderNodeBsdfDiffuse"}, {"params", {{"Color", {0, 0, 0, 1}}}}}},
                    {"m", {{"type", "ShaderNodeMixShader"}, {"params", {{"Fac", 0.25}, {"Shader", {{"node", "t"}}}, {"Shader_001", {{"node", "d"}}}}}}}}},
                  {"outputs", {{"surface", {{"node", "m"}}}}}});
}

TEST(Transparency, seen_through_and_alpha) {
    SceneKit kit;
    kit.add(floor_quad(10, 1), kit.add_material(half_transparent()));
    kit.scene.world.graph = emission(2);
    kit.scene.settings.samples = 256;
    const Image opaque = kit.render();
    EXPECT_NEAR(mean(opaque).x, 0.75 * 2, 0.01);
    EXPECT_EQ(opaque.find("")->planes[3][0], 1) << "the world is opaque unless the film is transparent";
    kit.scene.settings.film_transparent = true;
    const Image im = kit.render();
    double alpha = 0;
    for (const float a : im.find("")->planes[3]) alpha += a / 256;
    EXPECT_NEAR(alpha, 0.25, 0.01);
    EXPECT_EQ(mean(im).x, 0);
}

TEST(Transparency, holdout_cuts_alpha) {
    SceneKit kit;
    kit.add(floor_quad(10), kit.add_material(surface_graph("ShaderNodeHoldout", json::object())));
    const Image im = kit.render();
    EXPECT_EQ(im.find("")->planes[3][0], 0);
    EXPECT_EQ(mean(im).x, 0);
}

/// Two coloured panes between a lamp and the floor: the light is their product, by lamp samples and by scattered rays.
TEST(Transparency, shadows_through_coloured_panes) {
    for (const bool sun : {true, false}) {
        SceneKit kit;
        kit.look_at({0, 0, 0.5f}, {0, 0, 0}, 0.2f);
        kit.add(floor_quad(30), kit.add_material(diffuse(1, 1, 1)));
        kit.add(floor_quad(30, 1), kit.add_material(transparent(0.5f, 1, 0.25f)));
        kit.add(floor_quad(30, 1.5f), kit.add_material(transparent(1, 0.5f, 0.5f)));
        if (sun) kit.add_light(LightKind::Sun, 3.14159265f, aimed({0, 0, 9}, {0, 0, -1})).angle = 0.1f;
        else kit.scene.world.graph = emission(1);
        kit.scene.settings.samples = sun ? 16 : 512;
        const Vec3d m = mean(kit.render());
        EXPECT_NEAR(m.x, 0.5, 0.005) << sun;
        EXPECT_NEAR(m.y, 0.5, 0.005) << sun;
        EXPECT_NEAR(m.z, 0.125, 0.002) << sun;
    }
}

TEST(Transparency, more_panes_than_allowed_are_black) {
    SceneKit kit;
    kit.look_at({0, 0, 0.5f}, {0, 0, 0}, 0.2f);
    kit.add(floor_quad(30), kit.add_material(diffuse(1, 1, 1)));
    const uint32_t clear = kit.add_material(transparent(1, 1, 1));
    for (int i = 0; i < 5; ++i) kit.add(floor_quad(30, 1 + 0.1f * float(i)), clear);
    kit.add_light(LightKind::Sun, 3.14159265f, aimed({0, 0, 9}, {0, 0, -1}));
    kit.scene.settings.transparent_bounces = 5;
    EXPECT_NEAR(mean(kit.render()).x, 1, 1e-3);
    kit.scene.settings.transparent_bounces = 4;
    EXPECT_EQ(mean(kit.render()).x, 0);
}

/// An emitter behind a clear pane: light sampling and scattering see it through the pane with consistent weights.
TEST(Transparency, emitter_behind_a_pane) {
    SceneKit kit;
    kit.look_at({0, 0, 0.4f}, {0, 0, 0}, 0.2f);
    kit.add(floor_quad(30), kit.add_material(diffuse(1, 1, 1)));
    kit.add(floor_quad(30, 0.5f), kit.add_material(transparent(1, 1, 1)));
    kit.add(floor_quad(1, 1), kit.add_material(emission(1)));
    kit.scene.settings.samples = 256;
    // Four corner rectangles of 1 x 1 at height 1.
    const double expected = 4 / (2 * 3.14159265) * 2 * (1 / std::sqrt(2.0)) * std::atan(1 / std::sqrt(2.0));
    EXPECT_NEAR(mean(kit.render()).x, expected, 5e-3);
}

TEST(Materials, swapping_one_reuses_the_rest) {
    SceneKit kit;
    const uint32_t m = kit.add_material(diffuse(0.5f, 0.5f, 0.5f));
    kit.add(floor_quad(10), m);
    kit.scene.world.graph = emission(1);
    const auto base = kit.prepare();
    Diagnostics d;
    RenderStats stats;
    const auto red = with_material(base, m, diffuse(1, 0, 0), d);
    ASSERT_TRUE(red);
    EXPECT_NEAR(mean(alder::render(*red, {}, stats)).y, 0, 1e-6);
    EXPECT_NEAR(mean(alder::render(*base, {}, stats)).y, 0.5, 1e-3) << "the older revision is as it was";
    // Becoming an emitter, and ceasing to be one, changes the lights.
    const auto glow = with_material(red, m, emission(3), d);
    EXPECT_NEAR(mean(alder::render(*glow, {}, stats)).x, 3, 1e-5);
    const auto clear = with_material(glow, m, transparent(1, 1, 1), d);
    EXPECT_NEAR(mean(alder::render(*clear, {}, stats)).x, 1, 1e-5);
    EXPECT_FALSE(with_material(base, 7, diffuse(1, 0, 0), d));
    EXPECT_FALSE(d.ok());
}

}  // namespace
}  // namespace alder::testing
