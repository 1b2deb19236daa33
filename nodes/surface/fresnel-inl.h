// Fresnel reflectance: dielectrics, conductors, F82 metals, and a dielectric under a thin film.
// Shared by closure nodes (layering needs the reflectance of a layer) and by the lobes of render/closure.
// Cosines are taken as absolute values; eta is the index of the far medium over that of the near one and is limited to
// 1e-9 ... 1e9, so that its square stays finite.
#if defined(ALDER_NODES_SURFACE_FRESNEL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_SURFACE_FRESNEL_INL_H_
#undef ALDER_NODES_SURFACE_FRESNEL_INL_H_
#else
#define ALDER_NODES_SURFACE_FRESNEL_INL_H_
#endif

#include "nodes/num/lanes-inl.h"
#include "nodes/num/math-inl.h"
#include "nodes/num/vec-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Reflected amplitudes at one interface.
template <class F>
struct FresnelAmplitudes {
    F s, p;      ///< both 1 under total reflection
    F cos_t;     ///< cosine of the refracted ray, >= 0; 0 under total reflection
    Mask<F> total;
    HWY_INLINE FresnelAmplitudes() {}
};
/// eta cos_t = sqrt((eta-1)(eta+1) + c²) does not cancel near eta = 1, where eta² - (1 - c²) would.
template <class F>
HWY_INLINE FresnelAmplitudes<F> fresnel_amplitudes(F c, F eta) {
    c = min(abs(c), F(1));
    eta = clamp(eta, F(1e-9), F(1e9));
    const F g2 = (eta - F(1)) * (eta + F(1)) + c * c;
    FresnelAmplitudes<F> r;
    r.total = !(g2 > F(0));
    const F g = sqrt(select(r.total, F(1), g2));
    const F e2c = eta * eta * c;
    r.s = select(r.total, F(1), (c - g) / (c + g));
    r.p = select(r.total, F(1), (e2c - g) / (e2c + g));
    r.cos_t = select(r.total, F(0), g / eta);
    return r;
}
template <class F>
HWY_INLINE F fresnel_dielectric(F c, F eta) {
    const FresnelAmplitudes<F> r = fresnel_amplitudes(c, eta);
    return F(0.5) * (r.s * r.s + r.p * r.p);
}
template <class F>
HWY_INLINE F f0_from_ior(F ior) { return sqr((ior - F(1)) / (ior + F(1))); }
/// f0 is limited to 0.99.
template <class F>
HWY_INLINE F ior_from_f0(F f0) {
    const F r = sqrt(clamp(f0, F(0), F(0.99)));
    return (F(1) + r) / (F(1) - r);
}
/// 2 int c F dc: fits of Kulla and Conty, "Revisiting Physically Based Shading at Imageworks", 2017.
template <class F>
HWY_INLINE F fresnel_dielectric_average(F eta) {
    const F above = (eta - F(1)) / (F(4.08567) + F(1.00071) * eta);
    const F below = F(0.997118) + eta * (F(0.1014) - eta * (F(0.965241) + eta * F(0.130607)));
    return select(eta < F(1), below, above);
}

/// Where x lies between f0 (0) and 1 (1): how far the real curve has risen. 0 where f0 is 1 already.
template <class F>
HWY_INLINE F fresnel_rise(F x, F f0) { return saturate((x - f0) / max(F(1) - f0, F(1e-12))); }

template <class F>
HWY_INLINE F fresnel_conductor(F c, F n, F k) {
    n = clamp(n, F(0), F(1e9));
    k = clamp(k, F(0), F(1e9));
    const F t = n * n + k * k, c2 = c * c, m = F(2) * n * c;
    const F p = (t * c2 - m + F(1)) / (t * c2 + m + F(1));
    const F s = (t - m + c2) / max(t + m + c2, F(1e-30));
    return F(0.5) * (p + s);
}
template <class F>
HWY_INLINE Vec3<F> fresnel_conductor(F c, Vec3<F> n, Vec3<F> k) {
    return {fresnel_conductor(c, n.x, k.x), fresnel_conductor(c, n.y, k.y), fresnel_conductor(c, n.z, k.z)};
}

