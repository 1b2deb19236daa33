// Hashes of integers and coordinates to numbers in [0, 1], bit for bit those of Cycles: what its textures are random by.
// Robert Jenkins, lookup3.c, 2006 (burtleburtle.net/bob/c/lookup3.c): the final() and mix() rounds over one to four words.
#if defined(ALDER_NODES_NOISE_HASH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_NOISE_HASH_INL_H_
#undef ALDER_NODES_NOISE_HASH_INL_H_
#else
#define ALDER_NODES_NOISE_HASH_INL_H_
#endif

#include "nodes/num/lanes-inl.h"
#include "nodes/num/vec-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// lookup3's final() up to its last two rotations.
template <class I>
HWY_INLINE constexpr void jenkins_final_but_two(I& a, I& b, I& c) {
    c = (c ^ b) - rotl<14>(b);
    a = (a ^ c) - rotl<11>(c);
    b = (b ^ a) - rotl<25>(a);
    c = (c ^ b) - rotl<16>(b);
    a = (a ^ c) - rotl<4>(c);
}
template <class I>
HWY_INLINE constexpr I jenkins_final(I a, I b, I c) {
    jenkins_final_but_two(a, b, c);
    b = (b ^ a) - rotl<14>(a);
    return (c ^ b) - rotl<24>(b);
}
/// The low 6 bits of jenkins_final are right, the others are not. These come from the low 14 bits of b, which are right without what
/// the rotations bring into the upper ones: a shift is cheaper than a rotation.
template <class I>
HWY_INLINE constexpr I jenkins_final_low6(I a, I b, I c) {
    jenkins_final_but_two(a, b, c);
    b = (b ^ a) - shr<18>(a);
    return (c ^ b) - shr<8>(b);
}
template <class I>
HWY_INLINE constexpr void jenkins_mix(I& a, I& b, I& c) {
    a = (a - c) ^ rotl<4>(c), c = c + b;
    b = (b - a) ^ rotl<6>(a), a = a + c;
    c = (c - b) ^ rotl<8>(b), b = b + a;
    a = (a - c) ^ rotl<16>(c), c = c + b;
    b = (b - a) ^ rotl<19>(a), a = a + c;
    c = (c - b) ^ rotl<4>(b), b = b + a;
}
/// Start value for `words` words: 0xdeadbeef + (words << 2) + 13.
template <class I>
HWY_INLINE constexpr I jenkins_start(int words) {
    return I(static_cast<int32_t>(0xdeadbeefu + (static_cast<uint32_t>(words) << 2) + 13u));
}

template <class I>
HWY_INLINE constexpr I hash_uint(I x) {
    const I s = jenkins_start<I>(1);
    return jenkins_final(s + x, s, s);
}
template <class I>
HWY_INLINE constexpr I hash_uint2(I x, I y) {
    const I s = jenkins_start<I>(2);
    return jenkins_final(s + x, s + y, s);
}
template <class I>
HWY_INLINE constexpr I hash_uint3(I x, I y, I z) {
    const I s = jenkins_start<I>(3);
    return jenkins_final(s + x, s + y, s + z);
}
template <class I>
HWY_INLINE constexpr I hash_uint4(I x, I y, I z, I w) {
    const I s = jenkins_start<I>(4);
    I a = s + x, b = s + y, c = s + z;
    jenkins_mix(a, b, c);
    return jenkins_final(a + w, b, c);
}
// For gradients, which need a few low bits.
template <class I>
HWY_INLINE constexpr I hash_low6(I x) {
    const I s = jenkins_start<I>(1);
    return jenkins_final_low6(s + x, s, s);
}
template <class I>
HWY_INLINE constexpr I hash_low6(I x, I y) {
    const I s = jenkins_start<I>(2);
    return jenkins_final_low6(s + x, s + y, s);
}
template <class I>
HWY_INLINE constexpr I hash_low6(I x, I y, I z) {
    const I s = jenkins_start<I>(3);
    return jenkins_final_low6(s + x, s + y, s + z);
}
template <class I>
HWY_INLINE constexpr I hash_low6(I x, I y, I z, I w) {
    const I s = jenkins_start<I>(4);
    I a = s + x, b = s + y, c = s + z;
    jenkins_mix(a, b, c);
    return jenkins_final_low6(a + w, b, c);
}

/// [0, 2^32) to [0, 1]: Cycles divides by (float)0xffffffff, which is 2^32.
template <class F>
HWY_INLINE F uint_to_unit(Int<F> n) { return unsigned_to_float<F>(n) * F(0x1p-32f); }

// Coordinates are hashed by the bits of their 32-bit floats: 0 and -0 differ, as in Cycles.
template <class F>
HWY_INLINE F hash_to_float(F x) { return uint_to_unit<F>(hash_uint(float_bits(x))); }
template <class F>
HWY_INLINE F hash_to_float(F x, F y) { return uint_to_unit<F>(hash_uint2(float_bits(x), float_bits(y))); }
template <class F>
HWY_INLINE F hash_to_float(F x, F y, F z) {
    return uint_to_unit<F>(hash_uint3(float_bits(x), float_bits(y), float_bits(z)));
}
template <class F>
HWY_INLINE F hash_to_float(F x, F y, F z, F w) {
    return uint_to_unit<F>(hash_uint4(float_bits(x), float_bits(y), float_bits(z), float_bits(w)));
}

// Several numbers from one coordinate: Cycles appends 1 or 2, or permutes the four.
template <class F>
HWY_INLINE Vec3<F> hash_to_vec3(F x) { return {hash_to_float(x), hash_to_float(x, F(1)), hash_to_float(x, F(2))}; }
template <class F>
HWY_INLINE Vec3<F> hash_to_vec3(F x, F y) {
    return {hash_to_float(x, y), hash_to_float(x, y, F(1)), hash_to_float(x, y, F(2))};
}
template <class F>
HWY_INLINE Vec3<F> hash_to_vec3(F x, F y, F z) {
    return {hash_to_float(x, y, z), hash_to_float(x, y, z, F(1)), hash_to_float(x, y, z, F(2))};
}
template <class F>
HWY_INLINE Vec3<F> hash_to_vec3(F x, F y, F z, F w) {
    return {hash_to_float(x, y, z, w), hash_to_float(z, x, w, y), hash_to_float(w, z, y, x)};
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
