// alFresnelConductor: reflectance of a metal at the view angle. alshaders specification, section 3.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/input/al_fresnel_conductor.cpp"
#include "hwy/foreach_target.h"

#include "nodes/input/conductor-inl.h"
#include "nodes/kernel-inl.h"

#ifndef ALDER_NODES_INPUT_AL_FRESNEL_CONDUCTOR_
#define ALDER_NODES_INPUT_AL_FRESNEL_CONDUCTOR_
namespace alder {
struct Conductor {
    double reflectivity[3], edge_tint[3];
};
/// Fits of the named metals, in the order of the enum; the last item, custom, is not here.
constexpr Conductor kConductors[] = {
    {{0.914, 0.921, 0.921}, {0.971, 0.979, 0.989}},             // aluminium
    {{0.548, 0.549, 0.57}, {0.579, 0.598, 0.62}},               // chrome
    {{0.985, 0.649, 0.546}, {0.996, 0.918, 0.859}},             // copper
    {{0.99, 0.791587, 0.3465}, {0.99, 0.9801, 0.792}},          // gold
    {{0.97, 0.959109, 0.92441}, {0.999, 0.999, 0.998}},         // silver
    {{0.679, 0.642, 0.582}, {0.785, 0.789, 0.783}},             // platinum
    {{0.55, 0.501692, 0.4477}, {0.689119, 0.683298, 0.693}},    // titanium
    {{0.504, 0.49513, 0.475776}, {0.403, 0.419, 0.422}},        // tungsten
};
constexpr int kCustomConductor = 8;
}  // namespace alder
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Channels: normalize 0, reflectivity 1, edgetint 4, Rd 7, Nf 10.
struct NamedConductor {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Conductor& m = kConductors[k.statics().e(0)];
        const F c = dot(-k.v(7), k.v(10));
        for (int i = 0; i < 3; ++i) k.set(i, conductor_reflectance(F(m.reflectivity[i]), F(m.edge_tint[i]), c));
    }
};
struct CustomConductor {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, conductor_reflectance(k.v(1), k.v(4), dot(-k.v(7), k.v(10)))); }
};
template <class F>
void al_fresnel_conductor(const Call<F>& c) {
    if (c.statics().e(0) == kCustomConductor) return c.template each<CustomConductor>();
    c.template each<NamedConductor>();
}
ALDER_KERNEL(al_fresnel_conductor)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(al_fresnel_conductor)

static bool conductor_uses(const Statics& s, int param) { return param == 0 || (param >= 2 && s.e(0) == kCustomConductor); }

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alFresnelConductor";
    n.system = System::AlShaders;
    n.category = "geometry";
    n.summary = "conductor reflectance from reflectivity and edge tint";
    n.help = "Ole Gulbrandsen, \"Artist Friendly Metallic Fresnel\", JCGT 2014, at the angle between normal and view: for colour inputs.";
    n.params = {choice("material", {"aluminium", "chrome", "copper", "gold", "silver", "platinum", "titanium", "tungsten", "custom"}, "aluminium")
                    .doc("a metal, or custom: reflectivity and edgetint"),
                b("normalize", false).no_link().doc("no effect; kept for older scenes"),
                color("reflectivity", 0.94, 0.78, 0.37).doc("custom: reflectance seen head-on, limited to 0 ... 0.99"),
                color("edgetint", 1, 0.98, 0.73).doc("custom: tint towards the edge")};
    n.outputs = {{"out", Type::Color}};
    n.globals = {Global::Rd, Global::Nf};
    n.kernel = al_fresnel_conductor_kernel();
    n.cost_ns = 5;
    n.uses = conductor_uses;
    return n;
}
}  // namespace alder
#endif
