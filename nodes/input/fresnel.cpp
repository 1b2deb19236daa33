// Fresnel and Layer Weight: how much a dielectric reflects at the viewing angle, or how edge-on the surface is (Blender's nodes).
// Unpolarised Fresnel reflectance in Cook and Torrance's form, "A reflectance model for computer graphics", 1982, appendix.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/input/fresnel.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/math/cycles-inl.h"
#include "nodes/math/finite-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// 1 beyond the critical angle, and where a normal of absurd length leaves no number.
template <class F>
HWY_INLINE F dielectric_reflectance(F cosine, F eta) {
    const F c = abs(cosine);
    const F g2 = eta * eta - F(1) + c * c;
    const F g = safe_sqrt(g2);
    const F a = (g - c) / (g + c), b = (c * (g + c) - F(1)) / (c * (g - c) + F(1));
    const F r = F(0.5) * a * a * (F(1) + b * b);
    return select((g2 > F(0)) & isfinite(r), r, F(1));
}

/// Channels: IOR 0, Normal 1, then I 4, Backfacing 7. On back faces the ratio of indices is the other way round.
struct Fresnel {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F ior = number_max(k.f(0), F(1e-5));
        k.set(0, dielectric_reflectance(dot(k.v(4), k.v(1)), select(k.f(7) != F(0), F(1) / ior, ior)));
    }
};
/// Channels: Blend 0, Normal 1, then I 4, Backfacing 7; outputs Fresnel, Facing.
struct LayerWeight {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F blend = k.f(0), cosine = dot(k.v(4), k.v(1));
        if (k.wants(0)) {
            const F eta = number_max(F(1) - blend, F(1e-5));
            k.set(0, dielectric_reflectance(cosine, select(k.f(7) != F(0), eta, F(1) / eta)));
        }
        if (k.wants(1)) {
            const F limited = cycles_clamp(blend, F(0), F(1.0 - 1e-5));
            const F exponent = select(limited < F(0.5), F(2) * limited, F(0.5) / (F(1) - limited));
            const F facing = abs(cosine);
            k.set(1, F(1) - select(blend != F(0.5), finite_or_limit(pow(facing, exponent)), facing));
        }
    }
};
template <class F>
void fresnel(const Call<F>& c) { c.template each<Fresnel>(); }
template <class F>
void layer_weight(const Call<F>& c) { c.template each<LayerWeight>(); }
ALDER_KERNEL(fresnel)
ALDER_KERNEL(layer_weight)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(fresnel)
ALDER_KERNEL_EXPORT(layer_weight)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeFresnel";
    n.category = "Input";
    n.summary = "how much a dielectric reflects at the viewing angle";
    n.help = "On back faces the index is inverted: the ray comes from inside.";
    n.aliases = {"fresnel"};
    n.params.push_back(f("IOR", 1.5).range(0, 1000));
    n.params.push_back(vector("Normal", 0, 0, 0).unlinked(Global::N));
    n.outputs = {{"Fac", Type::Float}};
    n.globals = {Global::I, Global::Backfacing};
    n.kernel = fresnel_kernel();
    n.cost_ns = 3;
    return n;
}
ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeLayerWeight";
    n.category = "Input";
    n.summary = "weights that grow towards the silhouette, for layering";
    n.help = "Fresnel takes 1 / (1 - Blend) as index. Facing is 1 - |cos|, bent by Blend.";
    n.aliases = {"layer_weight"};
    n.params.push_back(f("Blend", 0.5).range(0, 1));
    n.params.push_back(vector("Normal", 0, 0, 0).unlinked(Global::N));
    n.outputs = {{"Fresnel", Type::Float}, {"Facing", Type::Float}};
    n.globals = {Global::I, Global::Backfacing};
    n.kernel = layer_weight_kernel();
    n.cost_ns = 6;
    return n;
}
}  // namespace alder
#endif
