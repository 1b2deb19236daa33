// Worley's cellular noise: one jittered feature point a unit cell, the nearest few of a point. Our stand-in for Arnold's
// closed AiCellular (alshaders specification, 1.8). Steven Worley, "A Cellular Texture Basis Function", SIGGRAPH 1996.
#if defined(ALDER_NODES_NOISE_CELLULAR_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_NOISE_CELLULAR_INL_H_
#undef ALDER_NODES_NOISE_CELLULAR_INL_H_
#else
#define ALDER_NODES_NOISE_CELLULAR_INL_H_
#endif

#ifndef ALDER_NODES_NOISE_CELLULAR_ORDER_
#define ALDER_NODES_NOISE_CELLULAR_ORDER_
#include <cstdint>
namespace alder {
/// The 5x5x5 cells around a point, nearest first, as offsets from its own.
struct CellOrder {
    int8_t offset[125][3];
    constexpr CellOrder() : offset{} {
        int n = 0;
        for (int d2 = 0; d2 <= 12; ++d2)
            for (int x = -2; x <= 2; ++x)
                for (int y = -2; y <= 2; ++y)
                    for (int z = -2; z <= 2; ++z)
                        if (x * x + y * y + z * z == d2) {
                            offset[n][0] = static_cast<int8_t>(x);
                            offset[n][1] = static_cast<int8_t>(y);
                            offset[n][2] = static_cast<int8_t>(z);
                            ++n;
                        }
    }
};
inline constexpr CellOrder kCellOrder;
}  // namespace alder
#endif

#include "nodes/num/vec-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Three words in, three out. Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020: pcg3d.
template <class I>
HWY_INLINE void pcg3d(I& x, I& y, I& z) {
    const I factor(1664525), addend(1013904223);
    x = x * factor + addend, y = y * factor + addend, z = z * factor + addend;
    x = x + y * z, y = y + z * x, z = z + x * y;
    x = x ^ shr<16>(x), y = y ^ shr<16>(y), z = z ^ shr<16>(z);
    x = x + y * z, y = y + z * x, z = z + x * y;
}

/// The N nearest features, ascending.
template <int N, class F>
struct Cellular {
    F distance[N];
    Vec3<F> delta[N];   ///< from the point to the feature
    Int<F> id[N];       ///< 32 random bits
    HWY_INLINE Cellular() {}
};

template <class F>
HWY_INLINE F jittered(F centre, F jitter, Int<F> random) { return centre + jitter * (to_float<F>(shr<8>(random)) * F(0x1p-24) - F(0.5)); }

/// Features lie within ±randomness/2 of their cell's centre; |randomness| above 2 counts as 2. Coordinates that are not finite
/// count as 0. Exact for randomness up to 1: cells that cannot hold a nearer feature in any lane are passed over.
template <int N, class F>
HWY_INLINE Cellular<N, F> cellular(Vec3<F> p, F randomness) {
    const F jitter = min(F(2), abs(randomness)), reach = F(0.5) * jitter;
    Int<F> cell[3];
    F near2[3][5];      // squared distance, along an axis, to the slab that cell i - 2 may have its feature in
    F centre[3];        // of the own cell, seen from the point
    for (int axis = 0; axis < 3; ++axis) {
        const F x = select(isfinite(p[axis]), p[axis], F(0)), below = floor(x);
        cell[axis] = to_int(below);
        centre[axis] = F(0.5) - (x - below);
        for (int i = 0; i < 5; ++i) near2[axis][i] = sqr(max(F(0), abs(centre[axis] + F(i - 2)) - reach));
    }
    Cellular<N, F> best;
    F best2[N];
    for (int n = 0; n < N; ++n) best2[n] = F(1e30), best.delta[n] = Vec3<F>(F(0)), best.id[n] = Int<F>(0);
    for (const auto& offset : kCellOrder.offset) {
        const int dx = offset[0], dy = offset[1], dz = offset[2];
        if (!any(near2[0][dx + 2] + near2[1][dy + 2] + near2[2][dz + 2] < best2[N - 1])) continue;
        Int<F> hx = cell[0] + Int<F>(dx), hy = cell[1] + Int<F>(dy), hz = cell[2] + Int<F>(dz);
        pcg3d(hx, hy, hz);
        Vec3<F> delta(jittered(centre[0] + F(dx), jitter, hx), jittered(centre[1] + F(dy), jitter, hy),
                      jittered(centre[2] + F(dz), jitter, hz));
        F d2 = dot(delta, delta);
        Int<F> id = hx ^ rotl<11>(hy) ^ rotl<22>(hz);
        for (int n = 0; n < N; ++n) {   // insertion: what is displaced moves on
            const Mask<F> nearer = d2 < best2[n];
            const F old2 = best2[n];
            const Vec3<F> old_delta = best.delta[n];
            const Int<F> old_id = best.id[n];
            best2[n] = select(nearer, d2, old2), best.delta[n] = select(nearer, delta, old_delta), best.id[n] = select(nearer, id, old_id);
            d2 = select(nearer, old2, d2), delta = select(nearer, old_delta, delta), id = select(nearer, old_id, id);
        }
    }
    for (int n = 0; n < N; ++n) best.distance[n] = sqrt(best2[n]);
    return best;
}

/// Octaves: the distances of the point at frequencies 1, lacunarity, lacunarity²... are summed by rank (and the sum stays
/// ascending); delta and id are those of the first.
template <int N, class F>
HWY_INLINE Cellular<N, F> cellular(Vec3<F> p, F randomness, int octaves, F lacunarity) {
    Cellular<N, F> sum = cellular<N>(p, randomness);
    for (int octave = 1; octave < octaves; ++octave) {
        p *= lacunarity;
        const Cellular<N, F> c = cellular<N>(p, randomness);
        for (int n = 0; n < N; ++n) sum.distance[n] = sum.distance[n] + c.distance[n];
    }
    return sum;
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
