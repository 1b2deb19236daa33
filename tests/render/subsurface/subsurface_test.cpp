// Subsurface scattering: profiles and their samples, reflectance of half spaces under even light, alSurface's profiles, thin bodies.
#include "render/subsurface/subsurface.h"

#include <gtest/gtest.h>

#include "tests/render/scene_kit.h"

namespace alder::testing {
namespace {

/// Integral of a density over [0, reach] by the midpoint rule.
template <class Density>
double integral(Density density, double reach) {
    constexpr int kSteps = 200000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) sum += density(static_cast<float>((i + 0.5) * reach / kSteps));
    return sum * reach / kSteps;
}

TEST(SubsurfaceProfile, densities_integrate_to_one_and_samples_invert_them) {
    for (const float scale : {1e-4f, 1.f, 300.f}) {
        EXPECT_NEAR(integral([&](float r) { return burley_radial_density(scale, r); }, 16 * scale), 1, 1e-3) << scale;
        EXPECT_NEAR(integral([&](float r) { return cubic_radial_density(scale, r); }, scale), 1, 1e-3) << scale;
        for (const float u : {0.f, 0.01f, 0.3f, 0.5f, 0.77f, 0.95f, 0.999f, 0.99999994f}) {
            const float b = sample_burley_radius(scale, u), c = sample_cubic_radius(scale, u);
            EXPECT_NEAR(integral([&](float r) { return burley_radial_density(scale, r); }, b), u, 1e-3) << scale;
            EXPECT_NEAR(integral([&](float r) { return cubic_radial_density(scale, r); }, c), u, 1e-3) << scale;
        }
    }
}

/// A block much larger than light spreads in it, seen from above, under light of 1 from everywhere.
Vec3d block_under_even_light(const std::shared_ptr<const Material>& material, int samples = 64) {
    SceneKit kit;
    kit.look_at({0, 0, 0.5f}, {0, 0, 0}, 0.2f);
    auto block = std::make_shared<Mesh>(*floor_quad(50));
    const auto below = floor_quad(50, -50);
    const auto base = static_cast<uint32_t>(block->positions.size());
    block->positions.insert(block->positions.end(), below->positions.begin(), below->positions.end());
    for (auto t : below->triangles) block->triangles.push_back({base + t[0], base + t[2], base + t[1]});
    block->smooth.assign(block->triangles.size(), 0);
    block->uv.clear();
    kit.add(block, kit.add_material(material));
    kit.scene.world.graph = emission(1);
    kit.scene.settings.samples = samples;
    return mean(kit.render());
}

/// What an isotropically scattering half space reflects of even light towards direction cosine 1: 1 - H(1) sqrt(1 - albedo), with
/// Chandrasekhar's H by its integral equation ("Radiative Transfer", 1960, chapter 5).
double half_space_albedo_at_normal(double albedo) {
    constexpr int kNodes = 400;
    const double root = std::sqrt(1 - albedo);
    std::vector<double> h(kNodes, 1);
    const auto next = [&](double mu) {
        double sum = 0;
        for (int i = 0; i < kNodes; ++i) {
            const double m = (i + 0.5) / kNodes;
            sum += m * h[i] / (mu + m) / kNodes;
        }
        return 1 / (root + 0.5 * albedo * sum);
    };
    for (int round = 0; round < 200; ++round) {
        std::vector<double> better(kNodes);
        for (int i = 0; i < kNodes; ++i) better[i] = next((i + 0.5) / kNodes);
        h = better;
    }
    return 1 - next(1) * root;
}

TEST(Subsurface, walk_agrees_with_radiative_transfer) {
    // Nearly no refraction: light enters along the view.
    const Vec3d m = block_under_even_light(surface_graph("ShaderNodeSubsurfaceScattering", {{"Color", {0.8, 0.5, 0.2, 1}}, {"Scale", 1},
                                                                                            {"Radius", {0.1, 0.05, 0.02}}, {"IOR", 1.01}, {"Roughness", 0}}),
                                           2048);
    const double colour[3] = {0.8, 0.5, 0.2};
    for (int c = 0; c < 3; ++c) {
        const double expected = half_space_albedo_at_normal(single_scattering_albedo(float(colour[c]), 0));
        EXPECT_NEAR(m[c], expected, 0.015 * expected) << colour[c];
    }
}

TEST(Subsurface, half_space_reflects_its_colour_about) {
    for (const char* method : {"RANDOM_WALK", "RANDOM_WALK_SKIN", "BURLEY"}) {
        const Vec3d m = block_under_even_light(surface_graph(
            "ShaderNodeSubsurfaceScattering", {{"falloff", method}, {"Color", {0.8, 0.5, 0.2, 1}}, {"Scale", 1}, {"Radius", {0.1, 0.05, 0.02}}}));
        // The walk's colours are those under light that enters from everywhere; seen from above some more is lost.
        const double limit = method[0] == 'B' ? 0.012 : 0.07;
        EXPECT_NEAR(m.x, 0.8, limit) << method;
        EXPECT_NEAR(m.y, 0.5, limit) << method;
        EXPECT_NEAR(m.z, 0.2, limit) << method;
    }
}

TEST(Subsurface, white_body_gives_back_no_more_than_it_gets) {
    for (const double anisotropy : {0.0, 0.8}) {
        const Vec3d m = block_under_even_light(surface_graph("ShaderNodeSubsurfaceScattering",
                                                             {{"Color", {1, 1, 1, 1}}, {"Scale", 1}, {"Radius", {0.05, 0.05, 0.05}}, {"Anisotropy", anisotropy}}));
        for (int c = 0; c < 3; ++c) {
            EXPECT_LT(m[c], 1.02) << anisotropy;
            EXPECT_GT(m[c], 0.9) << anisotropy;
        }
    }
}

TEST(Subsurface, channels_without_radius_are_lambert) {
    const Vec3d m = block_under_even_light(surface_graph("ShaderNodeSubsurfaceScattering",
                                                         {{"Color", {0.6, 0.6, 0.6, 1}}, {"Scale", 1}, {"Radius", {0, 0, 0}}}));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(m[c], 0.6, 1e-3);
}

TEST(Subsurface, principled_shares_its_base_between_both) {
    const Vec3d m = block_under_even_light(surface_graph("ShaderNodeBsdfPrincipled", {{"Base Color", {0.7, 0.7, 0.7, 1}},
                                                                                      {"Specular IOR Level", 0},
                                                                                      {"Subsurface Weight", 0.5},
                                                                                      {"Subsurface Scale", 1},
                                                                                      {"Subsurface Radius", {0.05, 0.05, 0.05}}}));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(m[c], 0.7, 0.03);
}

TEST(Subsurface, al_surface_profiles_reflect_the_diffuse_colour) {
    for (const char* mode : {"cubic", "empirical"}) {
        const Vec3d m = block_under_even_light(
            surface_graph("alSurface", {{"diffuseColor", {0.6, 0.4, 0.2}}, {"sssMix", 0.75}, {"sssMode", mode}, {"specular1Strength", 0},
                                        {"sssRadius", 0.3}, {"sssWeight2", 0.5}, {"sssRadius2", 0.8}}),
            4096);
        EXPECT_NEAR(m.x, 0.6, 0.012) << mode;
        EXPECT_NEAR(m.y, 0.4, 0.008) << mode;
        EXPECT_NEAR(m.z, 0.2, 0.004) << mode;
    }
}

/// A ray that goes on behind each hit meets a sphere twice, whatever the instance's scale, and nothing that is not the instance.
TEST(Subsurface, probes_meet_each_surface_once) {
    std::vector<Instance> instances;
    for (const float scale : {1.f, 0.37f, 123.4f, 3e-4f}) {
        Instance i;
        i.mesh = 0;
        i.materials = {0};
        i.object_to_world = scaling(scale);
        instances.push_back(i);
    }
    const Surfaces surfaces({sphere_mesh(1, 24, true)}, instances);
    for (uint32_t i = 0; i < instances.size(); ++i) {
        const float scale = instances[i].object_to_world.m[0];
        for (int k = 0; k < 200; ++k) {
            const Vec3f direction = safe_normalize(Vec3f(0.3f, -0.2f + 0.001f * float(k), -1));
            Ray ray{direction * (-3 * scale), direction, 0, 6 * scale};
            Hit hit;
            int met = 0;
            for (; met < 10 && surfaces.accel().intersect_instance(i, ray, hit); ++met) {
                EXPECT_EQ(hit.instance, i);
                ray.t_min = std::nextafter(hit.t, std::numeric_limits<float>::infinity());
            }
            EXPECT_EQ(met, 2) << "scale " << scale << ", ray " << k;
        }
    }
    Hit hit;
    EXPECT_FALSE(surfaces.accel().intersect_instance(99, {{0, 0, 3}, {0, 0, -1}, 0, 9}, hit)) << "no such instance";
}

TEST(Subsurface, small_radii_lose_no_light) {
    for (const double radius : {1e-8, 3e-8, 1e-7})  // between what walks and what Cycles' scale leaves of it
        for (const char* method : {"BURLEY", "RANDOM_WALK"}) {
            const Vec3d m = block_under_even_light(surface_graph("ShaderNodeSubsurfaceScattering", {{"falloff", method},
                                                                                                    {"Color", {0.5, 0.5, 0.5, 1}},
                                                                                                    {"Scale", 1},
                                                                                                    {"Radius", {radius, 0.05, radius}}}), 128);
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(m[c], 0.5, method[0] == 'B' ? 0.015 : 0.08) << method << ' ' << radius;
        }
}

TEST(Subsurface, light_goes_through_a_thin_body_only) {
    const auto lit_from_below = [](float radius) {
        SceneKit kit;
        kit.look_at({0, 0, 4}, {0, 0, 0}, 0.2f);
        kit.add(sphere_mesh(0.5f, 32, true), kit.add_material(surface_graph("ShaderNodeSubsurfaceScattering", {{"Scale", 1}, {"Radius", {radius, radius, radius}}})));
        kit.add_light(LightKind::Sun, 3, aimed({0, 0, -9}, {0, 0, 1})).angle = 0.01f;
        kit.scene.settings.samples = 64;
        return mean(kit.render()).x;
    };
    EXPECT_GT(lit_from_below(10), 20 * std::max(lit_from_below(0.1f), 1e-6));
}

TEST(Subsurface, settings_of_any_size_stay_finite) {
    for (const double radius : {1e-30, 1e-9, 1e30})
        for (const char* method : {"RANDOM_WALK", "RANDOM_WALK_SKIN", "BURLEY"}) {
            SceneKit kit;
            kit.add(sphere_mesh(1, 16, true), kit.add_material(surface_graph("ShaderNodeSubsurfaceScattering",
                                                                             {{"falloff", method}, {"Radius", {radius, 1.0, 0}}, {"IOR", 1e9}, {"Anisotropy", 1}})));
            kit.scene.world.graph = emission(1);
            kit.scene.settings.samples = 16;
            RenderStats stats;
            const Image im = kit.render({}, &stats);
            EXPECT_EQ(stats.nonfinite_samples, 0u) << method << ' ' << radius;
            EXPECT_LT(mean(im).y, 1.5) << method << ' ' << radius;
        }
}

}  // namespace
}  // namespace alder::testing
