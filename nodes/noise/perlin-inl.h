// Perlin noise in one to four dimensions, as Cycles has it: signed, scaled to about [-1, 1], repeating every 100,000 units.
// Ken Perlin, "Improving Noise", SIGGRAPH 2002; gradients chosen by hashes of the lattice cell (hash-inl.h). The scales
// 0.25, 0.6616, 0.982, 0.8344 were found by experiment for Open Shading Language, whose noise this is.
#if defined(ALDER_NODES_NOISE_PERLIN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_NOISE_PERLIN_INL_H_
#undef ALDER_NODES_NOISE_PERLIN_INL_H_
#else
#define ALDER_NODES_NOISE_PERLIN_INL_H_
#endif

#include "nodes/noise/hash-inl.h"
#include "nodes/num/math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// A point of D coordinates.
template <int D, class F>
struct Coord {
    F c[D];
    HWY_INLINE Coord() {}
    friend HWY_INLINE Coord operator+(Coord a, const Coord& b) {
        ALDER_UNROLL
        for (int i = 0; i < D; ++i) a.c[i] = a.c[i] + b.c[i];
        return a;
    }
    friend HWY_INLINE Coord operator*(Coord a, F s) {
        ALDER_UNROLL
        for (int i = 0; i < D; ++i) a.c[i] = a.c[i] * s;
        return a;
    }
};

/// Where a coordinate lies in the lattice: cell number, distance from the cell's lower end, Perlin's fade of that.
template <class F>
struct LatticeAxis {
    Int<F> cell;
    F f, fade;
    HWY_INLINE LatticeAxis() {}
    HWY_INLINE void set_fraction(F fraction) {
        f = fraction;
        fade = f * f * f * mad(f, mad(f, F(6), F(-15)), F(10));
    }
    HWY_INLINE Int<F> cell1() const { return cell + Int<F>(1); }
    HWY_INLINE F f1() const { return f - F(1); }
};

template <class F>
HWY_INLINE F perlin_lerp(F a, F b, F t) { return mad(t, b - a, a); }

/// 1D gradients are ±(1..8): bits 0-2 and the sign in bit 3.
template <class F>
HWY_INLINE F gradient1(Int<F> h, F x) {
    const F g = to_float<F>((h & Int<F>(7)) + Int<F>(1));
    return bits_to_float<F>(float_bits(g) ^ (shl<28>(h) & Int<F>(INT32_MIN))) * x;
}
/// ±x ± 2y or ±y ± 2x.
template <class F>
HWY_INLINE F gradient2(Int<F> h, F x, F y) {
    const Mask<F> first = (h & Int<F>(4)) == Int<F>(0);
    const F u = select(first, x, y), v = F(2) * select(first, y, x);
    if constexpr (std::is_same_v<F, VF>) {
        return bits_to_float<F>(float_bits(u) ^ shl<31>(h)) + bits_to_float<F>(float_bits(v) ^ (shl<30>(h) & VI(INT32_MIN)));
    } else {
        return ((h & 1) ? -u : u) + ((h & 2) ? -v : v);
    }
}
// In three and four dimensions the gradient is looked up as a vector of 0, ±2 and multiplied out. This gives the bits of
// choosing and negating coordinates (all but two or three of the terms are zero, the products exact) in half the instructions.

/// Twice ±a ± b: the twelve edges of the cube, four of them again.
inline constexpr TableOfTwos<16> kGradient3X({1, -1, 1, -1, 1, -1, 1, -1, 0, 0, 0, 0, 1, 0, -1, 0});
inline constexpr TableOfTwos<16> kGradient3Y({1, 1, -1, -1, 0, 0, 0, 0, 1, -1, 1, -1, 1, -1, 1, -1});
inline constexpr TableOfTwos<16> kGradient3Z({0, 0, 0, 0, 1, 1, -1, -1, 1, 1, -1, -1, 0, 1, 0, -1});
template <class F>
HWY_INLINE F gradient3(Int<F> h, F x, F y, F z) {
    return mad(lookup<F>(kGradient3Z, h), z, mad(lookup<F>(kGradient3Y, h), y, lookup<F>(kGradient3X, h) * x));
}
/// Twice ±a ± b ± c: the 32 edges of the hypercube.
inline constexpr TableOfTwos<32> kGradient4X({1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1,
                                              1, -1, 1, -1, 1, -1, 1, -1, 0, 0, 0, 0, 0, 0, 0, 0});
