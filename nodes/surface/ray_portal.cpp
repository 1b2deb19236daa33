// Ray Portal BSDF: rays go on elsewhere (Blender).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/surface/ray_portal.cpp"
#include "hwy/foreach_target.h"

#include "nodes/surface/closure-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct RayPortal {  // Color 0, Position 3, Direction 6; N after the Weight
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const LobeOut<F> out(k, 0);
        out.weight(allocate(k.v(0)));
        out.normal(k.v(10));
        out.param(0, k.v(3));
        out.param(3, k.v(6));
    }
};
template <class F>
void ray_portal(const Call<F>& c) { c.template each<RayPortal>(); }
ALDER_KERNEL(ray_portal)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "nodes/surface/cycles_params.h"

namespace alder {
ALDER_KERNEL_EXPORT(ray_portal)

ALDER_NODE {
    using namespace param;
    NodeType n = cycles_bsdf_node("ShaderNodeBsdfRayPortal", "ray_portal_bsdf", "rays go on elsewhere");
    n.help = "Counts as a transparent surface. Shadow rays do not pass: what lies behind is lit by what rays meet there.";
    n.params = {
        color("Color", 1, 1, 1).doc("share of light that passes"),
        vector("Position", 0, 0, 0).unlinked(Global::P).doc("where rays go on, world space; unlinked: where they are"),
        vector("Direction", 0, 0, 0).doc("where to, world space; zero: as before"),
        weight_socket(),
    };
    n.globals = {Global::N};
    n.kernel = ray_portal_kernel();
    n.cost_ns = 2;
    n.uses = [](const Statics&, int p) { return p != 3; };
    n.lobes = [](const Statics&) -> std::vector<LobeSpec> {
        return {{.kind = LobeKind::RayPortal, .label = LobeLabel::Transparent, .gates = {0}}};
    };
    return n;
}
}  // namespace alder
#endif