/// F82 of Kutz et al., "Novel aspects of the Adobe Standard Material", 2021: Schlick less b c (1-c)^6.
template <class F>
HWY_INLINE Vec3<F> fresnel_f82(F c, Vec3<F> f0, Vec3<F> b) {
    const F u = saturate(F(1) - c), u2 = u * u, u5 = u2 * u2 * u, dip = c * u5 * u;
    const Vec3<F> f = lerp(f0, Vec3<F>(F(1)), u5) - b * dip;
    return {saturate(f.x), saturate(f.y), saturate(f.z)};
}
inline constexpr double kF82SchlickWeight = (6.0 / 7) * (6.0 / 7) * (6.0 / 7) * (6.0 / 7) * (6.0 / 7);
inline constexpr double kF82Scale = 7.0 / (kF82SchlickWeight * 6.0 / 7);
/// b from the reflectance wanted at cos = 1/7 relative to Schlick's.
template <class F>
HWY_INLINE Vec3<F> f82_b_from_tint(Vec3<F> f0, Vec3<F> tint) {
    return lerp(f0, Vec3<F>(F(1)), F(kF82SchlickWeight)) * (Vec3<F>(F(1)) - tint) * F(kF82Scale);
}
template <class F>
HWY_INLINE Vec3<F> f82_average(Vec3<F> f0, Vec3<F> b) {
    return lerp(f0, Vec3<F>(F(1)), F(1.0 / 21)) - b * F(1.0 / 126);
}
/// Average of a conductor: of the F82 curve through its values at 0 and 82 degrees (Cycles).
template <class F>
HWY_INLINE Vec3<F> fresnel_conductor_average(Vec3<F> n, Vec3<F> k) {
    const Vec3<F> f0 = fresnel_conductor(F(1), n, k), f82 = fresnel_conductor(F(1.0 / 7), n, k);
    const Vec3<F> b = (lerp(f0, Vec3<F>(F(1)), F(kF82SchlickWeight)) - f82) * F(kF82Scale);
    const Vec3<F> a = f82_average(f0, b);
    return {saturate(a.x), saturate(a.y), saturate(a.z)};
}

// ---- thin film: Belcour and Barla, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence",
// SIGGRAPH 2017 ----------------------------------------------------------------------------------------------------------

