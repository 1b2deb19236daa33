// Math, Vector Math, Map Range, Clamp, Mapping, Vector Rotate: the laws of Blender's arithmetic nodes, on every path.
#include "tests/nodes/node_call.h"

#include <random>

namespace alder {
namespace {

using test::NodeCall;
using test::Path;
constexpr Path kPaths[] = {Path::Lanes, Path::Scalar, Path::Double};
const double kNan = std::numeric_limits<double>::quiet_NaN();
const double kInf = std::numeric_limits<double>::infinity();

double math(const char* op, double a, double b = 0, double c = 0, Path path = Path::Lanes, bool clamp = false) {
    return NodeCall("ShaderNodeMath").set("operation", op).set("use_clamp", clamp).set("Value", a).set("Value_001", b).set("Value_002", c).value(path);
}

TEST(math_node, outside_its_domain_an_operation_gives_zero) {
    const struct { const char* op; double a, b, c; } rows[] = {{"DIVIDE", 3, 0, 0}, {"SQRT", -2, 0, 0}, {"INVERSE_SQRT", 0, 0, 0}, {"INVERSE_SQRT", -1, 0, 0},
        {"LOGARITHM", -1, 2, 0}, {"LOGARITHM", 2, 0, 0}, {"LOGARITHM", 2, 1, 0}, {"POWER", -2, 0.5, 0}, {"POWER", -2, 1e30, 0}, {"MODULO", 3, 0, 0},
        {"FLOORED_MODULO", 3, 0, 0}, {"PINGPONG", 3, 0, 0}, {"SNAP", 3, 0, 0}, {"ARCTAN2", 0, 0, 0}, {"SIGN", 0, 0, 0}, {"SIGN", -0.0, 0, 0}};
    for (const auto& row : rows)
        for (Path path : kPaths) EXPECT_EQ(math(row.op, row.a, row.b, row.c, path), 0) << row.op << " of " << row.a << ", " << row.b;
}

TEST(math_node, known_values) {
    const struct { const char* op; double a, b, c, want; } rows[] = {{"POWER", -2, 3, 0, -8}, {"POWER", 0, 0, 0, 1}, {"MODULO", -5, 3, 0, -2}, {"FLOORED_MODULO", -5, 3, 0, 1},
        {"WRAP", 7, 5, 2, 4}, {"WRAP", 7, 2, 2, 2}, {"PINGPONG", 5, 2, 0, 1}, {"SNAP", 7, 2, 0, 6}, {"COMPARE", 1, 1.5, 0.5, 1}, {"COMPARE", 1, 1.5, 0.4, 0},
        {"COMPARE", kInf, kInf, 0, 1}, {"ROUND", 2.5, 0, 0, 3}, {"ROUND", -2.5, 0, 0, -2}, {"TRUNC", -2.5, 0, 0, -2}, {"FRACT", -0.25, 0, 0, 0.75},
        {"ARCSINE", 2, 0, 0, std::asin(1.0)}, {"ARCCOSINE", -2, 0, 0, std::acos(-1.0)}, {"MINIMUM", kNan, 2, 0, 2}, {"MAXIMUM", 2, kNan, 0, 2},
        {"SMOOTH_MIN", 1, 2, 0, 1}, {"SMOOTH_MAX", 1, 2, 0, 2}, {"LOGARITHM", 8, 2, 0, 3}, {"LESS_THAN", 1, 1, 0, 0}, {"GREATER_THAN", 2, 1, 0, 1}};
    for (const auto& row : rows)
        for (Path path : kPaths) EXPECT_NEAR(math(row.op, row.a, row.b, row.c, path), row.want, 1e-6) << row.op << " of " << row.a << ", " << row.b << ", " << row.c;
}

TEST(math_node, a_clamped_result_lies_between_zero_and_one) {
    for (double x : {-1e30, -1.0, 0.0, 0.25, 1.0, 7.0, 1e30, kInf, -kInf, kNan})
        for (Path path : kPaths) {
            const double y = math("MULTIPLY", x, 1, 0, path, true);
            EXPECT_TRUE(y >= 0 && y <= 1) << x << " -> " << y;
        }
}

TEST(math_node, smooth_minimum_stays_below_the_minimum_and_is_symmetric) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> u(-3, 3);
    for (int i = 0; i < 200; ++i) {
        const double a = u(random), b = u(random), k = std::fabs(u(random));
        const double s = math("SMOOTH_MIN", a, b, k);
        EXPECT_LE(s, std::min(a, b) + 1e-6);
        EXPECT_GE(s, std::min(a, b) - k / 6 - 1e-6);
        EXPECT_EQ(s, math("SMOOTH_MIN", b, a, k));
        EXPECT_NEAR(math("SMOOTH_MAX", a, b, k), -math("SMOOTH_MIN", -a, -b, k), 1e-6);
    }
}

/// Operands an operation does not have must not reach the result, whatever they hold.
TEST(math_node, unavailable_operands_have_no_effect) {
    const NodeType& type = *find_node("ShaderNodeMath");
    for (const Item& item : type.params[type.param_index("operation")].items) {
        NodeCall call("ShaderNodeMath");
        call.set("operation", item.name.c_str()).set("Value", 0.3);
        for (int p = 1; p < 3; ++p) call.set(type.params[p].name, type.uses(call.statics(), p) ? 0.7 : kNan);
        for (Path path : kPaths) EXPECT_TRUE(std::isfinite(call.value(path))) << item.name;
    }
}

std::vector<double> vector_math(const char* op, std::initializer_list<double> a, std::initializer_list<double> b, double scale = 1, Path path = Path::Lanes) {
    const auto r = NodeCall("ShaderNodeVectorMath").set("operation", op).set("Vector", a).set("Vector_001", b).set("Scale", scale).run(path);
    return {r[0][0], r[1][0], r[2][0], r[3][0]};
}

TEST(vector_math_node, known_values) {
    for (Path path : kPaths) {
        const auto expect = [&](const char* op, std::vector<double> got, std::vector<double> want) {
            for (size_t i = 0; i < want.size(); ++i) EXPECT_NEAR(got[i], want[i], 1e-6) << op << " component " << i;
        };
        expect("REFLECT", vector_math("REFLECT", {1, -1, 0}, {0, 2, 0}, 1, path), {1, 1, 0, 0});
        expect("REFRACT straight", vector_math("REFRACT", {0.6, -0.8, 0}, {0, 1, 0}, 1, path), {0.6, -0.8, 0, 0});
        expect("REFRACT beyond", vector_math("REFRACT", {0.8, -0.6, 0}, {0, 1, 0}, 2, path), {0, 0, 0, 0});
        expect("PROJECT", vector_math("PROJECT", {2, 3, 0}, {4, 0, 0}, 1, path), {2, 0, 0, 0});
        expect("PROJECT on nothing", vector_math("PROJECT", {2, 3, 0}, {0, 0, 0}, 1, path), {0, 0, 0, 0});
        expect("DIVIDE", vector_math("DIVIDE", {1, 2, 3}, {0, 2, -1}, 1, path), {0, 1, -3, 0});
        expect("DOT_PRODUCT", vector_math("DOT_PRODUCT", {1, 2, 3}, {4, 5, 6}, 1, path), {0, 0, 0, 32});
        expect("DISTANCE", vector_math("DISTANCE", {1, 2, 3}, {1, 2, 8}, 1, path), {0, 0, 0, 5});
        expect("NORMALIZE zero", vector_math("NORMALIZE", {0, 0, 0}, {1, 1, 1}, 1, path), {0, 0, 0, 0});
        expect("SNAP", vector_math("SNAP", {7, -1, 5}, {2, 2, 0}, 1, path), {6, -2, 0, 0});
    }
}

TEST(map_range_node, ends_go_to_ends_in_every_interpolation) {
    for (const char* mode : {"LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP"})
        for (Path path : kPaths)
            for (bool reversed : {false, true}) {
                const double lo = reversed ? 4 : -2, hi = reversed ? -2 : 4;
                NodeCall call("ShaderNodeMapRange");
                call.set("interpolation_type", mode).set("From Min", lo).set("From Max", hi).set("To Min", 10).set("To Max", -6);
                EXPECT_NEAR(call.set("Value", lo).value(path), 10, 1e-5) << mode << (reversed ? " reversed" : "");
                EXPECT_NEAR(call.set("Value", hi).value(path), -6, 1e-5) << mode << (reversed ? " reversed" : "");
                EXPECT_EQ(call.set("Value", lo + 10 * (lo - hi)).value(path), 10) << mode << ": clamped below";
            }
}

TEST(map_range_node, steps_are_levels) {
    NodeCall call("ShaderNodeMapRange");
    call.set("interpolation_type", "STEPPED").set("Steps", 4);
    for (int i = 0; i < 5; ++i) EXPECT_NEAR(call.set("Value", (i + 0.5) / 5).value(), i / 4.0, 1e-6);
    EXPECT_EQ(call.set("Steps", 0).value(), 0);
}

TEST(map_range_node, equal_bounds_give_zero_or_the_clamped_end) {
    NodeCall call("ShaderNodeMapRange");
    call.set("From Min", 1).set("From Max", 1).set("To Min", 2).set("To Max", 3).set("Value", 5);
    EXPECT_EQ(call.set("clamp", 0).value(), 0);
    EXPECT_EQ(call.set("clamp", 1).value(), 2);
}

TEST(clamp_node, bounds_either_way_round) {
    for (Path path : kPaths) {
        NodeCall call("ShaderNodeClamp");
        call.set("Value", 5).set("Min", 3).set("Max", 1);
        EXPECT_EQ(call.value(path), 1) << "MINMAX: the maximum has the last word";
        EXPECT_EQ(call.set("clamp_type", "RANGE").value(path), 3);
    }
}

TEST(mapping_node, texture_undoes_point) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> u(-3, 3);
    for (int i = 0; i < 50; ++i) {
        NodeCall call("ShaderNodeMapping");
        const std::initializer_list<double> v{u(random), u(random), u(random)};
        call.set("Location", {u(random), u(random), u(random)}).set("Rotation", {u(random), u(random), u(random)}).set("Scale", {1.5, -0.7, 2.25}).set("Vector", v);
        const auto there = call.run();
        call.set("vector_type", "TEXTURE").set("Vector", {there[0][0], there[1][0], there[2][0]});
        const auto back = call.run();
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(back[c][0], v.begin()[c], 2e-5) << "component " << c;
    }
}

