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

/// Owen scrambling of bit-reversed numbers: every bit is flipped depending on the bits below it only (Laine and Karras 2011;
/// these constants: Vegdahl, "Building a Better LK Hash", 2021).
uint32_t scramble_reversed(uint32_t x, uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
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
    const uint32_t* const t0 = kSobol.value[0][index & 255];
    const uint32_t* const t1 = kSobol.value[1][index >> 8 & 255];
    const uint32_t* const t2 = kSobol.value[2][index >> 16 & 255];
    const uint32_t* const t3 = kSobol.value[3][index >> 24];
    Sample4 r;
    uint32_t s = seed;
    for (int d = 0; d < 4; ++d) {
        s = hash32(s + 0x9e3779b9u);
        r.u[d] = unit_float(reverse_bits(scramble_reversed(t0[d] ^ t1[d] ^ t2[d] ^ t3[d], s)));
    }
    return r;
}

}  // namespace alder
