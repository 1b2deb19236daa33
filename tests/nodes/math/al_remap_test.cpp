// alRemapFloat, alRemapColor and their colour helpers: identities, hues against the reference table.
#include "nodes/math/al_color-inl.h"
#include "nodes/math/remap-inl.h"
#include "tests/nodes/al_table.h"
#include "tests/nodes/node_call.h"

namespace alder {
using test::NodeCall;

TEST(AlRemap, defaults_are_the_identity_within_the_clamp) {
    for (double x : {0.0, 0.1, 0.5, 0.999, 1.0}) EXPECT_EQ(NodeCall("alRemapFloat").set("input", x).value(), static_cast<float>(x));
    EXPECT_EQ(NodeCall("alRemapFloat").set("input", 2.5).value(), 1);
    EXPECT_EQ(NodeCall("alRemapFloat").set("input", -1).value(), 0);
    const auto out = NodeCall("alRemapColor").set("input", {-0.5, 0.25, 7}).run();
    EXPECT_EQ(out[0][0], -0.5);
    EXPECT_EQ(out[1][0], 0.25);
    EXPECT_EQ(out[2][0], 7);
}
TEST(AlRemap, mask_zero_returns_the_input_whatever_the_rest_holds) {
    EXPECT_EQ(NodeCall("alRemapFloat").set("input", 3).set("mask", 0).set("RMPinputMin", NAN).value(), 3);
    EXPECT_EQ(NodeCall("alRemapColor").set("input", {3, 4, 5}).set("mask", -1).set("gain", NAN).run()[1][0], 4);
}
TEST(AlRemap, equal_input_bounds_end_in_the_clamp) {
    NodeCall call("alRemapFloat");
    call.set("RMPinputMin", 0.5).set("RMPinputMax", 0.5).set("RMPclampMax", 0.75);
    EXPECT_EQ(call.set("input", 0.5).value(), 0.75);    // 0/0
    EXPECT_EQ(call.set("input", 0.25).value(), 0.75);   // -inf; 0·inf in the output range makes NaN of it
}
TEST(AlRemap, saturation_zero_is_grey_of_the_same_luminance) {
    const auto out = NodeCall("alRemapColor").set("input", {0.9, 0.2, 0.4}).set("saturation", 0).run();
    const double y = 0.212671 * 0.9 + 0.715160 * 0.2 + 0.072169 * 0.4;
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(out[i][0], y, 1e-6);
}
TEST(AlRemap, a_whole_turn_of_hue_changes_nothing_and_thirds_rotate_the_channels) {
    auto out = NodeCall("alRemapColor").set("input", {0.9, 0.2, 0.4}).set("hueOffset", 1).run();
    EXPECT_NEAR(out[0][0], 0.9, 1e-5);
    EXPECT_NEAR(out[1][0], 0.2, 1e-5);
    EXPECT_NEAR(out[2][0], 0.4, 1e-5);
    out = NodeCall("alRemapColor").set("input", {0.9, 0.2, 0.4}).set("hueOffset", 1.0 / 3).run();
    EXPECT_NEAR(out[1][0], 0.9, 1e-5);
    EXPECT_NEAR(out[2][0], 0.2, 1e-5);
    EXPECT_NEAR(out[0][0], 0.4, 1e-5);
}
TEST(AlColor, a_hue_just_below_a_turn_is_red_and_not_magenta) {
    const Vec3f red = HWY_NAMESPACE::al_hsv_to_rgb(Vec3f(-1e-9f, 1.0f, 0.8f));
    EXPECT_FLOAT_EQ(red.x, 0.8f);
    EXPECT_NEAR(red.y, 0, 1e-6);
    EXPECT_NEAR(red.z, 0, 1e-6);
}
TEST(AlRemap, bias_and_gain_match_the_reference) {
    int checked = 0;
    for (const auto& c : test::al_cases("helpers")) {
        if (c["function"] != "biasgain") continue;
        const auto& p = c["params"];
        const float got = HWY_NAMESPACE::al_biasgain(test::al_float(p["f"]), test::al_float(p["bias"]), test::al_float(p["gain"]));
        EXPECT_LE(test::al_error(got, test::al_number(c["output"][0])), 2e-4) << c;
        ++checked;
    }
    EXPECT_GT(checked, 10);
}
TEST(AlColor, hue_conversions_match_the_reference) {
    int checked = 0;
    double worst = 0;
    for (const auto& c : test::al_cases("helpers")) {
        const std::string function = c["function"];
        if (function != "rgbToHsv" && function != "hsvToRgb") continue;
        const auto& p = c["params"];
        Vec3f in = test::al_vec(*p.begin());
        const Vec3f got = function == "rgbToHsv" ? HWY_NAMESPACE::al_rgb_to_hsv(in) : HWY_NAMESPACE::al_hsv_to_rgb(in);
        const float turn = in.x - std::floor(in.x);
        if (function == "hsvToRgb" && 6 * turn >= 6) continue;   // where the original gives magenta, see above
        for (int i = 0; i < 3; ++i) {
            const double e = test::al_error(got[i], test::al_number(c["output"][i]));
            EXPECT_LE(e, 2e-4) << c;
            worst = std::max(worst, e);
        }
        ++checked;
    }
    EXPECT_GT(checked, 10);
    RecordProperty("worst_relative", std::to_string(worst));
}
}  // namespace alder
