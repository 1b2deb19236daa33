// Lanes: the number types that node kernels are written over.
//
// A kernel is a template over F, and F is one of
//   VF      a SIMD register of floats (4, 8 or 16 lanes, by instruction set),
//   float   one point: the scalar path, also used to fold constants,
//   double  one point: the accuracy reference.
// Int<F> and Mask<F> are the matching 32-bit integers (wrapping, two's complement) and masks. Control flow that depends on
// a lane is written with select(), any() and all(); the same source is then right for one lane and for sixteen.
//
// This is the only file that names Highway's types. It is included once per instruction set (hwy/foreach_target.h).
#if defined(ALDER_NODES_NUM_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_NUM_LANES_INL_H_
#undef ALDER_NODES_NUM_LANES_INL_H_
#else
#define ALDER_NODES_NUM_LANES_INL_H_
#endif

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "hwy/highway.h"

// Before a loop over the components of a small array of lanes: in registers only if unrolled, which -O2 does not do by itself.
#ifndef ALDER_UNROLL
#define ALDER_UNROLL _Pragma("GCC unroll 16")
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using TagF = hn::ScalableTag<float>;
using TagI = hn::ScalableTag<int32_t>;
using TagU = hn::ScalableTag<uint32_t>;

struct VF {
    hn::Vec<TagF> v;
    HWY_INLINE VF() {}
    HWY_INLINE VF(hn::Vec<TagF> x) : v(x) {}
    HWY_INLINE VF(float x) : v(hn::Set(TagF(), x)) {}
    HWY_INLINE VF(double x) : v(hn::Set(TagF(), static_cast<float>(x))) {}
    HWY_INLINE VF(int x) : v(hn::Set(TagF(), static_cast<float>(x))) {}
};
struct VI {
    hn::Vec<TagI> v;
    HWY_INLINE VI() {}
    HWY_INLINE VI(hn::Vec<TagI> x) : v(x) {}
    HWY_INLINE VI(int32_t x) : v(hn::Set(TagI(), x)) {}
    HWY_INLINE VI(uint32_t x) : v(hn::Set(TagI(), static_cast<int32_t>(x))) {}
};
struct VM {
    hn::Mask<TagF> m;
    HWY_INLINE VM() {}
    HWY_INLINE VM(hn::Mask<TagF> x) : m(x) {}
    HWY_INLINE VM(bool x) : m(hn::RebindMask(TagF(), hn::Eq(hn::Set(TagI(), x ? 1 : 0), hn::Set(TagI(), 1)))) {}
};

template <class F>
struct NumOf;
template <>
struct NumOf<VF> {
    using I = VI;
    using M = VM;
    using Real = float;
    static HWY_INLINE size_t width() { return hn::Lanes(TagF()); }
};
template <>
struct NumOf<float> {
    using I = int32_t;
    using M = bool;
    using Real = float;
    static HWY_INLINE size_t width() { return 1; }
};
template <>
struct NumOf<double> {
    using I = int32_t;
    using M = bool;
    using Real = double;
    static HWY_INLINE size_t width() { return 1; }
};
template <class F>
using Int = typename NumOf<F>::I;
template <class F>
using Mask = typename NumOf<F>::M;
template <class F>
using Real = typename NumOf<F>::Real;

// ---- arithmetic of VF -----------------------------------------------------------------------------------------------
HWY_INLINE VF operator+(VF a, VF b) { return hn::Add(a.v, b.v); }
HWY_INLINE VF operator-(VF a, VF b) { return hn::Sub(a.v, b.v); }
HWY_INLINE VF operator*(VF a, VF b) { return hn::Mul(a.v, b.v); }
HWY_INLINE VF operator/(VF a, VF b) { return hn::Div(a.v, b.v); }
HWY_INLINE VF operator-(VF a) { return hn::Neg(a.v); }
HWY_INLINE VF& operator+=(VF& a, VF b) { return a = a + b; }
HWY_INLINE VF& operator-=(VF& a, VF b) { return a = a - b; }
HWY_INLINE VF& operator*=(VF& a, VF b) { return a = a * b; }
HWY_INLINE VF& operator/=(VF& a, VF b) { return a = a / b; }
HWY_INLINE VM operator<(VF a, VF b) { return hn::Lt(a.v, b.v); }
HWY_INLINE VM operator<=(VF a, VF b) { return hn::Le(a.v, b.v); }
HWY_INLINE VM operator>(VF a, VF b) { return hn::Gt(a.v, b.v); }
HWY_INLINE VM operator>=(VF a, VF b) { return hn::Ge(a.v, b.v); }
HWY_INLINE VM operator==(VF a, VF b) { return hn::Eq(a.v, b.v); }
HWY_INLINE VM operator!=(VF a, VF b) { return hn::Not(hn::Eq(a.v, b.v)); }  // hn::Ne is false for NaN on AVX, true on SSE4

