// AOVs of simple scenes, where every value is known: depth, position, normals, uv, ids, colours, the graph's own outputs.
#include <gtest/gtest.h>

#include "render/aov.h"
#include "tests/render/scene_kit.h"

namespace alder::testing {
namespace {

float at(const Image& im, const std::string& layer, int channel, int x, int y) {
    const Layer* const l = im.find(layer);
    if (!l || channel >= int(l->planes.size())) {
        ADD_FAILURE() << "no channel " << channel << " of layer \"" << layer << "\"";
        return 0;
    }
    return l->planes[channel][size_t(y) * im.width + x];
}

/// A square of side 2 at height 1, seen from 5 above by an orthographic camera of 4: it covers the middle half.
SceneKit square() {
    SceneKit kit;
    kit.scene.camera.kind = Camera::Kind::Orthographic;
    kit.scene.camera.ortho_scale = 4;
    kit.scene.camera.to_world = translation(0, 0, 5);
    kit.add_material(diffuse(0, 0, 0), "unused");
    const uint32_t m = kit.add_material(diffuse(0.8f, 0.4f, 0.2f), "orange");
    kit.add(floor_quad(1), m, translation(0, 0, 1));
    kit.scene.settings.samples = 4;
    return kit;
}

TEST(Aovs, data_layers) {
    SceneKit kit = square();
    RenderRequest r;
    r.aovs = {"data", "ids", "denoise", "diffuse_color", "sample_count"};
    const Image im = kit.render(r);
    const int inside_x = 10, inside_y = 6;  // of 16: centre of the pixel at (0.625, 0.375)
    EXPECT_NEAR(at(im, "Z", 0, inside_x, inside_y), 4, 1e-5);
    EXPECT_EQ(at(im, "Z", 0, 0, 0), 1e10f);
    EXPECT_NEAR(at(im, "P", 0, inside_x, inside_y), 0.625, 0.13) << "a mean over the pixel";
    EXPECT_NEAR(at(im, "P", 1, inside_x, inside_y), 0.375, 0.13);
    EXPECT_NEAR(at(im, "P", 2, inside_x, inside_y), 1, 1e-5);
    EXPECT_EQ(at(im, "P", 2, 0, 0), 0);
    EXPECT_NEAR(at(im, "N", 2, inside_x, inside_y), 1, 1e-6);
    EXPECT_NEAR(at(im, "Ng", 2, inside_x, inside_y), 1, 1e-6);
    EXPECT_NEAR(at(im, "uv", 0, inside_x, inside_y), (0.625 + 1) / 2, 0.07);
    EXPECT_NEAR(at(im, "uv", 1, inside_x, inside_y), (0.375 + 1) / 2, 0.07);
    EXPECT_EQ(at(im, "id_object", 0, inside_x, inside_y), 0);
    EXPECT_EQ(at(im, "id_object", 0, 0, 0), -1) << "nothing";
    EXPECT_EQ(at(im, "id_material", 0, inside_x, inside_y), 1);
    EXPECT_NEAR(at(im, "denoise_albedo", 0, inside_x, inside_y), 0.8, 1e-5);
    EXPECT_NEAR(at(im, "diffuse_color", 2, inside_x, inside_y), 0.2, 1e-5);
    EXPECT_NEAR(at(im, "denoise_normal", 2, inside_x, inside_y), 1, 1e-6);
    EXPECT_EQ(at(im, "sample_count", 0, 3, 3), 4);
    EXPECT_EQ(im.find("Z")->channels, std::vector<std::string>{""});
    EXPECT_EQ(im.find("P")->channels, (std::vector<std::string>{"X", "Y", "Z"}));
    EXPECT_TRUE(im.find("P")->data);
}

TEST(Aovs, of_the_graph) {
    SceneKit kit = square();
    kit.scene.materials[1].graph = graph({{"version", 1},
                                          {"nodes",
                                           {{"d", {{"type", "ShaderNodeBsdfDiffuse"}, {"params", json::object()}}},
                                            {"v", {{"type", "ShaderNodeValue"}, {"params", {{"value", 0.75}}}}},
                                            {"c", {{"type", "ShaderNodeRGB"}, {"params", {{"Color", {0.1, 0.2, 0.3, 1}}}}}}}},
                                          {"outputs", {{"surface", {{"node", "d"}}}, {"aovs", {{"wear", {{"node", "v"}}}, {"tint", {{"node", "c"}}}}}}}});
    ASSERT_TRUE(kit.scene.materials[1].graph);
    RenderRequest r;
    r.aovs = {"wear", "tint", "nobody_has_this"};
    const Image im = kit.render(r);
    EXPECT_NEAR(at(im, "wear", 0, 10, 6), 0.75, 1e-6);
    EXPECT_EQ(im.find("wear")->planes.size(), 1u);
    EXPECT_NEAR(at(im, "tint", 1, 10, 6), 0.2, 1e-6);
    EXPECT_EQ(at(im, "tint", 1, 0, 0), 0);
    EXPECT_EQ(at(im, "nobody_has_this", 1, 10, 6), 0) << "present, and black";
}

TEST(Aovs, requests_expand_once_and_in_order) {
    const auto names = expand_aovs({"quality", "variance", "Z", "data", "beauty", "aovs"}, {"wear"});
    EXPECT_EQ(names, (std::vector<std::string>{"sample_count", "variance", "error", "Z", "P", "N", "Ng", "uv", "wear"}));
}

TEST(Aovs, only_what_is_asked_for_is_recorded) {
    const AovPlan none({}, {});
    EXPECT_EQ(none.row(), 4);
    const AovPlan some({"Z", "direct_diffuse"}, {});
    EXPECT_EQ(some.row(), 8);
}

/// Direct and indirect, by the first lobe: a red floor lit straight, and by a white wall.
TEST(Aovs, direct_and_indirect_light) {
    SceneKit kit;
    kit.look_at({0, 0, 5}, {0, 0, 0}, 1);
    kit.add(floor_quad(10), kit.add_material(diffuse(0.5f, 0, 0)));
    kit.add(quad({1, -10, 0}, {1, 10, 0}, {1, 10, 10}, {1, -10, 10}), kit.add_material(diffuse(1, 1, 1)));
    kit.add_light(LightKind::Sun, 3.14159265f, aimed({0, 0, 0}, {1, 0, -1}));
    RenderRequest r;
    r.aovs = {"shading"};
    const Image im = kit.render(r);
    EXPECT_NEAR(mean(im, "direct_diffuse").x, 0.5 * std::sqrt(0.5), 2e-3);
    EXPECT_GT(mean(im, "indirect_diffuse").x, 0.02);
    EXPECT_EQ(mean(im, "direct_diffuse").y, 0);
    EXPECT_EQ(mean(im, "direct_specular").x, 0);
}

TEST(Visibility, of_objects_and_lights) {
    SceneKit kit;
    kit.add(floor_quad(10), kit.add_material(diffuse(1, 1, 1)));
    const uint32_t black = kit.add_material(diffuse(0, 0, 0));
    Instance& roof = kit.add(floor_quad(10, 1), black);
    kit.add_light(LightKind::Sun, 3.14159265f, aimed({0, 0, 0}, {0, 0, -1}));
    EXPECT_EQ(mean(kit.render()).x, 0) << "the roof hides the floor";
    roof.visibility = kVisibleAll & ~kVisibleCamera;
    EXPECT_EQ(mean(kit.render()).x, 0) << "and still shades it";
    roof.visibility = kVisibleAll & ~(kVisibleCamera | kVisibleShadow);
    EXPECT_NEAR(mean(kit.render()).x, 1, 1e-3);
    kit.scene.instances[1].visibility = kVisibleAll & ~kVisibleShadow;
    EXPECT_EQ(mean(kit.render()).x, 0) << "seen by the camera again";
    kit.scene.instances[1].visibility = 0;
    kit.scene.lights[0].visibility = kVisibleAll & ~kVisibleDiffuse;
    EXPECT_EQ(mean(kit.render()).x, 0) << "a light hidden from diffuse surfaces";
    kit.scene.lights[0].visibility = kVisibleAll;
    kit.scene.lights[0].cast_shadow = false;
    kit.scene.instances[1].visibility = kVisibleAll & ~kVisibleCamera;
    EXPECT_NEAR(mean(kit.render()).x, 1, 1e-3) << "a light without shadows";
}

/// A lamp's graph multiplies it; one that depends on the place is evaluated for each sample.
TEST(LampGraphs, constant_and_textured) {
    SceneKit kit;
    kit.look_at({0, 0, 1}, {0, 0, 0}, 0.2f);
    kit.add(floor_quad(10), kit.add_material(diffuse(1, 1, 1)));
    Light& l = kit.add_light(LightKind::Area, 10, aimed({0, 0, 2}, {0, 0, -1}));
    l.visibility &= ~kVisibleCamera;
    const double plain = mean(kit.render()).x;
    l.graph = emission(0.5f, 1, 0.5f, 0);
    const Vec3d tinted = mean(kit.render());
    EXPECT_NEAR(tinted.x, 0.5 * plain, 1e-3 * plain);
    EXPECT_NEAR(tinted.y, 0.25 * plain, 1e-3 * plain);
    EXPECT_EQ(tinted.z, 0);
    l.graph = diffuse(1, 1, 1);
    EXPECT_EQ(mean(kit.render()).x, 0) << "a graph that does not emit";
    l.graph = noise_world(1);
    kit.scene.settings.samples = 512;
    double m[2];
    for (int s = 0; s < 2; ++s) {
        kit.scene.settings.light_strategy = static_cast<RenderSettings::LightStrategy>(1 + s);
        m[s] = mean(kit.render()).x;
    }
    EXPECT_GT(m[0], 0.2 * plain);
    EXPECT_LT(m[0], 0.9 * plain);
    EXPECT_NEAR(m[1], m[0], 0.01 * m[0]) << "sampled and met agree";
}

}  // namespace
}  // namespace alder::testing
