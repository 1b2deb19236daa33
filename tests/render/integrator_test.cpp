// Light transport against closed forms: furnaces, lamps over a plane, environments; and the estimators against each other.
#include <gtest/gtest.h>

#include <bit>

#include "tests/render/scene_kit.h"

namespace alder::testing {
namespace {

constexpr double kPi = 3.14159265358979;

/// Albedo 1 under a white sky: every path ends at radiance 1. (Flat faces: under interpolated normals some directions lie below
/// the surface, and are lost.)
TEST(Furnace, white_diffuse_sphere_under_white_sky_is_white) {
    SceneKit kit;
    kit.add(sphere_mesh(1, 32, false), kit.add_material(diffuse(1, 1, 1)));
    kit.scene.world.graph = emission(1);
    kit.scene.settings.max_bounces = kit.scene.settings.diffuse_bounces = 1000;
    const Image im = kit.render();
    const Layer& rgba = *im.find("");
    for (size_t i = 0; i < rgba.planes[0].size(); ++i)
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(rgba.planes[c][i], 1, 1e-5) << "pixel " << i << " channel " << c;
    EXPECT_NEAR(mean(im).x, 1, 1e-5);
}

/// Radiance of a floor of albedo rho under irradiance E is rho E / pi.
TEST(Lamps, sun_irradiance) {
    for (const float angle : {0.f, 0.01f, 1.f}) {
        SceneKit kit;
        kit.add(floor_quad(10), kit.add_material(diffuse(0.5f, 0.25f, 1)));
        kit.add_light(LightKind::Sun, 3, aimed({0, 0, 10}, {0, 0, -1})).angle = angle;
        const Vec3d m = mean(kit.render());
        EXPECT_NEAR(m.x, 0.5 * 3 / kPi, 2e-3 * 0.5) << "angular diameter " << angle;
        EXPECT_NEAR(m.y, 0.25 * 3 / kPi, 2e-3 * 0.25) << "angular diameter " << angle;
    }
}

TEST(Lamps, point_over_plane) {
    for (const float radius : {0.f, 0.2f}) {
        SceneKit kit;
        kit.look_at({3, 0, 3}, {0, 0, 0}, 0.2f);
        kit.add(floor_quad(10), kit.add_material(diffuse(1, 1, 1)));
        Light& l = kit.add_light(LightKind::Point, 100, translation(0, 1, 2));
        l.radius = radius;
        // Irradiance of a sphere that is wholly above the horizon: intensity x cos / d^2, exactly.
        const double d2 = 5, cosine = 2 / std::sqrt(d2), intensity = 100 / (4 * kPi);
        EXPECT_NEAR(mean(kit.render()).x, intensity * cosine / d2 / kPi, 0.01 * intensity * cosine / d2 / kPi) << "radius " << radius;
    }
}

TEST(Lamps, spot_inside_and_outside_its_cone) {
    for (const auto& [x, lit] : {std::pair{0.f, 1.0}, std::pair{3.f, 0.0}}) {
        SceneKit kit;
        kit.look_at({x, 0, 1}, {x, 0, 0}, 0.2f);
        kit.add(floor_quad(10), kit.add_material(diffuse(1, 1, 1)));
        Light& l = kit.add_light(LightKind::Spot, 100, aimed({0, 0, 2}, {0, 0, -1}));
        l.spot_angle = 1;
        l.spot_blend = 0;
        EXPECT_NEAR(mean(kit.render()).x, lit * 100 / (4 * kPi) / 4 / kPi, 0.01) << "at x = " << x;
    }
}

/// Irradiance at the foot of a parallel rectangle's axis (corner form, Modest, configuration factor 11: four equal corners).
double rectangle_form_factor(double a, double b, double h) {
    const double x = a / h, y = b / h;
    return 4 * (1 / (2 * kPi)) * (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) + y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y)));
}

