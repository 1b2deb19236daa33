// Sample numbers: Owen-scrambled Sobol points in [0,1), a pure function of (seed, pixel, sample index, set).
//
// A "set" is four dimensions that belong together (a lens and a filter position; the two directions, the lobe and the
// roulette of a bounce). Within a set the first 2^k samples of a pixel are a Sobol (0, 2)-sequence in each scrambled pair;
// different sets and pixels are shuffled and scrambled independently (Burley, "Practical Hash-based Owen Scrambling",
// JCGT 2020, sections 3 and 5). Nothing depends on thread, tile or order.
#pragma once
#include <cstdint>

namespace alder {

/// What a sample's numbers depend on besides the set.
struct SampleKey {
    uint32_t stream = 0;  ///< hash of seed and pixel
    uint32_t index = 0;   ///< the sample of the pixel
};

struct Sample4 {
    float u[4];
};

SampleKey sample_key(uint32_t seed, uint32_t x, uint32_t y, uint64_t sample);
Sample4 sample_set(SampleKey key, uint32_t set);

/// Sets by purpose. A vertex is any meeting with a surface, those passed straight through included.
inline constexpr uint32_t kSetCamera = 0;  ///< filter x, y; lens x, y
inline constexpr uint32_t kSetTime = 1;    ///< when, where something moves
inline constexpr uint32_t kSetsOfCamera = 2, kSetsPerVertex = 4;
inline constexpr uint32_t set_scatter(uint32_t vertex) { return kSetsOfCamera + kSetsPerVertex * vertex; }  ///< u1 u2, lobe, roulette
inline constexpr uint32_t set_light(uint32_t vertex) { return set_scatter(vertex) + 1; }                   ///< u1 u2, choice of light
inline constexpr uint32_t set_media(uint32_t vertex) { return set_scatter(vertex) + 3; }  ///< on the way to the vertex: distance, channel
inline constexpr uint32_t set_walk(uint32_t vertex) { return set_scatter(vertex) + 2; }  ///< inside a body: WalkNumbers

/// A well-mixed 32-bit hash (a bijection of x for each seed).
inline uint32_t hash32(uint32_t x) {
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0xd35a2d97u;
    return x ^ (x >> 15);
}
inline uint32_t hash32(uint32_t a, uint32_t b) { return hash32(a + 0x9e3779b9u * (hash32(b) | 1u) + b); }

/// Largest float below 1 times 2^-24 steps: never 1.
inline float unit_float(uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; }

}  // namespace alder
