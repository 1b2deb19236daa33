// Mix: what the factor switches off does not reach the result, and the blend modes keep their identities.
#include "tests/nodes/node_call.h"

namespace alder {
namespace {

using test::NodeCall;
using test::Path;
constexpr Path kPaths[] = {Path::Lanes, Path::Scalar, Path::Double};
const double kNan = std::numeric_limits<double>::quiet_NaN();

NodeCall color_mix(const char* mode) {
    NodeCall call("ShaderNodeMix");
    call.set("data_type", "RGBA").set("blend_type", mode);
    return call;
}
std::vector<double> color(NodeCall& call, Path path = Path::Lanes) {
    const auto r = call.run(path);
    return {r[4][0], r[5][0], r[6][0]};
}

TEST(mix_node, at_factor_zero_the_layer_does_not_matter_in_any_mode) {
    const NodeType& type = *find_node("ShaderNodeMix");
    for (const Item& item : type.params[type.param_index("blend_type")].items)
        for (Path path : kPaths) {
            NodeCall call = color_mix(item.name.c_str());
            call.set("Factor_Float", 0).set("A_Color", {0.2, 0.5, 0.7}).set("B_Color", {0.9, 0.1, 0.4});
            const auto one = color(call, path);
            call.set("B_Color", {kNan, kNan, kNan});
            const auto other = color(call, path);
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(one[c], std::vector<double>({0.2, 0.5, 0.7})[c], 1e-6) << item.name;
                EXPECT_NEAR(other[c], one[c], 1e-6) << item.name << ": layer not evaluated";
            }
        }
}

TEST(mix_node, at_factor_one_mix_is_the_layer_even_where_the_base_was_not_evaluated) {
    for (Path path : kPaths) {
        NodeCall call = color_mix("MIX");
        call.set("Factor_Float", 1).set("A_Color", {kNan, kNan, kNan}).set("B_Color", {0.9, 0.1, 0.4});
        EXPECT_NEAR(color(call, path)[0], 0.9, 1e-6);
        NodeCall number("ShaderNodeMix");
        number.set("Factor_Float", 3).set("A_Float", kNan).set("B_Float", 7);
        EXPECT_EQ(number.value(path), 7);
    }
}

TEST(mix_node, identities_of_blend_modes) {
    const struct { const char* mode; double a, b, want; } rows[] = {{"ADD", 0.3, 0.5, 0.8}, {"SUBTRACT", 0.3, 0.5, -0.2}, {"MULTIPLY", 0.3, 0.5, 0.15}, {"SCREEN", 0.3, 0, 0.3},
        {"SCREEN", 0.3, 1, 1}, {"DIVIDE", 0.3, 0.5, 0.6}, {"DIVIDE", 0.3, 0, 0.3}, {"DIFFERENCE", 0.3, 0.5, 0.2}, {"EXCLUSION", 0.5, 0.3, 0.5}, {"DARKEN", 0.3, 0.5, 0.3},
        {"LIGHTEN", 0.3, 0.5, 0.5}, {"DODGE", 0, 1, 0}, {"DODGE", 0.3, 1, 1}, {"BURN", 0.3, 0, 0}, {"BURN", 1, 0.5, 1}, {"OVERLAY", 0.25, 0.5, 0.25}, {"LINEAR_LIGHT", 0.3, 0.5, 0.3}};
    for (const auto& row : rows)
        for (Path path : kPaths) {
            NodeCall call = color_mix(row.mode);
            call.set("Factor_Float", 1).set("A_Color", {row.a, row.a, row.a}).set("B_Color", {row.b, row.b, row.b});
            EXPECT_NEAR(color(call, path)[1], row.want, 1e-6) << row.mode << " of " << row.a << " and " << row.b;
        }
}

TEST(mix_node, hue_and_colour_of_a_grey_layer_leave_the_base) {
    for (const char* mode : {"HUE", "COLOR"}) {
        NodeCall call = color_mix(mode);
        call.set("Factor_Float", 1).set("A_Color", {0.2, 0.5, 0.7}).set("B_Color", {0.4, 0.4, 0.4});
        EXPECT_NEAR(color(call)[2], 0.7, 1e-6) << mode;
    }
}

TEST(mix_node, lazy_rules_follow_factor_and_mode) {
    const NodeType& type = *find_node("ShaderNodeMix");
    const auto rules = [&](NodeCall& call) { return type.lazy(call.statics()); };
    NodeCall mix = color_mix("MIX");
    EXPECT_EQ(rules(mix).size(), 2u);
    NodeCall burn = color_mix("BURN");
    ASSERT_EQ(rules(burn).size(), 1u);
    EXPECT_EQ(rules(burn)[0].param, type.param_index("B_Color"));
    NodeCall open = color_mix("MIX");
    open.set("clamp_factor", 0);
    ASSERT_EQ(rules(open).size(), 1u);
    EXPECT_EQ(rules(open)[0].when, LazyRule::NeededIfNonZero);
    NodeCall uneven("ShaderNodeMix");
    uneven.set("data_type", "VECTOR").set("factor_mode", "NON_UNIFORM");
    EXPECT_TRUE(rules(uneven).empty());
}

}  // namespace
}  // namespace alder
