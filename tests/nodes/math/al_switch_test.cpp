// alSwitchFloat, alSwitchColor: which input is picked.
#include "tests/nodes/node_call.h"

namespace alder {
using test::NodeCall;
using test::Path;

class AlSwitch : public testing::TestWithParam<Path> {
  protected:
    static double picked(double mix, double threshold, Path path) {
        NodeCall call("alSwitchFloat");
        for (int i = 0; i < 8; ++i) call.set(std::string("input") + char('A' + i), 10.0 * i);
        return call.set("mix", mix).set("threshold", threshold).value(path) / 10;
    }
};

TEST_P(AlSwitch, rounds_to_nearest_and_halves_upward) {
    const std::pair<double, double> cases[] = {{0, 0}, {0.49, 0}, {0.5, 1}, {1.5, 2}, {2.5, 3}, {2.49, 2}, {6.6, 7}, {-0.5, 0}, {-3, 0}, {7.5, 7}, {100, 7}};
    for (auto [mix, index] : cases) EXPECT_EQ(picked(mix, 0.5, GetParam()), index) << "mix " << mix;
}
TEST_P(AlSwitch, threshold_zero_always_steps_up_and_above_one_never) {
    EXPECT_EQ(picked(2, 0, GetParam()), 3);
    EXPECT_EQ(picked(2.1, -5, GetParam()), 3);
    EXPECT_EQ(picked(2.999, 1.5, GetParam()), 2);
}
TEST_P(AlSwitch, huge_and_nan_mixes_have_a_defined_end) {
    EXPECT_EQ(picked(NAN, 0.5, GetParam()), 0);
    EXPECT_EQ(picked(-1e30, 0.5, GetParam()), 0);
    EXPECT_EQ(picked(-INFINITY, 0.5, GetParam()), 0);
    EXPECT_EQ(picked(1e30, 0.5, GetParam()), 7);
    EXPECT_EQ(picked(INFINITY, 0.5, GetParam()), 7);
    EXPECT_EQ(picked(2147483648.0, 0.5, GetParam()), 7);
    EXPECT_EQ(picked(3.7, NAN, GetParam()), 3);
}
TEST_P(AlSwitch, inputs_not_picked_may_hold_anything) {
    NodeCall call("alSwitchColor");
    for (char c = 'A'; c <= 'H'; ++c)
        if (c != 'D') call.set(std::string("input") + c, {NAN, INFINITY, NAN});
    const auto out = call.set("inputD", {0.25, 0.5, 0.75}).set("mix", 3.2).run(GetParam());
    EXPECT_EQ(out[0][0], 0.25);
    EXPECT_EQ(out[1][0], 0.5);
    EXPECT_EQ(out[2][0], 0.75);
}
INSTANTIATE_TEST_SUITE_P(Paths, AlSwitch, testing::Values(Path::Lanes, Path::Scalar, Path::Double));
}  // namespace alder
