// alSwitchFloat and alSwitchColor: pick one of eight inputs by a number. alshaders specification, sections 2 and 11 (defect 30).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/math/al_switch.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// 0 ... 7 as a float; NaN and large negative numbers give 0, large positive 7.
template <class F>
HWY_INLINE F switch_index(F mix, F threshold) {
    const F below = floor(mix);
    const F i = select(mix - below >= threshold, below + F(1), below);
    return min(max(F(0), i), F(7));
}
struct AlSwitchFloat {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F i = switch_index(k.f(8), k.f(9));
        F r = k.f(0);
        for (int c = 1; c < 8; ++c) r = select(i == F(c), k.f(c), r);
        k.set(0, r);
    }
};
struct AlSwitchColor {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F i = switch_index(k.f(24), k.f(25));
        Vec3<F> r = k.v(0);
        for (int c = 1; c < 8; ++c) r = select(i == F(c), k.v(3 * c), r);
        k.set(0, r);
    }
};
template <class F>
void al_switch_float(const Call<F>& c) { c.template each<AlSwitchFloat>(); }
template <class F>
void al_switch_color(const Call<F>& c) { c.template each<AlSwitchColor>(); }
ALDER_KERNEL(al_switch_float)
ALDER_KERNEL(al_switch_color)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(al_switch_float)
ALDER_KERNEL_EXPORT(al_switch_color)

static std::vector<LazyRule> only_the_picked_input(const Statics&) {
    std::vector<LazyRule> rules;
    for (int input = 0; input < 8; ++input) rules.push_back({input, 8, LazyRule::NeededIfIndex, input, 9});
    return rules;
}
static void add_switch_params(NodeType& n) {
    using namespace param;
    n.system = System::AlShaders;
    n.category = "math";
    n.help = "The index is mix rounded down, plus one where what is left reaches the threshold: with 0.5 the nearest, halves upward. "
             "It is limited to the eight inputs; only the picked input is evaluated, nothing is blended.";
    n.params.push_back(f("mix", 1).range(0, 7).doc("which input: 0 is inputA, 7 is inputH"));
    n.params.push_back(f("threshold", 0.5).range(0, 1).doc("fraction of mix from which on the next input is taken"));
    n.cost_ns = 1;
    n.lazy = only_the_picked_input;
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alSwitchFloat";
    n.summary = "select one of eight floats";
    const double value[8] = {0, 1, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9};
    for (int i = 0; i < 8; ++i) n.params.push_back(f(std::string("input") + char('A' + i), value[i]).doc("result where the index is " + std::to_string(i)));
    add_switch_params(n);
    n.outputs = {{"out", Type::Float}};
    n.kernel = al_switch_float_kernel();
    return n;
}
ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alSwitchColor";
    n.summary = "select one of eight colours";
    const double value[8][3] = {{0, 0, 0}, {1, 1, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}};
    for (int i = 0; i < 8; ++i)
        n.params.push_back(color(std::string("input") + char('A' + i), value[i][0], value[i][1], value[i][2]).doc("result where the index is " + std::to_string(i)));
    add_switch_params(n);
    n.outputs = {{"out", Type::Color}};
    n.kernel = al_switch_color_kernel();
    return n;
}
}  // namespace alder
#endif