TEST(Lamps, area_rectangle_against_closed_form) {
    for (const float size : {0.01f, 1.f, 6.f}) {
        SceneKit kit;
        kit.look_at({0, 0, 1}, {0, 0, 0}, 0.2f);
        kit.add(floor_quad(10), kit.add_material(diffuse(1, 1, 1)));
        Light& l = kit.add_light(LightKind::Area, 10, aimed({0, 0, 2}, {0, 0, -1}));
        l.size_x = size;
        l.size_y = 2 * size;
        l.visibility &= ~kVisibleCamera;
        const double radiance = 10 / (kPi * size * 2 * size);
        const double expected = radiance * rectangle_form_factor(0.5 * size, size, 2);
        EXPECT_NEAR(mean(kit.render()).x, expected, 5e-3 * expected) << "size " << size;
    }
}

/// A disk of radius r at height h above the point: form factor r^2 / (r^2 + h^2).
TEST(Lamps, area_disk_against_closed_form) {
    SceneKit kit;
    kit.look_at({0, 0, 1}, {0, 0, 0}, 0.2f);
    kit.add(floor_quad(10), kit.add_material(diffuse(1, 1, 1)));
    Light& l = kit.add_light(LightKind::Area, 10, aimed({0, 0, 2}, {0, 0, -1}));
    l.shape = Light::Shape::Ellipse;
    l.size_x = l.size_y = 3;
    l.visibility &= ~kVisibleCamera;
    const double radiance = 10 / (kPi * kPi * 1.5 * 1.5), expected = radiance * 2.25 / (2.25 + 4);
    EXPECT_NEAR(mean(kit.render()).x, expected, 5e-3 * expected);
}

/// The grid of a soft box keeps the power: irradiance straight below is radiance x integral of cos (1 - tan/tan a) over the cone.
TEST(Lamps, area_spread_attenuates_by_its_grid) {
    SceneKit kit;
    kit.look_at({0, 0, 1}, {0, 0, 0}, 0.2f);
    kit.add(floor_quad(10), kit.add_material(diffuse(1, 1, 1)));
    Light& l = kit.add_light(LightKind::Area, 10, aimed({0, 0, 1.5f}, {0, 0, -1}));
    l.size_x = l.size_y = 8;  // reaches beyond the cone of 60 degrees
    l.spread = float(kPi) / 3;
    l.visibility &= ~kVisibleCamera;
    // All of the light arrives that a point sees within the cone: by construction of the norm, pi x radiance of the full lamp.
    const double expected = 10 / (kPi * 64);
    EXPECT_NEAR(mean(kit.render()).x, expected, 5e-3 * expected);
}

TEST(Lamps, mesh_emitter_against_closed_form) {
    SceneKit kit;
    kit.look_at({0, 0, 1}, {0, 0, 0}, 0.2f);
    kit.add(floor_quad(10), kit.add_material(diffuse(1, 1, 1)));
    kit.add(floor_quad(1, 2), kit.add_material(emission(5)));
    const double expected = 5 * rectangle_form_factor(1, 1, 2);
    EXPECT_NEAR(mean(kit.render()).x, expected, 5e-3 * expected);
}

TEST(World, constant_sky_on_a_plane) {
    SceneKit kit;
    kit.add(floor_quad(10), kit.add_material(diffuse(0.5f, 0.5f, 0.5f)));
    kit.scene.world.graph = emission(2, 1, 0.5f, 0.25f);
    const Vec3d m = mean(kit.render());
    EXPECT_NEAR(m.x, 1, 1e-4);
    EXPECT_NEAR(m.y, 0.5, 1e-4);
    EXPECT_NEAR(m.z, 0.25, 1e-4);
}


/// Irradiance of a noisy sky on a plane by quadrature of the same graph, read off a camera that looks at the sky itself.
TEST(World, sampled_sky_matches_scattered_rays) {
    SceneKit kit;
    kit.add(floor_quad(10), kit.add_material(diffuse(0.5f, 0.5f, 0.5f)));
    kit.scene.world.graph = noise_world(1);
    kit.scene.world.importance_resolution = 64;
    kit.scene.settings.samples = 1024;
    Vec3d m[3];
    for (int s = 0; s < 3; ++s) {
        kit.scene.settings.light_strategy = static_cast<RenderSettings::LightStrategy>(s);
        m[s] = mean(kit.render());
    }
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(m[1][c], m[0][c], 2e-3 * m[0][c]) << "channel " << c;
        EXPECT_NEAR(m[2][c], m[0][c], 2e-3 * m[0][c]) << "channel " << c;
    }
    EXPECT_GT(m[0].x, 0.1);
}