// ---- arithmetic of VI: wrapping 32-bit; shr is logical, sar arithmetic ----------------------------------------------
HWY_INLINE VI operator+(VI a, VI b) { return hn::Add(a.v, b.v); }
HWY_INLINE VI operator-(VI a, VI b) { return hn::Sub(a.v, b.v); }
HWY_INLINE VI operator*(VI a, VI b) { return hn::Mul(a.v, b.v); }
HWY_INLINE VI operator&(VI a, VI b) { return hn::And(a.v, b.v); }
HWY_INLINE VI operator|(VI a, VI b) { return hn::Or(a.v, b.v); }
HWY_INLINE VI operator^(VI a, VI b) { return hn::Xor(a.v, b.v); }
HWY_INLINE VI& operator+=(VI& a, VI b) { return a = a + b; }
HWY_INLINE VI& operator-=(VI& a, VI b) { return a = a - b; }
HWY_INLINE VI& operator^=(VI& a, VI b) { return a = a ^ b; }
HWY_INLINE VM int_mask(hn::Mask<TagI> m) { return hn::RebindMask(TagF(), m); }
HWY_INLINE VM operator==(VI a, VI b) { return int_mask(hn::Eq(a.v, b.v)); }
HWY_INLINE VM operator!=(VI a, VI b) { return int_mask(hn::Ne(a.v, b.v)); }
HWY_INLINE VM operator<(VI a, VI b) { return int_mask(hn::Lt(a.v, b.v)); }
HWY_INLINE VM operator>(VI a, VI b) { return int_mask(hn::Gt(a.v, b.v)); }
HWY_INLINE VM operator<=(VI a, VI b) { return int_mask(hn::Not(hn::Gt(a.v, b.v))); }
HWY_INLINE VM operator>=(VI a, VI b) { return int_mask(hn::Not(hn::Lt(a.v, b.v))); }
template <int k>
HWY_INLINE VI shl(VI a) { return hn::ShiftLeft<k>(a.v); }
template <int k>
HWY_INLINE VI shr(VI a) { return hn::BitCast(TagI(), hn::ShiftRight<k>(hn::BitCast(TagU(), a.v))); }
template <int k>
HWY_INLINE VI sar(VI a) { return hn::ShiftRight<k>(a.v); }
/// Rotation by k bits. Without AVX-512's rotate, whole bytes are moved by one byte shuffle instead of two shifts and an or.
template <int k>
HWY_INLINE VI rotl(VI a) {
#if HWY_TARGET != HWY_AVX3 && HWY_TARGET != HWY_AVX3_DL
    if constexpr (k % 8 == 0) {
        constexpr uint8_t b = k / 8;
#define ALDER_ROTATED(i) 4 * i + (4 - b) % 4, 4 * i + (5 - b) % 4, 4 * i + (6 - b) % 4, 4 * i + (7 - b) % 4
        alignas(16) static constexpr uint8_t kOrder[16] = {ALDER_ROTATED(0), ALDER_ROTATED(1), ALDER_ROTATED(2), ALDER_ROTATED(3)};
#undef ALDER_ROTATED
        const hn::Repartition<uint8_t, TagI> bytes;
        return hn::BitCast(TagI(), hn::TableLookupBytes(hn::BitCast(bytes, a.v), hn::LoadDup128(bytes, kOrder)));
    }
#endif
    return hn::BitCast(TagI(), hn::RotateRight<32 - k>(hn::BitCast(TagU(), a.v)));
}