/// Fourier transform of the colour matching functions at optical path difference `opd` (nm), phase `shift`; their Gaussian
/// fits, X with two bumps. XYZ of an equal-energy spectrum.
template <class F>
HWY_INLINE Vec3<F> film_sensitivity(F opd, F shift) {
    const F ph = F(6.28318530717958648e-9) * min(opd, F(1e7)), ph2 = ph * ph;
    // val sqrt(2 pi var) / 1.0685e-7 of each curve
    const F x = F(5.4856e-13 * 164901.0897 / 1.0685e-7) * cos(F(1.6810e6) * ph + shift) * exp(F(-4.3278e9) * ph2);
    const F x2 = F(1.64408e-8 / 1.0685e-7) * cos(F(2.2399e6) * ph + shift) * exp(F(-4.5282e9) * ph2);
    const F y = F(4.4201e-13 * 241790.2521 / 1.0685e-7) * cos(F(1.7953e6) * ph + shift) * exp(F(-9.3046e9) * ph2);
    const F z = F(5.2481e-13 * 203826.0277 / 1.0685e-7) * cos(F(2.2084e6) * ph + shift) * exp(F(-6.6121e9) * ph2);
    return {x + x2, y, z};
}
/// Airy sum of one polarisation, orders 0 to 3 (equation 10 of the paper).
template <class F>
HWY_INLINE Vec3<F> film_airy_sum(F r12, F r23, F opd, F phase) {
    const F t121 = F(1) - r12, r123 = r12 * r23;
    const F rs = t121 * t121 * r23 / max(F(1) - r123, F(1e-12));
    Vec3<F> sum(r12 + rs);
    F cm = rs - t121;
    const F root = sqrt(r123);
    for (int m = 1; m <= 3; ++m) {
        cm = cm * root;
        sum = sum + film_sensitivity(F(m) * opd, F(m) * phase) * (F(2) * cm);
    }
    return sum;
}
/// Reflectance (linear Rec.709) of a film of index film_eta and the given thickness (nm) over a medium of index eta, all
/// relative to the near medium. Below 30 nm the film fades out, since wave optics would not.
template <class F>
HWY_INLINE Vec3<F> fresnel_thin_film(F c, F film_eta, F eta, F thickness) {
    const F s = saturate(thickness * F(1.0 / 30));
    film_eta = lerp(F(1), film_eta, s * s * (F(3) - F(2) * s));
    const FresnelAmplitudes<F> top = fresnel_amplitudes(c, film_eta);
    const FresnelAmplitudes<F> bottom = fresnel_amplitudes(top.cos_t, eta / film_eta);
    const F opd = F(2) * film_eta * thickness * top.cos_t;
    const F pi = F(3.14159265358979324);
    // A negative amplitude is a phase of pi.
    const F phase_s = pi - select(top.s < F(0), pi, F(0)) + select(bottom.s < F(0), pi, F(0));
    const F phase_p = pi - select(top.p < F(0), pi, F(0)) + select(bottom.p < F(0), pi, F(0));
    const Vec3<F> xyz = (film_airy_sum(sqr(top.s), sqr(bottom.s), opd, phase_s) +
                         film_airy_sum(sqr(top.p), sqr(bottom.p), opd, phase_p)) * F(0.5);
    // The fits assume an equal-energy spectrum: scale by the D65 white, then XYZ -> Rec.709.
    const F X = xyz.x * F(0.95047), Y = xyz.y, Z = xyz.z * F(1.08883);
    const Vec3<F> rgb(saturate(F(3.2404542) * X - F(1.5371385) * Y - F(0.4985314) * Z),
                      saturate(F(-0.9692660) * X + F(1.8760108) * Y + F(0.0415560) * Z),
                      saturate(F(0.0556434) * X - F(0.2040259) * Y + F(1.0572252) * Z));
    return select(top.total | bottom.total, Vec3<F>(F(1)), rgb);
}

/// The Principled BSDF's dielectric reflectance: the real curve at eta, stretched to run from f0 to 1.
template <class F>
HWY_INLINE Vec3<F> fresnel_principled(F c, F eta, Vec3<F> f0) {
    return lerp(f0, Vec3<F>(F(1)), fresnel_rise(fresnel_dielectric(c, eta), f0_from_ior(eta)));
}
/// The same under a film. A film can reflect less than the bare surface, so f0 scales it: fully where it is at the bare
/// surface's normal reflectance or below, not at all at 1.
template <class F>
HWY_INLINE Vec3<F> fresnel_principled_film(F c, F eta, Vec3<F> f0, F thickness, F film_eta) {
    Vec3<F> r = fresnel_thin_film(c, film_eta, eta, thickness);
    const F bare = f0_from_ior(eta);
    const Mask<F> scaled = (bare > F(1e-5)) & !((r.x == F(1)) & (r.y == F(1)) & (r.z == F(1)));
    const F inv = F(1) / select(scaled, bare, F(1));
    const F span = F(1) / select(scaled & (bare < F(1)), bare - F(1), F(-1));
    for (int i = 0; i < 3; ++i) {
        const F amount = saturate((r[i] - F(1)) * span);
        r[i] = select(scaled, r[i] * lerp(F(1), f0[i] * inv, amount), r[i]);
    }
    return r;
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
