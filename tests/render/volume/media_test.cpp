// Volumes against closed forms and independent integration: transmittance and emission of slabs, single scattering, furnaces, nesting,
// and what a scene without volumes pays.
#include <gtest/gtest.h>

#include "render/prepared_scene.h"
#include "render/volume/media.h"
#include "tests/render/scene_kit.h"

namespace alder::testing {
namespace {

std::shared_ptr<const Mesh> box(Vec3f low, Vec3f high) {
    auto m = std::make_shared<Mesh>();
    for (int i = 0; i < 8; ++i) m->positions.push_back({i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
    // Outwards.
    const uint32_t faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const auto& f : faces) {
        m->triangles.push_back({f[0], f[1], f[2]});
        m->triangles.push_back({f[0], f[2], f[3]});
    }
    m->smooth.assign(12, 0);
    m->generated_bounds = {low, high};
    return m;
}

std::shared_ptr<const Material> volume(const std::string& type, const json& params) {
    return graph({{"version", 1}, {"nodes", {{"v", {{"type", type}, {"params", params}}}}}, {"outputs", {{"volume", {{"node", "v"}}}}}});
}
std::shared_ptr<const Material> coefficients(json absorption, json scattering, json emission = {0, 0, 0}, double g = 0) {
    return volume("ShaderNodeVolumeCoefficients",
                  {{"Absorption Coefficients", absorption}, {"Scatter Coefficients", scattering}, {"Emission Coefficients", emission}, {"Anisotropy", g}});
}
/// Absorption and scattering grow with the object's x: x times the given density (negative x: nothing).
std::shared_ptr<const Material> graded(const char* type, const json& params, double density) {
    json p = params;
    p["Density"] = {{"node", "m"}, {"output", "Value"}};
    return graph({{"version", 1},
                  {"nodes",
                   {{"c", {{"type", "ShaderNodeTexCoord"}}},
                    {"s", {{"type", "ShaderNodeSeparateXYZ"}, {"params", {{"Vector", {{"node", "c"}, {"output", "Object"}}}}}}},
                    {"m", {{"type", "ShaderNodeMath"}, {"params", {{"operation", "MULTIPLY"}, {"Value", {{"node", "s"}, {"output", "X"}}}, {"Value_001", density}}}}},
                    {"v", {{"type", type}, {"params", p}}}}},
                  {"outputs", {{"volume", {{"node", "v"}}}}}});
}
void white_world(SceneKit& kit, float strength = 1) { kit.scene.world.graph = surface_graph("ShaderNodeBackground", {{"Color", {1, 1, 1, 1}}, {"Strength", strength}}); }

/// One camera ray along -x through the boxes, parallel: an orthographic camera.
SceneKit slab_kit() {
    SceneKit kit;
    kit.scene.camera.kind = Camera::Kind::Orthographic;
    kit.scene.camera.ortho_scale = 0.01f;
    kit.scene.camera.near_clip = 1e-6f;
    kit.look_at({10, 0, 0}, {0, 0, 0});
    kit.scene.settings.width = kit.scene.settings.height = 16;
    return kit;
}

TEST(Media, homogeneous_slabs_have_their_closed_form) {
    SceneKit kit = slab_kit();
    white_world(kit);
    kit.add(box({-1, -1, -1}, {1, 1, 1}), kit.add_material(coefficients({0.1, 0.5, 2}, {0, 0, 0}, {0.3, 0.2, 0.1})));
    kit.scene.settings.samples = 4;
    RenderStats stats;
    const Vec3d got = mean(kit.render({}, &stats));
    const double sigma[3] = {0.1, 0.5, 2}, emission[3] = {0.3, 0.2, 0.1};
    for (int c = 0; c < 3; ++c) {
        const double t = std::exp(-2 * sigma[c]);
        EXPECT_NEAR(got[c], t + emission[c] * (1 - t) / sigma[c], 2e-5) << "channel " << c;
    }
    EXPECT_GT(stats.medium_segments, 0u);
    EXPECT_EQ(stats.medium_points, 0u) << "constants are evaluated once";
}

TEST(Media, media_that_overlap_add_up_and_inner_ones_end_where_they_end) {
    SceneKit kit = slab_kit();
    white_world(kit);
    const uint32_t a = kit.add_material(coefficients({0.2, 0.2, 0.2}, {0, 0, 0})), b = kit.add_material(coefficients({0.5, 0.1, 1}, {0, 0, 0}));
    kit.add(box({-2, -1, -1}, {2, 1, 1}), a);
    kit.add(box({-1, -1.5, -1.5}, {0.5, 1.5, 1.5}), b);   // within
    kit.add(box({1, -1.2, -1.2}, {3, 1.2, 1.2}), b);      // half way out
    kit.scene.settings.samples = 4;
    const Vec3d got = mean(kit.render());
    const double inner[3] = {0.5, 0.1, 1};
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(got[c], std::exp(-0.2 * 4 - inner[c] * (1.5 + 2)), 2e-5) << "channel " << c;
}

TEST(Media, varying_slabs_match_quadrature) {
    SceneKit kit = slab_kit();
    white_world(kit);
    kit.add(box({-1, -1, -1}, {1, 1, 1}), kit.add_material(graded("ShaderNodeVolumeAbsorption", {{"Color", {0.2, 0.5, 0.9, 1}}}, 3)));
    kit.scene.settings.samples = 512;
    RenderStats stats;
    const Vec3d got = mean(kit.render({}, &stats));
    // density 3x over 0 < x < 1: optical depth 1.5 (1 - color)
    const double color[3] = {0.2, 0.5, 0.9};
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(got[c], std::exp(-1.5 * (1 - color[c])), 4e-3) << "channel " << c;
    EXPECT_GT(stats.medium_points, 0u);
}

TEST(Media, emission_of_what_varies_matches_quadrature) {
    SceneKit kit = slab_kit();
    // Emission x, absorption 1: from the camera's side at x = 1.
    const auto m = graph({{"version", 1},
                          {"nodes",
                           {{"c", {{"type", "ShaderNodeTexCoord"}}},
                            {"s", {{"type", "ShaderNodeSeparateXYZ"}, {"params", {{"Vector", {{"node", "c"}, {"output", "Object"}}}}}}},
                            {"k", {{"type", "ShaderNodeMath"}, {"params", {{"operation", "MAXIMUM"}, {"Value", {{"node", "s"}, {"output", "X"}}}, {"Value_001", 0}}}}},
                            {"e", {{"type", "ShaderNodeEmission"}, {"params", {{"Color", {1, 0.5, 0.25, 1}}, {"Strength", {{"node", "k"}, {"output", "Value"}}}}}}},
                            {"a", {{"type", "ShaderNodeVolumeAbsorption"}, {"params", {{"Color", {0, 0, 0, 1}}, {"Density", 1}}}}},
                            {"v", {{"type", "ShaderNodeAddShader"}, {"params", {{"Shader", {{"node", "e"}, {"output", "Emission"}}}, {"Shader_001", {{"node", "a"}, {"output", "Volume"}}}}}}}}},
                          {"outputs", {{"volume", {{"node", "v"}}}}}});
    kit.add(box({-1, -1, -1}, {1, 1, 1}), kit.add_material(m));
    kit.scene.settings.samples = 1024;
    const Vec3d got = mean(kit.render());
    double want = 0;
    const int n = 10000;
    for (int i = 0; i < n; ++i) {
        const double s = (i + 0.5) / n;
        want += (1 - s) * std::exp(-s) / n;
    }
    EXPECT_NEAR(got.x, want, 0.01 * want);
    EXPECT_NEAR(got.y, want / 2, 0.01 * want);
}

/// Albedo 1 in a white world: what is scattered is as bright as what it hides.
TEST(Media, furnace) {
    for (const bool varies : {false, true}) {
        SceneKit kit = slab_kit();
        white_world(kit);
        const json white = {{"Color", {1, 1, 1, 1}}, {"Anisotropy", 0.4}};
        json constant = white;
        constant["Density"] = 2;
        kit.add(box({-1, -1, -1}, {1, 1, 1}),
                kit.add_material(varies ? graded("ShaderNodeVolumeScatter", white, 4) : volume("ShaderNodeVolumeScatter", constant)));
        kit.scene.settings.samples = 256;
        kit.scene.settings.max_bounces = kit.scene.settings.volume_bounces = 1000;
        RenderRequest r;
        r.aovs = {"direct_volume", "indirect_volume", "background"};
        const Image image = kit.render(r);
        const Vec3d got = mean(image);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(got[c], 1, 5e-3) << (varies ? "varying" : "constant") << " channel " << c;
        const double sum = mean(image, "direct_volume").x + mean(image, "indirect_volume").x + mean(image, "background").x;
        EXPECT_NEAR(sum, got.x, 1e-4) << "layers sum to the beauty";
        EXPECT_GT(mean(image, "direct_volume").x, 0.1);
    }
}

/// A point lamp beside a thin slab, one scattering: against a sum along the ray.
TEST(Media, single_scattering_matches_integration) {
    for (const bool varies : {false, true}) {
        SceneKit kit = slab_kit();
        const double g = 0.5, sigma_s = 0.4, sigma_a = 0.2;
        const auto m = varies ? graph({{"version", 1},
                                       {"nodes",
                                        {{"p", {{"type", "ShaderNodeNewGeometry"}}},
                                         {"z", {{"type", "ShaderNodeVectorMath"}, {"params", {{"operation", "MULTIPLY"}, {"Vector", {{"node", "p"}, {"output", "Position"}}}, {"Vector_001", {0, 0, 0}}}}}},
                                         {"s", {{"type", "ShaderNodeVectorMath"}, {"params", {{"operation", "ADD"}, {"Vector", {{"node", "z"}, {"output", "Vector"}}}, {"Vector_001", {sigma_s, sigma_s, sigma_s}}}}}},
                                         {"v", {{"type", "ShaderNodeVolumeCoefficients"}, {"params", {{"Absorption Coefficients", {sigma_a, sigma_a, sigma_a}}, {"Scatter Coefficients", {{"node", "s"}, {"output", "Vector"}}}, {"Anisotropy", g}}}}}}},
                                       {"outputs", {{"volume", {{"node", "v"}}}}}})
                              : coefficients({sigma_a, sigma_a, sigma_a}, {sigma_s, sigma_s, sigma_s}, {0, 0, 0}, g);
        kit.add(box({-1, -1, -1}, {1, 1, 1}), kit.add_material(m));
        const Vec3f lamp(0.3f, 2, 0);
        const double watts = 100;
        kit.add_light(LightKind::Point, float(watts), translation(lamp.x, lamp.y, lamp.z));
        kit.scene.settings.samples = 4096;
        kit.scene.settings.width = kit.scene.settings.height = 4;
        kit.scene.settings.max_bounces = 0;   // one scattering, then light sampling only
        const double got = mean(kit.render()).x;
        double want = 0;
        const int n = 20000;
        const double sigma = sigma_s + sigma_a;
        for (int i = 0; i < n; ++i) {
            const double x = 1 - 2 * (i + 0.5) / n;
            const double dx = lamp.x - x, dy = lamp.y, d = std::sqrt(dx * dx + dy * dy), inside = d / dy;   // leaves at y = 1
            const double cosine = -dx / d;   // light travels from the lamp; on to +x, the camera
            const double phase = (1 - g * g) / (4 * 3.14159265358979 * std::pow(1 + g * g - 2 * g * cosine, 1.5));
            want += 2.0 / n * std::exp(-sigma * (1 - x)) * sigma_s * phase * std::exp(-sigma * inside) * watts / (4 * 3.14159265358979 * d * d);
        }
        EXPECT_NEAR(got, want, 0.015 * want) << (varies ? "tracked" : "closed form") << ": " << got << " against " << want;
    }
}

/// What evaluates to a constant but cannot be known to is tracked: the same picture.
TEST(Media, a_camera_inside_knows_it) {
    SceneKit kit = slab_kit();
    kit.look_at({0.5f, 0, 0}, {-5, 0, 0});
    white_world(kit);
    kit.add(box({-1, -1, -1}, {1, 1, 1}), kit.add_material(coefficients({1, 0.5, 0.25}, {0, 0, 0})));
    kit.scene.settings.samples = 4;
    const Vec3d got = mean(kit.render());
    const double sigma[3] = {1, 0.5, 0.25};
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(got[c], std::exp(-1.5 * sigma[c]), 1e-5);
}

TEST(Media, the_world_fills_everything) {
    SceneKit kit = slab_kit();
    kit.scene.world.graph = volume("ShaderNodeVolumeAbsorption", {{"Color", {0.5, 0.5, 0.5, 1}}, {"Density", 0.2}});
    kit.add(box({-1, -1, -1}, {1, 1, 1}), kit.add_material(emission(1)));
    kit.scene.settings.samples = 4;
    EXPECT_NEAR(mean(kit.render()).x, std::exp(-0.1 * 9), 1e-5);
}

/// Glass of index 1 with absorption: the body's light is dimmed once, straight through.
TEST(Media, glass_absorbs_within) {
    SceneKit kit = slab_kit();
    white_world(kit);
    const auto m = graph({{"version", 1},
                          {"nodes",
                           {{"g", {{"type", "ShaderNodeBsdfRefraction"}, {"params", {{"Color", {1, 1, 1, 1}}, {"Roughness", 0}, {"IOR", 1.5}}}}},
                            {"a", {{"type", "ShaderNodeVolumeAbsorption"}, {"params", {{"Color", {0.9, 0.5, 0.1, 1}}, {"Density", 1}}}}}}},
                          {"outputs", {{"surface", {{"node", "g"}}}, {"volume", {{"node", "a"}}}}}});
    kit.add(box({-1, -1, -1}, {1, 1, 1}), kit.add_material(m));
    kit.scene.settings.samples = 16;
    const Vec3d got = mean(kit.render());
    const double sigma[3] = {0.1, 0.5, 0.9};
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(got[c], std::exp(-2 * sigma[c]), 4e-3) << "roulette";
}

TEST(Media, shadows_fall_through_media) {
    for (const bool varies : {false, true}) {
        SceneKit kit;
        kit.look_at({0, 0, 8}, {0, 0, 0}, 1);
        kit.add(floor_quad(4), kit.add_material(diffuse(1, 1, 1)));
        const json dark = {{"Color", {0.2, 0.5, 0.8, 1}}};
        json constant = dark;
        constant["Density"] = 1.5;
        // A box that the light passes and the camera does not.
        kit.add(box({1, -1, 0.5}, {2, 1, 3}), kit.add_material(varies ? graded("ShaderNodeVolumeAbsorption", dark, 1) : volume("ShaderNodeVolumeAbsorption", constant)));
        kit.add_light(LightKind::Sun, 3.14159265f, aimed({0, 0, 0}, {-1, 0, -1}));
        kit.scene.settings.samples = 256;
        kit.scene.settings.width = kit.scene.settings.height = 8;
        const Vec3d got = mean(kit.render());
        // The ray (t, 0, t) is within for 1 < t < 2: sqrt 2 of density 1.5, or of t.
        const double depth = 1.5 * std::sqrt(2.0), color[3] = {0.2, 0.5, 0.8};
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(got[c], std::sqrt(0.5) * std::exp(-depth * (1 - color[c])), varies ? 6e-3 : 1e-3) << (varies ? "varying" : "constant") << " channel " << c;
    }
}

TEST(Media, scenes_without_volumes_pay_nothing) {
    SceneKit kit;
    white_world(kit);
    kit.add(floor_quad(4), kit.add_material(diffuse(0.5f, 0.5f, 0.5f)));
    RenderStats stats;
    kit.render({}, &stats);
    EXPECT_EQ(stats.medium_segments, 0u);
    EXPECT_EQ(stats.medium_points, 0u);
    const auto p = kit.prepare();
    const CameraModel camera(p->scene->camera, 16, 16);
    const InputScene inputs{p->surfaces.get(), &camera, {}};
    EXPECT_EQ(MediaPlan::make(p->materials, p->world->volume.get(), inputs, Vec3f(0.f), p->workers->context()), nullptr);
}

TEST(Media, bounds_that_are_too_low_cost_noise_and_no_bias) {
    // Rays along x through two cells; the grid says 1 where the medium is 3.
    const MajorantGrid grid({0, 0, 0}, {2, 1, 1}, {2, 1, 1}, {1, 0});
    const auto a = grid.at({-1, 0.5f, 0.5f}, {1, 0, 0}, 0);
    EXPECT_EQ(a.majorant, 0);
    EXPECT_EQ(a.exit, 1);
    const auto b = grid.at({-1, 0.5f, 0.5f}, {1, 0, 0}, 1);
    EXPECT_EQ(b.majorant, 1);
    EXPECT_EQ(b.exit, 2);
    const auto c = grid.at({-1, 0.5f, 0.5f}, {1, 0, 0}, 2);
    EXPECT_EQ(c.majorant, 0);
    EXPECT_EQ(c.exit, 3);
    EXPECT_TRUE(std::isinf(grid.at({-1, 0.5f, 0.5f}, {1, 0, 0}, 3).exit));
    EXPECT_TRUE(std::isinf(grid.at({-1, 2, 0.5f}, {1, 0, 0}, 0).exit));
}

}  // namespace
}  // namespace alder::testing
