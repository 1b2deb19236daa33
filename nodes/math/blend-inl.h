// The 25 blend modes of alLayerColor: M(b, s) for what is below and this layer. alshaders specification, section 2.
#if defined(ALDER_NODES_MATH_BLEND_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_MATH_BLEND_INL_H_
#undef ALDER_NODES_MATH_BLEND_INL_H_
#else
#define ALDER_NODES_MATH_BLEND_INL_H_
#endif

#include "nodes/math/blend_modes.h"
#include "nodes/num/vec-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

template <class F>
HWY_INLINE F blend_overlay(F b, F s) { return select(b < F(0.5), F(2) * b * s, F(1) - F(2) * (F(1) - b) * (F(1) - s)); }
template <class F>
HWY_INLINE F blend_dodge(F b, F s, Mask<F> clamped) {
    const F r = b / (F(1) - s);
    return select(s == F(1), F(1), select(clamped, min(r, F(1)), r));
}
template <class F>
HWY_INLINE F blend_burn(F b, F s) { return select(s == F(0), F(0), max(F(1) - (F(1) - b) / s, F(0))); }
template <class F>
HWY_INLINE F blend_reflect(F b, F s, Mask<F> clamped) {
    const F r = b * b / (F(1) - s);
    return select(s == F(1), F(1), select(clamped, clamp(r, F(0), F(1)), r));
}
template <class F>
HWY_INLINE F blend_vivid(F b, F s, Mask<F> clamped) {
    return select(s < F(0.5), blend_burn(b, F(2) * s), blend_dodge(b, F(2) * (s - F(0.5)), clamped));
}

/// `clamped`: clamp_result, read by the modes that the table names.
template <BlendMode mode, class F>
HWY_INLINE F blend_channel(F b, F s, Mask<F> clamped) {
    using enum BlendMode;
    if constexpr (mode == Lighten) return max(b, s);
    else if constexpr (mode == Darken) return min(b, s);
    else if constexpr (mode == Multiply) return b * s;
    else if constexpr (mode == Average) return (b + s) * F(0.5);
    else if constexpr (mode == Add || mode == LinearDodge) return select(clamped, min(b + s, F(1)), b + s);
    else if constexpr (mode == Subtract || mode == LinearBurn) {
        const F r = b + s - F(1);
        return select(clamped, max(r, F(0)), r);
    } else if constexpr (mode == Difference) return abs(b - s);
    else if constexpr (mode == Negation) return F(1) - abs(F(1) - b - s);
    else if constexpr (mode == Exclusion) return b + s - F(2) * b * s;
    else if constexpr (mode == Screen) return F(1) - (F(1) - b) * (F(1) - s);
    else if constexpr (mode == Overlay) return blend_overlay(b, s);
    else if constexpr (mode == SoftLight) {
        // NaN for b < 0 and s >= 1/2, as in the original.
        return select(s < F(0.5), F(2) * b * s + b * b * (F(1) - F(2) * s), sqrt(b) * (F(2) * s - F(1)) + F(2) * b * (F(1) - s));
    } else if constexpr (mode == HardLight) return blend_overlay(s, b);
    else if constexpr (mode == ColorDodge) return blend_dodge(b, s, clamped);
    else if constexpr (mode == ColorBurn) return blend_burn(b, s);
    else if constexpr (mode == LinearLight) {
        const F r = select(s < F(0.5), b + F(2) * s - F(1), b + F(2) * (s - F(0.5)));
        return select(clamped, clamp(r, F(0), F(1)), r);
    } else if constexpr (mode == VividLight) return blend_vivid(b, s, clamped);
    else if constexpr (mode == PinLight) return select(s < F(0.5), min(b, F(2) * s), max(b, F(2) * (s - F(0.5))));
    else if constexpr (mode == HardMix) return select(blend_vivid(b, s, clamped) < F(0.5), F(0), F(1));
    else if constexpr (mode == Reflect) return blend_reflect(b, s, clamped);
    else if constexpr (mode == Glow) return blend_reflect(s, b, clamped);
    else if constexpr (mode == Phoenix) return min(b, s) - max(b, s) + F(1);
    else return s;
}
template <BlendMode mode, class F>
HWY_INLINE Vec3<F> blend_colors(Vec3<F> b, Vec3<F> s, Mask<F> clamped) {
    return {blend_channel<mode>(b.x, s.x, clamped), blend_channel<mode>(b.y, s.y, clamped), blend_channel<mode>(b.z, s.z, clamped)};
}
/// The mode is the same for a whole batch, so that the branch costs next to nothing.
template <class F>
HWY_INLINE Vec3<F> blend(BlendMode mode, Vec3<F> b, Vec3<F> s, Mask<F> clamped) {
    switch (mode) {
#define ALDER_BLEND_CASE(name, label) \
    case BlendMode::name: return blend_colors<BlendMode::name>(b, s, clamped);
        ALDER_BLEND_MODES(ALDER_BLEND_CASE)
#undef ALDER_BLEND_CASE
    }
    return s;
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
