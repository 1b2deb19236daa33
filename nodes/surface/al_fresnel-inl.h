// Fresnel reflectance as alSurface uses it: dielectric with one index for both sides, and Gulbrandsen's metals.
// alshaders specification, sections 3 and 6.4. Gulbrandsen, "Artist Friendly Metallic Fresnel", JCGT 2014.
#if defined(ALDER_NODES_SURFACE_AL_FRESNEL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_SURFACE_AL_FRESNEL_INL_H_
#undef ALDER_NODES_SURFACE_AL_FRESNEL_INL_H_
#else
#define ALDER_NODES_SURFACE_AL_FRESNEL_INL_H_
#endif

#include "nodes/num/vec-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Smallest index of refraction: keeps 1/ior finite. Far below any use (an index under 1 is a bubble).
template <class F>
HWY_INLINE F al_ior(F ior) { return max(F(1e-3), ior); }

/// Unpolarised reflectance at the cosine c for the index `ior`; 1 under total reflection (ior < 1). The original returns 0 at
/// c = 1; this is the limit, ((ior-1)/(ior+1))^2.
template <class F>
HWY_INLINE F al_fresnel_dielectric(F c, F ior) {
    const F eta = F(1) / ior;
    const F cos_i = min(F(1), max(F(0), c));
    const F s2 = eta * eta * (F(1) - cos_i * cos_i);
    const F cos_t = safe_sqrt(F(1) - s2);
    const F rs = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    const F rp = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    return select(s2 < F(1), F(0.5) * (rs * rs + rp * rp), F(1));
}

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
    const F root = sqrt(r);
    const F n = g * (F(1) - r) / (F(1) + r) + (F(1) - g) * (F(1) + root) / (F(1) - root);
    // Gulbrandsen equation 6; an edge tint below 0 would ask for a negative square.
    const F k2 = ((n + F(1)) * (n + F(1)) * r - (n - F(1)) * (n - F(1))) / (F(1) - r);
    return {n, safe_sqrt(k2)};
}

/// Reflectance of a metal at the cosine c (the usual approximation for n^2 + k^2 >> 1).
template <class F>
HWY_INLINE F al_fresnel_metal(F c, AlMetal<F> m) {
    const F t = m.n * m.n + m.k * m.k, nc2 = F(2) * m.n * c, c2 = c * c;
    const F rs = (t - nc2 + c2) / (t + nc2 + c2);
    const F rp = (t * c2 - nc2 + F(1)) / (t * c2 + nc2 + F(1));
    return F(0.5) * (rs + rp);
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
