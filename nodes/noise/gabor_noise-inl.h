// Gabor noise in three dimensions: in each cell a random number of waves under Gaussian envelopes. alshaders specification, section 4.
// Lagae, Lefebvre, Drettakis and Dutré, "Procedural Noise using Sparse Gabor Convolution", SIGGRAPH 2009; Lagae and Drettakis,
// "Filtering Solid Gabor Noise", SIGGRAPH 2011 (random phases).
#if defined(ALDER_NODES_NOISE_GABOR_NOISE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_NOISE_GABOR_NOISE_INL_H_
#undef ALDER_NODES_NOISE_GABOR_NOISE_INL_H_
#else
#define ALDER_NODES_NOISE_GABOR_NOISE_INL_H_
#endif

#include "nodes/noise/hash-inl.h"
#include "nodes/num/math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

enum GaborAnisotropy { kGaborIsotropic, kGaborAnisotropic, kGaborHybrid };

/// Random numbers of a cell: a multiplicative congruential generator started from a hash of the cell. Specification, 1.6.
template <class F>
struct GaborRandom {
    Int<F> state;
    HWY_INLINE GaborRandom(Int<F> x, Int<F> y, Int<F> z) {
        const Int<F> seed = hash_uint4(x, y, z, Int<F>(0));
        state = select(seed == Int<F>(0), Int<F>(1), seed);
    }
    HWY_INLINE F draw() {
        state = state * Int<F>(static_cast<int32_t>(3039177861u));
        return unsigned_to_float<F>(state) * F(0x1p-32);
    }
    /// A Poisson-distributed number; g is exp(-mean). Donald Knuth, The Art of Computer Programming, volume 2, 3.4.1. Lanes that
    /// have their number draw no further.
    HWY_INLINE Int<F> poisson(F g) {
        Int<F> number(0);
        F product = draw();
        // The mean is at most 7.7: 64 rounds end by the product for all but one in 1e35.
        for (int i = 0; i < kMost; ++i) {
            const Mask<F> more = product > g;
            if (!any(more)) break;
            const Int<F> before = state;
            const F next = product * draw();
            state = select(more, state, before);
            number = number + select(more, Int<F>(1), Int<F>(0));
            product = select(more, next, product);
        }
        return number;
    }
    static constexpr int kMost = 64;
};

template <class F>
struct GaborParams {
    Vec3<F> direction;
    F a, radius, poisson_limit, scale;

    /// `impulses` waves a sphere on the average, limited to 1 ... 32; bandwidth in octaves, limited to 0.01 ... 100.
    HWY_INLINE GaborParams(Vec3<F> anisotropy_direction, F bandwidth, F impulses) : direction(anisotropy_direction) {
        const F b = min(max(F(0.01), bandwidth), F(100)), octaves = exp2(b);   // max drops a NaN
        const F count = min(max(F(1), impulses), F(32));
        a = F(2) * ((octaves - F(1)) / (octaves + F(1))) * F(2.12893403886245236);   // base frequency 2; sqrt(π / ln 2)
        radius = F(1.11590124903873280) / a;                                                // sqrt(-ln 0.02 / π): cut where the envelope is 2 %
        const F volume = F(1.33333333 * 3.14159265358979323846);
        poisson_limit = exp(-count / volume);
        const F inverse_root_density = sqrt(volume * radius * radius * radius / count);
        // The original's variance is 1/(4 sqrt2 a³); half of a third of its standard deviation's inverse.
        scale = inverse_root_density * F(0.5 / 3) * sqrt(F(5.65685424949238020) * a * a * a);
    }
};

/// The frequency vector of the next wave. `original`: the cosine of the turn is never negative, a defect.
template <bool original, class F>
HWY_INLINE Vec3<F> gabor_frequency(GaborRandom<F>& random, Vec3<F> direction, int anisotropy) {
    if (anisotropy == kGaborAnisotropic) return direction;
    const F turn = F(6.28318530717958647693) * random.draw();
    const F sine = sin(turn);
    F cosine;
    if constexpr (original) cosine = safe_sqrt(F(1) - sine * sine);
    else cosine = cos(turn);
    if (anisotropy == kGaborHybrid) {
        const F size = length(direction);
        return {size * cosine, size * sine, F(0)};
    }
    const F t = random.draw(), z = (F(1) - t) * F(-1) + t, r = safe_sqrt(F(1) - z * z);
    const Vec3<F> w(cosine * r, sine * r, z);
    if constexpr (original) return normalize(w);
    return w;
}

/// The noise at p. Coordinates that are not finite count as 0.
template <bool original, class F>
HWY_INLINE F gabor_noise(Vec3<F> p, const GaborParams<F>& g, int anisotropy) {
    using I = Int<F>;
    I cell[3];
    Vec3<F> x;   // inside the cell
    for (int c = 0; c < 3; ++c) {
        const F scaled = p[c] / g.radius, at = select(isfinite(scaled), scaled, F(0)), below = floor(at);
        cell[c] = to_int(below);
        x[c] = at - below;
    }
    const F envelope = F(-3.14159265358979323846) * g.a * g.a * g.radius * g.radius;
    F sum(0);
    for (int k = -1; k <= 1; ++k)
        for (int j = -1; j <= 1; ++j)
            for (int i = -1; i <= 1; ++i) {
                GaborRandom<F> random(cell[0] + I(i), cell[1] + I(j), cell[2] + I(k));
                const I count = random.poisson(g.poisson_limit);
                const Vec3<F> from_cell = x - Vec3<F>(F(i), F(j), F(k));
                for (int n = 0; n < GaborRandom<F>::kMost; ++n) {
                    const Mask<F> there = count > I(n);
                    if (!any(there)) break;
                    Vec3<F> at;
                    for (int c = 2; c >= 0; --c) at[c] = random.draw();
                    const Vec3<F> d = from_cell - at;   // in radii
                    const F d2 = dot(d, d);
                    const Mask<F> inside = there & (d2 < F(1));
                    if (!any(inside)) {
                        // As many numbers as the wave would have used.
                        for (int skipped = anisotropy == kGaborIsotropic ? 3 : anisotropy == kGaborHybrid ? 2 : 1; skipped > 0; --skipped) random.draw();
                        continue;
                    }
                    const Vec3<F> w = gabor_frequency<original>(random, g.direction, anisotropy);
                    const F phase = random.draw();
                    const F wave = exp(envelope * d2) * cos(F(6.28318530717958647693) * (g.radius * dot(w, d) + phase));
                    sum = sum + select(inside, wave, F(0));
                }
            }
    return sum * g.scale;
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