inline constexpr TableOfTwos<32> kGradient4Y({1, 1, -1, -1, 1, 1, -1, -1, 1, 1, -1, -1, 1, 1, -1, -1,
                                              0, 0, 0, 0, 0, 0, 0, 0, 1, -1, 1, -1, 1, -1, 1, -1});
inline constexpr TableOfTwos<32> kGradient4Z({1, 1, 1, 1, -1, -1, -1, -1, 0, 0, 0, 0, 0, 0, 0, 0,
                                              1, 1, -1, -1, 1, 1, -1, -1, 1, 1, -1, -1, 1, 1, -1, -1});
inline constexpr TableOfTwos<32> kGradient4W({0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, -1, -1, -1, -1,
                                              1, 1, 1, 1, -1, -1, -1, -1, 1, 1, 1, 1, -1, -1, -1, -1});
template <class F>
HWY_INLINE F gradient4(Int<F> h, F x, F y, F z, F w) {
    const F xy = mad(lookup<F>(kGradient4Y, h), y, lookup<F>(kGradient4X, h) * x);
    return mad(lookup<F>(kGradient4W, h), w, mad(lookup<F>(kGradient4Z, h), z, xy));
}

template <class F>
HWY_INLINE F perlin(const LatticeAxis<F> (&a)[1]) {
    const LatticeAxis<F>& x = a[0];
    return F(0.25) * perlin_lerp(gradient1(hash_low6(x.cell), x.f), gradient1(hash_low6(x.cell1()), x.f1()), x.fade);
}
template <class F>
HWY_INLINE F perlin(const LatticeAxis<F> (&a)[2]) {
    const LatticeAxis<F>&x = a[0], &y = a[1];
    F row[2];
    ALDER_UNROLL
    for (int j = 0; j < 2; ++j) {
        const Int<F> cy = j ? y.cell1() : y.cell;
        const F fy = j ? y.f1() : y.f;
        row[j] = perlin_lerp(gradient2(hash_low6(x.cell, cy), x.f, fy), gradient2(hash_low6(x.cell1(), cy), x.f1(), fy), x.fade);
    }
    return F(0.6616) * perlin_lerp(row[0], row[1], y.fade);
}
template <class F>
HWY_INLINE F perlin(const LatticeAxis<F> (&a)[3]) {
    const LatticeAxis<F>&x = a[0], &y = a[1], &z = a[2];
    F row[4];
    ALDER_UNROLL
    for (int j = 0; j < 4; ++j) {
        const Int<F> cy = j & 1 ? y.cell1() : y.cell, cz = j & 2 ? z.cell1() : z.cell;
        const F fy = j & 1 ? y.f1() : y.f, fz = j & 2 ? z.f1() : z.f;
        row[j] = perlin_lerp(gradient3(hash_low6(x.cell, cy, cz), x.f, fy, fz),
                             gradient3(hash_low6(x.cell1(), cy, cz), x.f1(), fy, fz), x.fade);
    }
    // 0.982 / 2, as gradient3 doubles.
    return F(0.5f * 0.982f) * perlin_lerp(perlin_lerp(row[0], row[1], y.fade), perlin_lerp(row[2], row[3], y.fade), z.fade);
}
template <class F>
HWY_INLINE F perlin(const LatticeAxis<F> (&a)[4]) {
    const LatticeAxis<F>&x = a[0], &y = a[1], &z = a[2], &w = a[3];
    F row[4];
    ALDER_UNROLL
    for (int j = 0; j < 4; ++j) {
        const Int<F> cy = j & 1 ? y.cell1() : y.cell, cz = j & 2 ? z.cell1() : z.cell;
        const F fy = j & 1 ? y.f1() : y.f, fz = j & 2 ? z.f1() : z.f;
        const F v0 = perlin_lerp(gradient4(hash_low6(x.cell, cy, cz, w.cell), x.f, fy, fz, w.f),
                                 gradient4(hash_low6(x.cell, cy, cz, w.cell1()), x.f, fy, fz, w.f1()), w.fade);
        const F v1 = perlin_lerp(gradient4(hash_low6(x.cell1(), cy, cz, w.cell), x.f1(), fy, fz, w.f),
                                 gradient4(hash_low6(x.cell1(), cy, cz, w.cell1()), x.f1(), fy, fz, w.f1()), w.fade);
        row[j] = perlin_lerp(v0, v1, x.fade);
    }
    return F(0.5f * 0.8344f) * perlin_lerp(perlin_lerp(row[0], row[1], y.fade), perlin_lerp(row[2], row[3], y.fade), z.fade);
}

