// The normal of a flake given the number of its cell. alshaders specification, section 4 (alFlake).
#if defined(ALDER_NODES_NOISE_FLAKE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_NOISE_FLAKE_INL_H_
#undef ALDER_NODES_NOISE_FLAKE_INL_H_
#else
#define ALDER_NODES_NOISE_FLAKE_INL_H_
#endif

#include "nodes/noise/tea-inl.h"
#include "nodes/num/math-inl.h"
#include "nodes/num/vec-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// In the tangent frame, z along the normal. `amount` is the share of cells with a flake, `divergence` how far it tilts. Not of
/// unit length.
template <class F>
HWY_INLINE Vec3<F> flake_normal(Int<F> id, F amount, F divergence) {
    const F share = saturate(amount), u1 = tea_float<F>(id, Int<F>(0));
    const Mask<F> flake = u1 < share;
    const Vec3<F> flat(F(0), F(0), F(1));
    if (!any(flake)) return flat;
    const F z = u1 / select(flake, share, F(1)), r = safe_sqrt(F(1) - z * z);
    const F angle = F(6.28318530717958647693) * tea_float<F>(id, Int<F>(1));
    const Vec3<F> d(r * cos(angle), r * sin(angle), z);
    return select<F>(flake, lerp(flat, d, saturate(divergence)), flat);
}

/// r of the frame (U, V, n): V = n × dPdu, U = V × n, or any frame of n where dPdu does not give one.
template <class F>
HWY_INLINE Vec3<F> to_shading_frame(Vec3<F> r, Vec3<F> n, Vec3<F> dpdu) {
    Vec3<F> v = cross(n, safe_normalize(dpdu));
    const Mask<F> usable = dot(v, v) > F(1e-12);
    if (!all(usable)) {
        // Across the axis that n is least along.
        const Mask<F> x_small = (abs(n.x) <= abs(n.y)) & (abs(n.x) <= abs(n.z)), y_small = abs(n.y) <= abs(n.z);
        const Vec3<F> axis = select<F>(x_small, {F(1), F(0), F(0)}, select<F>(y_small, {F(0), F(1), F(0)}, {F(0), F(0), F(1)}));
        v = select<F>(usable, v, cross(n, axis));
    }
    v = safe_normalize(v);
    return cross(v, n) * r.x + v * r.y + n * r.z;
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
