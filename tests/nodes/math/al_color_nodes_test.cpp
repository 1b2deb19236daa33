// alColorSpace, alBlackbody, alJitterColor: anchor values, laws, the jitter's arithmetic against the reference table.
#include "nodes/math/jitter-inl.h"
#include "nodes/noise/cell_hash-inl.h"
#include "tests/nodes/al_table.h"
#include "tests/nodes/node_call.h"

namespace alder {
using test::NodeCall;
using test::Path;

TEST(AlColorSpace, anchors_of_the_curves) {
    const auto linear = [](const char* space, double x) { return NodeCall("alColorSpace").set("input", {x, x, x}).set("sourceSpace", space).value(); };
    EXPECT_EQ(linear("sRGB", 0), 0);
    EXPECT_EQ(linear("sRGB", 1), 1);
    EXPECT_EQ(linear("sRGB", 3), 3);
    EXPECT_NEAR(linear("sRGB", 0.5), 0.21404114, 1e-7);
    EXPECT_NEAR(linear("Cineon", 685.0 / 1023), 1, 1e-6);   // reference white
    EXPECT_NEAR(linear("Cineon", 95.0 / 1023), 0, 1e-6);    // reference black
    EXPECT_EQ(linear("Cineon", 0), 0);
    EXPECT_NEAR(linear("LogC", 0.391007), 0.18, 1e-4);      // ARRI: 18 % grey
    EXPECT_NEAR(linear("LogC", 0.092809), 0, 1e-7);
    EXPECT_LT(linear("LogC", 0), 0);
}

TEST(AlBlackbody, channels_order_with_temperature_and_edges_are_safe) {
    NodeCall call("alBlackbody");
    call.set("physicalIntensity", 0);
    const auto at = [&](double kelvin) { return call.set("temperature", kelvin).run(); };
    const auto red = at(1500), white = at(6504), blue = at(12000);
    EXPECT_GT(red[0][0], red[1][0]);
    EXPECT_GT(red[1][0], red[2][0]);
    EXPECT_NEAR(white[0][0] / white[1][0], 1, 0.08);
    EXPECT_NEAR(white[2][0] / white[1][0], 1, 0.08);
    EXPECT_GT(blue[2][0], blue[0][0]);
    EXPECT_EQ(at(15000), at(1e9));
    EXPECT_EQ(at(4000.0), at(4000.75));   // whole kelvin
    for (double kelvin : {-5.0, 0.0, 1.0, -1e30, static_cast<double>(NAN)})
        for (const auto& channel : at(kelvin)) EXPECT_EQ(channel[0], 0) << kelvin;
}
TEST(AlBlackbody, physical_intensity_is_the_fourth_power) {
    NodeCall call("alBlackbody");
    call.set("physicalIntensity", 1).set("physicalExposure", 0);
    const double ratio = call.set("temperature", 20000).value() / call.set("temperature", 15000).value();
    EXPECT_NEAR(ratio, std::pow(20.0 / 15, 4), 1e-5);
    EXPECT_NEAR(call.set("physicalExposure", -3).value() / call.set("physicalExposure", 0).value(), 0.125, 1e-6);
}

TEST(AlJitterColor, arithmetic_matches_the_reference_with_its_noise_values) {
    double worst = 0;
    for (const auto& c : test::al_cases("alJitterColor")) {
        const auto& p = c["params"];
        const test::BasisReplay basis(c["basis"]);
        const float signal = test::al_float(p["signal"]);
        float n[3];
        for (int i = 0; i < 3; ++i) n[i] = test::al_float(basis.next("cellnoise2", {signal}));
        const auto between = [&](const char* lo, const char* hi, float t) { return HWY_NAMESPACE::lerp(test::al_float(p[lo]), test::al_float(p[hi]), t); };
        const Vec3f got = HWY_NAMESPACE::jitter_color(test::al_vec(p["input"]), between("minSaturation", "maxSaturation", n[0]),
                                                      between("minHueOffset", "maxHueOffset", n[1]), between("minGain", "maxGain", n[2]),
                                                      p["clamp"].get<bool>());
        for (int i = 0; i < 3; ++i) worst = std::max(worst, test::al_error(got[i], test::al_number(c["output"][i])));
        EXPECT_LE(worst, 2e-4) << c;
    }
    RecordProperty("worst_relative", std::to_string(worst));
}
TEST(AlJitterColor, one_choice_for_each_whole_number_and_all_choices_within_the_limits) {
    const size_t n = 4096;
    std::vector<double> signal, fraction;
    for (size_t i = 0; i < n; ++i) signal.push_back(static_cast<double>(i) - 1000), fraction.push_back(signal.back() + 0.75);
    NodeCall a("alJitterColor", n);
    a.set("input", {0.4, 0.4, 0.4}).set("clamp", 0).vary("signal", signal);
    const auto whole = a.run()[0];
    EXPECT_EQ(whole, a.vary("signal", fraction).run()[0]);
    EXPECT_EQ(whole, a.vary("signal", signal).run(Path::Scalar)[0]);
    double sum = 0, least = 10, most = 0;
    for (double v : whole) sum += v / 0.4, least = std::min(least, v / 0.4), most = std::max(most, v / 0.4);
    EXPECT_NEAR(sum / n, 1, 0.02);   // grey: gain alone, uniform in 0.5 ... 1.5; standard error 0.0045
    EXPECT_NEAR(least, 0.5, 0.005);
    EXPECT_NEAR(most, 1.5, 0.005);
}
TEST(CellNoise2, is_uniform_and_defined_everywhere) {
    int count[16] = {};
    for (int x = -300; x < 300; ++x)
        for (int y = 99900; y < 100000; ++y) ++count[static_cast<int>(16 * HWY_NAMESPACE::cell_noise2(x + 0.5f, y + 0.25f))];
    for (int c : count) EXPECT_NEAR(c, 60000 / 16, 300);   // five standard deviations
    for (float x : {-0.0f, 1e10f, -1e38f, INFINITY, NAN}) {
        const float v = HWY_NAMESPACE::cell_noise2(x, 0.0f);
        EXPECT_TRUE(v >= 0 && v < 1) << x;
    }
    EXPECT_EQ(HWY_NAMESPACE::cell_noise2(-0.0f, 0.0f), HWY_NAMESPACE::cell_noise2(0.5f, 0.5f));
}
}  // namespace alder