/// A room with every kind of light that has a size, diffuse and glossy surfaces, a textured emitter and a sky.
SceneKit mixed_room() {
    SceneKit kit;
    kit.look_at({0, -6, 2}, {0, 0, 0.6f}, 35);
    const uint32_t white = kit.add_material(diffuse(0.7f, 0.6f, 0.5f));
    const uint32_t glossy = kit.add_material(surface_graph("ShaderNodeBsdfAnisotropic", {{"Roughness", 0.5}, {"Color", {0.8, 0.8, 0.8, 1}}}));
    const uint32_t lamp = kit.add_material(emission(3, 1, 0.8f, 0.6f));
    kit.add(floor_quad(6), white);
    kit.add(sphere_mesh(0.7f, 24, true), glossy, translation(-1, 0, 0.7f));
    kit.add(sphere_mesh(0.7f, 24, true), white, translation(1, 0, 0.7f));
    kit.add(sphere_mesh(0.3f, 12, false), lamp, translation(0, 1, 2)).light_group = 1;
    Light& area = kit.add_light(LightKind::Area, 60, aimed({2, -2, 3}, {-2, 2, -3}));
    area.light_group = 2;
    Light& point = kit.add_light(LightKind::Point, 40, translation(-2, -2, 2));
    point.radius = 0.3f;
    point.light_group = 3;
    kit.add_light(LightKind::Sun, 0.5f, aimed({0, 0, 9}, {1, 1, -2})).angle = 0.3f;
    kit.scene.world.graph = noise_world(0.3f);
    kit.scene.world.importance_resolution = 64;
    kit.scene.settings.width = kit.scene.settings.height = 32;
    return kit;
}

/// Light sampling, scattering and their weighted sum estimate one integral: means over the image agree within their own noise.
TEST(Estimators, three_strategies_have_one_mean) {
    SceneKit kit = mixed_room();
    kit.scene.settings.samples = 128;
    RenderRequest r;
    r.aovs = {"variance"};
    double m[3], sd[3];
    for (int s = 0; s < 3; ++s) {
        kit.scene.settings.light_strategy = static_cast<RenderSettings::LightStrategy>(s);
        r.seed = 7 + s;
        const Image im = kit.render(r);
        m[s] = mean(im).y;
        sd[s] = std::sqrt(mean(im, "variance").y / (32 * 32));
    }
    for (int s = 1; s < 3; ++s) {
        const double z = (m[s] - m[0]) / std::sqrt(sd[s] * sd[s] + sd[0] * sd[0]);
        EXPECT_LT(std::abs(z), 4) << "strategy " << s << ": " << m[s] << " +- " << sd[s] << " against " << m[0] << " +- " << sd[0];
        EXPECT_LT(sd[s] / m[s], 0.05);
    }
    EXPECT_LT(sd[0], std::min(sd[1], sd[2])) << "weighting both must not be noisier than the better of the two";
}

