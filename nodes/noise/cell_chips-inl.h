// Colours of alCellNoise's chips, given the random number of the nearest feature. alshaders specification, section 4.
#if defined(ALDER_NODES_NOISE_CELL_CHIPS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_NOISE_CELL_CHIPS_INL_H_
#undef ALDER_NODES_NOISE_CELL_CHIPS_INL_H_
#else
#define ALDER_NODES_NOISE_CELL_CHIPS_INL_H_
#endif

#include "nodes/num/vec-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// x in [0, 1] picks one of five colours by probability; `smooth` blends from each colour to the next across its share.
/// All probabilities zero: the last colour.
template <bool smooth, class F>
HWY_INLINE Vec3<F> chip_color(F x, const Vec3<F> (&color)[5], const F (&probability)[5]) {
    F sum = probability[0], cdf[4];
    for (int i = 1; i < 5; ++i) sum = sum + probability[i];
    for (int i = 0; i < 4; ++i) cdf[i] = probability[i] / sum + (i ? cdf[i - 1] : F(0));
    Vec3<F> r = color[4];
    if constexpr (smooth) r = lerp(color[3], color[4], (x - cdf[3]) / (F(1) - cdf[3]));
    for (int i = 3; i > 0; --i) {
        Vec3<F> c = color[i];
        if constexpr (smooth) c = lerp(color[i - 1], color[i], (x - cdf[i - 1]) / (cdf[i] - cdf[i - 1]));
        r = select(x < cdf[i], c, r);
    }
    return select(x < cdf[0], color[0], select(isnan(cdf[0]), color[4], r));
}
/// The id divided by 100, as unsigned integers: randomChips groups ids so.
template <class F>
HWY_INLINE Int<F> unsigned_divide_by_100(Int<F> id) {
    // /4 leaves 30 bits; dividing those by 25 in float is a few dozen off at most, which the second step takes away.
    const Int<F> quarter = shr<2>(id), estimate = to_int(to_float<F>(quarter) * F(0.04));
    const Int<F> rest = quarter - estimate * Int<F>(25);
    return estimate + to_int(floor((to_float<F>(rest) + F(0.5)) * F(0.04)));
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
