// Reflectance of a metal from what an artist sees: Gulbrandsen, "Artist Friendly Metallic Fresnel", JCGT 3(4), 2014.
#if defined(ALDER_NODES_INPUT_CONDUCTOR_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_INPUT_CONDUCTOR_INL_H_
#undef ALDER_NODES_INPUT_CONDUCTOR_INL_H_
#else
#define ALDER_NODES_INPUT_CONDUCTOR_INL_H_
#endif

#include "nodes/math/finite-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// One channel at the cosine c. `reflectivity` at normal incidence, limited to 0 ... 0.99; `edge_tint` is Gulbrandsen's g.
template <class F>
HWY_INLINE F conductor_reflectance(F reflectivity, F edge_tint, F c) {
    const F r = clamp(reflectivity, F(0), F(0.99)), g = edge_tint;
    const F root = sqrt(r);
    const F n = g * (F(1) - r) / (F(1) + r) + (F(1) - g) * (F(1) + root) / (F(1) - root);   // equation 9
    const F k2 = (sqr(n + F(1)) * r - sqr(n - F(1))) / (F(1) - r);                          // equation 10
    const F n2k2 = n * n + k2, two_nc = F(2) * n * c, c2 = c * c;
    const F perpendicular = (n2k2 - two_nc + c2) / (n2k2 + two_nc + c2);
    const F parallel = (n2k2 * c2 - two_nc + F(1)) / (n2k2 * c2 + two_nc + F(1));
    const F reflectance = F(0.5) * (perpendicular + parallel);
    return select(isfinite(reflectance), reflectance, F(1));   // an index beyond floats: a mirror
}
template <class F>
HWY_INLINE Vec3<F> conductor_reflectance(Vec3<F> reflectivity, Vec3<F> edge_tint, F c) {
    return {conductor_reflectance(reflectivity.x, edge_tint.x, c), conductor_reflectance(reflectivity.y, edge_tint.y, c),
            conductor_reflectance(reflectivity.z, edge_tint.z, c)};
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