template <int k>
HWY_INLINE int32_t shl(int32_t a) { return static_cast<int32_t>(static_cast<uint32_t>(a) << k); }
template <int k>
HWY_INLINE int32_t shr(int32_t a) { return static_cast<int32_t>(static_cast<uint32_t>(a) >> k); }
template <int k>
HWY_INLINE int32_t sar(int32_t a) { return a >> k; }
template <int k>
HWY_INLINE int32_t rotl(int32_t a) { return static_cast<int32_t>(std::rotl(static_cast<uint32_t>(a), k)); }
// Unsigned, for constant expressions, where overflow of signed integers is an error.
template <int k>
HWY_INLINE constexpr uint32_t shr(uint32_t a) { return a >> k; }
template <int k>
HWY_INLINE constexpr uint32_t rotl(uint32_t a) { return std::rotl(a, k); }

// ---- masks: & | ! , any, all, select(mask, where true, where false) -------------------------------------------------
HWY_INLINE VM operator&(VM a, VM b) { return hn::And(a.m, b.m); }
HWY_INLINE VM operator|(VM a, VM b) { return hn::Or(a.m, b.m); }
HWY_INLINE VM operator!(VM a) { return hn::Not(a.m); }
HWY_INLINE bool any(VM a) { return !hn::AllFalse(TagF(), a.m); }
HWY_INLINE bool all(VM a) { return hn::AllTrue(TagF(), a.m); }
HWY_INLINE bool any(bool a) { return a; }
HWY_INLINE bool all(bool a) { return a; }
HWY_INLINE VF select(VM m, VF a, VF b) { return hn::IfThenElse(m.m, a.v, b.v); }
HWY_INLINE VI select(VM m, VI a, VI b) { return hn::IfThenElse(hn::RebindMask(TagI(), m.m), a.v, b.v); }
HWY_INLINE float select(bool m, float a, float b) { return m ? a : b; }
HWY_INLINE double select(bool m, double a, double b) { return m ? a : b; }
HWY_INLINE int32_t select(bool m, int32_t a, int32_t b) { return m ? a : b; }

// ---- min, max: min(a, b) is b < a ? b : a and max(a, b) is a < b ? b : a, for NaN too (a NaN in b is dropped) --------
HWY_INLINE VF min(VF a, VF b) { return select(b < a, b, a); }
HWY_INLINE VF max(VF a, VF b) { return select(a < b, b, a); }
HWY_INLINE float min(float a, float b) { return b < a ? b : a; }
HWY_INLINE float max(float a, float b) { return a < b ? b : a; }
HWY_INLINE double min(double a, double b) { return b < a ? b : a; }
HWY_INLINE double max(double a, double b) { return a < b ? b : a; }
HWY_INLINE VI min(VI a, VI b) { return hn::Min(a.v, b.v); }
HWY_INLINE VI max(VI a, VI b) { return hn::Max(a.v, b.v); }
HWY_INLINE int32_t min(int32_t a, int32_t b) { return b < a ? b : a; }
HWY_INLINE int32_t max(int32_t a, int32_t b) { return a < b ? b : a; }

// ---- exact elementary operations ------------------------------------------------------------------------------------
HWY_INLINE VF abs(VF a) { return hn::Abs(a.v); }
HWY_INLINE float abs(float a) { return std::fabs(a); }
HWY_INLINE double abs(double a) { return std::fabs(a); }
HWY_INLINE VF floor(VF a) { return hn::Floor(a.v); }
HWY_INLINE float floor(float a) { return std::floor(a); }
HWY_INLINE double floor(double a) { return std::floor(a); }
HWY_INLINE VF ceil(VF a) { return hn::Ceil(a.v); }
HWY_INLINE float ceil(float a) { return std::ceil(a); }
HWY_INLINE double ceil(double a) { return std::ceil(a); }
HWY_INLINE VF trunc(VF a) { return hn::Trunc(a.v); }
HWY_INLINE float trunc(float a) { return std::trunc(a); }
HWY_INLINE double trunc(double a) { return std::trunc(a); }
HWY_INLINE VF sqrt(VF a) { return hn::Sqrt(a.v); }
HWY_INLINE float sqrt(float a) { return std::sqrt(a); }
HWY_INLINE double sqrt(double a) { return std::sqrt(a); }
/// a*b + c: fused on AVX2 and AVX-512, rounded twice on SSE4 and for scalars. Plain a*b+c is never contracted.
HWY_INLINE VF mad(VF a, VF b, VF c) { return hn::MulAdd(a.v, b.v, c.v); }
HWY_INLINE float mad(float a, float b, float c) { return a * b + c; }
HWY_INLINE double mad(double a, double b, double c) { return a * b + c; }
HWY_INLINE VF copysign(VF magnitude, VF sign) { return hn::CopySign(magnitude.v, sign.v); }
HWY_INLINE float copysign(float magnitude, float sign) { return std::copysign(magnitude, sign); }
HWY_INLINE double copysign(double magnitude, double sign) { return std::copysign(magnitude, sign); }
HWY_INLINE VM isnan(VF a) { return hn::IsNaN(a.v); }
HWY_INLINE bool isnan(float a) { return a != a; }
HWY_INLINE bool isnan(double a) { return a != a; }
HWY_INLINE VM isfinite(VF a) { return hn::IsFinite(a.v); }
HWY_INLINE bool isfinite(float a) { return std::isfinite(a); }
HWY_INLINE bool isfinite(double a) { return std::isfinite(a); }

