// Voronoi Texture: against a brute-force search in double, geometry of grids, orders between features and metrics.
#include <cmath>
#include <random>

#include "nodes/noise/hash-inl.h"
#include "tests/nodes/node_call.h"

namespace alder {
namespace {
using test::NodeCall;
using test::Path;

constexpr size_t kPoints = 50;
enum { kDistance = 0, kColor = 1, kPosition = 4, kW = 7, kRadius = 8 };

std::vector<double> random_numbers(unsigned seed) {
    std::mt19937 rng(seed);
    std::uniform_real_distribution<float> u(-3, 3);
    std::vector<double> v(kPoints);
    for (double& x : v) x = u(rng);
    return v;
}
NodeCall voronoi(const char* feature, const char* dimensions = "3D") {
    NodeCall call("ShaderNodeTexVoronoi", kPoints);
    call.set("feature", feature).set("voronoi_dimensions", dimensions).set("Scale", 1).vary("W", random_numbers(3));
    for (int c = 0; c < 3; ++c) call.vary("Vector", random_numbers(c), c);
    return call;
}

TEST(TexVoronoi, f1_and_f2_are_the_nearest_of_all_points_around) {
    const auto f1 = voronoi("F1").run(), f2 = voronoi("F2").run(), edge = voronoi("DISTANCE_TO_EDGE").run();
    const auto x = random_numbers(0), y = random_numbers(1), z = random_numbers(2);
    namespace s = HWY_NAMESPACE;
    for (size_t i = 0; i < kPoints; ++i) {
        const double p[3] = {x[i], y[i], z[i]};
        double best = 1e9, second = 1e9, nearest[3] = {};
        std::vector<std::array<double, 3>> points;
        for (int k = 0; k < 125; ++k) {
            float cell[3];
            for (int c = 0, rest = k; c < 3; ++c, rest /= 5) cell[c] = static_cast<float>(std::floor(p[c]) + rest % 5 - 2);
            const auto h = s::hash_to_vec3(cell[0], cell[1], cell[2]);
            const std::array<double, 3> q = {cell[0] + h.x, cell[1] + h.y, cell[2] + h.z};
            points.push_back(q);
            const double d = std::hypot(q[0] - p[0], q[1] - p[1], q[2] - p[2]);
            if (d < best) {
                second = best, best = d;
                std::copy(q.begin(), q.end(), nearest);
            } else if (d < second) {
                second = d;
            }
        }
        EXPECT_NEAR(f1[kDistance][i], best, 2e-6) << i;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(f1[kPosition + c][i], nearest[c], 2e-6) << i;
        EXPECT_LE(f1[kDistance][i], f2[kDistance][i]);
        EXPECT_GE(f2[kDistance][i], second - 2e-6) << "Cycles looks at the 27 cells around only";
        double border = 1e9;
        for (const auto& q : points) {
            const double v[3] = {q[0] - nearest[0], q[1] - nearest[1], q[2] - nearest[2]}, l = std::hypot(v[0], v[1], v[2]);
            if (l < 0.01) continue;
            double d = 0;
            for (int c = 0; c < 3; ++c) d += ((q[c] + nearest[c]) / 2 - p[c]) * v[c] / l;
            border = std::min(border, d);
        }
        EXPECT_GE(edge[kDistance][i], border - 3e-6) << i;
        EXPECT_LE(edge[kDistance][i], (second + best) / 2 + 1e-6);
    }
}
TEST(TexVoronoi, without_randomness_points_form_a_grid) {
    const auto x = random_numbers(0), y = random_numbers(1), z = random_numbers(2);
    const auto near = [](double v) { return std::fabs(v - std::round(v)); };
    const auto euclid = voronoi("F1").set("Randomness", 0).run(), manhattan = voronoi("F1").set("Randomness", 0).set("distance", "MANHATTAN").run(),
               chebychev = voronoi("F1").set("Randomness", 0).set("distance", "CHEBYCHEV").run(),
               edge = voronoi("DISTANCE_TO_EDGE").set("Randomness", 0).run(), radius = voronoi("N_SPHERE_RADIUS").set("Randomness", 0).run();
    for (size_t i = 0; i < kPoints; ++i) {
        const double a = near(x[i]), b = near(y[i]), c = near(z[i]);
        EXPECT_NEAR(euclid[kDistance][i], std::hypot(a, b, c), 1e-6);
        EXPECT_NEAR(manhattan[kDistance][i], a + b + c, 1e-6);
        EXPECT_NEAR(chebychev[kDistance][i], std::max({a, b, c}), 1e-6);
        EXPECT_NEAR(edge[kDistance][i], 0.5 - std::max({a, b, c}), 1e-6);
        EXPECT_NEAR(radius[kRadius][i], 0.5, 1e-6);
    }
}
TEST(TexVoronoi, minkowski_meets_the_other_metrics) {
    const auto euclid = voronoi("F1").run(), manhattan = voronoi("F1").set("distance", "MANHATTAN").run();
    const auto two = voronoi("F1").set("distance", "MINKOWSKI").set("Exponent", 2).run(), one = voronoi("F1").set("distance", "MINKOWSKI").set("Exponent", 1).run();
    for (size_t i = 0; i < kPoints; ++i) {
        EXPECT_NEAR(two[kDistance][i], euclid[kDistance][i], 2e-6);
        EXPECT_NEAR(one[kDistance][i], manhattan[kDistance][i], 2e-6);
    }
}
TEST(TexVoronoi, smooth_f1_nears_f1) {
    for (const char* dimensions : {"1D", "2D", "3D", "4D"}) {
        const auto f1 = voronoi("F1", dimensions).run(), none = voronoi("SMOOTH_F1", dimensions).set("Smoothness", 0).run(),
                   little = voronoi("SMOOTH_F1", dimensions).set("Smoothness", 1e-3).run(), much = voronoi("SMOOTH_F1", dimensions).run();
        for (size_t i = 0; i < kPoints; ++i) {
            EXPECT_EQ(none[kDistance][i], f1[kDistance][i]) << dimensions;
            EXPECT_NEAR(little[kDistance][i], f1[kDistance][i], 1e-3) << dimensions;
            EXPECT_LE(much[kDistance][i], f1[kDistance][i] + 1e-6) << dimensions;
        }
    }
}
TEST(TexVoronoi, colour_is_the_cells) {
    // Neighbouring places in one cell share the colour; the colour of red is the hash of the cell.
    const auto r = voronoi("F1").run(), moved = voronoi("F1").set("Scale", 1.0000001).run();
    int same = 0;
    for (size_t i = 0; i < kPoints; ++i) same += r[kColor][i] == moved[kColor][i];
    EXPECT_GE(same, static_cast<int>(kPoints) - 1);
}
TEST(TexVoronoi, normalised_distance_stays_below_1) {
    for (const char* feature : {"F1", "F2", "DISTANCE_TO_EDGE"}) {
        for (const char* dimensions : {"1D", "2D", "3D", "4D"}) {
            const auto r = voronoi(feature, dimensions).set("normalize", 1).set("Detail", 3.5).run();
            for (double d : r[kDistance]) EXPECT_TRUE(d >= -1e-6 && d <= 1) << feature << " " << dimensions << ": " << d;
        }
    }
}
TEST(TexVoronoi, one_octave_is_what_zero_roughness_gives) {
    EXPECT_EQ(voronoi("F1").set("Detail", 4).set("Roughness", 0).run()[kDistance], voronoi("F1").run()[kDistance]);
}
TEST(TexVoronoi, detail_fades_octaves_in) {
    for (const char* feature : {"F1", "F2", "SMOOTH_F1"}) {
        const auto one = voronoi(feature).set("Detail", 1).run(), half = voronoi(feature).set("Detail", 1.5).run(), two = voronoi(feature).set("Detail", 2).run();
        for (size_t i = 0; i < kPoints; ++i) EXPECT_NEAR(half[kDistance][i], (one[kDistance][i] + two[kDistance][i]) / 2, 1e-5) << feature;
    }
}
TEST(TexVoronoi, a_batch_of_mixed_parameters_gives_what_each_alone_gives) {
    const auto x = random_numbers(0), y = random_numbers(1), z = random_numbers(2);
    for (const char* feature : {"F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE"}) {
        std::vector<double> detail(kPoints), smoothness(kPoints), randomness(kPoints);
        for (size_t i = 0; i < kPoints; ++i) detail[i] = i % 4 * 0.75, smoothness[i] = i % 3 * 0.5, randomness[i] = i % 5 * 0.25;
        const auto mixed = voronoi(feature).vary("Detail", detail).vary("Smoothness", smoothness).vary("Randomness", randomness).run();
        for (size_t i = 0; i < kPoints; i += 3) {
            NodeCall one("ShaderNodeTexVoronoi");
            one.set("feature", feature).set("Scale", 1).set("Vector", {x[i], y[i], z[i]});
            one.set("Detail", detail[i]).set("Smoothness", smoothness[i]).set("Randomness", randomness[i]);
            const auto alone = one.run();
            for (int c = 0; c < 9; ++c) EXPECT_EQ(mixed[c][i], alone[c][0]) << feature << " point " << i << " channel " << c;
        }
    }
}

}  // namespace
}  // namespace alder
