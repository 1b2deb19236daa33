// Scalar and vector functions with Cycles' own treatment of NaN, zero divisors and ties, shared by the Blender nodes.
// Cycles 4.5, util/math_base.h and util/math_float3.h: facts of behaviour; where a value differs from the C library's it says so.
#if defined(ALDER_NODES_MATH_CYCLES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_MATH_CYCLES_INL_H_
#undef ALDER_NODES_MATH_CYCLES_INL_H_
#else
#define ALDER_NODES_MATH_CYCLES_INL_H_
#endif

#include "nodes/num/math-inl.h"
#include "nodes/num/vec-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// The second operand where the comparison fails, so a NaN in `a` is dropped: clamping a NaN gives the lower bound.
template <class F>
HWY_INLINE F second_max(F a, F b) { return select(a > b, a, b); }
template <class F>
HWY_INLINE F second_min(F a, F b) { return select(a < b, a, b); }
template <class F>
HWY_INLINE F cycles_clamp(F x, F lo, F hi) { return second_min(second_max(x, lo), hi); }
template <class F>
HWY_INLINE F cycles_saturate(F x) { return cycles_clamp(x, F(0), F(1)); }
template <class F>
HWY_INLINE Vec3<F> cycles_saturate(Vec3<F> v) { return {cycles_saturate(v.x), cycles_saturate(v.y), cycles_saturate(v.z)}; }
/// C's fmin and fmax: a NaN on either side is dropped.
template <class F>
HWY_INLINE F number_min(F a, F b) { return select(isnan(a), b, min(a, b)); }
template <class F>
HWY_INLINE F number_max(F a, F b) { return select(isnan(a), b, max(a, b)); }

/// 0 for a negative base with a fractional exponent (or one too large to be an int).
template <class F>
HWY_INLINE F safe_pow(F a, F b) {
    const Mask<F> undefined = (a < F(0)) & (b != to_float<F>(to_int(b)));
    return select(undefined, F(0), pow(a, b));
}
/// Logarithm of a to base b; 0 where either is not positive or the base is 1.
template <class F>
HWY_INLINE F safe_log(F a, F b) {
    return select((a <= F(0)) | (b <= F(0)), F(0), safe_divide(log(a), log(b)));
}
template <class F>
HWY_INLINE F inverse_sqrt(F a) { return select(a > F(0), F(1) / sqrt(a), F(0)); }
template <class F>
HWY_INLINE F safe_asin(F a) { return asin(cycles_clamp(a, F(-1), F(1))); }
template <class F>
HWY_INLINE F safe_acos(F a) { return acos(cycles_clamp(a, F(-1), F(1))); }
/// 0 for the zero vector.
template <class F>
HWY_INLINE F safe_atan2(F y, F x) { return select((x == F(0)) & (y == F(0)), F(0), atan2(y, x)); }
template <class F>
HWY_INLINE F sign(F a) { return select(a == F(0), F(0), select(a < F(0), F(-1), F(1))); }
template <class F>
HWY_INLINE F fract(F a) { return a - floor(a); }
template <class F>
HWY_INLINE F truncate(F a) { return select(a >= F(0), floor(a), ceil(a)); }
template <class F>
HWY_INLINE F safe_modulo(F a, F b) { return select(b != F(0), fmod(a, select(b != F(0), b, F(1))), F(0)); }
/// a - q b rounded once: the reference is built with fused multiply-add, and remainders cancel. The product of two floats is
/// exact in double.
HWY_INLINE VF remainder_of(VF a, VF q, VF b) { return to_lanes(Doubles(a) - Doubles(q) * Doubles(b)); }
HWY_INLINE float remainder_of(float a, float q, float b) { return static_cast<float>(static_cast<double>(a) - static_cast<double>(q) * b); }
HWY_INLINE double remainder_of(double a, double q, double b) { return std::fma(-q, b, a); }
/// a b + c rounded once on every instruction set, where the reference's fused result shows (cancelling polynomials).
HWY_INLINE VF fused(VF a, VF b, VF c) { return to_lanes(Doubles(a) * Doubles(b) + Doubles(c)); }
HWY_INLINE float fused(float a, float b, float c) { return static_cast<float>(static_cast<double>(a) * b + c); }
HWY_INLINE double fused(double a, double b, double c) { return std::fma(a, b, c); }
template <class F>
HWY_INLINE F safe_floored_modulo(F a, F b) { return select(b != F(0), remainder_of(a, floor(a / b), b), F(0)); }
template <class F>
HWY_INLINE F snap(F a, F b) { return floor(safe_divide(a, b)) * b; }
template <class F>
HWY_INLINE F wrap(F value, F hi, F lo) {
    const F range = hi - lo;
    return select(range != F(0), remainder_of(value, floor((value - lo) / range), range), lo);
}
template <class F>
HWY_INLINE F pingpong(F a, F b) {
    return select(b != F(0), abs(fract((a - b) / (b * F(2))) * b * F(2) - b), F(0));
}
/// Polynomial smooth minimum, Inigo Quilez, "smooth minimum", cubic form.
template <class F>
HWY_INLINE F smooth_min(F a, F b, F k) {
    const F h = number_max(k - abs(a - b), F(0)) / k;
    const F sharp = number_min(a, b);
    return select(k != F(0), sharp - h * h * h * k * F(1.0 / 6.0), sharp);
}
template <class F>
HWY_INLINE F compare(F a, F b, F epsilon) {
    return select((a == b) | (abs(a - b) <= number_max(epsilon, F(1.1920928955078125e-7))), F(1), F(0));
}
/// a + t (b - a): Cycles' form, monotone in t; not exactly b at t = 1.
template <class F>
HWY_INLINE F interp(F a, F b, F t) { return a + t * (b - a); }
template <class F>
HWY_INLINE Vec3<F> interp(Vec3<F> a, Vec3<F> b, F t) { return a + t * (b - a); }

template <class F>
HWY_INLINE Vec3<F> safe_divide(Vec3<F> a, Vec3<F> b) {
    return {safe_divide(a.x, b.x), safe_divide(a.y, b.y), safe_divide(a.z, b.z)};
}
template <class F>
HWY_INLINE Mask<F> is_zero(Vec3<F> v) { return (v.x == F(0)) & (v.y == F(0)) & (v.z == F(0)); }

/// Rotation by Euler angles in XYZ order, columns.
template <class F>
struct Rotation {
    Vec3<F> x, y, z;
    HWY_INLINE explicit Rotation(Vec3<F> euler_rad) {
        const F cx = cos(euler_rad.x), cy = cos(euler_rad.y), cz = cos(euler_rad.z);
        const F sx = sin(euler_rad.x), sy = sin(euler_rad.y), sz = sin(euler_rad.z);
        x = {cy * cz, cy * sz, -sy};
        y = {sy * sx * cz - cx * sz, sy * sx * sz + cx * cz, cy * sx};
        z = {sy * cx * cz + sx * sz, sy * cx * sz - sx * cz, cy * cx};
    }
    HWY_INLINE Vec3<F> apply(Vec3<F> v) const { return x * v.x + y * v.y + z * v.z; }
    HWY_INLINE Vec3<F> apply_inverse(Vec3<F> v) const { return {dot(x, v), dot(y, v), dot(z, v)}; }
};

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
