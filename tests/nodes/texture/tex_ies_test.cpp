// IES profiles: the photometric types and shorthands for symmetry, and what is no profile.
#include "nodes/texture/ies_profile.h"

#include <gtest/gtest.h>

#include <cmath>

#include "graph/material.h"

namespace alder {
namespace {

/// Candela that come out as 1 for 1 cd.
constexpr double kWatt = 0.0706650768394;

std::string profile(int type, const std::string& vertical, const std::string& horizontal, const std::string& candela, int v, int h, const char* tilt = "NONE") {
    return "IESNA:LM-63-1995\r\n[TEST] x\r\nTILT=" + std::string(tilt) + "\r\n1 1000 1.0 " + std::to_string(v) + " " + std::to_string(h) + " " + std::to_string(type) +
           " 1 0,0,0\r\n1.0 1.0 50\r\n" + vertical + "\r\n" + horizontal + "\r\n" + candela + "\r\n";
}
std::shared_ptr<const IesProfile> parsed(const std::string& text) {
    std::string fault;
    const auto p = parse_ies(text, fault);
    EXPECT_TRUE(p) << fault;
    return p;
}

TEST(Ies, type_c_with_one_horizontal_angle_is_a_body_of_revolution) {
    const auto p = parsed(profile(1, "0 45 90", "0", "10 20 30", 3, 1));
    ASSERT_EQ(p->horizontal.size(), 2u);
    EXPECT_NEAR(p->horizontal[1], 2 * M_PI, 1e-6);
    EXPECT_NEAR(p->vertical[2], M_PI / 2, 1e-6);
    EXPECT_NEAR(p->intensity[1], 20 * kWatt, 1e-6);
    EXPECT_EQ(p->intensity[1], p->intensity[4]);
}
TEST(Ies, type_c_quadrants_and_halves_are_mirrored) {
    const auto p = parsed(profile(1, "0 90", "0 45 90", "1 1 2 2 3 3", 2, 3));
    ASSERT_EQ(p->horizontal.size(), 9u);
    const int expected[9] = {1, 2, 3, 2, 1, 2, 3, 2, 1};
    for (int i = 0; i < 9; ++i) {
        EXPECT_NEAR(p->horizontal[i], i * M_PI / 4, 1e-5);
        EXPECT_NEAR(p->intensity[2 * i], expected[i] * kWatt, 1e-6) << i;
    }
    EXPECT_EQ(parsed(profile(1, "0 90", "0 90 180", "1 1 2 2 3 3", 2, 3))->horizontal.size(), 5u);
    EXPECT_EQ(parsed(profile(1, "0 90", "0 90 180 270", "1 1 2 2 3 3 4 4", 2, 4))->horizontal.size(), 5u) << "360 degrees left out";
    EXPECT_NEAR(parsed(profile(1, "0 90", "90 180 270", "1 1 2 2 3 3", 2, 3))->horizontal[0], 0, 1e-6) << "turned by 90 degrees";
}
TEST(Ies, types_a_and_b_become_type_c) {
    const auto a = parsed(profile(3, "-90 0 90", "0 90", "1 2 3 4 5 6", 3, 2));
    ASSERT_EQ(a->horizontal.size(), 3u);
    EXPECT_NEAR(a->horizontal[0], M_PI / 2, 1e-6);
    EXPECT_NEAR(a->horizontal[2], 3 * M_PI / 2, 1e-6);
    EXPECT_NEAR(a->vertical[0], 0, 1e-6);
    EXPECT_NEAR(a->intensity[0], 4 * kWatt, 1e-6);
    EXPECT_NEAR(a->intensity[3], 1 * kWatt, 1e-6);
    const auto b = parsed(profile(2, "0 90", "0 90", "1 2 3 4", 2, 2));
    ASSERT_EQ(b->horizontal.size(), 3u);
    ASSERT_EQ(b->vertical.size(), 3u);
    EXPECT_NEAR(b->intensity[4], 1 * kWatt, 1e-6) << "the middle is angle 0 both ways";
    EXPECT_NEAR(b->intensity[0], 4 * kWatt, 1e-6);
}
TEST(Ies, tilt_blocks_are_skipped) {
    const auto p = parsed(profile(1, "0 90", "0", "10 20", 2, 1, "INCLUDE\r\n1\r\n2\r\n0 90\r\n1.0 0.5"));
    EXPECT_NEAR(p->intensity[1], 20 * kWatt, 1e-6);
}
TEST(Ies, what_is_no_profile_is_said) {
    for (const std::string& text : {std::string(), std::string("hello"), std::string("a\nTILT=NONE"), std::string("a\nTILT=NONE\n1 2 3"),
                                    profile(7, "0 90", "0", "1 2", 2, 1), profile(1, "0 90", "0", "1", 2, 1), profile(1, "0 90", "0", "1 2", 2000000000, 1),
                                    profile(1, "", "", "", -3, 1), profile(1, "0", "0", "1", 0, 0), std::string("\nTILT=INCLUDE\n1\n2000000000\n")}) {
        std::string fault;
        EXPECT_FALSE(parse_ies(text, fault)) << text;
        EXPECT_FALSE(fault.empty()) << text;
    }
}
TEST(Ies, profiles_are_written_out_in_the_document_or_refused) {
    nlohmann::json doc = {{"nodes", {{"n", {{"type", "ShaderNodeTexIES"}, {"params", {{"ies", profile(1, "0 90 180", "0", "10 20 30", 3, 1)}}}}}}}};
    Diagnostics d;
    const auto m = build_material(doc, {}, d);
    ASSERT_TRUE(m);
    EXPECT_TRUE(m->program({.outputs = {"n"}}, d));
    doc["nodes"]["n"]["params"]["ies"] = {{"text", "no profile"}};
    const auto wrong = build_material(doc, {}, d);
    EXPECT_FALSE(wrong && wrong->program({.outputs = {"n"}}, d));
    ASSERT_FALSE(d.errors.empty());
    EXPECT_EQ(d.errors[0].pointer, "/nodes/n/params/ies");
}

}  // namespace
}  // namespace alder
