// Elementary functions over lanes, about one unit in the last place. Scalars and double use libm, the reference.
//
// Two ways to that accuracy without relying on fused multiply-add, so that SSE4 gives the same quality as AVX2:
//   float    argument reduction that is exact in float, then a short polynomial (exp, asin, atan, sinh, ...);
//   Doubles  the register widened to double for the few steps that lose digits (log, pow, the reduction of sin, cos, fmod).
// Special values (NaN, infinities, signed zeros, denormals) are those of C's Annex F. Arguments beyond a fast path's range
// go to libm, one lane at a time.
// Argument reductions: Cody and Waite, "Software Manual for the Elementary Functions", 1980; Moshier, Cephes.
// Polynomials: near-minimax fits of our own (Lawson's reweighting on Chebyshev nodes); each states its relative error.
#if defined(ALDER_NODES_NUM_MATH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_NUM_MATH_INL_H_
#undef ALDER_NODES_NUM_MATH_INL_H_
#else
#define ALDER_NODES_NUM_MATH_INL_H_
#endif

#include <limits>

#include "nodes/num/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

// ---- Doubles: the lanes of one VF as two registers of double ---------------------------------------------------------
using TagD = hn::ScalableTag<double>;
using TagD64 = hn::RebindToSigned<TagD>;
using TagHalfF = hn::Rebind<float, TagD>;
using TagHalfI = hn::Rebind<int32_t, TagD>;

struct Doubles {
    hn::Vec<TagD> lo, hi;
    HWY_INLINE Doubles(hn::Vec<TagD> l, hn::Vec<TagD> h) : lo(l), hi(h) {}
    HWY_INLINE explicit Doubles(double x) : lo(hn::Set(TagD(), x)), hi(lo) {}
    HWY_INLINE explicit Doubles(VF x)
        : lo(hn::PromoteTo(TagD(), hn::LowerHalf(x.v))), hi(hn::PromoteTo(TagD(), hn::UpperHalf(TagHalfF(), x.v))) {}
    HWY_INLINE explicit Doubles(VI x)
        : lo(hn::PromoteTo(TagD(), hn::LowerHalf(x.v))), hi(hn::PromoteTo(TagD(), hn::UpperHalf(TagHalfI(), x.v))) {}
    friend HWY_INLINE Doubles operator+(Doubles a, Doubles b) { return {hn::Add(a.lo, b.lo), hn::Add(a.hi, b.hi)}; }
    friend HWY_INLINE Doubles operator-(Doubles a, Doubles b) { return {hn::Sub(a.lo, b.lo), hn::Sub(a.hi, b.hi)}; }
    friend HWY_INLINE Doubles operator*(Doubles a, Doubles b) { return {hn::Mul(a.lo, b.lo), hn::Mul(a.hi, b.hi)}; }
    friend HWY_INLINE Doubles operator/(Doubles a, Doubles b) { return {hn::Div(a.lo, b.lo), hn::Div(a.hi, b.hi)}; }
};
/// Rounds to float once: overflow gives infinity, small values denormals.
HWY_INLINE VF to_lanes(Doubles a) {
    return VF(hn::Combine(TagF(), hn::DemoteTo(TagHalfF(), a.hi), hn::DemoteTo(TagHalfF(), a.lo)));
}
HWY_INLINE VI to_int_lanes(Doubles a) {
    return VI(hn::Combine(TagI(), hn::DemoteTo(TagHalfI(), a.hi), hn::DemoteTo(TagHalfI(), a.lo)));
}
HWY_INLINE Doubles mad(Doubles a, Doubles b, Doubles c) {
    return {hn::MulAdd(a.lo, b.lo, c.lo), hn::MulAdd(a.hi, b.hi, c.hi)};
}
HWY_INLINE Doubles round(Doubles a) { return {hn::Round(a.lo), hn::Round(a.hi)}; }
HWY_INLINE Doubles trunc(Doubles a) { return {hn::Trunc(a.lo), hn::Trunc(a.hi)}; }
/// Limits to lo ... hi; what a NaN becomes is not defined.
HWY_INLINE Doubles limit(Doubles a, double lo, double hi) {
    const auto l = hn::Set(TagD(), lo), h = hn::Set(TagD(), hi);
    return {hn::Min(hn::Max(a.lo, l), h), hn::Min(hn::Max(a.hi, l), h)};
}
HWY_INLINE Doubles if_then_add(Doubles value, Doubles test_negative, Doubles addend) {
    const auto zero = hn::Zero(TagD());
    return {hn::Add(value.lo, hn::IfThenElseZero(hn::Lt(test_negative.lo, zero), addend.lo)),
            hn::Add(value.hi, hn::IfThenElseZero(hn::Lt(test_negative.hi, zero), addend.hi))};
}

