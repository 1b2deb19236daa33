// Lights by themselves: densities against what is sampled, in both directions of the interface.
#include <gtest/gtest.h>

#include <random>

#include "render/light/environment.h"
#include "render/light/lamp.h"
#include "render/light/rectangle.h"
#include "render/light/selector.h"
#include "render/light/triangle.h"
#include "render/sampling.h"

namespace alder {
namespace {

Light lamp_of(LightKind kind, Transform t) {
    Light l;
    l.kind = kind;
    l.strength = 10;
    l.to_world = t;
    return l;
}

std::vector<std::pair<const char*, Light>> all_lamps() {
    std::vector<std::pair<const char*, Light>> list;
    const Transform above{{1, 0, 0, 0.3f, 0, 1, 0, -0.2f, 0, 0, 1, 2}};
    Light point = lamp_of(LightKind::Point, above);
    point.radius = 0.7f;
    list.push_back({"sphere", point});
    Light spot = lamp_of(LightKind::Spot, above);
    spot.radius = 0.2f;
    spot.spot_angle = 1.2f;
    list.push_back({"spot", spot});
    point.soft_falloff = spot.soft_falloff = true;
    list.push_back({"disk that faces the point", point});
    list.push_back({"spot with soft falloff", spot});
    Light sun = lamp_of(LightKind::Sun, above);
    sun.angle = 0.5f;
    list.push_back({"sun", sun});
    Light area = lamp_of(LightKind::Area, above);
    area.size_x = 3;
    list.push_back({"rectangle", area});
    area.size_x = area.size_y = 1e-3f;
    list.push_back({"tiny rectangle", area});
    area.size_x = area.size_y = 50;
    list.push_back({"huge rectangle", area});
    area.size_x = 2;
    area.size_y = 1;
    area.shape = Light::Shape::Ellipse;
    list.push_back({"ellipse", area});
    area.spread = 1;
    list.push_back({"ellipse with spread", area});
    area.shape = Light::Shape::Rectangle;
    list.push_back({"rectangle with spread", area});
    return list;
}

/// A ray in a sampled direction meets the lamp there, with the same density and radiance.
TEST(Lamp, sampled_and_met_agree) {
    std::mt19937 rng(1);
    std::uniform_real_distribution<float> u(0, 1);
    for (const auto& [name, light] : all_lamps()) {
        const Lamp lamp(light);
        int sampled = 0, met = 0;
        for (int i = 0; i < 2000; ++i) {
            const Vec3f p{2 * u(rng) - 1, 2 * u(rng) - 1, u(rng)};
            LampSample s, m;
            if (!lamp.sample(p, u(rng), u(rng), s)) continue;
            ++sampled;
            // A direction at the very rim may round off the lamp.
            if (!lamp.intersect(p, s.wi, 0, std::numeric_limits<float>::infinity(), m)) continue;
            ++met;
            ASSERT_NEAR(m.pdf / s.pdf, 1, 2e-3) << name;
            // A spread's attenuation ends in a kink, where rounding of the direction shows.
            ASSERT_NEAR(m.radiance.x, s.radiance.x, 2e-3f * s.radiance.x + 1e-4f) << name;
            if (std::isfinite(s.distance)) {
                ASSERT_NEAR(m.distance / s.distance, 1, 1e-2) << name;
            }
        }
        EXPECT_GT(sampled, 900) << name;
        EXPECT_GT(met, 0.97 * sampled) << name;
    }
}

/// The mean of 1/pdf over samples is the solid angle of the lamp: against uniform directions that are tested against it.
TEST(Lamp, mean_inverse_density_is_the_solid_angle) {
    std::mt19937 rng(2);
    std::uniform_real_distribution<float> u(0, 1);
    const Vec3f p{0.4f, -0.6f, 0.3f};
    for (const auto& [name, light] : all_lamps()) {
        if (std::string(name) == "tiny rectangle" || light.spread < 3) continue;
        const Lamp lamp(light);
        const int n = 200000;
        double inverse = 0, hits = 0;
        for (int i = 0; i < n; ++i) {
            LampSample s;
            if (lamp.sample(p, u(rng), u(rng), s)) inverse += 1 / s.pdf;
            const float z = 1 - 2 * u(rng), r = safe_sqrt(1 - z * z), phi = 2 * kPi * u(rng);
            if (lamp.intersect(p, {r * std::cos(phi), r * std::sin(phi), z}, 0, std::numeric_limits<float>::infinity(), s)) hits += 1;
        }
        const double expected = 4 * kPi * hits / n;
        if (light.kind == LightKind::Spot) continue;  // samples outside the cone are refused
        EXPECT_NEAR(inverse / n, expected, 5 * 4 * kPi * std::sqrt(hits) / n + 1e-3 * expected) << name;
    }
}

/// A disk that faces the point sends, far away, what a sphere of the same radius does; at its middle it does not blow up.
TEST(Lamp, soft_falloff_keeps_the_intensity) {
    Light soft = lamp_of(LightKind::Point, Transform{});
    soft.radius = 0.5f;
    Light hard = soft;
    soft.soft_falloff = true;
    const auto irradiance = [](const Light& light, float distance) {
        const Lamp lamp(light);
        double sum = 0;
        std::mt19937 rng(3);
        std::uniform_real_distribution<float> u(0, 1);
        for (int i = 0; i < 100000; ++i) {
            LampSample s;
            if (lamp.sample({0, 0, -distance}, u(rng), u(rng), s) && s.wi.z > 0) sum += s.radiance.x * s.wi.z / s.pdf / 100000;
        }
        return sum;
    };
    EXPECT_NEAR(irradiance(soft, 50) / irradiance(hard, 50), 1, 2e-3);
    // E = pi L r^2 / (r^2 + d^2) of a disk, pi L r^2 / d^2 of a sphere.
    for (const float d : {0.6f, 1.f, 2.f}) EXPECT_NEAR(irradiance(soft, d) / irradiance(hard, d), d * d / (d * d + 0.25f), 5e-3) << d;
}

/// Few emitters are weighed for each point: probabilities add to one, agree with what is picked, and favour the near one.
TEST(LightSelector, probabilities_are_those_of_the_choice) {
    std::vector<EmitterBounds> list;
    for (const auto& [name, light] : all_lamps()) list.push_back(Lamp(light).bounds(10));
    const LightSelector few(list);
    for (int i = 0; i < 5; ++i) list.insert(list.end(), list.begin(), list.begin() + 5);
    const LightSelector many(list);
    std::mt19937 rng(4);
    std::uniform_real_distribution<float> u(0, 1);
    for (const LightSelector* s : {&few, &many})
        for (int k = 0; k < 20; ++k) {
            const Vec3f p{4 * u(rng) - 2, 4 * u(rng) - 2, 4 * u(rng) - 1};
            const size_t n = s == &few ? all_lamps().size() : list.size();
            double sum = 0;
            for (uint32_t i = 0; i < n; ++i) sum += s->probability(p, i);
            ASSERT_NEAR(sum, 1, 1e-5);
            for (int j = 0; j < 100; ++j) {
                float x = u(rng), probability = 0;
                const int e = s->pick(p, x, probability);
                ASSERT_GE(e, 0);
                ASSERT_EQ(probability, s->probability(p, uint32_t(e)));
                ASSERT_TRUE(x >= 0 && x < 1);
            }
        }
}

/// Whatever a lamp sends to a point, the choice must not exclude: its probability is above zero wherever a sample arrives.
TEST(LightSelector, bounds_are_conservative) {
    std::mt19937 rng(5);
    std::uniform_real_distribution<float> u(0, 1);
    for (const auto& [name, light] : all_lamps()) {
        const Lamp lamp(light);
        const LightSelector one({lamp.bounds(10)});
        for (int i = 0; i < 5000; ++i) {
            const Vec3f p{6 * u(rng) - 3, 6 * u(rng) - 3, 5 * u(rng) - 1};
            LampSample s;
            if (lamp.sample(p, u(rng), u(rng), s)) {
                ASSERT_GT(one.probability(p, 0), 0) << name;
            }
        }
    }
}

TEST(SphericalRectangle, is_uniform_in_solid_angle) {
    const SphericalRectangle r({0.5f, 0, 1}, {1, 0, 0}, {0, 1, 0}, 4, 2, {0, 0, 0});
    ASSERT_FALSE(r.is_small());
    // Solid angle of a rectangle from its corners: sum of asin terms (independent form, Van Oosterom on two triangles).
    const auto triangle = [](Vec3f a, Vec3f b, Vec3f c) {
        return SphericalTriangle({a, b, c}, {0, 0, 0}).solid_angle();
    };
    const Vec3f a{-1.5f, -1, 1}, b{2.5f, -1, 1}, c{2.5f, 1, 1}, d{-1.5f, 1, 1};
    EXPECT_NEAR(r.solid_angle(), triangle(a, b, c) + triangle(a, c, d), 1e-5);
    // Halves by x: the share of samples is the share of solid angle.
    const Vec3f e{0, -1, 1}, f{0, 1, 1};
    const double left = (triangle(a, e, f) + triangle(a, f, d)) / r.solid_angle();
    int count = 0;
    const int n = 1000;  // x depends on the first number alone
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) count += r.sample((i + 0.5f) / n, (j + 0.5f) / n).x < 0;
    EXPECT_NEAR(double(count) / (n * n), left, 2e-3);
}

TEST(SphericalTriangle, is_uniform_in_solid_angle) {
    const std::array<Vec3f, 3> corners{Vec3f{-1, -1, 1}, Vec3f{2, -0.5f, 0.8f}, Vec3f{0.3f, 1.5f, 1.2f}};
    const SphericalTriangle t(corners, {0, 0, 0});
    ASSERT_TRUE(t.is_usable());
    // Cut at the middle of an edge: the share of samples is the share of the part's solid angle.
    const Vec3f mid = (corners[1] + corners[2]) * 0.5f;
    const double part = SphericalTriangle({corners[0], corners[1], mid}, {0, 0, 0}).solid_angle() / t.solid_angle();
    int count = 0;
    const int n = 200;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            Vec3f d;
            float b1, b2;
            ASSERT_TRUE(t.sample((i + 0.5f) / n, (j + 0.5f) / n, d, b1, b2));
            const Vec3f q = corners[0] * (1 - b1 - b2) + corners[1] * b1 + corners[2] * b2;
            ASSERT_NEAR(dot(safe_normalize(q), d), 1, 1e-5);
            count += b1 > b2;
        }
    EXPECT_NEAR(double(count) / (n * n), part, 3e-3);
}