/// The lattice place of a coordinate of any size, NaN included. Beyond 100,000 Cycles takes the remainder, by fmod in one and
/// two dimensions and by p - trunc(p/1e5)·1e5 in three and four, and adds 0.5 from a million on, where floats have no fraction left.
template <int D, class F>
HWY_NOINLINE void set_far_axes(const Coord<D, F>& p, LatticeAxis<F>* a) {
    ALDER_UNROLL
    for (int i = 0; i < D; ++i) {
        F x = p.c[i];
        const F half = select(abs(x) >= F(1e6), F(0.5), F(0));
        if constexpr (D <= 2) {
            x = fmod(x, F(1e5));
        } else {
            x = fused_mad(-trunc(x / F(1e5)), F(1e5), x);
        }
        x = x + half;
        const F below = floor(x);
        a[i].cell = to_int(below);
        a[i].set_fraction(x - below);
    }
}

/// Whether all lanes lie in one cell.
template <int D, class F>
HWY_INLINE bool in_one_cell(const LatticeAxis<F> (&a)[D]) {
    // x first: it alone tells most of the time.
    if (!all(a[0].cell == first_lane(a[0].cell))) return false;
    Int<F> difference = a[1].cell ^ first_lane(a[1].cell);
    ALDER_UNROLL
    for (int i = 2; i < D; ++i) difference = difference | (a[i].cell ^ first_lane(a[i].cell));
    return all(difference == Int<F>(0));
}
/// The gradients of a cell's 2^D corners, corner number = bit per axis, each component an array.
template <int D, class F>
struct CornerGradients {
    static constexpr int kCorners = 1 << D;
    alignas(64) float component[D][kMostLanes<F>];
    /// One hash over lanes serves all corners.
    HWY_INLINE explicit CornerGradients(const LatticeAxis<F> (&a)[D]) {
        alignas(64) static constexpr int32_t kBit[4][16] = {{0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1},
                                                            {0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1},
                                                            {0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1},
                                                            {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1}};
        Int<F> c[D];
        ALDER_UNROLL
        for (int i = 0; i < D; ++i) c[i] = first_lane(a[i].cell) + load_ints<F>(kBit[i]);
        if constexpr (D == 2) {
            const Int<F> h = hash_low6(c[0], c[1]);
            const F one = bits_to_float<F>(shl<31>(h) | Int<F>(0x3f800000)), two = bits_to_float<F>((shl<30>(h) & Int<F>(INT32_MIN)) | Int<F>(0x40000000));
            const Mask<F> first = (h & Int<F>(4)) == Int<F>(0);
            store_floats(select(first, one, two), component[0]);
            store_floats(select(first, two, one), component[1]);
        } else if constexpr (D == 3) {
            const Int<F> h = hash_low6(c[0], c[1], c[2]);
            store_floats(lookup<F>(kGradient3X, h), component[0]);
            store_floats(lookup<F>(kGradient3Y, h), component[1]);
            store_floats(lookup<F>(kGradient3Z, h), component[2]);
        } else {
            const Int<F> h = hash_low6(c[0], c[1], c[2], c[3]);
            store_floats(lookup<F>(kGradient4X, h), component[0]);
            store_floats(lookup<F>(kGradient4Y, h), component[1]);
            store_floats(lookup<F>(kGradient4Z, h), component[2]);
            store_floats(lookup<F>(kGradient4W, h), component[3]);
        }
    }
    /// gradient · (place - corner), summed in the order of perlin().
    HWY_INLINE F dot(const LatticeAxis<F> (&a)[D], int corner) const {
        F s = F(component[0][corner]) * (corner & 1 ? a[0].f1() : a[0].f);
        ALDER_UNROLL
        for (int i = 1; i < D; ++i) s = mad(F(component[i][corner]), corner >> i & 1 ? a[i].f1() : a[i].f, s);
        return s;
    }
};
/// perlin() where all lanes lie in one cell, as neighbouring points do at low frequencies: two to four times as fast, the same bits.
template <int D, class F>
HWY_INLINE F perlin_in_one_cell(const LatticeAxis<F> (&a)[D]) {
    const CornerGradients<D, F> g(a);
    if constexpr (D == 2) {
        const F low = perlin_lerp(g.dot(a, 0), g.dot(a, 1), a[0].fade), high = perlin_lerp(g.dot(a, 2), g.dot(a, 3), a[0].fade);
        return F(0.6616) * perlin_lerp(low, high, a[1].fade);
    } else {
        F row[4];
        ALDER_UNROLL
        for (int j = 0; j < 4; ++j) {
            if constexpr (D == 3) {
                row[j] = perlin_lerp(g.dot(a, 2 * j), g.dot(a, 2 * j + 1), a[0].fade);
            } else {
                row[j] = perlin_lerp(perlin_lerp(g.dot(a, 2 * j), g.dot(a, 2 * j + 8), a[3].fade),
                                     perlin_lerp(g.dot(a, 2 * j + 1), g.dot(a, 2 * j + 9), a[3].fade), a[0].fade);
            }
        }
        return F(0.5f * (D == 3 ? 0.982f : 0.8344f)) *
               perlin_lerp(perlin_lerp(row[0], row[1], a[1].fade), perlin_lerp(row[2], row[3], a[1].fade), a[2].fade);
    }
}

/// Signed noise of a point. `reach` is at least the largest |coordinate|, or NaN where one is.
template <int D, class F>
HWY_INLINE F signed_noise(const Coord<D, F>& p, F reach) {
    LatticeAxis<F> a[D];
    if (HWY_LIKELY(all(reach < F(1e5)))) {
        ALDER_UNROLL
        for (int i = 0; i < D; ++i) {
            const F below = floor(p.c[i]);
            a[i].cell = small_floor_to_int(below);
            a[i].set_fraction(p.c[i] - below);
        }
        if constexpr (D > 1 && kMostLanes<F> >= (1 << D)) {
            if (in_one_cell(a)) return perlin_in_one_cell(a);
        }
    } else {
        set_far_axes(p, a);
    }
    return perlin(a);
}
/// A bound of |coordinate| that NaN passes through: the sum.
template <int D, class F>
HWY_INLINE F reach_of(const Coord<D, F>& p) {
    F r = abs(p.c[0]);
    ALDER_UNROLL
    for (int i = 1; i < D; ++i) r = r + abs(p.c[i]);
    return r;
}
template <int D, class F>
HWY_INLINE F signed_noise(const Coord<D, F>& p) { return signed_noise(p, reach_of(p)); }

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
