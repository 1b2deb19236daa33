// Noise Texture: fractal Perlin noise in one to four dimensions, as a value and as a colour of three independent values.
// Follows Cycles' SVM: coordinates times Scale, then distortion, then the fractal of the chosen type (noise/fractal-inl.h).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/texture/tex_noise.cpp"
#include "hwy/foreach_target.h"

#include "nodes/noise/fractal-inl.h"
#include "nodes/texture/texture_mapping-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

namespace tex_noise {
// Parameters, and the channels of the dynamic ones.
enum Parameter { kMapping, kDimensions, kType, kVector, kW, kScale, kDetail, kRoughness, kLacunarity, kOffset, kGain, kDistortion, kNormalize };
enum Channel { kVectorIn = 0, kWIn = 3, kScaleIn, kDetailIn, kRoughnessIn, kLacunarityIn, kOffsetIn, kGainIn, kDistortionIn };
enum Out { kFacOut, kColorOut };

/// Where the noise that distorts an axis, or makes another colour component, is read: far from the first, in [100, 200].
constexpr float random_offset(int dimensions, int seed, int axis) {
    const uint32_t s = std::bit_cast<uint32_t>(static_cast<float>(seed)), a = std::bit_cast<uint32_t>(static_cast<float>(axis));
    return 100.0f + 100.0f * (static_cast<float>(dimensions == 1 ? hash_uint(s) : hash_uint2(s, a)) * 0x1p-32f);
}
/// Seeds 0 to D-1 distort the D axes, D and D+1 make green and blue.
template <int D>
struct RandomOffsets {
    float at[D + 2][D];
    constexpr RandomOffsets() : at{} {
        for (int seed = 0; seed < D + 2; ++seed) {
            ALDER_UNROLL
            for (int axis = 0; axis < D; ++axis) at[seed][axis] = random_offset(D, seed, axis);
        }
    }
    template <class F>
    HWY_INLINE Coord<D, F> moved(Coord<D, F> p, int seed) const {
        ALDER_UNROLL
        for (int axis = 0; axis < D; ++axis) p.c[axis] = p.c[axis] + F(at[seed][axis]);
        return p;
    }
};
template <int D>
inline constexpr RandomOffsets<D> kOffsets;
}  // namespace tex_noise

template <int D, FractalType kType>
struct TexNoise {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        using namespace tex_noise;
        constexpr const RandomOffsets<D>& offsets = kOffsets<D>;
        Coord<D, F> p;
        if constexpr (D > 1) {
            const Vec3<F> v = mapped_vector(k, kVectorIn);
            ALDER_UNROLL
            for (int i = 0; i < (D < 3 ? D : 3); ++i) p.c[i] = v[i];
        }
        if constexpr (D == 1 || D == 4) p.c[D - 1] = k.f(kWIn);
        p = p * k.f(kScaleIn);

        FractalParams<F> q;
        q.detail = clamp_nan_to_low(k.f(kDetailIn), F(0), F(15));
        q.roughness = max(F(0), k.f(kRoughnessIn));
        q.lacunarity = k.f(kLacunarityIn);
        q.offset = k.f(kOffsetIn);
        q.gain = k.f(kGainIn);
        q.normalize = k.statics().e(kNormalize) != 0;

        const F distortion = k.f(kDistortionIn);
        const Mask<F> distorted = distortion != F(0);
        if (any(distorted)) {
            Coord<D, F> d;
            ALDER_UNROLL
            for (int axis = 0; axis < D; ++axis) d.c[axis] = signed_noise(offsets.moved(p, axis));
            ALDER_UNROLL
            for (int axis = 0; axis < D; ++axis) p.c[axis] = select(distorted, fused_mad(d.c[axis], distortion, p.c[axis]), p.c[axis]);
        }
        // One call for value, red, green and blue keeps the code small.
        for (int component = 0; component < 3; ++component) {
            const bool wanted = k.wants(kColorOut + component) || (component == 0 && k.wants(kFacOut));
            if (!wanted) continue;
            const F value = fractal<kType>(component == 0 ? p : offsets.moved(p, D - 1 + component), q);
            if (component == 0) k.set(kFacOut, value);
            k.set(kColorOut + component, value);
        }
    }
};
template <int D, class F>
HWY_INLINE void tex_noise_dimension(const Call<F>& c) {
    switch (c.statics().e(tex_noise::kType)) {
        case kMultifractal: return c.template each<TexNoise<D, kMultifractal>>();
        case kRidgedMultifractal: return c.template each<TexNoise<D, kRidgedMultifractal>>();
        case kHybridMultifractal: return c.template each<TexNoise<D, kHybridMultifractal>>();
        case kHeteroTerrain: return c.template each<TexNoise<D, kHeteroTerrain>>();
        default: return c.template each<TexNoise<D, kFbm>>();
    }
}
template <class F>
void tex_noise_kernel(const Call<F>& c) {
    switch (c.statics().e(tex_noise::kDimensions)) {
        case 0: return tex_noise_dimension<1>(c);
        case 1: return tex_noise_dimension<2>(c);
        case 2: return tex_noise_dimension<3>(c);
        default: return tex_noise_dimension<4>(c);
    }
}
ALDER_KERNEL(tex_noise_kernel)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(tex_noise_kernel)

