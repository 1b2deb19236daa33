// Colour of a glowing body in Rec.709 by Cycles' fit: per band of temperature a/T + b T + c for red and green, a cubic for blue.
// Its luminance is about 1 throughout; colours outside Rec.709 have negative channels.
#if defined(ALDER_NODES_COLOR_BLACKBODY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_COLOR_BLACKBODY_INL_H_
#undef ALDER_NODES_COLOR_BLACKBODY_INL_H_
#else
#define ALDER_NODES_COLOR_BLACKBODY_INL_H_
#endif

#include "nodes/color/spectrum_tables.h"
#include "nodes/kernel-inl.h"
#include "nodes/math/cycles-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// t in kelvin, limited to 800 ... 12000.
template <class F>
HWY_INLINE Vec3<F> blackbody_rec709(F t) {
    using I = Int<F>;
    I band = I(0);
    for (int i = 1; i < kBlackbodyBands; ++i) band = select(t >= F(kBlackbodyBandStart[i]), I(i), band);
    const F inverse = F(1) / t;
    Vec3<F> c;
    for (int i = 0; i < 2; ++i) {
        const float* const fit = i == 0 ? kBlackbodyRed : kBlackbodyGreen;
        const I at = band + band + band;
        c[i] = fused(gather<F>(fit, at), inverse, gather<F>(fit, at + I(1)) * t) + gather<F>(fit, at + I(2));
    }
    const I at = shl<2>(band);
    c.z = gather<F>(kBlackbodyBlue, at);
    for (int i = 1; i < 4; ++i) c.z = fused(c.z, t, gather<F>(kBlackbodyBlue, at + I(i)));
    const Mask<F> hot = t >= F(12000), cold = t < F(800);
    for (int i = 0; i < 3; ++i) c[i] = select(hot, F(kBlackbodyHot[i]), select(cold, F(kBlackbodyCold[i]), c[i]));
    return c;
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