// ---- conversions ----------------------------------------------------------------------------------------------------
/// Truncates toward zero. Outside the range of int32 and for NaN: INT32_MIN, as cvttps2dq gives.
HWY_INLINE int32_t scalar_to_int(double a) {
    return a >= -2147483648.0 && a < 2147483648.0 ? static_cast<int32_t>(a) : INT32_MIN;
}
HWY_INLINE VI to_int(VF a) {
    const auto in_range = hn::And(hn::Ge(a.v, hn::Set(TagF(), -2147483648.0f)), hn::Lt(a.v, hn::Set(TagF(), 2147483648.0f)));
    const auto safe = hn::IfThenElseZero(in_range, a.v);
    return hn::IfThenElse(hn::RebindMask(TagI(), in_range), hn::ConvertTo(TagI(), safe), hn::Set(TagI(), INT32_MIN));
}
HWY_INLINE int32_t to_int(float a) { return scalar_to_int(a); }
HWY_INLINE int32_t to_int(double a) { return scalar_to_int(a); }
/// to_float<F>(i): signed 32-bit integer to F.
template <class F>
HWY_INLINE F to_float(Int<F> a) {
    if constexpr (std::is_same_v<F, VF>) return VF(hn::ConvertTo(TagF(), a.v));
    else return static_cast<F>(a);
}
/// The integer read as unsigned.
template <class F>
HWY_INLINE F unsigned_to_float(Int<F> a) {
    if constexpr (std::is_same_v<F, VF>) {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
        return VF(hn::ConvertTo(TagF(), hn::BitCast(TagU(), a.v)));
#else
        // Exact rounding: split in 16-bit halves; the sum of two exact floats rounds once.
        const VF hi = VF(hn::ConvertTo(TagF(), shr<16>(a).v)) * VF(65536.0f);
        const VF lo = VF(hn::ConvertTo(TagF(), (a & VI(0xffff)).v));
        return hi + lo;
#endif
    } else {
        return static_cast<F>(static_cast<uint32_t>(a));
    }
}
/// Bits of the value as a 32-bit float (a double is rounded to float first: hashes of coordinates need float's bits).
HWY_INLINE VI float_bits(VF a) { return hn::BitCast(TagI(), a.v); }
HWY_INLINE int32_t float_bits(float a) { return std::bit_cast<int32_t>(a); }
HWY_INLINE int32_t float_bits(double a) { return std::bit_cast<int32_t>(static_cast<float>(a)); }
template <class F>
HWY_INLINE F bits_to_float(Int<F> a) {
    if constexpr (std::is_same_v<F, VF>) return VF(hn::BitCast(TagF(), a.v));
    else return static_cast<F>(std::bit_cast<float>(a));
}
/// table[index] per lane; the caller keeps every lane's index inside the table.
template <class F>
HWY_INLINE F gather(const float* table, Int<F> index) {
    if constexpr (std::is_same_v<F, VF>) return VF(hn::GatherIndex(TagF(), table, index.v));
    else return static_cast<F>(table[index]);
}
template <class F>
HWY_INLINE Int<F> gather_int(const int32_t* table, Int<F> index) {
    if constexpr (std::is_same_v<F, VF>) return VI(hn::GatherIndex(TagI(), table, index.v));
    else return table[index];
}