/// c[0] + x (c[1] + x (c[2] + ...)), Horner.
template <class V>
HWY_INLINE V poly(V, double c0) { return V(c0); }
template <class V, class... C>
HWY_INLINE V poly(V x, double c0, C... c) { return mad(poly(x, c...), x, V(c0)); }

// ---- building blocks -------------------------------------------------------------------------------------------------
inline constexpr float kInf = std::numeric_limits<float>::infinity();

HWY_INLINE VI round_to_int(VF a) { return hn::NearestInt(a.v); }
/// x·2^k for |k| <= 252, rounded once.
HWY_INLINE VF scale_by_power_of_two(VF x, VI k) {
    const VI half = sar<1>(k);
    return x * bits_to_float<VF>(shl<23>(half + VI(127))) * bits_to_float<VF>(shl<23>(k - half + VI(127)));
}
/// e^x·2^shift, without overflow on the way; shift 0 or -1.
HWY_INLINE VF exp_shifted(VF x, int shift) {
    x = max(min(x, VF(90)), VF(-105));   // in this order a NaN stays
    const VI k = round_to_int(x * VF(1.44269504088896340736));
    const VF kf = to_float<VF>(k);
    // ln 2 = 355/512 - 2.12194440e-4; the first product is exact.
    const VF r = mad(kf, VF(2.12194440054690583e-4), x - kf * VF(0.693359375));
    // e^r = 1 + r + r² p(r), |r| <= ln 2 / 2, error 2^-28
    const VF p = poly(r, 0.49999994, 0.166665211, 0.041668389, 0.00836871564, 0.00138146);
    return scale_by_power_of_two(mad(r * r, p, r) + VF(1), k + VI(shift));
}
/// log2 of |x| in double, error below 2^-44 relative; +-infinity at infinity and zero. NaN gives garbage.
HWY_INLINE Doubles log2_magnitude(VF x) {
    const VF a = abs(x);
    const VM tiny = a < VF(std::numeric_limits<float>::min());
    const VI bits = float_bits(select(tiny, a * VF(8388608.0f), a));
    // a = 2^e·m with m in sqrt(1/2) ... sqrt(2)
    const VI e = sar<23>(bits - VI(0x3f3504f3));
    const Doubles m(bits_to_float<VF>(bits - shl<23>(e)));
    VF exponent = to_float<VF>(select(tiny, e - VI(23), e));
    exponent = select(a == VF(kInf), VF(kInf), select(a == VF(0), VF(-kInf), exponent));
    // log2 m = s p(s²), s = (m-1)/(m+1), |s| <= 0.1716, error 2^-45
    const Doubles s = (m - Doubles(1.0)) / (m + Doubles(1.0));
    const Doubles p = poly(s * s, 2.8853900817778477, 0.96179669411335766, 0.57707794238857602, 0.41220924737627068,
                           0.31990600102071748, 0.28289451020330741);
    return mad(s, p, Doubles(exponent));
}
/// 2^t rounded to float. NaN gives garbage.
HWY_INLINE VF exp2_of_doubles(Doubles t) {
    t = limit(t, -400.0, 400.0);
    // Adding 1.5·2^52 leaves the nearest integer in the low mantissa bits.
    const Doubles magic(6755399441055744.0), shifted = t + magic, f = t - (shifted - magic);
    // 2^f, |f| <= 1/2, error 2^-34
    const Doubles p = poly(f, 0.99999999996168221, 0.69314718072845383, 0.24022651198156783, 0.055504103534262064,
                           0.0096180272537383996, 0.0013333922579439512, 0.00015469291137759414, 1.5201918294946371e-05);
    const TagD d;
    const TagD64 i;
    return to_lanes({hn::BitCast(d, hn::Add(hn::BitCast(i, p.lo), hn::ShiftLeft<52>(hn::BitCast(i, shifted.lo)))),
                     hn::BitCast(d, hn::Add(hn::BitCast(i, p.hi), hn::ShiftLeft<52>(hn::BitCast(i, shifted.hi))))});
}
/// log2|x|·factor for x >= 0, NaN elsewhere.
HWY_INLINE VF log_scaled(VF x, double factor) {
    const VF l = to_lanes(log2_magnitude(x) * Doubles(factor));
    return select(x >= VF(0), l, VF(std::numeric_limits<float>::quiet_NaN()));
}
/// x = q π/2 + r, |r| <= π/4, for |x| <= kTrigLimit: the integer times the first part of π/2 (33 bits) is exact in double.
inline constexpr float kTrigLimit = 1.6e6f;
HWY_INLINE VF reduce_by_half_pi(VF x, VI& q) {
    const Doubles xd(x), k = round(xd * Doubles(0.63661977236758134308));
    q = to_int_lanes(k);
    return to_lanes(mad(k, Doubles(-6.0771005065061922e-11), xd - k * Doubles(1.5707963267341256)));
}
/// |r| <= π/4, error 2^-28
HWY_INLINE VF sin_reduced(VF r) {
    const VF z = r * r;
    return mad(r * z, poly(z, -0.166666672, 0.00833332911, -0.000198393114, 2.71811768e-06), r);
}
/// |r| <= π/4, error 2^-32
HWY_INLINE VF cos_reduced(VF r) {
    const VF z = r * r;
    return mad(z * z, poly(z, 0.0416666456, -0.00138873165, 2.44331186e-05), VF(1) - VF(0.5) * z);
}
HWY_INLINE VM beyond_trig_limit(VF x) { return (abs(x) > VF(kTrigLimit)) & (abs(x) < VF(kInf)); }
HWY_INLINE VF flip_sign_if(VI bit_at_one, VF x) { return bits_to_float<VF>(float_bits(x) ^ shl<30>(bit_at_one & VI(2))); }
/// asin s for |s| <= 1/2, z = s², error 2^-29
HWY_INLINE VF asin_reduced(VF s, VF z) {
    return mad(s * z, poly(z, 0.166666597, 0.0750050396, 0.0445169546, 0.0318077169, 0.014438604, 0.0375164524), s);
}
/// atan(a/b) for a, b >= 0 in 0 ... π/2, both finite and not both zero. Cephes' three intervals with one division.
HWY_INLINE VF atan_of_ratio(VF a, VF b) {
    const VM high = a > VF(2.41421356237309504880) * b, mid = (!high) & (a > VF(0.41421356237309504880) * b);
    const VF t = select(high, -b, select(mid, a - b, a)) / select(high, a, select(mid, a + b, b));
    // π/2 and π/4 in two parts: what float leaves out matters in the last place.
    const VF rest = select(high, VF(-4.371139e-08), select(mid, VF(-2.1855695e-08), VF(0)));
    const VF base = select(high, VF(1.57079637), select(mid, VF(0.785398185), VF(0)));
    const VF z = t * t;   // error 2^-28
    const VF p = poly(z, -0.333333164, 0.199984714, -0.142435282, 0.105937742, -0.0607811771);
    return base + (mad(t * z, p, rest) + t);
}

