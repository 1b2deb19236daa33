// The sum of alFractal over any basis of noise. alshaders specification, section 4.
#if defined(ALDER_NODES_NOISE_AL_FRACTAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_NOISE_AL_FRACTAL_INL_H_
#undef ALDER_NODES_NOISE_AL_FRACTAL_INL_H_
#else
#define ALDER_NODES_NOISE_AL_FRACTAL_INL_H_
#endif

#include "nodes/noise/octave_fade-inl.h"
#include "nodes/num/vec-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

template <class F>
struct AlFractalParams {
    F time, distortion, lacunarity, gain;
    int octaves;
    bool turbulent;
    bool fades = false;  ///< octaves that are too fine for the pixel; not with `turbulent`, whose octaves have no mean of 0
    F reach = F(0);      ///< how far the point moves to the next pixel
};
template <class F>
HWY_INLINE F noise4(const auto& basis, Vec3<F> p, F t, F*) { return basis.perlin4(p, t); }
template <class F>
HWY_INLINE Vec3<F> noise4(const auto& basis, Vec3<F> p, F t, Vec3<F>*) { return basis.vnoise4(p, t); }
template <class F>
HWY_INLINE Vec3<F> abs(Vec3<F> a) { return {abs(a.x), abs(a.y), abs(a.z)}; }

/// V: F for the scalar mode, Vec3<F> for the vector mode. The sum is not divided by the amplitudes.
template <class V, class Basis, class F>
HWY_INLINE V al_fractal_sum(const Basis& basis, Vec3<F> p, const AlFractalParams<F>& f) {
    V sum(F(0));
    F amplitude(1), cells = f.reach;
    const bool fades = f.fades && !f.turbulent;
    const Mask<F> distorted = f.distortion != F(0);
    for (int octave = 0; octave < f.octaves; ++octave) {
        Vec3<F> q = p;
        if (any(distorted)) q = select(distorted, p + f.distortion * basis.vnoise3(p), p);
        V v = noise4(basis, q, f.time, static_cast<V*>(nullptr));
        if (f.turbulent) v = abs(v);
        if (fades) {
            const F w = octave_weight(cells);
            if (!any((w > F(0)) | (abs(f.lacunarity) < F(1)))) break;  // those to come are finer
            v = v * w;
            cells *= abs(f.lacunarity);
        }
        sum += v * amplitude;
        amplitude *= f.gain;
        p *= f.lacunarity;
    }
    return sum;
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
