// Nodes that depend on the scene, in renders: lamps with IES profiles in the lamp's own space, ambient occlusion, bevel.
#include "tests/render/scene_kit.h"

namespace alder::testing {
namespace {

/// 100 W within 40 degrees of straight down, then nothing.
std::shared_ptr<const Material> downlight() {
    const std::string profile = "IESNA\nTILT=NONE\n1 1 14.151261 5 1 1 1 0 0 0 1 1 1\n0 39 40 41 180\n0\n100 100 100 0 0\n";
    return graph({{"nodes", {{"i", {{"type", "ShaderNodeTexIES"}, {"params", {{"ies", profile}}}}},
                             {"e", {{"type", "ShaderNodeEmission"}, {"params", {{"Color", {1, 1, 1, 1}}, {"Strength", {{"node", "i"}}}}}}}}},
                  {"outputs", {{"surface", {{"node", "e"}}}}}});
}
float center(const SceneKit& kit) { return static_cast<float>(mean(kit.render()).x); }

TEST(SceneNodes, ies_profiles_turn_with_their_lamp) {
    const auto lit = [](Vec3f direction, bool profile) {
        SceneKit kit;
        kit.add(floor_quad(5), kit.add_material(diffuse(1, 1, 1)));
        Light& l = kit.add_light(LightKind::Point, 1, aimed({0.5f, 0, 2}, direction));
        l.graph = profile ? downlight() : emission(100);
        return center(kit);
    };
    const float plain = lit({0, 0, -1}, false);
    EXPECT_GT(plain, 0.1f);
    // Up to an eighth more: the spline over the horizontal angle has zeros beyond 0 and 360 degrees, as Cycles has them.
    EXPECT_NEAR(lit({0, 0, -1}, true) / plain, 1.0625f, 0.0635f) << "shining down";
    EXPECT_EQ(lit({1, 0, 0}, true), 0) << "shining aside";
    EXPECT_EQ(lit({0, 0, 1}, true), 0) << "shining up";
}

std::shared_ptr<const Material> glowing(const json& node, const char* output) {
    return graph({{"nodes", {{"n", node}, {"e", {{"type", "ShaderNodeEmission"}, {"params", {{"Color", {{"node", "n"}, {"output", output}}}, {"Strength", 1}}}}}}},
                  {"outputs", {{"surface", {{"node", "e"}}}}}});
}

TEST(SceneNodes, ambient_occlusion_sees_the_scene) {
    SceneKit kit;
    const uint32_t m = kit.add_material(glowing({{"type", "ShaderNodeAmbientOcclusion"}, {"params", {{"Distance", 10}, {"samples", 32}}}}, "AO"));
    kit.add(floor_quad(50), m);
    EXPECT_EQ(center(kit), 1.0f);
    kit.add(quad({1, -500, 0}, {1, 500, 0}, {1, 500, 500}, {1, -500, 500}), kit.add_material(diffuse(1, 1, 1)));
    EXPECT_NEAR(center(kit), 0.5f, 0.1f) << "a wall hides nearly half";
    RenderRequest other;
    other.threads = 3;
    EXPECT_EQ(static_cast<float>(mean(kit.render(other)).x), center(kit)) << "whatever the threads";
}

TEST(SceneNodes, bevel_leaves_a_plane_alone) {
    SceneKit kit;
    kit.add(floor_quad(50), kit.add_material(glowing({{"type", "ShaderNodeBevel"}, {"params", {{"Radius", 0.5}}}}, "Normal")));
    const Image image = kit.render();
    EXPECT_NEAR(mean(image).z, 1, 1e-5f);
    EXPECT_NEAR(mean(image).x, 0, 1e-5f);
}

}  // namespace
}  // namespace alder::testing