/// floor(x) as an integer for |x| < 2^22; other lanes give some integer.
template <class F>
HWY_INLINE Int<F> small_floor_to_int(F floor_of_x) {
    if constexpr (std::is_same_v<F, VF>) {
        // Adding 1.5·2^23 leaves the integer in the low bits of the sum: one addition instead of a conversion and its range check.
        return float_bits(floor_of_x + VF(12582912.0f)) - VI(0x4b400000);
    } else {
        return to_int(floor_of_x);
    }
}

// ---- tables held in registers ---------------------------------------------------------------------------------------
/// 16 or 32 numbers out of {0, 2, -2}: these differ in their top byte alone, so that a byte shuffle looks them up where there
/// is no permutation of sixteen floats.
template <int kSize>
struct TableOfTwos {
    static_assert(kSize == 16 || kSize == 32);
    alignas(64) float value[kSize];
    alignas(16) uint8_t top_byte[kSize];
    constexpr explicit TableOfTwos(const int8_t (&sign)[kSize]) : value{}, top_byte{} {
        for (int i = 0; i < kSize; ++i) {
            value[i] = 2.0f * sign[i];
            top_byte[i] = static_cast<uint8_t>(std::bit_cast<uint32_t>(value[i]) >> 24);
        }
    }
};
/// table[index mod kSize].
template <class F, int kSize>
HWY_INLINE F lookup(const TableOfTwos<kSize>& table, Int<F> index) {
    if constexpr (std::is_same_v<F, VF>) {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
        const auto low = hn::Load(TagF(), table.value);
        if constexpr (kSize == 32) {
            return VF(hn::Vec<TagF>{_mm512_permutex2var_ps(low.raw, index.v.raw, hn::Load(TagF(), table.value + 16).raw)});
        } else {
            return VF(hn::Vec<TagF>{_mm512_permutexvar_ps(index.v.raw, low.raw)});
        }
#else
        const hn::Repartition<uint8_t, TagI> bytes;
        const VI position = (shl<24>(index) & VI(0x0f000000)) | VI(0x00808080);  // a set top bit makes a zero byte
        const auto low = hn::TableLookupBytes(hn::LoadDup128(bytes, table.top_byte), hn::BitCast(bytes, position.v));
        if constexpr (kSize == 32) {
            const auto high = hn::TableLookupBytes(hn::LoadDup128(bytes, table.top_byte + 16), hn::BitCast(bytes, position.v));
            return select((index & VI(16)) == VI(0), VF(hn::BitCast(TagF(), low)), VF(hn::BitCast(TagF(), high)));
        } else {
            return VF(hn::BitCast(TagF(), low));
        }
#endif
    } else {
        return static_cast<F>(table.value[index & (kSize - 1)]);
    }
}

// ---- one lane at a time ---------------------------------------------------------------------------------------------
/// Calls a plain function per lane: for functions that no polynomial of ours serves. fn: Real -> Real.
template <class F, class Fn>
HWY_INLINE F map_lanes(F x, Fn fn) {
    if constexpr (std::is_same_v<F, VF>) {
        HWY_ALIGN float b[HWY_MAX_BYTES / sizeof(float)];
        const size_t w = hn::Lanes(TagF());
        hn::Store(x.v, TagF(), b);
        for (size_t i = 0; i < w; ++i) b[i] = fn(b[i]);
        return VF(hn::Load(TagF(), b));
    } else {
        return fn(x);
    }
}
template <class F, class Fn>
HWY_INLINE F map_lanes(F x, F y, Fn fn) {
    if constexpr (std::is_same_v<F, VF>) {
        HWY_ALIGN float a[HWY_MAX_BYTES / sizeof(float)], b[HWY_MAX_BYTES / sizeof(float)];
        const size_t w = hn::Lanes(TagF());
        hn::Store(x.v, TagF(), a);
        hn::Store(y.v, TagF(), b);
        for (size_t i = 0; i < w; ++i) a[i] = fn(a[i], b[i]);
        return VF(hn::Load(TagF(), a));
    } else {
        return fn(x, y);
    }
}