static bool tex_noise_uses(const Statics& s, int p) {
    using namespace HWY_NAMESPACE;
    using namespace HWY_NAMESPACE::tex_noise;
    const int dimensions = s.e(kDimensions) + 1, type = s.e(kType);
    switch (p) {
        case kVector: case kMapping: return dimensions > 1;
        case kW: return dimensions == 1 || dimensions == 4;
        case kOffset: return type == kRidgedMultifractal || type == kHybridMultifractal || type == kHeteroTerrain;
        case kGain: return type == kRidgedMultifractal || type == kHybridMultifractal;
        case kNormalize: return type == kFbm;
        default: return true;
    }
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeTexNoise";
    n.aliases = {"noise_texture"};
    n.system = System::Cycles;
    n.category = "texture";
    n.summary = "fractal Perlin noise, as a value and as a colour";
    n.help = "Perlin noise summed over octaves. Detail is the number of octaves beyond the first (0 to 15), its fraction fades the last one in; "
             "Roughness the strength of each octave relative to the one before, Lacunarity its frequency. The colour is three such noises.";
    n.params = {
        texture_mapping_param(),
        choice("noise_dimensions", {{"1D", "1D", "1D"}, {"2D", "2D", "2D"}, {"3D", "3D", "3D"}, {"4D", "4D", "4D"}}, "3D")
            .alias("dimensions").doc("which coordinates are read: W; Vector's x, y; Vector; Vector and W"),
        choice("noise_type",
               {{"MULTIFRACTAL", "Multifractal", "multifractal"},
                {"RIDGED_MULTIFRACTAL", "Ridged Multifractal", "ridged_multifractal"},
                {"HYBRID_MULTIFRACTAL", "Hybrid Multifractal", "hybrid_multifractal"},
                {"FBM", "fBM", "fBM"},
                {"HETERO_TERRAIN", "Hetero Terrain", "hetero_terrain"}},
               "FBM").alias("type").doc("how octaves are combined"),
        vector("Vector", 0, 0, 0).unlinked(Global::Generated).doc("where the noise is read; unlinked: generated coordinates"),
        f("W").range(-1000, 1000).doc("coordinate of 1D, fourth coordinate of 4D"),
        f("Scale", 5).range(-1000, 1000).doc("frequency of the first octave"),
        f("Detail", 2).range(0, 15).doc("octaves beyond the first; clamped to 0 to 15"),
        f("Roughness", 0.5).range(0, 1).doc("strength of an octave relative to the one before; negative counts as 0"),
        f("Lacunarity", 2).range(0, 1000).doc("frequency of an octave relative to the one before"),
        f("Offset", 0).range(-1000, 1000).doc("added to each octave before it multiplies (ridged, hybrid, hetero terrain)"),
        f("Gain", 1).range(0, 1000).doc("weight of an octave by the one before (ridged, hybrid)"),
        f("Distortion", 0).range(-1000, 1000).doc("how far noise moves the coordinates first"),
        b("normalize", true).no_link().alias("use_normalize").doc("fBM: bring the sum to 0 to 1; else it is about -1 to 1 and grows with octaves"),
        color_mapping_param(),
    };
    n.outputs = {{"Fac", Type::Float}, {"Color", Type::Color}};
    n.kernel = tex_noise_kernel_kernel();
    n.cost_ns = 40;
    n.uses = tex_noise_uses;
    n.prepare = prepare_texture_mapping;
    return n;
}
}  // namespace alder
#endif
