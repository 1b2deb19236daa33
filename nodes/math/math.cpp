// Math: one of 41 operations on up to three numbers, as Blender's Math node computes it in Cycles.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/math/math.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/math/cycles-inl.h"

// Identifier, label, Cycles' name, number of operands, value.
#ifndef ALDER_MATH_OPS
#define ALDER_MATH_OPS(X) \
    X(ADD, "Add", "add", 2, a + b) \
    X(SUBTRACT, "Subtract", "subtract", 2, a - b) \
    X(MULTIPLY, "Multiply", "multiply", 2, a * b) \
    X(DIVIDE, "Divide", "divide", 2, safe_divide(a, b)) \
    X(MULTIPLY_ADD, "Multiply Add", "multiply_add", 3, a * b + c) \
    X(POWER, "Power", "power", 2, safe_pow(a, b)) \
    X(LOGARITHM, "Logarithm", "logarithm", 2, safe_log(a, b)) \
    X(SQRT, "Square Root", "sqrt", 1, sqrt(second_max(a, F(0)))) \
    X(INVERSE_SQRT, "Inverse Square Root", "inversesqrt", 1, inverse_sqrt(a)) \
    X(ABSOLUTE, "Absolute", "absolute", 1, abs(a)) \
    X(EXPONENT, "Exponent", "exponent", 1, exp(a)) \
    X(MINIMUM, "Minimum", "minimum", 2, number_min(a, b)) \
    X(MAXIMUM, "Maximum", "maximum", 2, number_max(a, b)) \
    X(LESS_THAN, "Less Than", "less_than", 2, select(a < b, F(1), F(0))) \
    X(GREATER_THAN, "Greater Than", "greater_than", 2, select(a > b, F(1), F(0))) \
    X(SIGN, "Sign", "sign", 1, sign(a)) \
    X(COMPARE, "Compare", "compare", 3, compare(a, b, c)) \
    X(SMOOTH_MIN, "Smooth Minimum", "smoothmin", 3, smooth_min(a, b, c)) \
    X(SMOOTH_MAX, "Smooth Maximum", "smoothmax", 3, -smooth_min(-a, -b, c)) \
    X(ROUND, "Round", "round", 1, floor(a + F(0.5))) \
    X(FLOOR, "Floor", "floor", 1, floor(a)) \
    X(CEIL, "Ceil", "ceil", 1, ceil(a)) \
    X(TRUNC, "Truncate", "trunc", 1, truncate(a)) \
    X(FRACT, "Fraction", "fraction", 1, fract(a)) \
    X(MODULO, "Truncated Modulo", "modulo", 2, safe_modulo(a, b)) \
    X(FLOORED_MODULO, "Floored Modulo", "floored_modulo", 2, safe_floored_modulo(a, b)) \
    X(WRAP, "Wrap", "wrap", 3, wrap(a, b, c)) \
    X(SNAP, "Snap", "snap", 2, snap(a, b)) \
    X(PINGPONG, "Ping-Pong", "pingpong", 2, pingpong(a, b)) \
    X(SINE, "Sine", "sine", 1, sin(a)) \
    X(COSINE, "Cosine", "cosine", 1, cos(a)) \
    X(TANGENT, "Tangent", "tangent", 1, tan(a)) \
    X(ARCSINE, "Arcsine", "arcsine", 1, safe_asin(a)) \
    X(ARCCOSINE, "Arccosine", "arccosine", 1, safe_acos(a)) \
    X(ARCTANGENT, "Arctangent", "arctangent", 1, atan(a)) \
    X(ARCTAN2, "Arctan2", "arctan2", 2, safe_atan2(a, b)) \
    X(SINH, "Hyperbolic Sine", "sinh", 1, sinh(a)) \
    X(COSH, "Hyperbolic Cosine", "cosh", 1, cosh(a)) \
    X(TANH, "Hyperbolic Tangent", "tanh", 1, tanh(a)) \
    X(RADIANS, "To Radians", "radians", 1, a * F(0.017453292519943295)) \
    X(DEGREES, "To Degrees", "degrees", 1, a * F(57.29577951308232))
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

#define X(ID, label, cycles, operands, ...)                                                   \
    struct MathOp_##ID {                                                                      \
        template <class F>                                                                    \
        static HWY_INLINE F eval([[maybe_unused]] F a, [[maybe_unused]] F b, [[maybe_unused]] F c) { \
            return __VA_ARGS__;                                                               \
        }                                                                                     \
    };
ALDER_MATH_OPS(X)
#undef X

template <class Op>
struct MathBody {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F value = Op::eval(k.f(0), k.f(1), k.f(2));
        k.set(0, k.statics().e(4) ? cycles_saturate(value) : value);
    }
};

template <class F>
void math_node(const Call<F>& c) {
    int index = 0;
    const int op = c.statics().e(3);
#define X(ID, ...) \
    if (op == index++) return c.template each<MathBody<MathOp_##ID>>();
    ALDER_MATH_OPS(X)
#undef X
}
ALDER_KERNEL(math_node)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(math_node)

static int math_operands(int op) {
#define X(ID, label, cycles, operands, ...) operands,
    static constexpr int kOperands[] = {ALDER_MATH_OPS(X)};
#undef X
    return op >= 0 && op < static_cast<int>(std::size(kOperands)) ? kOperands[op] : 3;
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeMath";
    n.category = "Converter";
    n.summary = "one of 41 operations on up to three numbers";
    n.help = "Division by zero, roots and logarithms outside their domain give 0; powers of negative numbers with fractional exponents too.";
    n.aliases = {"math"};
    n.params.push_back(f("Value", 0.5).range(-10000, 10000).alias("Value1"));
    n.params.push_back(f("Value_001", 0.5).range(-10000, 10000).alias("Value2"));
    n.params.push_back(f("Value_002", 0.5).range(-10000, 10000).alias("Value3"));
#define X(ID, label, cycles, operands, ...) {#ID, label, cycles},
    n.params.push_back(choice("operation", std::vector<Item>{ALDER_MATH_OPS(X)}, "ADD").alias("math_type"));
#undef X
    n.params.push_back(b("use_clamp", false).no_link().doc("limit the result to 0 ... 1"));
    n.outputs = {{"Value", Type::Float}};
    n.kernel = math_node_kernel();
    n.cost_ns = 2;
    n.uses = [](const Statics& s, int param) { return param > 2 || param < math_operands(s.e(3)); };
    return n;
}
}  // namespace alder
#endif