/// 1/sqrt(x) for positive normal x, to 3e-7 relative: the instruction's estimate and one step of Newton's method.
template <class F>
HWY_INLINE F reciprocal_sqrt_estimate(F x) {
    if constexpr (std::is_same_v<F, VF>) {
        const VF y(hn::ApproximateReciprocalSqrt(x.v));
        return y * mad(x * VF(-0.5f) * y, y, VF(1.5f));
    } else {
        return F(1) / std::sqrt(x);
    }
}
/// a*b + c rounded once on every target: where the rounding decides (a hash or a floor follows). A library call a lane on SSE4.
template <class F>
HWY_INLINE F fused_mad(F a, F b, F c) {
    if constexpr (std::is_same_v<F, VF>) {
#if HWY_TARGET <= HWY_AVX2  // these have the instruction; smaller is newer
        return mad(a, b, c);
#else
        HWY_ALIGN float x[HWY_MAX_BYTES / sizeof(float)], y[HWY_MAX_BYTES / sizeof(float)], z[HWY_MAX_BYTES / sizeof(float)];
        hn::Store(a.v, TagF(), x);
        hn::Store(b.v, TagF(), y);
        hn::Store(c.v, TagF(), z);
        for (size_t i = 0; i < hn::Lanes(TagF()); ++i) x[i] = std::fma(x[i], y[i], z[i]);
        return VF(hn::Load(TagF(), x));
#endif
    } else {
        return std::fma(a, b, c);
    }
}

// ---- lanes in memory: for loads that no gather serves; arrays of kMostLanes<F>, aligned --------------------------------
template <class F>
inline constexpr int kMostLanes = std::is_same_v<F, VF> ? HWY_MAX_BYTES / sizeof(float) : 1;
template <class F>
HWY_INLINE void store_ints(Int<F> x, int32_t* to) {
    if constexpr (std::is_same_v<F, VF>) hn::Store(x.v, TagI(), to);
    else *to = x;
}
template <class F>
HWY_INLINE Int<F> load_ints(const int32_t* from) {
    if constexpr (std::is_same_v<F, VF>) return VI(hn::Load(TagI(), from));
    else return *from;
}
template <class F>
HWY_INLINE void store_floats(F x, float* to) {
    if constexpr (std::is_same_v<F, VF>) hn::Store(x.v, TagF(), to);
    else *to = static_cast<float>(x);
}
template <class F>
HWY_INLINE F load_floats(const float* from) {
    if constexpr (std::is_same_v<F, VF>) return VF(hn::Load(TagF(), from));
    else return static_cast<F>(*from);
}
/// Four floats a lane, one lane after the other: the first, second, third and fourth of all lanes.
template <class F>
HWY_INLINE void load_floats_by_four(const float* from, F (&out)[4]) {
    if constexpr (std::is_same_v<F, VF>) hn::LoadInterleaved4(TagF(), from, out[0].v, out[1].v, out[2].v, out[3].v);
    else for (int i = 0; i < 4; ++i) out[i] = static_cast<F>(from[i]);
}

/// The first lane's value in all lanes.
HWY_INLINE VI first_lane(VI a) { return VI(hn::GetLane(a.v)); }
HWY_INLINE int32_t first_lane(int32_t a) { return a; }

// ---- small named helpers --------------------------------------------------------------------------------------------
template <class F>
HWY_INLINE F clamp(F x, F lo, F hi) { return min(max(x, lo), hi); }
template <class F>
HWY_INLINE F saturate(F x) { return min(max(x, F(0)), F(1)); }
/// (1-t)·a + t·b, t not clamped (the alShaders form; exact at both ends).
template <class F>
HWY_INLINE F lerp(F a, F b, F t) { return (F(1) - t) * a + t * b; }
template <class F>
HWY_INLINE F safe_sqrt(F x) { return sqrt(max(F(0), x)); }
/// a/b, or 0 where b is 0 (Cycles' safe_divide).
template <class F>
HWY_INLINE F safe_divide(F a, F b) { return select(b != F(0), a / select(b != F(0), b, F(1)), F(0)); }
template <class F>
HWY_INLINE F sqr(F x) { return x * x; }

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
