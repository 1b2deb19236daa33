// Gabor Texture: ranges, and what its parameters mean.
#include "tests/nodes/node_call.h"

namespace alder {
using test::NodeCall;
using test::Path;

static NodeCall gabor(const char* type, size_t points, double anisotropy = 1) {
    NodeCall call("ShaderNodeTexGabor", points);
    std::vector<double> x, y, z;
    for (size_t i = 0; i < points; ++i) {
        x.push_back(0.37 * static_cast<double>(i) - 9);
        y.push_back(0.11 * static_cast<double>(i * i % 97));
        z.push_back(0.23 * static_cast<double>(i % 41));
    }
    call.set("gabor_type", type).set("Anisotropy", anisotropy).set("Scale", 1).vary("Vector", x, 0).vary("Vector", y, 1).vary("Vector", z, 2);
    return call;
}
TEST(TexGabor, value_has_mean_one_half_and_stays_near_the_unit_interval) {
    for (const char* type : {"2D", "3D"}) {
        const auto r = gabor(type, 2000, 0.5).run();
        double sum = 0;
        for (size_t i = 0; i < 2000; ++i) {
            sum += r[0][i];
            EXPECT_TRUE(r[0][i] > -0.3 && r[0][i] < 1.3) << type << ": " << r[0][i];
            EXPECT_TRUE(r[1][i] >= 0 && r[1][i] <= 1) << type << ": " << r[1][i];
            EXPECT_NEAR(r[0][i], 0.5 - 0.5 * r[2][i] * std::sin(2 * M_PI * r[1][i]), 2e-5) << type << ": the value is intensity times sine of the phase";
        }
        EXPECT_NEAR(sum / 2000, 0.5, 0.02) << type;
    }
}
TEST(TexGabor, a_full_turn_of_the_orientation_changes_nothing) {
    const auto a = gabor("2D", 64).set("Orientation 2D", 0.5).run(Path::Double), b = gabor("2D", 64).set("Orientation 2D", 0.5 + 2 * M_PI).run(Path::Double);
    for (size_t i = 0; i < 64; ++i) EXPECT_NEAR(a[0][i], b[0][i], 1e-5);
}
TEST(TexGabor, orientation_is_a_direction_its_length_does_not_matter) {
    const auto a = gabor("3D", 64).set("Orientation 3D", {1, 2, 3}).run(), b = gabor("3D", 64).set("Orientation 3D", {2, 4, 6}).run();
    for (size_t i = 0; i < 64; ++i) EXPECT_NEAR(a[0][i], b[0][i], 1e-5);
}
}  // namespace alder
