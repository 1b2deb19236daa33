// alCombineFloat, alCombineColor: identities of the operations, the ends of lerp.
#include "tests/nodes/node_call.h"

namespace alder {
using test::NodeCall;

static double combined(const char* op, double a, double b, double t = 0) {
    return NodeCall("alCombineFloat").set("combineOp", op).set("input1", a).set("input2", b).set("input3", t).value();
}
TEST(AlCombine, arithmetic) {
    EXPECT_EQ(combined("multiply 1*2", 3, 4), 12);
    EXPECT_EQ(combined("add 1+2", 3, 4), 7);
    EXPECT_EQ(combined("divide 1/2", 3, 4), 0.75);
    EXPECT_EQ(combined("subtract 1-2", 3, 4), -1);
    EXPECT_EQ(combined("lerp(1, 2, 3)", 2, 4, 0.25), 2.5);
}
TEST(AlCombine, division_by_zero_follows_IEEE) {
    EXPECT_EQ(combined("divide 1/2", 1, 0), INFINITY);
    EXPECT_EQ(combined("divide 1/2", -1, 0), -INFINITY);
    EXPECT_TRUE(std::isnan(combined("divide 1/2", 0, 0)));
}
TEST(AlCombine, lerp_ends_ignore_the_other_input_and_do_not_extrapolate) {
    EXPECT_EQ(combined("lerp(1, 2, 3)", 5, NAN, 0), 5);
    EXPECT_EQ(combined("lerp(1, 2, 3)", 5, NAN, -3), 5);
    EXPECT_EQ(combined("lerp(1, 2, 3)", NAN, 7, 1), 7);
    EXPECT_EQ(combined("lerp(1, 2, 3)", INFINITY, 7, 42), 7);
}
TEST(AlCombine, cross_product_is_orthogonal_and_dot_and_distance_are_grey) {
    NodeCall call("alCombineColor");
    call.set("input1", {1, 2, 3}).set("input2", {-2, 0.5, 4});
    auto out = call.set("combineOp", "cross(1, 2)").run();
    EXPECT_FLOAT_EQ(out[0][0] * 1 + out[1][0] * 2 + out[2][0] * 3, 0);
    EXPECT_FLOAT_EQ(out[0][0] * -2 + out[1][0] * 0.5 + out[2][0] * 4, 0);
    out = call.set("combineOp", "dot(1, 2)").run();
    for (int i = 0; i < 3; ++i) EXPECT_FLOAT_EQ(out[i][0], 11);
    out = call.set("combineOp", "distance(1 -> 2)").run();
    for (int i = 0; i < 3; ++i) EXPECT_FLOAT_EQ(out[i][0], std::sqrt(9 + 2.25 + 1));
}
TEST(AlCombine, third_input_is_used_by_lerp_alone) {
    const NodeType& type = *find_node("alCombineColor");
    NodeCall call("alCombineColor");
    EXPECT_FALSE(type.uses(call.set("combineOp", "add 1+2").statics(), 2));
    EXPECT_TRUE(type.lazy(call.statics()).empty());
    EXPECT_TRUE(type.uses(call.set("combineOp", "lerp(1, 2, 3)").statics(), 2));
    EXPECT_EQ(type.lazy(call.statics()).size(), 2u);
}
}  // namespace alder
