// Vector Math: one of 29 operations on up to three vectors, as Blender's Vector Math node computes it in Cycles.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/math/vector_math.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/math/cycles-inl.h"

// Identifier, label, Cycles' name, operands (1 Vector, 2 Vector_001, 4 Vector_002, 8 Scale), value.
#ifndef ALDER_VECTOR_MATH_OPS
#define ALDER_VECTOR_MATH_OPS(VECTOR, EACH, VALUE)                                                        \
    VECTOR(ADD, "Add", "add", 3, a + b)                                                                   \
    VECTOR(SUBTRACT, "Subtract", "subtract", 3, a - b)                                                    \
    VECTOR(MULTIPLY, "Multiply", "multiply", 3, a * b)                                                    \
    VECTOR(DIVIDE, "Divide", "divide", 3, safe_divide(a, b))                                              \
    VECTOR(MULTIPLY_ADD, "Multiply Add", "multiply_add", 7, a * b + c)                                    \
    VECTOR(CROSS_PRODUCT, "Cross Product", "cross_product", 3, cross(a, b))                               \
    VECTOR(PROJECT, "Project", "project", 3, project(a, b))                                               \
    VECTOR(REFLECT, "Reflect", "reflect", 3, reflect_at(a, safe_normalize(b)))                            \
    VECTOR(REFRACT, "Refract", "refract", 11, refract_at(a, safe_normalize(b), s))                        \
    VECTOR(FACEFORWARD, "Faceforward", "faceforward", 7, select<F>(dot(c, b) < F(0), a, -a))              \
    VALUE(DOT_PRODUCT, "Dot Product", "dot_product", 3, dot(a, b))                                        \
    VALUE(DISTANCE, "Distance", "distance", 3, length(a - b))                                             \
    VALUE(LENGTH, "Length", "length", 1, length(a))                                                       \
    VECTOR(SCALE, "Scale", "scale", 9, a * s)                                                             \
    VECTOR(NORMALIZE, "Normalize", "normalize", 1, safe_normalize(a))                                     \
    EACH(ABSOLUTE, "Absolute", "absolute", 1, abs(a))                                                     \
    EACH(POWER, "Power", "power", 3, safe_pow(a, b))                                                      \
    EACH(SIGN, "Sign", "sign", 1, sign(a))                                                                \
    EACH(MINIMUM, "Minimum", "minimum", 3, second_min(a, b))                                              \
    EACH(MAXIMUM, "Maximum", "maximum", 3, second_max(a, b))                                              \
    EACH(FLOOR, "Floor", "floor", 1, floor(a))                                                            \
    EACH(CEIL, "Ceil", "ceil", 1, ceil(a))                                                                \
    EACH(FRACTION, "Fraction", "fraction", 1, fract(a))                                                   \
    EACH(MODULO, "Modulo", "modulo", 3, safe_modulo(a, b))                                                \
    EACH(WRAP, "Wrap", "wrap", 7, wrap(a, b, c))                                                          \
    EACH(SNAP, "Snap", "snap", 3, snap(a, b))                                                             \
    EACH(SINE, "Sine", "sine", 1, sin(a))                                                                 \
    EACH(COSINE, "Cosine", "cosine", 1, cos(a))                                                           \
    EACH(TANGENT, "Tangent", "tangent", 1, tan(a))
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

template <class F>
HWY_INLINE Vec3<F> project(Vec3<F> v, Vec3<F> onto) {
    const F squared = dot(onto, onto);
    const Vec3<F> p = onto * (dot(v, onto) / squared);
    return select<F>(squared != F(0), p, Vec3<F>(F(0)));
}
template <class F>
HWY_INLINE Vec3<F> reflect_at(Vec3<F> v, Vec3<F> n) { return v - F(2) * n * dot(v, n); }
/// Zero where nothing is refracted.
template <class F>
HWY_INLINE Vec3<F> refract_at(Vec3<F> v, Vec3<F> n, F eta) {
    const F cosine = dot(n, v);
    const F k = F(1) - eta * eta * (F(1) - cosine * cosine);
    const Vec3<F> refracted = eta * v - (eta * cosine + sqrt(k)) * n;
    return select<F>(k < F(0), Vec3<F>(F(0)), refracted);
}