/// Many lamps: chosen by power, found by box queries instead of one by one.
TEST(Estimators, many_lamps) {
    SceneKit kit;
    kit.look_at({0, 0, 8}, {0, 0, 0}, 20);
    kit.add(floor_quad(6), kit.add_material(diffuse(0.8f, 0.8f, 0.8f)));
    for (int i = 0; i < 49; ++i) {
        const float x = float(i % 7) - 3, y = float(i / 7) - 3;
        Light& l = kit.add_light(i % 2 ? LightKind::Point : LightKind::Area, 1 + 0.2f * float(i % 5), aimed({x, y, 1.5f}, {0.2f, 0.1f, -1}));
        l.radius = 0.2f;
        l.size_x = l.size_y = 0.5f;
    }
    kit.add_light(LightKind::Sun, 0.1f, aimed({0, 0, 0}, {0, 0.3f, -1})).angle = 0.5f;
    kit.scene.settings.samples = 256;
    RenderRequest r;
    r.aovs = {"variance"};
    double m[3], sd[3];
    for (int s = 0; s < 3; ++s) {
        kit.scene.settings.light_strategy = static_cast<RenderSettings::LightStrategy>(s);
        r.seed = 3 + s;
        const Image im = kit.render(r);
        m[s] = mean(im).y;
        sd[s] = std::sqrt(mean(im, "variance").y / 256);
    }
    for (int s = 1; s < 3; ++s)
        EXPECT_LT(std::abs(m[s] - m[0]), 4 * std::sqrt(sd[s] * sd[s] + sd[0] * sd[0])) << "strategy " << s << ": " << m[s] << " against " << m[0];
    EXPECT_LT(sd[0] / m[0], 0.01);
}

TEST(Layers, shading_layers_and_light_groups_add_up_to_the_beauty) {
    SceneKit kit = mixed_room();
    kit.scene.settings.samples = 32;
    RenderRequest r;
    r.aovs = {"shading", "light_groups"};
    const Image im = kit.render(r);
    const Layer& beauty = *im.find("");
    for (const std::string kind : {"shading", "light_groups"}) {
        std::vector<const Layer*> parts;
        for (const Layer& l : im.layers)
            if (!l.name.empty() && (l.name.rfind("light_group", 0) == 0) == (kind == "light_groups")) parts.push_back(&l);
        EXPECT_EQ(parts.size(), kind == "shading" ? 15u : 9u);
        for (size_t i = 0; i < beauty.planes[0].size(); ++i)
            for (int c = 0; c < 3; ++c) {
                double sum = 0;
                for (const Layer* l : parts) sum += l->planes[c][i];
                ASSERT_NEAR(sum, beauty.planes[c][i], 1e-5 * beauty.planes[c][i] + 1e-9) << kind << ", pixel " << i << " channel " << c;
            }
    }
    for (const char* name : {"direct_diffuse", "indirect_diffuse", "direct_specular", "emission", "background", "light_group_1",
                             "light_group_2", "light_group_3", "light_group_default"})
        EXPECT_GT(mean(im, name).y, 0) << name;
    EXPECT_EQ(mean(im, "sss").y, 0);
}

void expect_same_bits(const Image& a, const Image& b, const std::string& what) {
    ASSERT_EQ(a.layers.size(), b.layers.size());
    for (size_t l = 0; l < a.layers.size(); ++l)
        for (size_t c = 0; c < a.layers[l].planes.size(); ++c)
            for (size_t i = 0; i < a.layers[l].planes[c].size(); ++i)
                ASSERT_EQ(std::bit_cast<uint32_t>(a.layers[l].planes[c][i]), std::bit_cast<uint32_t>(b.layers[l].planes[c][i]))
                    << what << ", layer " << a.layers[l].name << " channel " << c << " pixel " << i;
}

TEST(Determinism, same_bits_for_any_number_of_threads) {
    SceneKit kit = mixed_room();
    kit.scene.settings.samples = 40;
    RenderRequest r;
    r.aovs = {"shading", "data", "quality", "half_b", "light_groups", "ids"};
    r.threads = 1;
    const Image one = kit.render(r);
    for (const int threads : {2, 7}) {
        r.threads = threads;
        expect_same_bits(one, kit.render(r), std::to_string(threads) + " threads");
    }
}

TEST(Determinism, a_crop_has_the_pixels_of_the_whole) {
    SceneKit kit = mixed_room();
    kit.scene.settings.samples = 4;
    RenderRequest r;
    const Image whole = kit.render(r);
    r.crop[0] = 5, r.crop[1] = 9, r.crop[2] = 20, r.crop[3] = 30;
    const Image crop = kit.render(r);
    ASSERT_EQ(crop.width, 15);
    ASSERT_EQ(crop.height, 21);
    for (int y = 0; y < crop.height; ++y)
        for (int x = 0; x < crop.width; ++x)
            ASSERT_EQ(crop.find("")->planes[1][y * 15 + x], whole.find("")->planes[1][(y + 9) * 32 + x + 5]) << x << ", " << y;
}

