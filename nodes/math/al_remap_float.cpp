// alRemapFloat: input range, contrast about a pivot, bias and gain, output range, clamp; blended with the input by a mask.
// alshaders specification, section 2; bias and gain: Perlin and Hoffert, "Hypertexture", SIGGRAPH 1989.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/math/al_remap_float.cpp"
#include "hwy/foreach_target.h"

#include "nodes/math/remap-inl.h"
#include "nodes/math/remap_params.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct AlRemapFloat {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F input = k.f(0), mask = k.f(13);
        k.set(0, select(mask > F(0), lerp(input, al_remap(k, 1, input), mask), input));
    }
};
template <class F>
void al_remap_float(const Call<F>& c) { c.template each<AlRemapFloat>(); }
ALDER_KERNEL(al_remap_float)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(al_remap_float)

/// The correction matters only where the mask is positive.
static std::vector<LazyRule> masked(const Statics&) {
    std::vector<LazyRule> rules;
    for (int param = 1; param <= 12; ++param) rules.push_back({param, 13, LazyRule::NeededIfPositive});
    return rules;
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alRemapFloat";
    n.system = System::AlShaders;
    n.category = "math";
    n.summary = "float correction chain";
    n.help = "Range, contrast, bias and gain, range, clamp. Equal input bounds give an infinity or NaN, which the clamp turns into clampMax.";
    n.params.push_back(f("input", 0).doc("value to remap"));
    add_remap_params(n.params);
    n.params.push_back(f("mask", 1).range(0, 1).doc("0 leaves the input, 1 is the full remap; above 1 extrapolates"));
    n.outputs = {{"out", Type::Float}};
    n.kernel = al_remap_float_kernel();
    n.cost_ns = 3;
    n.lazy = masked;
    return n;
}
}  // namespace alder
#endif
