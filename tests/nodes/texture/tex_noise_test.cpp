// Noise, Wave, White Noise, Magic, Gradient and Brick textures, and the placement built into all of them.
#include <cmath>
#include <random>

#include "nodes/texture/texture_mapping.h"
#include "tests/nodes/node_call.h"

namespace alder {
namespace {
using test::NodeCall;
using test::Path;

constexpr size_t kPoints = 37;
std::vector<double> random_numbers(unsigned seed, double lo = -4, double hi = 4) {
    std::mt19937 rng(seed);
    std::uniform_real_distribution<float> u(static_cast<float>(lo), static_cast<float>(hi));
    std::vector<double> v(kPoints);
    for (double& x : v) x = u(rng);
    return v;
}
NodeCall at_random_points(const char* node) {
    NodeCall call(node, kPoints);
    for (int c = 0; c < 3; ++c) call.vary("Vector", random_numbers(c), c);
    return call;
}
constexpr const char* kTypes[] = {"MULTIFRACTAL", "RIDGED_MULTIFRACTAL", "HYBRID_MULTIFRACTAL", "FBM", "HETERO_TERRAIN"};

TEST(TexNoise, red_is_the_value_and_the_colours_differ) {
    for (const char* type : kTypes) {
        const auto r = at_random_points("ShaderNodeTexNoise").set("noise_type", type).set("Offset", 0.5).run();
        for (size_t i = 0; i < kPoints; ++i) {
            EXPECT_EQ(r[0][i], r[1][i]) << type;
            EXPECT_NE(r[1][i], r[2][i]) << type;
            EXPECT_NE(r[2][i], r[3][i]) << type;
        }
    }
}
TEST(TexNoise, value_does_not_depend_on_what_else_is_asked) {
    const auto all = at_random_points("ShaderNodeTexNoise").run(), value = at_random_points("ShaderNodeTexNoise").without("Color").run(),
               color = at_random_points("ShaderNodeTexNoise").without("Fac").run();
    EXPECT_EQ(all[0], value[0]);
    for (int c = 1; c < 4; ++c) EXPECT_EQ(all[c], color[c]);
}
TEST(TexNoise, a_batch_of_mixed_parameters_gives_what_each_alone_gives) {
    for (const char* type : kTypes) {
        const auto detail = random_numbers(11, -1, 17), roughness = random_numbers(12, -0.2, 1.2), distortion = random_numbers(13, -0.5, 1);
        const auto mixed = at_random_points("ShaderNodeTexNoise").set("noise_type", type).vary("Detail", detail).vary("Roughness", roughness)
                               .vary("Distortion", distortion).run();
        const auto x = random_numbers(0), y = random_numbers(1), z = random_numbers(2);
        for (size_t i = 0; i < kPoints; i += 5) {
            NodeCall one("ShaderNodeTexNoise");
            one.set("noise_type", type).set("Vector", {x[i], y[i], z[i]}).set("Detail", detail[i]).set("Roughness", roughness[i]).set("Distortion", distortion[i]);
            EXPECT_EQ(mixed[0][i], one.run()[0][0]) << type << " point " << i;
        }
    }
}
TEST(TexNoise, dimensions_read_their_coordinates_only) {
    const auto value = [](const char* dimensions, double z, double w) {
        return NodeCall("ShaderNodeTexNoise").set("noise_dimensions", dimensions).set("Vector", {0.3, 1.7, z}).set("W", w).value();
    };
    EXPECT_EQ(value("2D", 0.1, 0.2), value("2D", 5.3, 0.9));
    EXPECT_EQ(value("3D", 0.1, 0.2), value("3D", 0.1, 0.9));
    EXPECT_NE(value("3D", 0.1, 0.2), value("3D", 0.15, 0.2));
    EXPECT_NE(value("4D", 0.1, 0.2), value("4D", 0.1, 0.25));
    EXPECT_NE(value("1D", 0.1, 0.2), value("1D", 0.1, 0.25));
}
TEST(TexNoise, normalised_fbm_lies_between_0_and_1) {
    const auto r = at_random_points("ShaderNodeTexNoise").set("Detail", 8).run();
    for (int c = 0; c < 4; ++c) {
        for (double v : r[c]) EXPECT_TRUE(v >= 0 && v <= 1) << v;
    }
}
TEST(TexNoise, detail_is_limited_to_15_and_nan_counts_as_0) {
    const auto value = [](double detail) { return NodeCall("ShaderNodeTexNoise").set("Vector", {0.3, 1.7, 0.6}).set("Detail", detail).value(); };
    EXPECT_EQ(value(15), value(1e9));
    EXPECT_EQ(value(0), value(-3));
    EXPECT_EQ(value(0), value(std::nan("")));
}

TEST(TexWave, profiles_at_known_places) {
    // n = 20 (x + 1e-6) · 0.999999; the sine starts at its lowest point.
    const auto value = [](const char* profile, double x) {
        return NodeCall("ShaderNodeTexWave").set("wave_profile", profile).set("Scale", 1).set("Vector", {x, 0, 0}).run()[3][0];
    };
    const double period = 2 * M_PI / 20;
    EXPECT_NEAR(value("SIN", 0), 0, 1e-4);
    EXPECT_NEAR(value("SIN", period / 2), 1, 1e-4);
    EXPECT_NEAR(value("SAW", period / 4), 0.25, 1e-4);
    EXPECT_NEAR(value("TRI", period / 2), 1, 1e-4);
    EXPECT_NEAR(value("TRI", period * 3 / 4), 0.5, 1e-4);
}
TEST(TexWave, rings_surround_their_axis) {
    const auto value = [](const char* axis, double x, double y, double z) {
        return NodeCall("ShaderNodeTexWave").set("wave_type", "RINGS").set("rings_direction", axis).set("Scale", 1).set("Vector", {x, y, z}).run()[3][0];
    };
    EXPECT_NEAR(value("X", 0.1, 0.3, 0.4), value("X", 7.0, 0.5, 0), 1e-4);
    EXPECT_NEAR(value("Z", 0.3, 0.4, 0.1), value("Z", 0, 0.5, 9), 1e-4);
    EXPECT_NEAR(value("SPHERICAL", 0.2, 0.4, 0.4), value("SPHERICAL", 0.6, 0, 0), 1e-4);
}
TEST(TexWave, ends_for_any_detail) {
    for (double detail : {1e9, -1e9, HUGE_VAL, std::nan("")}) NodeCall("ShaderNodeTexWave").set("Distortion", 1).set("Detail", detail).run();
}

TEST(TexWhiteNoise, is_uniform_and_repeatable) {
    NodeCall call("ShaderNodeTexWhiteNoise", 4096);
    std::vector<double> x(4096);
    for (size_t i = 0; i < x.size(); ++i) x[i] = static_cast<double>(i) * 0.01;
    call.set("noise_dimensions", "1D").vary("W", x);
    const auto a = call.run(), b = call.run(Path::Scalar);
    for (int c = 0; c < 4; ++c) {
        EXPECT_EQ(a[c], b[c]);
        double mean = 0;
        for (double v : a[c]) mean += v / 4096;
        EXPECT_NEAR(mean, 0.5, 0.02) << c;  // standard error 0.0045
    }
    EXPECT_EQ(a[0], a[1]);
}

TEST(TexGradient, shapes_at_known_places) {
    const auto value = [](const char* type, double x, double y, double z) {
        return NodeCall("ShaderNodeTexGradient").set("gradient_type", type).set("Vector", {x, y, z}).run()[3][0];
    };
    EXPECT_NEAR(value("LINEAR", 0.3, 9, 9), 0.3, 1e-7);
    EXPECT_NEAR(value("QUADRATIC", 0.3, 9, 9), 0.09, 1e-7);
    EXPECT_NEAR(value("EASING", 0.5, 9, 9), 0.5, 1e-7);
    EXPECT_NEAR(value("DIAGONAL", 0.3, 0.5, 9), 0.4, 1e-7);
    EXPECT_NEAR(value("RADIAL", 0, 1, 0), 0.75, 1e-6);
    EXPECT_NEAR(value("SPHERICAL", 0.3, 0.4, 0), 0.5, 1e-5);
    EXPECT_NEAR(value("QUADRATIC_SPHERE", 0.3, 0.4, 0), 0.25, 1e-5);
    EXPECT_EQ(value("LINEAR", -1, 0, 0), 0);
    EXPECT_EQ(value("LINEAR", 2, 0, 0), 1);
    EXPECT_EQ(value("LINEAR", std::nan(""), 0, 0), 0);
}
TEST(TexMagic, without_depth_is_three_sines) {
    const auto r = NodeCall("ShaderNodeTexMagic").set("turbulence_depth", 0).set("Vector", {0.1, 0.2, 0.3}).set("Scale", 1).set("Distortion", 1).run();
    EXPECT_NEAR(r[0][0], 0.5 - std::sin(3.0) / 2, 1e-6);
    EXPECT_NEAR(r[1][0], 0.5 - std::cos(-1.0) / 2, 1e-6);
    EXPECT_NEAR(r[2][0], 0.5 + std::cos(0.0) / 2, 1e-6);
    EXPECT_NEAR(r[3][0], (r[0][0] + r[1][0] + r[2][0]) / 3, 1e-6);
}
TEST(TexBrick, mortar_lies_around_bricks_and_rows_shift) {
    const auto fac = [](double x, double y, double offset) {
        return NodeCall("ShaderNodeTexBrick").set("Vector", {x, y, 0}).set("Scale", 1).set("Mortar Smooth", 0).set("offset", offset).run()[3][0];
    };
    EXPECT_EQ(fac(0.25, 0.125 + 0.25, 0.5), 0);  // middle of a brick of the second row, which is not shifted
    EXPECT_EQ(fac(0.01, 0.125 + 0.25, 0.5), 1);
    EXPECT_EQ(fac(0.25, 0.01, 0), 1);
    EXPECT_EQ(fac(0.01, 0.125, 0), 1);
    EXPECT_EQ(fac(0.01, 0.125, 0.5), 0) << "first row, shifted by half a brick";
    EXPECT_EQ(fac(0.25, 0.125, 0.5), 1);
}

TextureMapping parsed(const std::string& json) {
    std::vector<std::string> errors;
    const TextureMapping m = parse_texture_mapping(json, errors);
    EXPECT_TRUE(errors.empty()) << errors[0];
    return m;
}
TEST(TextureMapping, default_is_nothing) {
    EXPECT_FALSE(parsed("null").active);
    EXPECT_FALSE(parsed(R"({"vector_type": "NORMAL", "translation": [0,0,0], "scale": [1,1,1], "mapping_x": "X"})").active);
}
TEST(TextureMapping, texture_is_the_inverse_of_point) {
    const char* const placement = R"("translation": [1, 2, 3], "rotation": [0.3, -0.4, 0.5], "scale": [2, 0.5, -1.5]})";
    const TextureMapping forth = parsed(std::string(R"({"vector_type": "POINT", )") + placement), back = parsed(std::string(R"({"vector_type": "TEXTURE", )") + placement);
    const double p[3] = {0.2, -0.7, 0.9};
    double q[3], r[3];
    for (int i = 0; i < 3; ++i) q[i] = forth.matrix[i][0] * p[0] + forth.matrix[i][1] * p[1] + forth.matrix[i][2] * p[2] + forth.matrix[i][3];
    for (int i = 0; i < 3; ++i) r[i] = back.matrix[i][0] * q[0] + back.matrix[i][1] * q[1] + back.matrix[i][2] * q[2] + back.matrix[i][3];
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(r[i], p[i], 1e-6);
}
TEST(TextureMapping, moves_what_the_texture_reads) {
    const auto value = [](const char* mapping, double x, double y) {
        return NodeCall("ShaderNodeTexGradient").set("texture_mapping", mapping).set("Vector", {x, y, 0}).run()[3][0];
    };
    EXPECT_NEAR(value(R"({"translation": [0.25, 0, 0]})", 0.5, 0), 0.75, 1e-6);
    EXPECT_NEAR(value(R"({"mapping_x": "Y", "mapping_y": "X"})", 0.1, 0.6), 0.6, 1e-6);
    EXPECT_NEAR(value(R"({"mapping_x": "NONE"})", 0.1, 0.6), 0, 1e-6);
}
TEST(TextureMapping, faults_are_named) {
    std::vector<std::string> errors;
    parse_texture_mapping(R"({"rotation": [1, 2], "vector_type": "SPIN"})", errors);
    ASSERT_EQ(errors.size(), 2u);
    EXPECT_NE(errors[0].find("rotation"), std::string::npos);
    EXPECT_NE(errors[1].find("vector_type"), std::string::npos);
}

}  // namespace
}  // namespace alder
