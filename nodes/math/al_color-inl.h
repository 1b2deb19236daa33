// Colour helpers of the alShaders nodes: powers, hue-saturation-value. alshaders specification, sections 1.2 and 1.3.
#if defined(ALDER_NODES_MATH_AL_COLOR_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_MATH_AL_COLOR_INL_H_
#undef ALDER_NODES_MATH_AL_COLOR_INL_H_
#else
#define ALDER_NODES_MATH_AL_COLOR_INL_H_
#endif

#include "nodes/num/math-inl.h"
#include "nodes/num/vec-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// c^e, and 0 where c <= 0.
template <class F>
HWY_INLINE F al_powc(F c, F e) { return select(c > F(0), pow(max(F(0), c), e), F(0)); }
template <class F>
HWY_INLINE Vec3<F> al_powc(Vec3<F> c, F e) { return {al_powc(c.x, e), al_powc(c.y, e), al_powc(c.z, e)}; }

/// Hue in turns; greys and black have hue 0.
template <class F>
HWY_INLINE Vec3<F> al_rgb_to_hsv(Vec3<F> c) {
    const F v = max_component(c), delta = v - min_component(c);
    const F s = select(v > F(0), delta / v, F(0));
    F h = select(c.x >= v, (c.y - c.z) / delta, select(c.y >= v, F(2) + (c.z - c.x) / delta, F(4) + (c.x - c.y) / delta));
    h = h / F(6);
    h = select(h < F(0), h + F(1), h);
    return {select(s <= F(0), F(0), h), s, v};
}
template <class F>
HWY_INLINE Vec3<F> al_hsv_to_rgb(Vec3<F> c) {
    F h = F(6) * (c.x - floor(c.x));
    h = select(h >= F(6), F(0), h);   // a hue just below a whole turn rounds to 6: red, not magenta
    const F i = trunc(h), f = h - i, s = c.y, v = c.z;
    const F p = v * (F(1) - s), q = v * (F(1) - s * f), t = v * (F(1) - s * (F(1) - f));
    Vec3<F> r(v, p, q);
    r = select(i == F(0), Vec3<F>(v, t, p), r);
    r = select(i == F(1), Vec3<F>(q, v, p), r);
    r = select(i == F(2), Vec3<F>(p, v, t), r);
    r = select(i == F(3), Vec3<F>(p, q, v), r);
    r = select(i == F(4), Vec3<F>(t, p, v), r);
    return select(s < F(1e-4), Vec3<F>(v), r);
}
/// Turns the hue by `turns`.
template <class F>
HWY_INLINE Vec3<F> al_turn_hue(Vec3<F> c, F turns) {
    Vec3<F> hsv = al_rgb_to_hsv(c);
    hsv.x += turns;
    return al_hsv_to_rgb(hsv);
}
/// Towards grey of the same luminance (saturation below 1) or away from it.
template <class F>
HWY_INLINE Vec3<F> al_saturate(Vec3<F> c, F saturation) { return lerp(Vec3<F>(luminance_al(c)), c, saturation); }

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
