// alLayerFloat, alLayerColor: the stack, its top, blend modes by their algebra.
#include "tests/nodes/node_call.h"

namespace alder {
using test::NodeCall;

TEST(AlLayer, alpha_one_shows_the_layer_and_alpha_zero_hides_it) {
    NodeCall call("alLayerFloat");
    call.set("layer1", 0.25).set("layer1a", 1).set("layer2", 0.75).set("layer2a", 0);
    EXPECT_EQ(call.value(), 0.25);
    EXPECT_EQ(call.set("layer2a", 1).value(), 0.75);
    EXPECT_EQ(call.set("layer2enabled", 0).value(), 0.25);
    EXPECT_EQ(call.set("layer2enabled", 1).set("layer2a", 2).value(), 1.25);   // not clamped
}
TEST(AlLayer, a_layer_with_alpha_zero_may_hold_anything) {
    NodeCall call("alLayerColor", 3);
    call.set("layer1", {0.5, 0.5, 0.5}).set("layer1a", 1).vary("layer2a", {0, 1, 0}).vary("layer2", {NAN, 0.25, INFINITY});
    const auto out = call.run();
    EXPECT_EQ(out[0][0], 0.5);
    EXPECT_EQ(out[0][1], 0.25);
    EXPECT_EQ(out[0][2], 0.5);
}
TEST(AlLayer, layers_above_the_top_have_no_effect) {
    const NodeType& type = *find_node("alLayerFloat");
    Statics s = NodeCall("alLayerFloat").statics();
    s.zero.assign(type.params.size(), true);
    s.zero[type.param_index("layer3a")] = false;
    EXPECT_TRUE(type.uses(s, type.param_index("layer2")));
    EXPECT_TRUE(type.uses(s, type.param_index("layer3")));
    EXPECT_FALSE(type.uses(s, type.param_index("layer4")));
    EXPECT_FALSE(type.uses(s, type.param_index("layer3name")));
    s.enums[type.param_index("layer3enabled")] = 0;
    EXPECT_FALSE(type.uses(s, type.param_index("layer3")));
}

static double blended(const char* mode, double below, double layer, bool clamp) {
    NodeCall call("alLayerColor");
    call.set("layer1", {below, below, below}).set("layer1a", 1).set("layer2", {layer, layer, layer}).set("layer2a", 1).set("layer2blend", mode);
    const auto out = call.set("clamp_result", clamp).run();
    for (int i = 1; i < 3; ++i) EXPECT_TRUE(out[i][0] == out[0][0] || (std::isnan(out[i][0]) && std::isnan(out[0][0])));
    return out[0][0];
}
TEST(AlLayer, modes_have_their_neutral_values) {
    const std::pair<const char*, double> neutral[] = {{"Multiply", 1}, {"Add", 0}, {"Subtract", 1}, {"Difference", 0}, {"Exclusion", 0},
                                                      {"Screen", 0}, {"Overlay", 0.5}, {"Soft Light", 0.5}, {"Hard Light", 0.5}, {"Color Dodge", 0},
                                                      {"Color Burn", 1}, {"Linear Dodge", 0}, {"Linear Burn", 1}, {"Linear Light", 0.5},
                                                      {"Vivid Light", 0.5}, {"Pin Light", 0.5}};
    for (auto [mode, layer] : neutral)
        for (double below : {0.1, 0.3, 0.5, 0.6, 0.95}) EXPECT_NEAR(blended(mode, below, layer, true), below, 1e-6) << mode << " over " << below;
}
TEST(AlLayer, symmetric_modes_are_symmetric_and_pairs_are_mirrored) {
    for (const char* mode : {"Lighten", "Darken", "Multiply", "Average", "Add", "Subtract", "Difference", "Negation", "Exclusion", "Screen", "Phoenix"})
        for (double a : {-0.5, 0.2, 0.7, 1.5})
            for (double b : {0.1, 0.9, 3.0}) EXPECT_NEAR(blended(mode, a, b, false), blended(mode, b, a, false), 1e-6) << mode;
    for (double a : {0.2, 0.7})
        for (double b : {0.1, 0.9}) {
            EXPECT_EQ(blended("Hard Light", a, b, true), blended("Overlay", b, a, true));
            EXPECT_EQ(blended("Glow", a, b, true), blended("Reflect", b, a, true));
        }
}
TEST(AlLayer, clamp_result_limits_the_modes_of_its_table) {
    EXPECT_EQ(blended("Add", 0.8, 0.7, true), 1);
    EXPECT_NEAR(blended("Add", 0.8, 0.7, false), 1.5, 1e-6);
    EXPECT_EQ(blended("Linear Burn", 0.2, 0.3, true), 0);
    EXPECT_NEAR(blended("Linear Burn", 0.2, 0.3, false), -0.5, 1e-6);
    EXPECT_EQ(blended("Color Dodge", 0.8, 0.9, true), 1);
    EXPECT_NEAR(blended("Color Dodge", 0.8, 0.9, false), 8, 1e-4);
    EXPECT_EQ(blended("Color Dodge", 0.8, 1, false), 1);
    EXPECT_EQ(blended("Color Burn", 0.1, 0.05, false), 0);   // regardless of clamp_result
    EXPECT_EQ(blended("Color Burn", 0.5, 0, false), 0);
    EXPECT_TRUE(std::isnan(blended("Soft Light", -0.5, 0.75, true)));
    EXPECT_EQ(blended("Multiply", 3, 2, true), 6);
}
}  // namespace alder
