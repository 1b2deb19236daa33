// alSurface, the arithmetic: widths, the colour budget, which lobes run, and the energy that each layer passes down.
// alshaders specification, section 6. A stack: specular 1 over specular 2 over (diffuse, backlight, transmission), emission
// below both speculars.
#if defined(ALDER_NODES_SURFACE_AL_SURFACE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_SURFACE_AL_SURFACE_INL_H_
#undef ALDER_NODES_SURFACE_AL_SURFACE_INL_H_
#else
#define ALDER_NODES_SURFACE_AL_SURFACE_INL_H_
#endif

#include "nodes/surface/al_albedo-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Below this a contribution is not worth a lobe (the original's IMPORTANCE_EPS).
template <class F>
HWY_INLINE F al_eps() { return F(1e-5); }

/// Smallest width of a rough lobe.
template <class F>
HWY_INLINE F al_min_alpha() { return F(1e-3); }

template <class F>
struct AlWidths {
    F x, y;
};

/// Widths of a specular (6.3): anisotropy lengthens one of them towards 1; `floor` is what the path's roughness demands.
template <class F>
HWY_INLINE AlWidths<F> al_widths(F alpha, F anisotropy, F floor) {
    const F a = min(F(1), max(F(0), anisotropy));
    const F k = sqr(F(2) * a - F(1));
    const F drawn_out = lerp(max(F(0.0025), alpha), F(1), k);
    AlWidths<F> w{select(a < F(0.5), drawn_out, alpha), select(a > F(0.5), drawn_out, alpha)};
    w.x = max(al_min_alpha<F>(), max(floor, w.x));
    w.y = max(al_min_alpha<F>(), max(floor, w.y));
    return w;
}

/// Frame about n: x along dPdu where that is usable (6.1), else any. n is a unit vector.
template <class F>
struct AlFrame {
    Vec3<F> u, v;
};
template <class F>
HWY_INLINE AlFrame<F> al_frame(Vec3<F> n, Vec3<F> dpdu) {
    // Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017, listing 3.
    const F sign = copysign(F(1), n.z);
    const F a = F(-1) / (sign + n.z), b = n.x * n.y * a;
    const Vec3<F> any_u(F(1) + sign * n.x * n.x * a, sign * b, -sign * n.x);
    const Vec3<F> side = cross(n, dpdu);
    const F length2 = dot(side, side);
    const Mask<F> usable = (length2 > F(1e-30)) & isfinite(length2);
    const Vec3<F> v = side * (F(1) / sqrt(select(usable, length2, F(1))));
    const Vec3<F> u = select(usable, cross(v, n), any_u);
    return {u, select(usable, v, cross(n, any_u))};
}

/// Where the ray stands in its tree (6.5).
template <class F>
struct AlPath {
    F depth, diffuse_depth, glossy_depth, transmission_depth;
    F previous_alpha;  ///< width of the lobe that cast the ray; 0 on camera rays
    HWY_INLINE AlPath() {}
};

/// Whether a specular runs. `alpha` is the roughness squared, before anisotropy and floor.
template <class F>
HWY_INLINE Mask<F> al_specular_runs(const AlPath<F>& path, Vec3<F> color, F alpha, bool caustic_paths,
                                    Mask<F> internal_reflections) {
    Mask<F> off = (max_component(color) < al_eps<F>()) | (alpha > F(1));
    off = off | ((path.transmission_depth > F(0)) & !internal_reflections);
    if (!caustic_paths) off = off | (path.diffuse_depth > F(0));
    return !off;
}

/// Whether the mirror path of specular 1 runs besides: not where a rough bounce would see it (a firefly), nor from inside where
/// the surface reflects totally (6.6, 6.11): there transmission carries the reflected ray, undimmed since specular 1 is off.
template <class F>
HWY_INLINE Mask<F> al_mirror_runs(const AlPath<F>& path, F cos_o, F ior, Mask<F> inside) {
    const Mask<F> total = inside & (ior * ior * (F(1) - cos_o * cos_o) >= F(1));
    return !(total | (path.previous_alpha > F(0)));
}