TEST(mapping_node, normals_are_unit_and_a_zero_scale_gives_zero) {
    NodeCall call("ShaderNodeMapping");
    call.set("vector_type", "NORMAL").set("Vector", {3, -4, 12}).set("Scale", {2, 0.5, 1}).set("Rotation", {0.1, 0.2, 0.3});
    const auto n = call.run();
    EXPECT_NEAR(n[0][0] * n[0][0] + n[1][0] * n[1][0] + n[2][0] * n[2][0], 1, 1e-6);
    call.set("Scale", {0, 0, 0});
    for (int c = 0; c < 3; ++c) EXPECT_EQ(call.run()[c][0], 0);
}

TEST(vector_rotate_node, rotation_keeps_length_and_invert_undoes_it) {
    for (const char* type : {"AXIS_ANGLE", "X_AXIS", "Y_AXIS", "Z_AXIS", "EULER_XYZ"})
        for (Path path : kPaths) {
            NodeCall call("ShaderNodeVectorRotate");
            call.set("rotation_type", type).set("Center", {0.5, -1, 2}).set("Axis", {1, 2, -0.5}).set("Angle", 0.8).set("Rotation", {0.3, -1.1, 2}).set("Vector", {2, 3, -1});
            const auto there = call.run(path);
            const double dx = there[0][0] - 0.5, dy = there[1][0] + 1, dz = there[2][0] - 2;
            EXPECT_NEAR(std::sqrt(dx * dx + dy * dy + dz * dz), std::sqrt(1.5 * 1.5 + 16 + 9), 1e-5) << type;
            const auto back = call.set("invert", 1).set("Vector", {there[0][0], there[1][0], there[2][0]}).run(path);
            EXPECT_NEAR(back[0][0], 2, 1e-5) << type;
            EXPECT_NEAR(back[1][0], 3, 1e-5) << type;
            EXPECT_NEAR(back[2][0], -1, 1e-5) << type;
        }
}

}  // namespace
}  // namespace alder