#define VECTOR(ID, label, cycles, operands, ...)                                                                    \
    struct VectorMath_##ID {                                                                                        \
        template <class F>                                                                                          \
        static HWY_INLINE void run(Lanes<F> k) {                                                                    \
            [[maybe_unused]] const Vec3<F> a = k.v(0), b = k.v(3), c = k.v(6);                                      \
            [[maybe_unused]] const F s = k.f(9);                                                                    \
            k.set(0, Vec3<F>(__VA_ARGS__));                                                                         \
            k.set(3, F(0));                                                                                         \
        }                                                                                                           \
    };
#define EACH(ID, label, cycles, operands, ...)                                                                      \
    struct VectorMath_##ID {                                                                                        \
        template <class F>                                                                                          \
        static HWY_INLINE F one([[maybe_unused]] F a, [[maybe_unused]] F b, [[maybe_unused]] F c) { return __VA_ARGS__; } \
        template <class F>                                                                                          \
        static HWY_INLINE void run(Lanes<F> k) {                                                                    \
            for (int i = 0; i < 3; ++i) k.set(i, one(k.f(i), k.f(3 + i), k.f(6 + i)));                              \
            k.set(3, F(0));                                                                                         \
        }                                                                                                           \
    };
#define VALUE(ID, label, cycles, operands, ...)                                                                     \
    struct VectorMath_##ID {                                                                                        \
        template <class F>                                                                                          \
        static HWY_INLINE void run(Lanes<F> k) {                                                                    \
            [[maybe_unused]] const Vec3<F> a = k.v(0), b = k.v(3);                                                  \
            k.set(0, Vec3<F>(F(0)));                                                                                \
            k.set(3, F(__VA_ARGS__));                                                                               \
        }                                                                                                           \
    };
ALDER_VECTOR_MATH_OPS(VECTOR, EACH, VALUE)
#undef VECTOR
#undef EACH
#undef VALUE

template <class F>
void vector_math(const Call<F>& c) {
    int index = 0;
    const int op = c.statics().e(4);
#define X(ID, ...) \
    if (op == index++) return c.template each<VectorMath_##ID>();
    ALDER_VECTOR_MATH_OPS(X, X, X)
#undef X
}
ALDER_KERNEL(vector_math)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(vector_math)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeVectorMath";
    n.category = "Converter";
    n.summary = "one of 29 operations on up to three vectors";
    n.help = "Dot Product, Distance and Length deliver Value, the others Vector; the other output is 0. Division by zero gives 0.";
    n.aliases = {"vector_math"};
    n.params.push_back(vector("Vector", 0, 0, 0).range(-10000, 10000).alias("Vector1"));
    n.params.push_back(vector("Vector_001", 0, 0, 0).range(-10000, 10000).alias("Vector2"));
    n.params.push_back(vector("Vector_002", 0, 0, 0).range(-10000, 10000).alias("Vector3"));
    n.params.push_back(f("Scale", 1).range(-10000, 10000).doc("factor of Scale; ratio of refractive indices for Refract"));
#define X(ID, label, cycles, operands, ...) {#ID, label, cycles},
    n.params.push_back(choice("operation", std::vector<Item>{ALDER_VECTOR_MATH_OPS(X, X, X)}, "ADD").alias("math_type"));
#undef X
    n.outputs = {{"Vector", Type::Vector}, {"Value", Type::Float}};
    n.kernel = vector_math_kernel();
    n.cost_ns = 3;
    n.uses = [](const Statics& s, int param) {
#define X(ID, label, cycles, operands, ...) operands,
        static constexpr int kOperands[] = {ALDER_VECTOR_MATH_OPS(X, X, X)};
#undef X
        return param > 3 || ((kOperands[s.e(4)] >> param) & 1) != 0;
    };
    return n;
}
}  // namespace alder
#endif
