// Directional albedo, with Fresnel, of a rough specular lobe: what one layer of alSurface keeps from the layers below.
// Rules and their derivation: al_albedo_table.py. Largest error against integration, isotropic: 0.002 for indices 1.1 to 2.5,
// 0.02 (at grazing angles) for 10 to 1000; tests/nodes/surface/al_albedo_test.cpp measures it. Indices below 1 have a kink that
// three nodes a cell cannot follow: up to 0.1 there.
#if defined(ALDER_NODES_SURFACE_AL_ALBEDO_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_SURFACE_AL_ALBEDO_INL_H_
#undef ALDER_NODES_SURFACE_AL_ALBEDO_INL_H_
#else
#define ALDER_NODES_SURFACE_AL_ALBEDO_INL_H_
#endif

#include "nodes/surface/al_albedo_table.h"
#include "nodes/surface/al_fresnel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// A place in the table: four cells and how much each counts. Every cell's rule is applied on its own, since the nodes of
/// neighbours do not correspond: far tails are caught by one rule and not by the next.
template <class F>
struct AlAlbedoPlace {
    Int<F> cell;  ///< of the lowest row and column, times 6
    F mu, alpha, fx, fy;

    HWY_INLINE AlAlbedoPlace(F mu_, F alpha_) : mu(mu_), alpha(min(F(1), max(F(kAlbedoMinAlpha), alpha_))) {
        const F last = F(kAlbedoSize - 1), spread = F(kAlbedoStretch) * alpha;
        const F x = min(last, max(F(0), mu * (F(1) + spread) / (mu + spread) * last));
        const F y = min(last, max(F(0), (sqrt(alpha) - F(kAlbedoMinRoot)) * (last / F(1 - kAlbedoMinRoot))));
        const Int<F> column = min(to_int(x), Int<F>(kAlbedoSize - 2)), row = min(to_int(y), Int<F>(kAlbedoSize - 2));
        cell = (row * Int<F>(kAlbedoSize) + column) * Int<F>(6);
        fx = x - to_float<F>(column);
        fy = y - to_float<F>(row);
    }
    HWY_INLINE F share(int corner) const {
        return (corner & 1 ? fx : F(1) - fx) * (corner & 2 ? fy : F(1) - fy);
    }
    static HWY_INLINE const float* corner_of(const float* table, int corner) {
        return table + 6 * ((corner & 1) + (corner & 2 ? kAlbedoSize : 0));
    }
    HWY_INLINE F cosine(const float* t, int i) const { return min(F(1), max(F(0), mu + alpha * gather<F>(t + i, cell))); }
    HWY_INLINE F weight(const float* t, int i) const { return gather<F>(t + 3 + i, cell); }
};

/// The albedo without Fresnel: what masking leaves.
template <class F>
HWY_INLINE F al_albedo_total(const float* table, const AlAlbedoPlace<F>& place) {
    F sum = F(0);
    for (int corner = 0; corner < 4; ++corner) {
        const float* t = AlAlbedoPlace<F>::corner_of(table, corner);
        sum += place.share(corner) * (place.weight(t, 0) + place.weight(t, 1) + place.weight(t, 2));
    }
    return sum;
}

/// Directional albedo for the view cosine mu in (0, 1] and the width alpha; alpha outside 0 ... 1 takes the end's. `fresnel` is
/// a struct whose call gives F or Vec3<F> for a cosine.
template <class F, class Fresnel>
HWY_INLINE auto al_albedo(const float* table, const AlAlbedoPlace<F>& place, const Fresnel& fresnel) {
    auto sum = fresnel(place.mu) * F(0);
    for (int corner = 0; corner < 4; ++corner) {
        const float* t = AlAlbedoPlace<F>::corner_of(table, corner);
        const F share = place.share(corner);
        for (int i = 0; i < 3; ++i) sum += fresnel(place.cosine(t, i)) * (share * place.weight(t, i));
    }
    return sum;
}

/// The same for two widths: the microfacet angles seen from wo spread by the width in wo's plane, while masking follows the
/// mean square of both. x and y are wo's components in the lobe's frame. Rms error 0.006 (dielectric), 0.02 (metal).
template <class F, class Fresnel>
HWY_INLINE auto al_albedo_anisotropic(const float* table, F mu, F alpha_x, F alpha_y, F x, F y, const Fresnel& fresnel) {
    const F mean2 = F(0.5) * (alpha_x * alpha_x + alpha_y * alpha_y), plane2 = x * x + y * y;
    const F ax = alpha_x * x, ay = alpha_y * y;
    const Mask<F> tilted = plane2 > F(1e-12);
    const F seen2 = select(tilted, (ax * ax + ay * ay) / select(tilted, plane2, F(1)), mean2);
    const AlAlbedoPlace<F> seen(mu, sqrt(seen2)), mean(mu, sqrt(mean2));
    return al_albedo(table, seen, fresnel) * (al_albedo_total(table, mean) / al_albedo_total(table, seen));
}

/// Fresnel curves to call al_albedo with.
template <class F>
struct AlDielectricCurve {
    F ior;
    HWY_INLINE F operator()(F c) const { return fresnel_dielectric(c, ior); }
};
template <class F>
struct AlMetalCurve {
    Vec3<F> n, k;
    HWY_INLINE Vec3<F> operator()(F c) const { return fresnel_conductor(c, n, k); }
};

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