/// One specular as the layers below see it.
template <class F>
struct AlCoat {
    Vec3<F> color;
    Mask<F> runs;
    F albedo;  ///< largest channel of the directional albedo with Fresnel, without the colour
    HWY_INLINE AlCoat() : color(F(0)), runs(false), albedo(F(0)) {}
    /// What it passes down. Colours above 1 would make it negative.
    HWY_INLINE F passed() const {
        return select(runs, max(F(0), F(1) - albedo * max_component(color)), F(1));
    }
};

/// Colours times strengths, before the budget.
template <class F>
struct AlBase {
    Vec3<F> diffuse, backlight, transmission, emission, opacity;
    F sss_mix;
    HWY_INLINE AlBase() {}
};

template <class F>
struct AlWeights {
    Vec3<F> specular1, specular2, diffuse, subsurface, backlight, transmission, emission, shadow, transparent;
    HWY_INLINE AlWeights() {}
};

/// Diffuse, backlight and transmission together reflect or pass at most all the light (6.2).
template <class F>
HWY_INLINE void al_balance(AlBase<F>& b) {
    const F t = max_component(b.transmission) + max_component(b.diffuse) + max_component(b.backlight);
    const F scale = F(1) / select(t > F(1), t, F(1));
    b.diffuse *= scale;
    b.backlight *= scale;
    b.transmission *= scale;
}

/// Subsurface scattering runs on camera rays and their first glossy bounce; elsewhere diffuse takes its part over.
template <class F>
HWY_INLINE F al_sss_mix(const AlPath<F>& path, F mix, Mask<F> has_weights) {
    const Mask<F> off = (path.diffuse_depth > F(0)) | (path.glossy_depth > F(1)) | (mix < F(0.01)) | !has_weights;
    return select(off, F(0), mix);
}

/// Lobe weights of the stack (6.5, 6.6). `base` is balanced. Arnold's renderer composites the shader's colour by its opacity
/// ("over"); a closure has to carry that itself, so every lobe is multiplied by opacity and the rest is transparent.
/// fresnel_straight: specular 1's reflectance for the straight line of a shadow ray; 1 where metallic (6.8).
template <class F>
HWY_INLINE AlWeights<F> al_weights(const AlPath<F>& path, const AlBase<F>& base, const AlCoat<F>& s1, const AlCoat<F>& s2,
                                   bool transmission_caustics, F fresnel_straight) {
    const Vec3<F> black(F(0));
    const Vec3<F> o(min(F(1), max(F(0), base.opacity.x)), min(F(1), max(F(0), base.opacity.y)),
                    min(F(1), max(F(0), base.opacity.z)));
    const F k1 = s1.passed(), k2 = k1 * s2.passed(), k = k2 * (F(1) - base.sss_mix);
    Mask<F> transmits = !(max_component(base.transmission) < al_eps<F>());
    const Mask<F> casts_light = transmits;
    if (!transmission_caustics) transmits = transmits & !(path.diffuse_depth > F(0));

    AlWeights<F> w;
    w.specular1 = select(s1.runs, o * s1.color, black);
    w.specular2 = select(s2.runs, o * s2.color * k1, black);
    w.diffuse = select(max_component(base.diffuse) < al_eps<F>(), black, o * base.diffuse * k);
    w.subsurface = select(max_component(base.diffuse) < al_eps<F>(), black, o * base.diffuse * (k2 * base.sss_mix));
    w.backlight = select(max_component(base.backlight) < al_eps<F>(), black, o * base.backlight * k);
    w.transmission = select(transmits, o * base.transmission * k2, black);
    w.emission = o * base.emission * k2;
    const F kappa = F(1) - fresnel_straight;
    w.shadow = select(casts_light & !(kappa < al_eps<F>()), o * base.transmission * kappa, black);
    w.transparent = Vec3<F>(F(1)) - o;
    return w;
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
