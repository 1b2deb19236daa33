// The energy tables: some nodes recomputed, lookups between and beyond the nodes, limits of the compensation.
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "nodes/surface/energy-inl.h"
#include "tests/tools/energy_quadrature.h"

namespace alder {
namespace {

namespace hw = HWY_NAMESPACE;

TEST(energy_tables, nodes_are_their_definition) {
    std::mt19937 engine(1);
    const int n = 200;
    for (int i = 0; i < 40; ++i) {
        const int rough = engine() % 32, mu = engine() % 32;
        EXPECT_NEAR(kGgxE[mu * 32 + rough], energy::ggx_albedo(energy::axis_node(rough, 32), energy::axis_node(mu, 32), n), 1e-4)
            << rough << " " << mu;
    }
    for (int i = 0; i < 40; ++i) {
        const int rough = engine() % 16, mu = engine() % 16, z = 1 + engine() % 15, k = (z * 16 + mu) * 16 + rough;
        const double r = energy::axis_node(rough, 16), c = energy::axis_node(mu, 16), ior = energy::ior_of(z / 15.0);
        EXPECT_NEAR(kGgxGlassE[k], energy::ggx_glass_albedo(r, c, ior, false, n), 3e-4) << k;
        EXPECT_NEAR(kGgxGlassInsideE[k], energy::ggx_glass_albedo(r, c, ior, true, n), 3e-3) << k;
        EXPECT_NEAR(kGgxFresnelRise[k], energy::ggx_fresnel_rise(r, c, ior, n), 1e-3) << k;
    }
    for (const int rough : {0, 7, 20, 31})
        EXPECT_NEAR(kGgxEavg[rough], energy::hemispherical(12, [&](double mu) {
                        return energy::ggx_albedo(energy::axis_node(rough, 32), mu, 100);
                    }), 3e-4);
}

// With the layout known from the nodes, a lookup at a node gives the node, and half-way their mean.
TEST(energy_tables, lookups_are_linear) {
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) {
            EXPECT_NEAR(hw::table_3d(kGgxGlassE, 16, x / 15.0, y / 15.0, 7 / 15.0), kGgxGlassE[(7 * 16 + y) * 16 + x], 1e-6);
            if (x < 15) {
                EXPECT_NEAR(hw::table_2d(kGgxGlassEavg, 16, (x + 0.5) / 15, y / 15.0),
                            0.5 * (kGgxGlassEavg[y * 16 + x] + kGgxGlassEavg[y * 16 + x + 1]), 1e-6);
            }
        }
}

TEST(energy_tables, lookups_stay_inside_for_any_argument) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    for (const float a : {nan, inf, -inf, -1e30f, 1e30f, 0.0f, 1.0f, 1.0000001f})
        for (const float b : {nan, inf, -inf, 2.0f}) {
            EXPECT_GE(hw::TableAxis<float>(a, 32).index, 0);
            EXPECT_LE(hw::TableAxis<float>(a, 32).index, 30);
            if (a == a && b == b) {
                EXPECT_TRUE(std::isfinite(hw::table_3d(kGgxFresnelRise, 16, a, b, a))) << a << " " << b;
            }
        }
    EXPECT_EQ(hw::table_1d(kGgxEavg, 32, 5.0f), kGgxEavg[31]);
}

// A white lobe is compensated in full, a black one not at all beyond its single bounce, and nothing exceeds white.
TEST(energy_tables, compensation_limits) {
    for (const double rough : {0.0, 0.3, 0.7, 1.0})
        for (const double mu : {0.02, 0.3, 1.0}) {
            const auto albedo = hw::ggx_energy(rough, mu);
            const hw::MultiScatter<double> white(albedo, Vec3d(1, 1, 1)), black(albedo, Vec3d(0, 0, 0)), grey(albedo, Vec3d(0.5, 0.5, 0.5));
            EXPECT_NEAR(white.factor().x * albedo.e, 1, 1e-12);
            EXPECT_NEAR(black.factor().x, 1, 1e-12);
            EXPECT_LE(grey.factor().x, white.factor().x);
            EXPECT_GE(grey.factor().x, 1);
            EXPECT_NEAR(hw::ggx_glass_energy(rough, mu, 1.0).e, 1, 1e-6);
        }
}

}  // namespace
}  // namespace alder
