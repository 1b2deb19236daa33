// The Voronoi Texture's kernel for D dimensions: reads the operands, picks the feature, writes the outputs.
#if defined(ALDER_NODES_TEXTURE_TEX_VORONOI_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_TEXTURE_TEX_VORONOI_INL_H_
#undef ALDER_NODES_TEXTURE_TEX_VORONOI_INL_H_
#else
#define ALDER_NODES_TEXTURE_TEX_VORONOI_INL_H_
#endif

#include "nodes/math/finite-inl.h"
#include "nodes/noise/voronoi-inl.h"
#include "nodes/texture/tex_voronoi.h"
#include "nodes/texture/texture_mapping-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

template <int D, VoronoiFeature kFeature>
struct TexVoronoi {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        using namespace tex_voronoi;
        VoronoiParams<F> q;
        q.scale = k.f(kScaleIn);
        Coord<D, F> p;
        if constexpr (D > 1) {
            const Vec3<F> v = mapped_vector(k, kVectorIn);
            ALDER_UNROLL
            for (int i = 0; i < (D < 3 ? D : 3); ++i) p.c[i] = v[i];
        }
        if constexpr (D == 1 || D == 4) p.c[D - 1] = k.f(kWIn);
        p = p * q.scale;

        q.detail = clamp_nan_to_low(k.f(kDetailIn), F(0), F(15));
        q.roughness = clamp_nan_to_low(k.f(kRoughnessIn), F(0), F(1));
        q.lacunarity = k.f(kLacunarityIn);
        q.smoothness = clamp_nan_to_low(k.f(kSmoothnessIn) * F(0.5), F(0), F(0.5));
        q.exponent = k.f(kExponentIn);
        q.randomness = clamp_nan_to_low(k.f(kRandomnessIn), F(0), F(1));
        q.metric = k.statics().e(kDistance);
        q.normalize = k.statics().e(kNormalize) != 0;
        q.wants_color = k.wants(kColorOut) || k.wants(kColorOut + 1) || k.wants(kColorOut + 2);
        q.wants_position = k.wants(kPositionOut) || k.wants(kPositionOut + 1) || k.wants(kPositionOut + 2) || k.wants(kWOut);

        if constexpr (kFeature == kDistanceToEdge) {
            k.set(kDistanceOut, finite_or_limit(fractal_voronoi_distance_to_edge(p, q)));
        } else if constexpr (kFeature == kSphereRadius) {
            k.set(kRadiusOut, finite_or_limit(voronoi_sphere_radius(p, q)));
        } else {
            const VoronoiResult<D, F> r = fractal_voronoi<kFeature>(p, q);
            k.set(kDistanceOut, finite_or_limit(r.distance));
            if (q.wants_color) k.set(kColorOut, finite_or_limit(r.color));
            if (q.wants_position) {
                const F zero(0);
                k.set(kPositionOut, finite_or_limit(Vec3<F>(D > 1 ? r.position.c[0] : zero, D > 1 ? r.position.c[D > 1 ? 1 : 0] : zero,
                                            D > 2 ? r.position.c[D > 2 ? 2 : 0] : zero)));
                k.set(kWOut, D == 1 || D == 4 ? finite_or_limit(r.position.c[D - 1]) : zero);
            }
        }
        // What the feature does not give is 0.
        for (int out = kDistanceOut; out < kOutputs; ++out) {
            const bool given = kFeature == kDistanceToEdge ? out == kDistanceOut : kFeature == kSphereRadius ? out == kRadiusOut : out != kRadiusOut;
            if (!given) k.set(out, F(0));
        }
    }
};
template <int D, class F>
HWY_INLINE void tex_voronoi_dimension(const Call<F>& c) {
    switch (c.statics().e(tex_voronoi::kFeature)) {
        case kF1: return c.template each<TexVoronoi<D, kF1>>();
        case kF2: return c.template each<TexVoronoi<D, kF2>>();
        case kSmoothF1: return c.template each<TexVoronoi<D, kSmoothF1>>();
        case kDistanceToEdge: return c.template each<TexVoronoi<D, kDistanceToEdge>>();
        default: return c.template each<TexVoronoi<D, kSphereRadius>>();
    }
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
