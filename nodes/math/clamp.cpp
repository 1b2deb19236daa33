// Clamp: limits a number to a range; Range mode accepts the bounds either way round (Blender's node).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/math/clamp.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/math/cycles-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// min(max(value, lo), hi): reversed bounds give hi.
struct ClampMinMax {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, cycles_clamp(k.f(0), k.f(1), k.f(2))); }
};
struct ClampRange {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F value = k.f(0), lo = k.f(1), hi = k.f(2);
        k.set(0, select(lo > hi, cycles_clamp(value, hi, lo), cycles_clamp(value, lo, hi)));
    }
};
template <class F>
void clamp_node(const Call<F>& c) {
    if (c.statics().e(3) == 1) c.template each<ClampRange>();
    else c.template each<ClampMinMax>();
}
ALDER_KERNEL(clamp_node)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(clamp_node)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeClamp";
    n.category = "Converter";
    n.summary = "limits a number to a range";
    n.help = "Min Max: min(max(Value, Min), Max). Range: the bounds may be given either way round.";
    n.aliases = {"clamp"};
    n.params.push_back(f("Value", 1));
    n.params.push_back(f("Min", 0).range(-10000, 10000));
    n.params.push_back(f("Max", 1).range(-10000, 10000));
    n.params.push_back(choice("clamp_type", std::vector<Item>{{"MINMAX", "Min Max", "minmax"}, {"RANGE", "Range", "range"}}, "MINMAX"));
    n.outputs = {{"Result", Type::Float}};
    n.kernel = clamp_node_kernel();
    return n;
}
}  // namespace alder
#endif
