// Lookups into the energy tables, and what closure nodes derive from them: compensation for the light that single
// scattering loses (Multiscatter GGX), the albedo of a dielectric layer, the microfibre sheen's parameters.
// Grids are those of Cycles (linear, clamped, nodes k/(n-1)): its results depend on the interpolation more than on the nodes.
#if defined(ALDER_NODES_SURFACE_ENERGY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_SURFACE_ENERGY_INL_H_
#undef ALDER_NODES_SURFACE_ENERGY_INL_H_
#else
#define ALDER_NODES_SURFACE_ENERGY_INL_H_
#endif

#include "nodes/num/lanes-inl.h"
#include "nodes/num/vec-inl.h"
#include "nodes/surface/fresnel-inl.h"
#include "nodes/surface/tables/tables.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Position on an axis of n nodes: the node at or below x, and the share of the next one. Any x, NaN included, stays inside.
template <class F>
struct TableAxis {
    Int<F> index;
    F share;
    HWY_INLINE TableAxis(F x, int n) {
        const F s = saturate(x) * F(n - 1);
        index = max(min(to_int(s), Int<F>(n - 2)), Int<F>(0));
        share = s - to_float<F>(index);
    }
};
template <class F>
HWY_INLINE F table_1d(const float* table, int n, F x) {
    const TableAxis<F> a(x, n);
    return lerp(gather<F>(table, a.index), gather<F>(table + 1, a.index), a.share);
}
template <class F>
HWY_INLINE F table_2d(const float* table, int n, F x, F y) {
    const TableAxis<F> a(x, n), b(y, n);
    const Int<F> i = a.index + b.index * Int<F>(n);
    return lerp(lerp(gather<F>(table, i), gather<F>(table + 1, i), a.share),
                lerp(gather<F>(table + n, i), gather<F>(table + n + 1, i), a.share), b.share);
}
template <class F>
HWY_INLINE F table_3d(const float* table, int n, F x, F y, F z) {
    const TableAxis<F> a(x, n), b(y, n), c(z, n);
    const Int<F> i = a.index + (b.index + c.index * Int<F>(n)) * Int<F>(n);
    F plane[2];
    for (int k = 0; k < 2; ++k) {
        const float* t = table + k * n * n;
        plane[k] = lerp(lerp(gather<F>(t, i), gather<F>(t + 1, i), a.share),
                        lerp(gather<F>(t + n, i), gather<F>(t + n + 1, i), a.share), b.share);
    }
    return lerp(plane[0], plane[1], c.share);
}

/// The tables' roughness axis: the socket's roughness, (alpha_x alpha_y)^(1/4).
template <class F>
HWY_INLINE F table_roughness(F alpha_x, F alpha_y) { return sqrt(sqrt(alpha_x * alpha_y)); }
/// The tables' index axis: F0^(1/4), the same for ior and 1/ior.
template <class F>
HWY_INLINE F table_index(F ior) { return sqrt(abs((ior - F(1)) / (ior + F(1)))); }

/// Albedo of single scattering towards a viewer of cosine mu, and its average over the hemisphere.
template <class F>
struct SingleScatterAlbedo {
    F e, average;
};
template <class F>
HWY_INLINE SingleScatterAlbedo<F> ggx_energy(F rough, F mu) {
    return {table_2d(kGgxE, 32, rough, mu), table_1d(kGgxEavg, 32, rough)};
}
/// Of reflection and refraction together; eta < 1 seen from inside.
template <class F>
HWY_INLINE SingleScatterAlbedo<F> ggx_glass_energy(F rough, F mu, F eta) {
    const F z = table_index(eta);
    const Mask<F> inside = eta < F(1);
    SingleScatterAlbedo<F> r{F(1), F(1)};
    if (!all(inside)) r = {table_3d(kGgxGlassE, 16, rough, mu, z), table_2d(kGgxGlassEavg, 16, rough, z)};
    if (any(inside)) {
        r.e = select(inside, table_3d(kGgxGlassInsideE, 16, rough, mu, z), r.e);
        r.average = select(inside, table_2d(kGgxGlassInsideEavg, 16, rough, z), r.average);
    }
    return r;
}

/// Factor that a single-scattering lobe's weight is multiplied by: 1/E, less what further bounces lose to the average
/// Fresnel term fss. Kulla and Conty, "Revisiting Physically Based Shading at Imageworks", 2017, with one bounce of Fresnel
/// in the lobe itself. `darkening` is the colour part (1 where fss is 1): Cycles lets it alone dim the layers below.
template <class F>
struct MultiScatter {
    F scale;
    Vec3<F> darkening;
    HWY_INLINE MultiScatter(SingleScatterAlbedo<F> a, Vec3<F> fss) {
        const F missing = (F(1) - a.e) / a.e;
        scale = F(1) / a.e;
        for (int i = 0; i < 3; ++i) {
            const F lost = max(F(1) - fss[i] * (F(1) - a.average), F(1e-6));
            const F fms = fss[i] * a.average / lost;
            darkening[i] = select(fss[i] == F(1), F(1), (F(1) + fms * missing) * a.e);
        }
    }
    HWY_INLINE Vec3<F> factor() const { return darkening * scale; }
};

/// How far the Fresnel curve of a dielectric layer has risen from F0 (0) towards 1, averaged over the normals that a viewer
/// sees. Uses the outside curve for eta < 1 too, as Cycles does.
template <class F>
HWY_INLINE F layer_fresnel_rise(F rough, F mu, F eta) {
    return table_3d(kGgxFresnelRise, 16, rough, mu, table_index(eta));
}

/// Microfibre sheen towards a viewer of cosine mu. Absent where albedo is 0.
template <class F>
struct SheenFit {
    F a, b, albedo;
    HWY_INLINE SheenFit(F mu, F roughness) {
        const F r = clamp(roughness, F(1e-3), F(1));
        a = table_2d(kSheenLtc[0], 32, mu, r);
        b = table_2d(kSheenLtc[1], 32, mu, r);
        albedo = table_2d(kSheenLtc[2], 32, mu, r);
        albedo = select((abs(a) < F(1e-5)) | (albedo < F(1e-5)), F(0), albedo);
    }
};

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
