// Gulbrandsen's metals, as alSurface's metallic mode and alFresnelConductor use them, and limits of the index of refraction.
// alshaders specification, sections 3 and 6.4. Gulbrandsen, "Artist Friendly Metallic Fresnel", JCGT 2014.
#if defined(ALDER_NODES_SURFACE_AL_FRESNEL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_SURFACE_AL_FRESNEL_INL_H_
#undef ALDER_NODES_SURFACE_AL_FRESNEL_INL_H_
#else
#define ALDER_NODES_SURFACE_AL_FRESNEL_INL_H_
#endif

#include "nodes/surface/fresnel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Keeps 1/ior finite. Far below any use (an index under 1 is a bubble).
template <class F>
HWY_INLINE F al_ior(F ior) { return max(F(1e-3), ior); }

/// Index n and extinction k of a metal by its reflectivity and edge tint, one channel.
template <class F>
struct AlMetal {
    F n, k;
    HWY_INLINE AlMetal() {}
    HWY_INLINE AlMetal(F n_, F k_) : n(n_), k(k_) {}
};
template <class F>
HWY_INLINE AlMetal<F> al_metal(F reflectivity, F edge_tint) {
    const F r = min(F(0.99), max(F(0), reflectivity)), g = edge_tint;
    const F root = sqrt(r), highest = (F(1) + root) / (F(1) - root);
    const F n = g * (F(1) - r) / (F(1) + r) + (F(1) - g) * highest;
    // Gulbrandsen, equation 6: ((n+1)^2 r - (n-1)^2)/(1-r), in factors, since the difference cancels for small edge tints; `range` is the
    // highest n less the lowest. Tints below 0 would ask for a negative square.
    const F range = F(2) * root * (F(1) + root) / ((F(1) - root) * (F(1) + r));
    const F k2 = g * range * (n - F(1) / highest);
    return {n, safe_sqrt(k2)};
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
