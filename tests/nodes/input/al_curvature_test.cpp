// alCurvature: the sphere fit on shapes that are known, and on the probes of the reference table.
#include <gtest/gtest.h>

#include <cmath>

#include "nodes/input/scene_query.h"
#include "tests/nodes/al_pattern_table.h"
#include "tests/nodes/al_table.h"

namespace alder {
namespace {

TEST(AlCurvature, sphere_of_radius_two_has_curvature_half) {
    for (const double side : {1.0, -1.0}) {  // bulging and seen from inside
        SphereFit fit(0.5);
        for (int i = 0; i < 9; ++i) {
            const double a = 0.1 * (i % 3 - 1), b = 0.1 * (i / 3 - 1), z = std::sqrt(4 - a * a - b * b);
            const double q[3] = {a, b, z - 2}, n[3] = {side * a / 2, side * b / 2, side * z / 2};
            fit.add(q, n);
        }
        float value = 0;
        ASSERT_TRUE(fit.curvature(value));
        EXPECT_NEAR(value, side * 0.25, 1e-4) << "the fit gives half the curvature, as the original";
    }
}

TEST(AlCurvature, one_place_and_nothing_have_none) {
    float value;
    SphereFit nothing(1), one(1), far(1);
    EXPECT_FALSE(nothing.curvature(value));
    const double q[3] = {0.1, 0, 0}, n[3] = {0, 0, 1}, beyond[3] = {2, 0, 0};
    for (int i = 0; i < 5; ++i) one.add(q, n);
    EXPECT_FALSE(one.curvature(value));
    far.add(beyond, n);
    EXPECT_FALSE(far.curvature(value));
}

TEST(AlCurvature, fits_the_probes_of_the_reference) {
    int cases = 0, outside = 0;
    double worst = 0;
    for (const auto& c : test::al_cases("alCurvature")) {
        const auto& p = c["params"];
        const Vec3f at = test::al_vec(c["globals"]["P"]);
        SphereFit fit(test::al_number(p["sampleRadius"]));
        for (const auto& h : c["hits"]) {
            double q[3], n[3];
            for (int i = 0; i < 3; ++i) {
                q[i] = test::al_number(h[i]) - at[i];
                n[i] = test::al_number(h[3 + i]);
            }
            fit.add(q, n);
        }
        float value = 0;
        const bool found = fit.curvature(value);
        value = std::max(p["mode"] == "negative" ? -value : value, 0.f);
        const float x = found ? test::remapped(p, value) : 0.f;
        const Vec3f got = HWY_NAMESPACE::lerp(test::al_vec(p["color1"]), test::al_vec(p["color2"]), x);
        double error = 0;
        for (int i = 0; i < 3; ++i) error = std::max(error, test::al_error(got[i], test::al_number(c["output"][i])));
        ++cases;
        outside += error > 0.02;  // the table's own allowance: the original shifts by (10,10,10)
        worst = std::max(worst, error);
    }
    EXPECT_GT(cases, 20);
    EXPECT_EQ(outside, 0) << "of " << cases << ", worst " << worst;
}

}  // namespace
}  // namespace alder
