// alCombineFloat and alCombineColor: arithmetic on two inputs, or a blend of them by a third. alshaders specification, section 2.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/math/al_combine.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"

#ifndef ALDER_NODES_MATH_AL_COMBINE_
#define ALDER_NODES_MATH_AL_COMBINE_
namespace alder {
enum class CombineOp { Multiply, Add, Divide, Subtract, Lerp, Dot, Distance, Cross };
}
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

template <CombineOp op, class V, class F>
HWY_INLINE V combine(V a, V b, F t) {
    if constexpr (op == CombineOp::Multiply) return a * b;
    else if constexpr (op == CombineOp::Add) return a + b;
    else if constexpr (op == CombineOp::Divide) return a / b;
    else if constexpr (op == CombineOp::Subtract) return a - b;
    else {
        // At the ends the other input may hold anything: it was not evaluated.
        static_assert(op == CombineOp::Lerp);
        return select(t <= F(0), a, select(t >= F(1), b, lerp(a, b, t)));
    }
}

template <CombineOp op>
struct AlCombineFloat {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, combine<op>(k.f(0), k.f(1), k.f(2))); }
};
template <CombineOp op>
struct AlCombineColor {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> a = k.v(0), b = k.v(3);
        if constexpr (op == CombineOp::Dot) k.set(0, Vec3<F>(dot(a, b)));
        else if constexpr (op == CombineOp::Distance) k.set(0, Vec3<F>(length(b - a)));
        else if constexpr (op == CombineOp::Cross) k.set(0, cross(a, b));
        else k.set(0, combine<op>(a, b, k.f(6)));
    }
};

template <class F>
void al_combine_float(const Call<F>& c) {
    switch (static_cast<CombineOp>(c.statics().e(3))) {
        case CombineOp::Add: return c.template each<AlCombineFloat<CombineOp::Add>>();
        case CombineOp::Divide: return c.template each<AlCombineFloat<CombineOp::Divide>>();
        case CombineOp::Subtract: return c.template each<AlCombineFloat<CombineOp::Subtract>>();
        case CombineOp::Lerp: return c.template each<AlCombineFloat<CombineOp::Lerp>>();
        default: return c.template each<AlCombineFloat<CombineOp::Multiply>>();
    }
}
template <class F>
void al_combine_color(const Call<F>& c) {
    switch (static_cast<CombineOp>(c.statics().e(3))) {
        case CombineOp::Multiply: return c.template each<AlCombineColor<CombineOp::Multiply>>();
        case CombineOp::Add: return c.template each<AlCombineColor<CombineOp::Add>>();
        case CombineOp::Divide: return c.template each<AlCombineColor<CombineOp::Divide>>();
        case CombineOp::Subtract: return c.template each<AlCombineColor<CombineOp::Subtract>>();
        case CombineOp::Lerp: return c.template each<AlCombineColor<CombineOp::Lerp>>();
        case CombineOp::Dot: return c.template each<AlCombineColor<CombineOp::Dot>>();
        case CombineOp::Distance: return c.template each<AlCombineColor<CombineOp::Distance>>();
        case CombineOp::Cross: return c.template each<AlCombineColor<CombineOp::Cross>>();
    }
}
ALDER_KERNEL(al_combine_float)
ALDER_KERNEL(al_combine_color)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(al_combine_float)
ALDER_KERNEL_EXPORT(al_combine_color)

static bool is_lerp(const Statics& s) { return static_cast<CombineOp>(s.e(3)) == CombineOp::Lerp; }
static bool combine_uses(const Statics& s, int param) { return param != 2 || is_lerp(s); }
static std::vector<LazyRule> combine_lazy(const Statics& s) {
    if (!is_lerp(s)) return {};
    return {{0, 2, LazyRule::NeededIfBelowOne}, {1, 2, LazyRule::NeededIfPositive}};
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alCombineFloat";
    n.system = System::AlShaders;
    n.category = "math";
    n.summary = "two-input float arithmetic";
    n.help = "Division has no guard. lerp leaves its ends exact: input3 <= 0 is input1, >= 1 is input2, and the other input is not evaluated there.";
    n.params = {f("input1", 0).doc("first operand"), f("input2", 0).doc("second operand"),
                f("input3", 0).range(0, 1).doc("blend of lerp"),
                choice("combineOp", {"multiply 1*2", "add 1+2", "divide 1/2", "subtract 1-2", "lerp(1, 2, 3)"}, "multiply 1*2").doc("operation")};
    n.outputs = {{"out", Type::Float}};
    n.kernel = al_combine_float_kernel();
    n.cost_ns = 0.5;
    n.uses = combine_uses;
    n.lazy = combine_lazy;
    return n;
}
ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alCombineColor";
    n.system = System::AlShaders;
    n.category = "math";
    n.summary = "two-input colour arithmetic";
    n.help = "The first five operations act on each channel; dot and distance give a grey, cross the vector product of (r, g, b). "
             "lerp leaves its ends exact: input3 <= 0 is input1, >= 1 is input2, and the other input is not evaluated there.";
    n.params = {color("input1", 1, 1, 1).doc("first operand"), color("input2", 1, 1, 1).doc("second operand"),
                f("input3", 0).range(0, 1).doc("blend of lerp"),
                choice("combineOp", {"multiply 1*2", "add 1+2", "divide 1/2", "subtract 1-2", "lerp(1, 2, 3)", "dot(1, 2)", "distance(1 -> 2)", "cross(1, 2)"},
                       "multiply 1*2").doc("operation")};
    n.outputs = {{"out", Type::Color}};
    n.kernel = al_combine_color_kernel();
    n.cost_ns = 1;
    n.uses = combine_uses;
    n.lazy = combine_lazy;
    return n;
}
}  // namespace alder
#endif