/// Runs over disjoint ranges are parts of one run.
TEST(Determinism, sample_ranges_merge_to_the_whole) {
    SceneKit kit = mixed_room();
    RenderRequest r;
    r.samples = 48;
    const Image whole = kit.render(r);
    std::vector<Image> parts;
    for (const auto& [offset, count] : {std::pair{0, 7}, std::pair{7, 25}, std::pair{32, 16}}) {
        r.sample_offset = offset;
        r.samples = count;
        parts.push_back(kit.render(r));
    }
    const double weight[] = {7. / 48, 25. / 48, 16. / 48};
    for (size_t i = 0; i < whole.find("")->planes[0].size(); ++i) {
        double sum = 0;
        for (int k = 0; k < 3; ++k) sum += weight[k] * parts[k].find("")->planes[0][i];
        ASSERT_NEAR(sum, whole.find("")->planes[0][i], 2e-6 * sum + 1e-9) << "pixel " << i;
    }
}

TEST(Determinism, another_seed_is_another_image) {
    SceneKit kit = mixed_room();
    RenderRequest r;
    r.samples = 2;
    r.seed = 1;
    const Image a = kit.render(r);
    r.seed = 2;
    EXPECT_NE(a.find("")->planes[0], kit.render(r).find("")->planes[0]);
}

/// One real estimate of the error: the scatter of independent renders around a long one.
TEST(Quality, estimated_error_is_of_the_size_of_the_error) {
    SceneKit kit = mixed_room();
    RenderRequest r;
    r.samples = 2048;
    r.seed = 99;
    const Image truth = kit.render(r);
    for (const int samples : {16, 256}) {
        r.samples = samples;
        r.seed = 5;
        RenderStats stats;
        const Image im = kit.render(r, &stats);
        double sum = 0;
        const size_t n = im.find("")->planes[0].size();
        for (size_t i = 0; i < n; ++i) {
            double d2 = 0, l = 0;
            for (int c = 0; c < 3; ++c) {
                const double d = im.find("")->planes[c][i] - truth.find("")->planes[c][i];
                d2 += d * d / 3;
                l += (c == 1 ? 0.7152 : c == 0 ? 0.2126 : 0.0722) * truth.find("")->planes[c][i];
            }
            sum += d2 / ((l + 0.01) * (l + 0.01));
        }
        const double actual = std::sqrt(sum / double(n));
        EXPECT_LT(actual, 1.3 * stats.estimated_error) << samples << " samples";
        EXPECT_GT(actual, 0.3 * stats.estimated_error) << samples << " samples";
    }
}

TEST(Stopping, target_error_and_time_and_cancel) {
    SceneKit kit = mixed_room();
    RenderStats stats;
    RenderRequest r;
    r.samples = 1 << 20;
    r.target_error = 0.2;
    kit.render(r, &stats);
    EXPECT_LE(stats.estimated_error, 0.2);
    EXPECT_TRUE(stats.complete);
    EXPECT_LT(stats.samples, 4096);

    r.target_error = 0;
    r.seconds = 0.3;
    const Image timed = kit.render(r, &stats);
    EXPECT_FALSE(stats.complete);
    EXPECT_GT(stats.samples, 0);
    EXPECT_LT(stats.render_seconds, 1.5);
    EXPECT_GT(mean(timed).y, 0);

    r.seconds = 0;
    std::atomic<bool> cancel{false};
    r.cancel = &cancel;
    auto prepared = kit.prepare();
    int calls = 0;
    double last = 0;
    const Image cancelled = alder::render(*prepared, r, stats, [&](double f) {
        EXPECT_GE(f, last);
        last = f;
        if (++calls == 200) cancel = true;
    });
    EXPECT_FALSE(stats.complete);
    EXPECT_EQ(cancelled.width, 32);
    EXPECT_GE(calls, 200);
}

}  // namespace
}  // namespace alder::testing
