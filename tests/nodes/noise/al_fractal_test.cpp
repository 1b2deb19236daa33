// alFractal: laws of its noise, its arithmetic against the reference table with that table's noise values.
#include "nodes/math/remap-inl.h"
#include "nodes/noise/al_fractal-inl.h"
#include "nodes/noise/arnold_basis-inl.h"
#include "tests/nodes/al_table.h"
#include "tests/nodes/node_call.h"

#include <random>

namespace alder {
using test::NodeCall;
using test::Path;

struct ReplayedNoise {
    const test::BasisReplay& calls;
    float perlin4(Vec3f p, float t) const { return test::al_float(calls.next("perlin4", {p.x, p.y, p.z, t})); }
    Vec3f vnoise3(Vec3f p) const { return test::al_vec(calls.next("vnoise3", {p.x, p.y, p.z})); }
    Vec3f vnoise4(Vec3f p, float t) const { return test::al_vec(calls.next("vnoise4", {p.x, p.y, p.z, t})); }
};
static float remapped(const nlohmann::json& p, float x) {
    const char* names[12] = {"RMPinputMin", "RMPinputMax", "RMPcontrast", "RMPcontrastPivot", "RMPbias", "RMPgain",
                             "RMPoutputMin", "RMPoutputMax", "RMPclampEnable", "RMPthreshold", "RMPclampMin", "RMPclampMax"};
    float value[12];
    Channel<float> in[12];
    for (int i = 0; i < 12; ++i) value[i] = test::al_float(p[names[i]]), in[i] = {&value[i], 0};
    const OpCall<float> call{in, nullptr, nullptr, nullptr, 1};
    return HWY_NAMESPACE::al_remap(HWY_NAMESPACE::Lanes<float>{call, 0}, 0, x);
}
static Vec3f point_of(const nlohmann::json& c) {
    const auto& p = c["params"];
    const auto& g = c["globals"];
    if (c.contains("links")) return test::al_vec(p["P"]);
    if (p["space"] == "world") return test::al_vec(g["P"]);
    if (p["space"] == "UV") return {test::al_float(g["u"]), test::al_float(g["v"]), 0};
    if (p["space"] == "Pref" && c.contains("userData") && c["userData"].contains("Pref")) return test::al_vec(c["userData"]["Pref"]);
    return test::al_vec(g["Po"]);
}

TEST(AlFractal, arithmetic_matches_the_reference_with_its_noise_values) {
    double worst = 0;
    for (const auto& c : test::al_cases("alFractal")) {
        const auto& p = c["params"];
        const test::BasisReplay calls(c["basis"]);
        const HWY_NAMESPACE::AlFractalParams<float> f = {test::al_float(p["time"]), test::al_float(p["distortion"]), test::al_float(p["lacunarity"]),
                                                         test::al_float(p["gain"]), p["octaves"].get<int>(), p["turbulent"].get<bool>()};
        const Vec3f at = point_of(c) * test::al_float(p["frequency"]) * test::al_vec(p["scale"]);
        Vec3f got;
        if (p["mode"] == "scalar") {
            const float n = remapped(p, HWY_NAMESPACE::al_fractal_sum<float>(ReplayedNoise{calls}, at, f));
            got = HWY_NAMESPACE::lerp(test::al_vec(p["color1"]), test::al_vec(p["color2"]), n);
        } else {
            const Vec3f n = HWY_NAMESPACE::al_fractal_sum<Vec3f>(ReplayedNoise{calls}, at, f);
            got = {remapped(p, n.x), remapped(p, n.y), remapped(p, n.z)};
        }
        EXPECT_TRUE(calls.finished()) << "calls of noise are missing in " << c;
        for (int i = 0; i < 3; ++i) worst = std::max(worst, test::al_error(got[i], test::al_number(c["output"][i])));
        ASSERT_LE(worst, 2e-4) << c;
    }
    RecordProperty("worst_relative", std::to_string(worst));
}

TEST(ArnoldBasis, is_zero_at_lattice_points) {
    const HWY_NAMESPACE::ArnoldBasis noise;
    for (float x : {-7.0f, 0.0f, 3.0f, 1e5f, 8388608.0f, 1e20f}) {
        EXPECT_EQ(noise.perlin4(Vec3f(x, 2, -5), 4.0f), 0);
        const Vec3f v = noise.vnoise3(Vec3f(1, x, 9)), w = noise.vnoise4(Vec3f(1, x, 9), -2.0f);
        for (int i = 0; i < 3; ++i) EXPECT_TRUE(v[i] == 0 && w[i] == 0) << x;
    }
}
TEST(ArnoldBasis, has_mean_zero_stays_in_range_and_its_channels_are_independent) {
    const HWY_NAMESPACE::ArnoldBasis noise;
    std::mt19937 rng(3);
    std::uniform_real_distribution<float> at(-1000, 1000);
    const int n = 40000;
    double mean = 0, mean3[3] = {}, square[3] = {}, product[3] = {}, largest = 0, square4 = 0;
    for (int i = 0; i < n; ++i) {
        const Vec3f p(at(rng), at(rng), at(rng));
        const float a = noise.perlin4(p, at(rng));
        const Vec3f v = noise.vnoise3(p);
        mean += a, square4 += a * a, largest = std::max({largest, std::fabs(static_cast<double>(a)), std::fabs(static_cast<double>(v.x))});
        for (int k = 0; k < 3; ++k) mean3[k] += v[k], square[k] += v[k] * v[k], product[k] += v[k] * v[(k + 1) % 3];
    }
    EXPECT_NEAR(mean / n, 0, 5 * std::sqrt(square4 / n / n));
    for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(mean3[k] / n, 0, 5 * std::sqrt(square[k] / n / n));
        EXPECT_NEAR(product[k] / std::sqrt(square[k] * square[(k + 1) % 3]), 0, 5 / std::sqrt(n)) << "channels " << k << ", " << (k + 1) % 3;
    }
    EXPECT_GT(largest, 0.6);
    EXPECT_LT(largest, 1.1);
}
TEST(ArnoldBasis, is_continuous_with_its_first_derivative_across_the_lattice) {
    const HWY_NAMESPACE::ArnoldBasis noise;
    const double h = 1e-4;
    for (int i = 0; i < 200; ++i) {
        const double y = 0.37 + 0.011 * i, z = -3.3 + 0.07 * i, x = i % 20;
        const auto f = [&](double dx) { return noise.perlin4(HWY_NAMESPACE::Vec3<double>(x + dx, y, z), 0.3); };
        EXPECT_NEAR(f(-1e-9), f(1e-9), 1e-7);
        EXPECT_NEAR((f(0) - f(-h)) / h, (f(h) - f(0)) / h, 5e-3) << "slope at x = " << x;
    }
}
TEST(ArnoldBasis, a_whole_time_takes_the_short_way_to_the_same_value) {
    const HWY_NAMESPACE::ArnoldBasis noise;
    for (int i = 0; i < 50; ++i) {
        const Vec3f p(0.13f * i, 1.7f - 0.31f * i, 0.71f * i);
        const HWY_NAMESPACE::LatticeAxis<float> a[4] = {HWY_NAMESPACE::lattice_axis(p.x), HWY_NAMESPACE::lattice_axis(p.y),
                                                        HWY_NAMESPACE::lattice_axis(p.z), HWY_NAMESPACE::lattice_axis(2.0f)};
        EXPECT_EQ(noise.perlin4(p, 2.0f), HWY_NAMESPACE::perlin(a));
    }
}
TEST(AlFractal, huge_and_undefined_points_give_a_finite_colour_on_every_path) {
    for (const char* mode : {"scalar", "vector"})
        for (double x : {1e9, -1e30, 3e38, static_cast<double>(INFINITY), static_cast<double>(NAN)})
            for (Path path : {Path::Lanes, Path::Scalar, Path::Double}) {
                const auto out = NodeCall("alFractal").set("mode", mode).set("P", {x, 0.5, 0.25}).set("distortion", 1).run(path);
                for (const auto& channel : out) EXPECT_TRUE(std::isfinite(channel[0])) << mode << " at " << x;
            }
}
TEST(AlFractal, lanes_equal_scalar_and_octaves_add_detail) {
    const size_t n = 256;
    std::vector<double> x;
    for (size_t i = 0; i < n; ++i) x.push_back(0.01 * static_cast<double>(i * i) - 50);
    NodeCall call("alFractal", n);
    call.vary("P", x).set("RMPclampEnable", 0).set("distortion", 0.5);
    const auto lanes = call.run(), scalar = call.run(Path::Scalar), exact = call.run(Path::Double);
    for (size_t i = 0; i < n; ++i) {
        EXPECT_NEAR(lanes[0][i], scalar[0][i], 1e-3);   // eight octaves magnify the rounding of the point by 2.121^7
        EXPECT_NEAR(scalar[0][i], exact[0][i], 1e-2);
    }
    EXPECT_NE(call.set("octaves", 1).run()[0], lanes[0]);
    const auto none = call.set("octaves", 0).run();
    for (double v : none[0]) EXPECT_EQ(v, 0);
}
}  // namespace alder