TEST(EnvironmentMap, density_is_normalised_and_follows_the_map) {
    const int w = 32, h = 16;
    std::vector<Vec3f> radiance(w * h);
    std::mt19937 rng(3);
    std::uniform_real_distribution<float> u(0, 1);
    for (Vec3f& r : radiance) r = Vec3f(u(rng) * u(rng));
    radiance[5 * w + 7] = Vec3f(300.f);
    radiance[6 * w + 7] = Vec3f(0.f);
    const EnvironmentMap map(w, h, radiance);
    ASSERT_TRUE(map.is_usable());
    double integral = 0;
    int in_sun = 0;
    const int n = 100000;
    for (int i = 0; i < n; ++i) {
        float pdf;
        const Vec3f d = map.sample(u(rng), u(rng), pdf);
        ASSERT_NEAR(length(d), 1, 1e-5);
        // At the border of two cells rounding may fall to the neighbour.
        if (map.pdf(d) != pdf) continue;
        in_sun += dot(d, EnvironmentMap::cell_direction(w, h, 7, 5)) > 0.97f;
    }
    for (int i = 0; i < n; ++i) {
        const float z = 1 - 2 * u(rng), r = safe_sqrt(1 - z * z), phi = 2 * kPi * u(rng);
        const Vec3f d{r * std::cos(phi), r * std::sin(phi), z};
        if (dot(d, EnvironmentMap::cell_direction(w, h, 7, 5)) < 0.9f) integral += map.pdf(d) * 4 * kPi / n;
    }
    double elsewhere = 0, total = 0, sun = 0;
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
            const double cell = radiance[y * w + x].x * (std::cos(kPi * y / h) - std::cos(kPi * (y + 1) / h));
            total += cell;
            if (x == 7 && y == 5) sun = cell;
            if (dot(EnvironmentMap::cell_direction(w, h, x, y), EnvironmentMap::cell_direction(w, h, 7, 5)) < 0.9f) elsewhere += cell;
        }
    EXPECT_NEAR(double(in_sun) / n, sun / total, 0.03) << "a few other cells lie as near";
    EXPECT_NEAR(integral, elsewhere / total, 0.05 * elsewhere / total);
    EXPECT_FALSE(EnvironmentMap(4, 2, std::vector<Vec3f>(8, Vec3f(0.f))).is_usable());
}

}  // namespace
}  // namespace alder
