// Colour models and corrections: round trips and fixed points.
#include "tests/nodes/node_call.h"

#include <random>

namespace alder {
namespace {

using test::NodeCall;
using test::Path;
constexpr Path kPaths[] = {Path::Lanes, Path::Scalar, Path::Double};

TEST(separate_color, combine_undoes_separate) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> u(0, 1);
    for (const char* mode : {"RGB", "HSV", "HSL"})
        for (int i = 0; i < 100; ++i)
            for (Path path : kPaths) {
                const double c[3] = {u(random), i % 5 == 0 ? 0.5 : u(random), i % 7 == 0 ? 0.5 : u(random)};
                NodeCall split("ShaderNodeSeparateColor"), join("ShaderNodeCombineColor");
                const auto parts = split.set("mode", mode).set("Color", {c[0], c[1], c[2]}).run(path);
                const auto back = join.set("mode", mode).set("Red", parts[0][0]).set("Green", parts[1][0]).set("Blue", parts[2][0]).run(path);
                for (int k = 0; k < 3; ++k) EXPECT_NEAR(back[k][0], c[k], 1e-6) << mode << " component " << k;
            }
}

TEST(separate_color, greys_have_no_hue_and_no_saturation) {
    for (const char* mode : {"HSV", "HSL"})
        for (double grey : {0.0, 0.25, 1.0, 7.0}) {
            const auto parts = NodeCall("ShaderNodeSeparateColor").set("mode", mode).set("Color", {grey, grey, grey}).run();
            EXPECT_EQ(parts[0][0], 0) << mode << " " << grey;
            EXPECT_EQ(parts[1][0], 0) << mode << " " << grey;
        }
}

TEST(adjust, defaults_leave_the_colour) {
    const struct { const char* node; const char* input; } rows[] = {{"ShaderNodeHueSaturation", "Color"}, {"ShaderNodeBrightContrast", "Color"}, {"ShaderNodeGamma", "Color"}};
    for (const auto& row : rows)
        for (Path path : kPaths) {
            const auto r = NodeCall(row.node).set(row.input, {0.2, 0.5, 0.7}).run(path);
            EXPECT_NEAR(r[0][0], 0.2, 1e-6) << row.node;
            EXPECT_NEAR(r[2][0], 0.7, 1e-6) << row.node;
        }
}

TEST(adjust, invert_twice_is_the_colour_and_gamma_zero_is_white) {
    EXPECT_NEAR(NodeCall("ShaderNodeInvert").set("Color", {0.3, 0.5, 0.7}).run()[0][0], 0.7, 1e-7);
    EXPECT_NEAR(NodeCall("ShaderNodeInvert").set("Fac", 0).set("Color", {0.3, 0.5, 0.7}).run()[0][0], 0.3, 1e-7);
    const auto white = NodeCall("ShaderNodeGamma").set("Gamma", 0).set("Color", {-0.3, 0, 0.7}).run();
    for (int k = 0; k < 3; ++k) EXPECT_EQ(white[k][0], 1);
    EXPECT_EQ(NodeCall("ShaderNodeGamma").set("Gamma", 2).set("Color", {-0.5, 0, 0.7}).run()[0][0], -0.5);
}

TEST(spectrum, black_bodies_redden_as_they_cool_and_the_ends_are_limits) {
    const auto at = [](double kelvin) {
        const auto r = NodeCall("ShaderNodeBlackbody").set("Temperature", kelvin).run();
        return std::array<double, 3>{r[0][0], r[1][0], r[2][0]};
    };
    double last = 1e9;
    for (double t = 800; t < 12000; t += 100) {
        const auto c = at(t);
        EXPECT_LT(c[0], last) << t;
        last = c[0];
    }
    EXPECT_EQ(at(100)[0], at(799)[0]);
    EXPECT_EQ(at(1e6)[2], at(12000)[2]);
    EXPECT_EQ(NodeCall("ShaderNodeWavelength").set("Wavelength", 300).run()[0][0], 0);
    EXPECT_EQ(NodeCall("ShaderNodeWavelength").set("Wavelength", 800).run()[0][0], 0);
    EXPECT_GT(NodeCall("ShaderNodeWavelength").set("Wavelength", 620).run()[0][0], 0.3);
}

}  // namespace
}  // namespace alder
