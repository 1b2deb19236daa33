// alFlowNoise: the original's numbers, seam and all; then what the mended wrap and the exact lattice are for.
#include "nodes/noise/flow_noise-inl.h"
#include "tests/nodes/al_pattern_table.h"

#include <random>

namespace alder {
using test::NodeCall;
using test::Path;
namespace kn = HWY_NAMESPACE;

TEST(AlFlowNoise, matches_the_reference_with_the_originals_wrap) {
    int cases = 0, outside = 0;
    for (const auto& c : test::al_cases("alFlowNoise")) {
        const auto& p = c["params"];
        const kn::FlowNoiseParams<float> f = {test::al_float(p["lacunarity"]), test::al_float(p["gain"]), test::al_float(p["angle"]),
                                              test::al_float(p["advection"]), p["octaves"].get<int>(), p["turbulent"].get<bool>()};
        const Vec3f at = test::pattern_point_of(c) * test::al_float(p["frequency"]);
        outside += test::pattern_error(c, kn::flow_noise_sum<true>(at, f)) > 2e-4;
        if (c["lattice"] == "positive") outside += test::pattern_error(c, kn::flow_noise_sum<false>(at, f)) > 2e-4;
        ++cases;
    }
    EXPECT_LE(outside, cases / 100) << "of " << cases;
}
TEST(AlFlowNoise, has_no_seam_at_zero) {
    // Moved by 128 along every axis, which skewed is 256 cells, the pattern repeats; the original's does not across 0.
    std::mt19937 rng(3);
    std::uniform_real_distribution<float> u(-6, 6);
    double worst = 0, original = 0;
    for (int i = 0; i < 500; ++i) {
        const Vec3f p(u(rng), u(rng), u(rng));
        const Vec3f far = p + Vec3f(128, 128, 128);
        worst = std::max<double>(worst, std::fabs(kn::flow_noise<false>(p, 0.6f, 0.8f).value - kn::flow_noise<false>(far, 0.6f, 0.8f).value));
        original = std::max<double>(original, std::fabs(kn::flow_noise<true>(p, 0.6f, 0.8f).value - kn::flow_noise<true>(far, 0.6f, 0.8f).value));
    }
    EXPECT_LE(worst, 2e-4);
    EXPECT_GT(original, 0.1);
}
TEST(AlFlowNoise, gradient_is_the_derivative) {
    std::mt19937 rng(4);
    std::uniform_real_distribution<double> u(-20, 20);
    int off = 0;
    for (int i = 0; i < 300; ++i) {
        const Vec3d p(u(rng), u(rng), u(rng));
        const auto n = kn::flow_noise<false>(p, 0.0, 1.0);
        for (int c = 0; c < 3; ++c) {
            Vec3d a = p, b = p;
            a[c] -= 1e-5, b[c] += 1e-5;
            const double slope = (kn::flow_noise<false>(b, 0.0, 1.0).value - kn::flow_noise<false>(a, 0.0, 1.0).value) / 2e-5;
            off += std::fabs(slope - n.gradient[c]) > 1e-3;
        }
    }
    EXPECT_LE(off, 3) << "of 900: faces between simplices apart, where the kernel of radius sqrt(0.6) reaches over";
}
TEST(AlFlowNoise, is_as_exact_far_from_the_origin_as_the_point) {
    std::mt19937 rng(5);
    for (const double away : {0.0, 2e4, 1e6}) {
        std::uniform_real_distribution<float> u(static_cast<float>(away), static_cast<float>(away + 50));
        double worst = 0;
        for (int i = 0; i < 2000; ++i) {
            const Vec3f p(u(rng), -u(rng), u(rng));
            const Vec3d d(p.x, p.y, p.z);
            worst = std::max(worst, std::fabs(kn::flow_noise<false>(p, 0.6f, 0.8f).value - kn::flow_noise<false>(d, 0.6, 0.8).value));
        }
        EXPECT_LE(worst, away == 0 ? 3e-5 : 5e-6) << "at " << away;   // near the origin in the original's order of operations
    }
}
TEST(AlFlowNoise, lanes_equal_scalar_and_double) {
    const size_t n = 512;
    std::vector<double> x, y;
    for (size_t i = 0; i < n; ++i) x.push_back(0.3713 * static_cast<double>(i) - 90.017), y.push_back(0.1107 * static_cast<double>(i) - 20.03);   // off the simplices' faces
    NodeCall call("alFlowNoise", n);
    call.set("turbulent", 1).set("angle", 1.3).set("P", {0, 0, 0.3}).vary("P", x, 0).vary("P", y, 1);
    const auto lanes = call.run(), scalar = call.run(Path::Scalar), exact = call.run(Path::Double);
    for (size_t i = 0; i < n; ++i) {
        EXPECT_NEAR(lanes[0][i], scalar[0][i], 2e-5) << i;
        EXPECT_NEAR(lanes[0][i], exact[0][i], 3e-4) << i;
    }
}
TEST(AlFlowNoise, huge_points_are_finite) {
    for (double x : {1e9, -3e38, 1e-40, 5e8, -5e8})
        for (double lacunarity : {2.172, 1e30}) {
            const double v = NodeCall("alFlowNoise").set("RMPclampEnable", 0).set("octaves", 6).set("lacunarity", lacunarity).set("P", {x, 0.5, -x}).value();
            EXPECT_TRUE(std::isfinite(v)) << x << " gives " << v;
        }
}
}  // namespace alder
