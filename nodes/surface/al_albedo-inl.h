// Directional albedo, with Fresnel, of a rough specular lobe: what one layer of alSurface keeps from the layers below.
// Rules and their derivation: al_albedo_table.py. Largest error against integration, isotropic: 0.008 for indices 1.1 to 2.5,
// 0.025 for 10 to 1000 and for metals; tests/nodes/surface/al_albedo_test.cpp measures it.
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

/// Albedo = sum of weight[i] F(cosine[i]).
template <class F>
struct AlAlbedoRule {
    F cosine[3], weight[3];
    HWY_INLINE AlAlbedoRule() {}
    HWY_INLINE F total() const { return weight[0] + weight[1] + weight[2]; }
};

/// One number of the cells around a place in the table, bilinear.
template <class F>
struct AlAlbedoPlace {
    Int<F> cell;
    F fx, fy;
    HWY_INLINE F value(const float* t) const {
        const F low = lerp(gather<F>(t, cell), gather<F>(t + 6, cell), fx);
        const F high = lerp(gather<F>(t + 6 * kAlbedoSize, cell), gather<F>(t + 6 * kAlbedoSize + 6, cell), fx);
        return lerp(low, high, fy);
    }
};

/// Rule for the view cosine mu in (0, 1] and the width alpha, bilinear in the table; alpha outside 0 ... 1 takes the end's.
template <class F>
HWY_INLINE AlAlbedoRule<F> al_albedo_rule(const float* table, F mu, F alpha) {
    const F last = F(kAlbedoSize - 1);
    const F a = min(F(1), max(F(1e-3), alpha)), spread = F(kAlbedoStretch) * a;
    const F x = min(last, max(F(0), mu * (F(1) + spread) / (mu + spread) * last)), y = sqrt(a) * last;
    const Int<F> column = min(to_int(x), Int<F>(kAlbedoSize - 2)), row = min(to_int(y), Int<F>(kAlbedoSize - 2));
    const AlAlbedoPlace<F> place{(row * Int<F>(kAlbedoSize) + column) * Int<F>(6), x - to_float<F>(column), y - to_float<F>(row)};
    AlAlbedoRule<F> rule;
    for (int i = 0; i < 3; ++i) {
        rule.cosine[i] = min(F(1), max(F(0), mu + a * place.value(table + i)));
        rule.weight[i] = place.value(table + 3 + i);
    }
    return rule;
}

/// The same for two widths: the microfacet angles seen from wo spread by the width in wo's plane, while masking follows the
/// mean square of both. x and y are wo's components in the lobe's frame. Rms error 0.006 (dielectric), 0.02 (metal).
template <class F>
HWY_INLINE AlAlbedoRule<F> al_albedo_rule(const float* table, F mu, F alpha_x, F alpha_y, F x, F y) {
    const F mean2 = F(0.5) * (alpha_x * alpha_x + alpha_y * alpha_y), plane2 = x * x + y * y;
    const F ax = alpha_x * x, ay = alpha_y * y;
    const Mask<F> tilted = plane2 > F(1e-12);
    const F seen2 = select(tilted, (ax * ax + ay * ay) / select(tilted, plane2, F(1)), mean2);
    AlAlbedoRule<F> rule = al_albedo_rule(table, mu, sqrt(seen2));
    const F scale = al_albedo_rule(table, mu, sqrt(mean2)).total() / rule.total();
    for (int k = 0; k < 3; ++k) rule.weight[k] = rule.weight[k] * scale;
    return rule;
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
