// alFresnelConductor: reflectance at the ends of the angle, the named metals.
#include "tests/nodes/node_call.h"

namespace alder {
using test::NodeCall;

static NodeCall facing(double cosine) {
    NodeCall call("alFresnelConductor");
    call.global(Global::Nf, {0, 0, 1}).global(Global::Rd, {std::sqrt(1 - cosine * cosine), 0, -cosine});
    return call;
}
TEST(AlFresnelConductor, head_on_is_the_reflectivity_and_grazing_is_one) {
    auto out = facing(1).set("material", "custom").set("reflectivity", {0.2, 0.5, 0.9}).set("edgetint", {0.1, 0.5, 0.9}).run();
    EXPECT_NEAR(out[0][0], 0.2, 1e-5);
    EXPECT_NEAR(out[1][0], 0.5, 1e-5);
    EXPECT_NEAR(out[2][0], 0.9, 1e-5);
    out = facing(0).set("material", "custom").set("reflectivity", {0.2, 0.5, 0.9}).set("edgetint", {0.1, 0.5, 0.9}).run();
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(out[i][0], 1, 1e-6);
}
TEST(AlFresnelConductor, named_metals_reflect_their_fits_head_on_and_ignore_the_custom_colours) {
    const auto gold = facing(1).set("material", "gold").set("reflectivity", {0.1, 0.1, 0.1}).run();
    EXPECT_NEAR(gold[0][0], 0.99, 1e-5);
    EXPECT_NEAR(gold[1][0], 0.791587, 1e-5);
    EXPECT_NEAR(gold[2][0], 0.3465, 1e-5);
    NodeCall call("alFresnelConductor");
    EXPECT_FALSE(find_node("alFresnelConductor")->uses(call.statics(), 2));
    EXPECT_TRUE(find_node("alFresnelConductor")->uses(call.set("material", "custom").statics(), 2));
}
TEST(AlFresnelConductor, reflectance_stays_between_zero_and_one_for_any_colour) {
    for (double r : {-1.0, 0.0, 0.04, 0.5, 0.99, 1.0, 50.0})
        for (double g : {0.0, 0.5, 1.0})
            for (double c : {0.001, 0.1, 0.5, 1.0}) {
                const double v = facing(c).set("material", "custom").set("reflectivity", {r, r, r}).set("edgetint", {g, g, g}).value();
                EXPECT_TRUE(v >= -1e-6 && v <= 1 + 1e-6) << "r " << r << " g " << g << " cosine " << c << ": " << v;
            }
}
}  // namespace alder
