// alPattern: the three profiles.
#include "tests/nodes/node_call.h"

namespace alder {
using test::NodeCall;

static double at(const char* shape, double x, double offset = 0) {
    return NodeCall("alPattern").set("shape", shape).set("axis", "Y").set("frequency", 2).set("offset", offset).set("P", {9, x, 7}).set("RMPclampEnable", 0).value();
}
TEST(AlPattern, profiles) {
    EXPECT_NEAR(at("sine", 0.25), std::sin(0.5), 1e-6);
    EXPECT_NEAR(at("sine", -0.25), -std::sin(0.5), 1e-6);
    EXPECT_EQ(at("square", 0.25), 1);
    EXPECT_EQ(at("square", -0.25), 0);
    EXPECT_EQ(at("square", 0), 0);
    EXPECT_NEAR(at("saw", 0.5), 0.25, 1e-6);
    EXPECT_NEAR(at("saw", -0.5), 0.75, 1e-6);
    EXPECT_NEAR(at("saw", 0.5 + 2 * 5), 0.25, 1e-6);   // period 4, frequency 2
    EXPECT_NEAR(at("sine", 0.25, 1.5), std::sin(2.0), 1e-6);
}
TEST(AlPattern, the_default_clamp_cuts_the_lower_half_of_the_sine) {
    EXPECT_EQ(NodeCall("alPattern").set("P", {-0.1, 0, 0}).value(), 0);
    EXPECT_NEAR(NodeCall("alPattern").set("P", {0.1, 0, 0}).value(), std::sin(0.5), 1e-6);
}
TEST(AlPattern, saw_stays_in_the_unit_interval) {
    for (double x : {-1e6, -3.99, -1e-9, 0.0, 3.999, 1e7, 1e20}) {
        const double v = at("saw", x);
        EXPECT_TRUE(v >= 0 && v <= 1) << x << ": " << v;
    }
}
}  // namespace alder
