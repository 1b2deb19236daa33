// Sample numbers: the first four Sobol dimensions by table, Owen-scrambled by hashing.
#include "render/sampler.h"

#include <array>

namespace alder {
namespace {

/// Direction numbers of Sobol dimensions 1..4: primitive polynomials and m_i of Joe and Kuo, "Constructing Sobol sequences
/// with better two-dimensional projections", 2008 (file new-joe-kuo-6): (s, a, m) = (-), (1, 0, 1), (2, 1, 1 3), (3, 1, 1 3 1).
constexpr std::array<std::array<uint32_t, 32>, 4> direction_numbers() {
    std::array<std::array<uint32_t, 32>, 4> v{};
    for (int i = 0; i < 32; ++i) v[0][i] = 0x80000000u >> i;
    constexpr int s[4] = {0, 1, 2, 3};
    constexpr uint32_t a[4] = {0, 0, 1, 1};
    constexpr uint32_t m[4][3] = {{}, {1}, {1, 3}, {1, 3, 1}};
    for (int d = 1; d < 4; ++d) {
        for (int i = 0; i < s[d]; ++i) v[d][i] = m[d][i] << (31 - i);
        for (int i = s[d]; i < 32; ++i) {
            v[d][i] = v[d][i - s[d]] ^ (v[d][i - s[d]] >> s[d]);
            for (int k = 1; k < s[d]; ++k) v[d][i] ^= ((a[d] >> (s[d] - 1 - k)) & 1u) * v[d][i - k];
        }
    }
    return v;
}

constexpr uint32_t reverse_bits(uint32_t x) {
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    return __builtin_bswap32(x);
}

/// Sobol values for each byte of a *bit-reversed* index, themselves bit-reversed: scrambling works on reversed bits, so the
/// reversals before and after the matrix product cancel. 16 KB.
struct SobolTables {
    uint32_t value[4][256][4];  ///< [byte][its value][dimension]
    constexpr SobolTables() : value{} {
        const auto v = direction_numbers();
        for (int byte = 0; byte < 4; ++byte)
            for (uint32_t bits = 0; bits < 256; ++bits)
                for (int d = 0; d < 4; ++d) {
                    uint32_t x = 0;
                    for (int k = 0; k < 8; ++k)
                        if (bits >> k & 1) x ^= v[d][31 - (8 * byte + k)];
                    value[byte][bits][d] = reverse_bits(x);
                }
    }
};
const SobolTables kSobol;

/// The four dimensions of a set, worked on together (GCC and Clang vector type: SSE2 here, 3x the scalar form).
using U4 = uint32_t __attribute__((vector_size(16)));
using F4 = float __attribute__((vector_size(16)));

/// Owen scrambling of bit-reversed numbers: every bit is flipped depending on the bits below it only (Laine and Karras 2011;
/// these constants: Vegdahl, "Building a Better LK Hash", 2021).
template <class U>
U scramble_reversed(U x, U seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

U4 reverse_bits4(U4 x) {
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    return (x >> 16) | (x << 16);
}

U4 load4(const uint32_t* p) {
    U4 v;
    __builtin_memcpy(&v, p, sizeof v);
    return v;
}

}  // namespace

SampleKey sample_key(uint32_t seed, uint32_t x, uint32_t y, uint64_t sample) {
    SampleKey k;
    k.stream = hash32(hash32(hash32(seed, 0x5eedu), x), y);
    // Beyond 2^32 samples a pixel the sequence starts again with another scrambling.
    if (const uint32_t high = static_cast<uint32_t>(sample >> 32)) k.stream = hash32(k.stream, high);
    k.index = static_cast<uint32_t>(sample);
    return k;
}

Sample4 sample_set(SampleKey key, uint32_t set) {
    const uint32_t seed = hash32(key.stream, set);
    const uint32_t index = scramble_reversed(reverse_bits(key.index), seed);
    const U4 sobol = load4(kSobol.value[0][index & 255]) ^ load4(kSobol.value[1][index >> 8 & 255]) ^
                     load4(kSobol.value[2][index >> 16 & 255]) ^ load4(kSobol.value[3][index >> 24]);
    // One seed a dimension: the hash of sampler.h, on four numbers.
    U4 s = U4{seed, seed, seed, seed} + U4{0x9e3779b9u, 0x3c6ef372u, 0xdaa66d2bu, 0x78dde6e4u};
    s ^= s >> 16;
    s *= 0x21f0aaadu;
    s ^= s >> 15;
    s *= 0xd35a2d97u;
    s ^= s >> 15;
    const U4 bits = reverse_bits4(scramble_reversed(sobol, s)) >> 8;
    const F4 u = __builtin_convertvector(reinterpret_cast<const int32_t __attribute__((vector_size(16)))&>(bits), F4) * 0x1p-24f;
    Sample4 r;
    __builtin_memcpy(r.u, &u, sizeof r.u);
    return r;
}

}  // namespace alder
