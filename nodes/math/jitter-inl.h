// The arithmetic of alJitterColor, given its three random numbers. alshaders specification, section 2.
#if defined(ALDER_NODES_MATH_JITTER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_MATH_JITTER_INL_H_
#undef ALDER_NODES_MATH_JITTER_INL_H_
#else
#define ALDER_NODES_MATH_JITTER_INL_H_
#endif

#include "nodes/math/al_color-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

template <class F>
HWY_INLINE Vec3<F> jitter_color(Vec3<F> c, F saturation, F hue, F gain, Mask<F> clamped) {
    const Mask<F> has_saturation = saturation != F(1), has_hue = hue != F(0);
    c = select(has_saturation, al_saturate(c, saturation), c);
    if (any(has_hue)) c = select(has_hue, al_turn_hue(c, hue), c);
    c = c * gain;
    return select(clamped, Vec3<F>(saturate(c.x), saturate(c.y), saturate(c.z)), c);
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
