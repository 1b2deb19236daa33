// Baked ramps and curves: they pass where they should, keep their bounds, and refuse what is no ramp or curve.
#include <gtest/gtest.h>

#include <cmath>

#include "nodes/color/curve_table.h"
#include "nodes/color/ramp_table.h"

namespace alder {
namespace {

std::shared_ptr<const RampTable> ramp(const std::string& json) {
    std::vector<std::string> errors;
    auto t = bake_ramp(json, errors);
    EXPECT_TRUE(t) << (errors.empty() ? "" : errors[0]);
    return t;
}
std::shared_ptr<const CurveTable> curve(const std::string& json, CurveKind kind = CurveKind::Float) {
    std::vector<std::string> errors;
    auto t = bake_curves(json, kind, errors);
    EXPECT_TRUE(t) << (errors.empty() ? "" : errors[0]);
    return t;
}

TEST(ramp_table, the_default_runs_from_black_to_white) {
    const auto t = ramp("null");
    for (int i = 0; i < kRampSize; ++i) EXPECT_NEAR(t->rgba[1][i], i / 256.0, 1e-6);
    EXPECT_EQ(t->rgba[3][100], 1);
}

TEST(ramp_table, stops_are_met_and_order_in_the_document_does_not_matter) {
    for (const char* mode : {"LINEAR", "EASE", "CONSTANT"}) {
        const std::string head = std::string(R"({"interpolation": ")") + mode + R"(", "elements": [)";
        const std::string a = R"({"position": 0.25, "color": [1, 0, 0, 0.5]})", b = R"({"position": 0.75, "color": [0, 1, 0, 1]})";
        const auto one = ramp(head + a + "," + b + "]}"), two = ramp(head + b + "," + a + "]}");
        EXPECT_EQ(one->rgba, two->rgba) << mode;
        EXPECT_EQ(one->rgba[0][0], 1) << mode;
        EXPECT_EQ(one->rgba[0][64], 1) << mode;
        EXPECT_EQ(one->rgba[1][192], 1) << mode;
        EXPECT_EQ(one->rgba[1][256], 1) << mode;
        EXPECT_NEAR(one->rgba[0][128], std::string(mode) == "CONSTANT" ? 1 : 0.5, 1e-6) << mode;
    }
}

TEST(ramp_table, splines_stay_between_zero_and_one) {
    for (const char* mode : {"CARDINAL", "B_SPLINE"}) {
        const auto t = ramp(std::string(R"({"interpolation": ")") + mode +
                            R"(", "elements": [{"position": 0.1, "color": [0,1,0,1]}, {"position": 0.2, "color": [1,0,1,0]}, {"position": 0.3, "color": [1,1,0,0]}, {"position": 0.9, "color": [0,0,1,1]}]})");
        for (const auto& channel : t->rgba)
            for (float x : channel) EXPECT_TRUE(x >= 0 && x <= 1) << mode << " " << x;
    }
}

TEST(ramp_table, near_takes_the_short_way_round_the_hue_circle_and_far_the_long_one) {
    const std::string stops = R"("elements": [{"position": 0, "color": [1, 0, 0.2, 1]}, {"position": 1, "color": [1, 0.2, 0, 1]}]})";
    const auto near = ramp(R"({"color_mode": "HSV", "hue_interpolation": "NEAR", )" + stops);
    const auto far = ramp(R"({"color_mode": "HSV", "hue_interpolation": "FAR", )" + stops);
    EXPECT_GT(near->rgba[0][128], 0.99f);  // by way of red
    EXPECT_LT(far->rgba[0][128], 0.01f);   // by way of cyan
}

TEST(ramp_table, faults_are_named) {
    for (const char* bad : {"[1]", R"({"elements": []})", R"({"elements": [{"position": 0}]})", R"({"interpolation": "CUBIC"})", R"({"elements": [{"position": 0, "color": [1, 2]}]})", "{"}) {
        std::vector<std::string> errors;
        EXPECT_FALSE(bake_ramp(bad, errors)) << bad;
        ASSERT_FALSE(errors.empty()) << bad;
        EXPECT_EQ(errors[0].rfind("color_ramp", 0), 0u) << errors[0];
    }
}

TEST(curve_table, the_default_is_the_diagonal) {
    for (CurveKind kind : {CurveKind::Float, CurveKind::Vector, CurveKind::Rgb}) {
        const auto t = curve("null", kind);
        for (const auto& channel : t->channels)
            for (int i = 0; i < kCurveSize; ++i) {
                const double x = t->min_x + i / 256.0 * (t->max_x - t->min_x);
                EXPECT_NEAR(channel[i], x, 2e-6);
            }
    }
}

TEST(curve_table, vector_handles_give_straight_lines_and_heights_are_not_clipped) {
    const auto t = curve(R"({"curves": [[{"location": [0, -1], "handle_type": "VECTOR"}, {"location": [0.5, 2], "handle_type": "VECTOR"}, {"location": [1, 0], "handle_type": "VECTOR"}]]})");
    EXPECT_NEAR(t->channels[0][64], 0.5, 1e-5);
    EXPECT_NEAR(t->channels[0][128], 2, 1e-5);
    EXPECT_NEAR(t->channels[0][192], 1, 1e-5);
}

TEST(curve_table, clamped_handles_do_not_overshoot) {
    const auto t = curve(R"({"curves": [[{"location": [0, 0], "handle_type": "AUTO_CLAMPED"}, {"location": [0.5, 1], "handle_type": "AUTO_CLAMPED"}, {"location": [0.6, 0.2], "handle_type": "AUTO_CLAMPED"}, {"location": [1, 0.2], "handle_type": "AUTO_CLAMPED"}]]})");
    for (float y : t->channels[0]) EXPECT_TRUE(y >= -1e-5f && y <= 1 + 1e-5f) << y;
}

TEST(curve_table, the_combined_curve_goes_first) {
    const std::string diagonal = R"([{"location": [0, 0], "handle_type": "VECTOR"}, {"location": [1, 1], "handle_type": "VECTOR"}])";
    const std::string falling = R"([{"location": [0, 1], "handle_type": "VECTOR"}, {"location": [1, 0], "handle_type": "VECTOR"}])";
    const std::string half = R"([{"location": [0, 0], "handle_type": "VECTOR"}, {"location": [1, 0.5], "handle_type": "VECTOR"}])";
    const auto t = curve(R"({"curves": [)" + half + "," + diagonal + "," + falling + "," + falling + "]}", CurveKind::Rgb);
    EXPECT_NEAR(t->channels[0][64], 0.375, 1e-5);
    EXPECT_NEAR(t->channels[1][64], 0.75, 1e-5);
    EXPECT_NEAR(t->channels[2][64], 0.25, 1e-5);
}

TEST(curve_table, faults_are_named) {
    for (const char* bad : {"3", R"({"curves": [[]]})", R"({"curves": []})", R"({"curves": [[{"location": [0, 0]}, {"location": [1]}]]})", R"({"extend": "UP"})"}) {
        std::vector<std::string> errors;
        EXPECT_FALSE(bake_curves(bad, CurveKind::Float, errors)) << bad;
        ASSERT_FALSE(errors.empty()) << bad;
        EXPECT_EQ(errors[0].rfind("mapping", 0), 0u) << errors[0];
    }
}

}  // namespace
}  // namespace alder
