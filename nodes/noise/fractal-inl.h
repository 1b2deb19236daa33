// Sums and products of Perlin noise over octaves: fBM and four multifractals, as Cycles' Noise and Wave textures use them.
// Musgrave, Peachey, Perlin, Worley, Ebert, "Texturing and Modeling", 3rd ed. 2003, ch. 16; Cycles' variants of detail (a
// fractional last octave) and of roughness (gain from octave to octave).
#if defined(ALDER_NODES_NOISE_FRACTAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_NOISE_FRACTAL_INL_H_
#undef ALDER_NODES_NOISE_FRACTAL_INL_H_
#else
#define ALDER_NODES_NOISE_FRACTAL_INL_H_
#endif

#include "nodes/noise/perlin-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

enum FractalType { kMultifractal, kRidgedMultifractal, kHybridMultifractal, kFbm, kHeteroTerrain };

template <class F>
struct FractalParams {
    F detail;  ///< octaves beyond the first; a fraction adds that much of one more
    F roughness, lacunarity, offset, gain;
    bool normalize;  ///< fBM: to [0, 1] about
    HWY_INLINE FractalParams() {}
};

/// min(max(x, lo), hi) as Cycles orders the comparisons: NaN gives lo.
template <class F>
HWY_INLINE F clamp_nan_to_low(F x, F lo, F hi) { return min(max(lo, x), hi); }

/// Which octaves each lane takes part in: 0 to trunc(detail) in full, then one more where detail has a fraction.
/// At most kMost, so that a linked Detail of a billion ends: beyond that every octave lies where floats have no fraction.
template <class F>
struct Octaves {
    static constexpr int kMost = 64;
    Int<F> last, partial_index;
    F fraction;
    Mask<F> has_fraction;
    HWY_INLINE explicit Octaves(F detail) {
        const F bounded = clamp_nan_to_low(detail, F(-2), F(kMost));
        last = to_int(bounded);
        fraction = detail - floor(detail);
        has_fraction = fraction != F(0);
        partial_index = max(last + Int<F>(1), Int<F>(0));
    }
    HWY_INLINE Mask<F> full(int i) const { return Int<F>(i) <= last; }
    HWY_INLINE Mask<F> partial(int i) const { return has_fraction & (Int<F>(i) == partial_index); }
};

template <int D, class F>
HWY_INLINE F fbm(const Coord<D, F>& p, const FractalParams<F>& q) {
    const Octaves<F> octaves(q.detail);
    const F reach = reach_of(p);
    F scale(1), amplitude(1), weight_sum(0), sum(0), last_amplitude(0), last_noise(0);
    for (int i = 0;; ++i) {
        const Mask<F> full = octaves.full(i), partial = octaves.partial(i);
        if (!any(full | partial)) break;
        const F n = signed_noise(p * scale, reach * abs(scale));
        sum = select(full, mad(n, amplitude, sum), sum);
        weight_sum = select(full, weight_sum + amplitude, weight_sum);
        last_noise = select(partial, n, last_noise);
        last_amplitude = select(partial, amplitude, last_amplitude);
        amplitude = amplitude * q.roughness;
        scale = scale * q.lacunarity;
    }
    F value = sum, longer = mad(last_noise, last_amplitude, sum);
    if (q.normalize) {
        value = F(0.5) * sum / weight_sum + F(0.5);
        longer = F(0.5) * longer / (weight_sum + last_amplitude) + F(0.5);
    }
    return select(octaves.has_fraction, mad(octaves.fraction, longer - value, value), value);
}

template <int D, class F>
HWY_INLINE F multifractal(Coord<D, F> p, const FractalParams<F>& q) {
    const Octaves<F> octaves(q.detail);
    F reach = reach_of(p), value(1), power(1);
    for (int i = 0;; ++i) {
        const Mask<F> full = octaves.full(i), partial = octaves.partial(i);
        if (!any(full | partial)) break;
        const F n = power * signed_noise(p, reach);
        const F factor = mad(select(full, F(1), octaves.fraction), n, F(1));
        value = select(full | partial, value * factor, value);
        power = power * q.roughness;
        p = p * q.lacunarity;
        reach = reach * abs(q.lacunarity);
    }
    return value;
}

template <int D, class F>
HWY_INLINE F hetero_terrain(Coord<D, F> p, const FractalParams<F>& q) {
    const Octaves<F> octaves(q.detail);
    F reach = reach_of(p), value(1), power(1);  // the first octave is neither scaled nor added
    for (int i = 0;; ++i) {
        const Mask<F> full = octaves.full(i), partial = octaves.partial(i);
        if (!any(full | partial)) break;
        const F increment = (signed_noise(p, reach) + q.offset) * power * value;
        if (i == 0) {
            value = increment;
        } else {
            value = select(full, value + increment, select(partial, mad(octaves.fraction, increment, value), value));
        }
        power = power * q.roughness;
        p = p * q.lacunarity;
        reach = reach * abs(q.lacunarity);
    }
    return value;
}

template <int D, class F>
HWY_INLINE F hybrid_multifractal(Coord<D, F> p, const FractalParams<F>& q) {
    const Octaves<F> octaves(q.detail);
    F reach = reach_of(p), value(0), power(1), weight(1);
    for (int i = 0;; ++i) {
        // A weight that has fallen to 0.001 ends the lane's sum, and leaves no last fraction.
        const Mask<F> alive = weight > F(0.001);
        const Mask<F> full = alive & octaves.full(i), partial = alive & octaves.partial(i);
        if (!any(full | partial)) break;
        const F w = min(weight, F(1));
        const F signal = (signed_noise(p, reach) + q.offset) * power;
        value = select(full, mad(w, signal, value), select(partial, mad(octaves.fraction * w, signal, value), value));
        weight = select(full, w * (q.gain * signal), weight);
        power = power * q.roughness;
        p = p * q.lacunarity;
        reach = reach * abs(q.lacunarity);
    }
    return value;
}

template <int D, class F>
HWY_INLINE F ridged_multifractal(Coord<D, F> p, const FractalParams<F>& q) {
    const Octaves<F> octaves(q.detail);
    F reach = reach_of(p), value(0), power(1), signal(0);
    for (int i = 0;; ++i) {
        const Mask<F> full = octaves.full(i);
        if (!any(full)) break;  // no fractional octave here
        const F ridge = q.offset - abs(signed_noise(p, reach));
        const F weight = i == 0 ? F(1) : clamp_nan_to_low(signal * q.gain, F(0), F(1));
        signal = ridge * ridge * weight;
        value = select(full, mad(signal, power, value), value);
        power = power * q.roughness;
        p = p * q.lacunarity;
        reach = reach * abs(q.lacunarity);
    }
    return value;
}

template <FractalType kType, int D, class F>
HWY_INLINE F fractal(const Coord<D, F>& p, const FractalParams<F>& q) {
    if constexpr (kType == kFbm) return fbm(p, q);
    else if constexpr (kType == kMultifractal) return multifractal(p, q);
    else if constexpr (kType == kHybridMultifractal) return hybrid_multifractal(p, q);
    else if constexpr (kType == kRidgedMultifractal) return ridged_multifractal(p, q);
    else return hetero_terrain(p, q);
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
