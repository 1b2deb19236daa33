// Results that stay finite for finite operands of any size: lengths and directions of vectors whose squares leave a float's range,
// and the limit that an overflow is taken to. Ordinary numbers come out with the same bits as from length() and normalize().
#if defined(ALDER_NODES_MATH_FINITE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_MATH_FINITE_INL_H_
#undef ALDER_NODES_MATH_FINITE_INL_H_
#else
#define ALDER_NODES_MATH_FINITE_INL_H_
#endif

#include <limits>

#include "nodes/num/vec-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// x; the largest number of its sign where it overflowed; 0 for NaN, which two overflows that met have left.
template <class F>
HWY_INLINE F finite_or_limit(F x) {
    const F most(std::numeric_limits<float>::max());
    return select(abs(x) <= most, x, select(isnan(x), F(0), copysign(most, x)));
}
template <class F>
HWY_INLINE Vec3<F> finite_or_limit(Vec3<F> v) { return {finite_or_limit(v.x), finite_or_limit(v.y), finite_or_limit(v.z)}; }

/// A power of two that brings the vector to where its square is neither infinite nor denormal; 1 for ordinary vectors.
template <class F>
HWY_INLINE F scale_for_square(Vec3<F> v) {
    const F most = max_component(Vec3<F>(abs(v.x), abs(v.y), abs(v.z)));
    return select(most > F(0x1p60f), F(0x1p-70f), select(most < F(0x1p-60f), F(0x1p100f), F(1)));
}
/// |v|, infinite only where the length itself is.
template <class F>
HWY_INLINE F length_of_any(Vec3<F> v) {
    const F s = scale_for_square(v);
    return length(v * s) / s;
}
/// v/|v|. The zero vector gives NaN, as normalize() does.
template <class F>
HWY_INLINE Vec3<F> normalize_any(Vec3<F> v) { return normalize(v * scale_for_square(v)); }
/// The same, but the zero vector stays zero.
template <class F>
HWY_INLINE Vec3<F> safe_normalize_any(Vec3<F> v) { return safe_normalize(v * scale_for_square(v)); }

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