// ---- the functions on lanes ------------------------------------------------------------------------------------------
// Long bodies are not inlined: a call costs a few cycles, a dozen copies of pow in a node cost cache and compile time.
namespace lanes {

HWY_INLINE VF exp(VF x) { return exp_shifted(x, 0); }
HWY_INLINE VF exp2(VF x) {
    x = max(min(x, VF(130)), VF(-151));
    const VI k = round_to_int(x);
    const VF f = x - to_float<VF>(k);
    // 2^f = 1 + f p(f), |f| <= 1/2, error 2^-28
    const VF p = poly(f, 0.693147182, 0.240226507, 0.0555041023, 0.00961803831, 0.00133339351, 0.000154667563, 1.5196154e-05);
    return scale_by_power_of_two(mad(f, p, VF(1)), k);
}
inline HWY_NOINLINE VF log(VF x) { return log_scaled(x, 0.69314718055994530942); }
inline HWY_NOINLINE VF log2(VF x) { return log_scaled(x, 1.0); }
inline HWY_NOINLINE VF log10(VF x) { return log_scaled(x, 0.30102999566398119521); }

inline HWY_NOINLINE VF pow(VF x, VF y) {
    const VF ax = abs(x), ay = abs(y);
    VF r = exp2_of_doubles(log2_magnitude(x) * Doubles(y));
    const VF nan(std::numeric_limits<float>::quiet_NaN());
    // Infinite y: above or below one decides; the product above is NaN at |x| = 1 alone.
    r = select((ax == VF(1)) & (ay == VF(kInf)), VF(1), r);
    const VM integer = trunc(y) == y;                                  // every float from 2^24 on is even
    const VF half_y = VF(0.5) * y;
    const VM odd = integer & (trunc(half_y) != half_y);
    const VM sign_bit = float_bits(x) < VI(0);
    r = select(sign_bit & odd, -r, r);
    r = select((x < VF(0)) & !integer & (ax != VF(kInf)), nan, r);
    r = select(isnan(x) | isnan(y), nan, r);
    return select((y == VF(0)) | (x == VF(1)), VF(1), r);
}

inline HWY_NOINLINE VF sin(VF x) {
    VI q;
    const VF r = reduce_by_half_pi(x, q);
    const VF y = flip_sign_if(q, select((q & VI(1)) != VI(0), cos_reduced(r), sin_reduced(r)));
    const VM huge = beyond_trig_limit(x);
    if (any(huge)) return select(huge, map_lanes(x, [](float a) { return std::sin(a); }), y);
    return select(x == VF(0), x, y);   // keeps -0
}
inline HWY_NOINLINE VF cos(VF x) {
    VI q;
    const VF r = reduce_by_half_pi(x, q);
    const VF y = flip_sign_if(q + VI(1), select((q & VI(1)) != VI(0), sin_reduced(r), cos_reduced(r)));
    const VM huge = beyond_trig_limit(x);
    if (any(huge)) return select(huge, map_lanes(x, [](float a) { return std::cos(a); }), y);
    return y;
}
inline HWY_NOINLINE VF tan(VF x) {
    VI q;
    const VF r = reduce_by_half_pi(x, q), s = sin_reduced(r), c = cos_reduced(r);
    const VM odd = (q & VI(1)) != VI(0);
    const VF y = select(odd, -c, s) / select(odd, s, c);
    const VM huge = beyond_trig_limit(x);
    if (any(huge)) return select(huge, map_lanes(x, [](float a) { return std::tan(a); }), y);
    return select(x == VF(0), x, y);
}

inline HWY_NOINLINE VF asin(VF x) {
    const VF a = abs(x);
    const VM outer = a > VF(0.5);
    // Beyond 1/2: asin a = π/2 - 2 asin sqrt((1-a)/2); 1-a is exact there. |x| > 1 gives NaN by the root.
    const VF z = select(outer, VF(0.5) * (VF(1) - a), x * x), s = select(outer, sqrt(z), a);
    const VF p = asin_reduced(s, z);
    return copysign(select(outer, VF(1.57079637) - mad(VF(2), p, VF(4.371139e-08)), p), x);
}
inline HWY_NOINLINE VF acos(VF x) {
    const VF a = abs(x);
    const VM outer = a > VF(0.5);
    const VF z = select(outer, VF(0.5) * (VF(1) - a), x * x), s = select(outer, sqrt(z), x);
    const VF p = asin_reduced(s, z), twice = p + p;
    const VF inner = VF(1.57079637) - (p + VF(4.371139e-08));
    return select(outer, select(x < VF(0), VF(3.14159274) - (twice + VF(8.742278e-08)), twice), inner);
}
inline HWY_NOINLINE VF atan(VF x) {
    const VF a = min(abs(x), VF(1e30));   // infinity; a NaN stays
    return copysign(atan_of_ratio(a, VF(1)), x);
}
inline HWY_NOINLINE VF atan2(VF y, VF x) {
    VF a = abs(y), b = abs(x);
    const VM both_infinite = (a == VF(kInf)) & (b == VF(kInf)), at_origin = (a == VF(0)) & (b == VF(0));
    a = select(both_infinite, VF(1), select(at_origin, VF(0), a));
    b = select(both_infinite | at_origin, VF(1), b);
    // Neither may a + b overflow nor denormals lose digits; the ratio is unchanged.
    const VF larger = max(a, b);
    const VF scale = select(larger > VF(1e38), VF(0.25), select(larger < VF(1e-30), VF(16777216.0f), VF(1)));
    const VF t = atan_of_ratio(a * scale, b * scale);
    const VM left = float_bits(x) < VI(0);   // -0 counts as negative
    const VF r = select(left, VF(3.14159274) - (t + VF(8.742278e-08)), t);
    return select(isnan(x) | isnan(y), x + y, copysign(r, y));
}

inline HWY_NOINLINE VF sinh(VF x) {
    const VF z = x * x, h = exp_shifted(abs(x), -1);   // e^|x| / 2
    // |x| <= 1, error 2^-27
    const VF small = mad(x * z, poly(z, 0.166666672, 0.0083333496, 0.000198361595, 2.81695134e-06), x);
    return select(abs(x) <= VF(1), small, copysign(h - VF(0.25) / h, x));
}
inline HWY_NOINLINE VF cosh(VF x) {
    const VF h = exp_shifted(abs(x), -1);
    return h + VF(0.25) / h;
}
inline HWY_NOINLINE VF tanh(VF x) {
    const VF a = abs(x), z = x * x;
    // |x| <= 5/8, error 2^-28
    const VF p = poly(z, -0.333333313, 0.133332059, -0.0539467633, 0.0217007007, -0.00817739498, 0.00214295881);
    const VF large = VF(1) - VF(2) / (exp(a + a) + VF(1));
    return copysign(select(a <= VF(0.625), mad(a * z, p, a), large), x);
}

inline HWY_NOINLINE VF cbrt(VF x) {
    const VF a = abs(x);
    const VM tiny = a < VF(std::numeric_limits<float>::min());
    const VF n = select(tiny, a * VF(16777216.0f), a);
    // A third of the exponent by integer arithmetic (within 4 %), then Halley's iteration twice in double (cubic).
    const VI third = to_int(to_float<VF>(float_bits(n)) * VF(1.0 / 3.0));
    const Doubles d(n);
    Doubles y(bits_to_float<VF>(third + VI(0x2a5137a0)));
    for (int i = 0; i < 2; ++i) {
        const Doubles y3 = y * y * y;
        y = y * (y3 + d + d) / (y3 + y3 + d);
    }
    const VF r = to_lanes(y) * select(tiny, VF(1.0 / 256), VF(1));
    return select((a > VF(0)) & (a < VF(kInf)), copysign(r, x), x);
}

/// Exact, as C demands.
inline HWY_NOINLINE VF fmod(VF x, VF y) {
    const VF a = abs(x), b = abs(y);
    const Doubles ad(a), bd(b), q = trunc(ad / bd);
    // q·b is exact below 2^29; the rounded quotient can be one too large (then the rest is negative), never too small.
    const Doubles rest = ad - q * bd;
    VF r = copysign(to_lanes(if_then_add(rest, rest, bd)), x);
    r = select((b == VF(kInf)) & (a < VF(kInf)), x, r);
    const VF quotient = to_lanes(q);
    const VM far = (quotient >= VF(268435456.0f)) & (b > VF(0)) & (a < VF(kInf));
    if (any(far)) return select(far, map_lanes(x, y, [](float p, float s) { return std::fmod(p, s); }), r);
    return r;
}

}  // namespace lanes

// ---- what kernels call -----------------------------------------------------------------------------------------------
#define ALDER_MATH1(name)                                          \
    template <class F>                                             \
    HWY_INLINE F name(F x) {                                       \
        if constexpr (std::is_same_v<F, VF>) return lanes::name(x); \
        else return std::name(x);                                  \
    }
#define ALDER_MATH2(name)                                             \
    template <class F>                                                \
    HWY_INLINE F name(F x, F y) {                                     \
        if constexpr (std::is_same_v<F, VF>) return lanes::name(x, y); \
        else return std::name(x, y);                                  \
    }
ALDER_MATH1(exp) ALDER_MATH1(exp2) ALDER_MATH1(log) ALDER_MATH1(log2) ALDER_MATH1(log10)
ALDER_MATH1(sin) ALDER_MATH1(cos) ALDER_MATH1(tan) ALDER_MATH1(asin) ALDER_MATH1(acos) ALDER_MATH1(atan)
ALDER_MATH1(sinh) ALDER_MATH1(cosh) ALDER_MATH1(tanh) ALDER_MATH1(cbrt)
ALDER_MATH2(pow) ALDER_MATH2(atan2) ALDER_MATH2(fmod)
#undef ALDER_MATH1
#undef ALDER_MATH2

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
