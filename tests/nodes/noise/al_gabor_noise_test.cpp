// alGaborNoise: the original's numbers with its defects, then what was mended.
#include "nodes/noise/gabor_noise-inl.h"
#include "tests/nodes/al_pattern_table.h"

#include <random>

namespace alder {
using test::NodeCall;
using test::Path;
namespace kn = HWY_NAMESPACE;

static int anisotropy_of(const nlohmann::json& p) { return p["anisotropy"] == "isotropic" ? 0 : p["anisotropy"] == "anisotropic" ? 1 : 2; }

TEST(AlGaborNoise, matches_the_reference_with_the_originals_defects) {
    int cases = 0, outside = 0;
    double worst = 0;
    for (const auto& c : test::al_cases("alGaborNoise")) {
        const auto& p = c["params"];
        const kn::GaborParams<float> g(test::al_vec(p["anisotropyDirection"]), test::al_float(p["bandwidth"]), test::al_float(c["impulsesEffective"]));
        float n = kn::gabor_noise<true>(test::pattern_point_of(c) * test::al_float(p["frequency"]), g, anisotropy_of(p));
        if (p["turbulent"].get<bool>()) n = std::fabs(n);
        const double error = test::pattern_error(c, n);
        outside += error > 1e-3;
        worst = std::max(worst, error);
        ++cases;
    }
    EXPECT_LE(outside, cases / 100) << "of " << cases << ", worst " << worst;
}
/// Values of the noise at scattered points.
static std::vector<double> values(double impulses, const char* anisotropy, size_t n, unsigned seed, double spread = 200) {
    std::mt19937 rng(seed);
    std::uniform_real_distribution<double> u(-spread, spread);
    std::vector<double> x[3];
    for (size_t i = 0; i < n; ++i)
        for (auto& v : x) v.push_back(u(rng));
    NodeCall call("alGaborNoise", n);
    call.set("impulses", impulses).set("anisotropy", anisotropy).set("RMPclampEnable", 0);
    for (int c = 0; c < 3; ++c) call.vary("P", x[c], c);
    return call.run()[0];
}
TEST(AlGaborNoise, has_mean_zero_and_the_same_variance_for_any_number_of_impulses) {
    double variance[2];
    for (int k = 0; k < 2; ++k) {
        const auto v = values(k ? 32 : 2, "isotropic", 20000, 7);
        double sum = 0, squares = 0;
        for (double x : v) sum += x, squares += x * x;
        variance[k] = squares / v.size();
        EXPECT_NEAR(sum / v.size(), 0, 5 * std::sqrt(variance[k] / v.size()));
    }
    EXPECT_NEAR(variance[0] / variance[1], 1, 0.1);
}
TEST(AlGaborNoise, fewer_impulses_leave_more_empty_space) {
    // An impulse count read as a float: with one impulse a reach, exp(-1) of space is out of reach of any.
    const auto v = values(1, "isotropic", 20000, 8);
    const double empty = static_cast<double>(std::count(v.begin(), v.end(), 0.0)) / v.size();
    EXPECT_NEAR(empty, std::exp(-1.0), 0.02);
    const auto w = values(32, "isotropic", 2000, 8);
    EXPECT_EQ(std::count(w.begin(), w.end(), 0.0), 0);
}
TEST(AlGaborNoise, frequencies_point_both_ways) {
    kn::GaborRandom<float> random(3, 1, 2), old(3, 1, 2);
    double sum = 0, original = 0;
    const int n = 20000;
    for (int i = 0; i < n; ++i) {
        sum += kn::gabor_frequency<false>(random, Vec3f(0, 1, 0), kn::kGaborIsotropic).x;
        original += kn::gabor_frequency<true>(old, Vec3f(0, 1, 0), kn::kGaborIsotropic).x;
    }
    EXPECT_NEAR(sum / n, 0, 5 * std::sqrt(1.0 / 3 / n));
    EXPECT_NEAR(original / n, 0.5, 0.02);
}
TEST(AlGaborNoise, lanes_equal_scalar_and_double_in_every_mode) {
    const size_t n = 512;
    std::vector<double> x, y;
    for (size_t i = 0; i < n; ++i) x.push_back(0.037 * static_cast<double>(i) - 9), y.push_back(0.11 * static_cast<double>(i));
    for (const char* mode : {"isotropic", "anisotropic", "hybrid"}) {
        NodeCall call("alGaborNoise", n);
        call.set("anisotropy", mode).set("RMPclampEnable", 0).vary("P", x, 0).vary("P", y, 1);
        const auto lanes = call.run(), scalar = call.run(Path::Scalar), exact = call.run(Path::Double);
        for (size_t i = 0; i < n; ++i) {
            EXPECT_NEAR(lanes[0][i], scalar[0][i], 2e-5) << mode << " " << i;
            EXPECT_NEAR(lanes[0][i], exact[0][i], 2e-4) << mode << " " << i;
        }
    }
}
TEST(AlGaborNoise, huge_points_and_bandwidths_are_finite) {
    for (double x : {1e9, -3e38, 1e-40})
        for (double bandwidth : {-1.0, 0.0, 1.0, 1e30}) {
            const double v = NodeCall("alGaborNoise").set("RMPclampEnable", 0).set("bandwidth", bandwidth).set("P", {x, 0.5, -x}).value();
            EXPECT_TRUE(std::isfinite(v)) << x << ", bandwidth " << bandwidth << " gives " << v;
        }
}
}  // namespace alder
