// alInputScalar: a number known at the shading point, remapped. alshaders specification, section 3.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/input/al_input_scalar.cpp"
#include "hwy/foreach_target.h"

#include "nodes/math/remap-inl.h"
#include "nodes/math/remap_params.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct FacingRatio {   // operands Nf, Rd
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, dot(k.v(0), -k.v(3))); }
};
struct RemapOnly {   // operands: the twelve parameters, then the value
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, al_remap(k, 0, k.f(12))); }
};
template <class F>
void facing_ratio(const Call<F>& c) { c.template each<FacingRatio>(); }
template <class F>
void remap_only(const Call<F>& c) { c.template each<RemapOnly>(); }
ALDER_KERNEL(facing_ratio)
ALDER_KERNEL(remap_only)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "graph/lowering.h"

namespace alder {
ALDER_KERNEL_EXPORT(facing_ratio)
ALDER_KERNEL_EXPORT(remap_only)

static ValueRef scalar_of(Lowering& l) {
    switch (l.statics().e(0)) {
        case 1: return l.global(Global::FootprintArea);
        case 2: return l.global(Global::FaceIndex);
        case 3: return l.global(Global::RayLength);
        case 4: return l.global(Global::RayDepth);
        case 5: {
            const std::string& name = l.statics().text[1];
            return name.empty() ? l.constant(Type::Float, 0) : l.attribute(name, Type::Float);   // missing: 0
        }
        default: {
            const ValueRef operands[] = {l.global(Global::Nf), l.global(Global::Rd)};
            return l.op("facing_ratio", facing_ratio_kernel(), operands, Type::Float);
        }
    }
}
static void lower_input_scalar(Lowering& l, int) {
    std::vector<ValueRef> operands;
    for (int i = 2; i < 14; ++i) operands.push_back(l.input(i));
    operands.push_back(scalar_of(l));
    l.result(l.op("al_remap", remap_only_kernel(), operands, Type::Float));
}
static bool input_scalar_uses(const Statics& s, int param) { return param != 1 || s.e(0) == 5; }

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alInputScalar";
    n.system = System::AlShaders;
    n.category = "geometry";
    n.summary = "shading scalars, remapped";
    n.help = "facing-ratio is the cosine between normal and view; area is that of the ray's footprint; User reads a float attribute, 0 where missing.";
    n.params.push_back(choice("input", {"facing-ratio", "area", "face-index", "ray-length", "ray-depth", "User"}, "facing-ratio").doc("which number"));
    n.params.push_back(string("userName").doc("User: name of the attribute"));
    add_remap_params(n.params);
    n.outputs = {{"out", Type::Float}};
    n.cost_ns = 3;
    n.uses = input_scalar_uses;
    n.lower = lower_input_scalar;
    return n;
}
}  // namespace alder
#endif
