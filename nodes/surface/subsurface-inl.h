// What Cycles' nodes with subsurface scattering share: lengths, and the two lobes that light is divided over.
// No include guard of the usual kind: included once per instruction set.
#if defined(ALDER_NODES_SURFACE_SUBSURFACE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_SURFACE_SUBSURFACE_INL_H_
#undef ALDER_NODES_SURFACE_SUBSURFACE_INL_H_
#else
#define ALDER_NODES_SURFACE_SUBSURFACE_INL_H_
#endif

#include "nodes/surface/closure-inl.h"
#include "nodes/surface/subsurface_specs.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// sqrt(3 (1 - alpha')) of the dipole whose diffuse reflectance is `albedo` (Jensen et al. 2001, equation 15: alpha'/2 (1 + e^(-4/3 A s)) e^-s).
/// Cycles halves the interval of alpha' twelve times, which leaves up to 1 % to the step; s itself is searched here, and converges.
template <class F>
HWY_INLINE F dipole_decay(F albedo, F four_thirds_a) {
    F low = F(0), high = F(1.7320508075688772), middle = F(0.8);
    for (int i = 0; i < 24; ++i) {
        middle = F(0.5) * (low + high);
        const F reflected = F(0.5) * (F(1) - middle * middle * F(1.0 / 3)) * (F(1) + exp(-four_thirds_a * middle)) * exp(-middle);
        const Mask<F> above = reflected > albedo;
        low = select(above, middle, low);
        high = select(above, high, middle);
    }
    return select(albedo < F(1e-4), F(1.7320508075688772), select(albedo >= F(0.995), F(1.7320508075688772e-3), middle));
}

/// Mean free path of one channel from Blender's radius.
template <class F>
HWY_INLINE F skin_mean_free_path(F radius, F albedo, F ior) {
    const F inverse = F(1) / ior;
    const F diffuse_fresnel = inverse * (F(0.710) - F(1.440) * inverse) + F(0.668) + F(0.0636) * ior;
    const F four_thirds_a = F(4.0 / 3.0) * (F(1) + diffuse_fresnel) / (F(1) - diffuse_fresnel);
    return radius * dipole_decay(albedo, four_thirds_a);
}

/// `weight` over the lobe that walks and, in channels whose radius is too small to walk, Lambert.
template <class F>
HWY_INLINE void emit_subsurface(const LobeOut<F>& deep, const LobeOut<F>& shallow, Vec3<F> weight, Vec3<F> entry_n, Vec3<F> n, Vec3<F> radius,
                                Vec3<F> albedo, F ior, F width, F anisotropy) {
    const F index = clamp(ior, F(1.01), F(3.8));
    Vec3<F> near(F(0)), length(F(0));
    for (int c = 0; c < 3; ++c) {
        const Mask<F> walks = radius[c] >= F(1e-8);
        near[c] = select(walks, F(0), weight[c]);
        weight[c] = select(walks, weight[c], F(0));
        F l = radius[c] * F(0.25 / 3.14159265358979323846);
        if (deep.spec.kind == LobeKind::RandomWalk && deep.spec.order == 1) l = skin_mean_free_path(radius[c], albedo[c], index);
        length[c] = select(walks, min(l, F(1e15)), F(0));
    }
    if (shallow.wanted()) {
        shallow.weight(near);
        shallow.normal(n);
    }
    if (!deep.wanted()) return;
    deep.weight(weight);
    deep.normal(entry_n);
    deep.param(0, length);
    if (deep.spec.kind == LobeKind::Profile) return;
    deep.param(3, albedo);
    deep.param(6, index);
    deep.param(7, saturate(width));
    deep.param(8, clamp(anisotropy, F(0), F(0.9)));
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
