// Noise Texture: fractal Perlin noise in one to four dimensions, as a value and as a colour of three independent values.
// Follows Cycles' SVM: coordinates times Scale, then distortion, then the fractal of the chosen type (noise/fractal-inl.h).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/texture/tex_noise.cpp"
#include "hwy/foreach_target.h"

#include "nodes/math/finite-inl.h"
#include "nodes/noise/fractal-inl.h"
#include "nodes/texture/texture_mapping-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

namespace tex_noise {
// Parameters, and the channels of the dynamic ones.
enum Parameter { kMapping, kDimensions, kType, kVector, kW, kScale, kDetail, kRoughness, kLacunarity, kOffset, kGain, kDistortion, kNormalize };
// The last five are used where noise fades: Vector and W at the next pixels in x and y, and 1.
enum Channel { kVectorIn = 0, kWIn = 3, kScaleIn, kDetailIn, kRoughnessIn, kLacunarityIn, kOffsetIn, kGainIn, kDistortionIn, kNormalizeIn,
               kVectorXIn, kVectorYIn = kVectorXIn + 3, kWXIn = kVectorYIn + 3, kWYIn, kFadesIn };
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

namespace tex_noise {
template <int D, class F>
HWY_INLINE Coord<D, F> position(const Lanes<F>& k, int vector, int w) {
    Coord<D, F> p;
    if constexpr (D > 1) {
        const Vec3<F> v = mapped_vector(k, vector);
        ALDER_UNROLL
        for (int i = 0; i < (D < 3 ? D : 3); ++i) p.c[i] = v[i];
    }
    if constexpr (D == 1 || D == 4) p.c[D - 1] = k.f(w);
    return p * k.f(kScaleIn);
}
template <int D, class F>
HWY_INLINE F distance(const Coord<D, F>& a, const Coord<D, F>& b) {
    F sum(0);
    ALDER_UNROLL
    for (int i = 0; i < D; ++i) sum = mad(b.c[i] - a.c[i], b.c[i] - a.c[i], sum);
    return sqrt(sum);
}
/// The amplitudes of all octaves together.
template <class F>
HWY_NOINLINE F total_amplitude(F detail, F roughness) {
    F sum(0), amplitude(1);
    for (int i = 0; i <= 16; ++i) {
        const F part = saturate(detail + F(static_cast<float>(1 - i)));
        if (!any(part > F(0))) break;
        sum = mad(part, amplitude, sum);
        amplitude = amplitude * roughness;
    }
    return sum;
}

/// What is left of the fractal in a pixel: Detail ends with the last octave that it can hold (a cell a pixel; the fraction of Detail
/// fades), and the first octave goes the same way. What is left of an fBM then keeps its size, for the others fade to a mean of 0; the
/// multifractals' octaves act on each other, so there only Detail ends.
template <class F>
struct Fade {
    F detail, scale;
    HWY_INLINE Fade(F cells, const FractalParams<F>& q) {
        const Mask<F> some = cells > F(0), rising = abs(q.lacunarity) > F(1);
        const F left = F(0) - log2(select(some, cells, F(1)));
        const F octaves = left / log2(select(rising, abs(q.lacunarity), F(2)));
        detail = select(some & rising, min(q.detail, max(octaves, F(0))), q.detail);
        scale = select(some, saturate(left + F(1)), F(1));
        if (q.normalize) scale = scale * (total_amplitude(detail, q.roughness) / total_amplitude(q.detail, q.roughness));
    }
};
}  // namespace tex_noise

template <int D, FractalType kType>
struct TexNoise {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        using namespace tex_noise;
        constexpr const RandomOffsets<D>& offsets = kOffsets<D>;
        Coord<D, F> p = position<D>(k, kVectorIn, kWIn);

        FractalParams<F> q;
        q.detail = clamp_nan_to_low(k.f(kDetailIn), F(0), F(15));
        q.roughness = max(F(0), k.f(kRoughnessIn));
        q.lacunarity = k.f(kLacunarityIn);
        q.offset = k.f(kOffsetIn);
        q.gain = k.f(kGainIn);
        q.normalize = k.statics().e(kNormalize) != 0;

        F left(1);
        const bool fades = k.call.in[kFadesIn].p[0] != 0;
        if (fades) {
            const Fade<F> fade(max(distance<D>(p, position<D>(k, kVectorXIn, kWXIn)), distance<D>(p, position<D>(k, kVectorYIn, kWYIn))), q);
            q.detail = fade.detail;
            left = fade.scale;
        }

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
            F value = fractal<kType>(component == 0 ? p : offsets.moved(p, D - 1 + component), q);
            if (kType == kFbm && fades) value = q.normalize ? mad(left, value - F(0.5f), F(0.5f)) : left * value;
            value = finite_or_limit(value);   // roughness and lacunarity have no upper limit
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
#include "graph/lowering.h"

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

/// Where noise fades: Vector and W are evaluated at the next pixels as well, through whatever graph they come from.
static void lower_tex_noise(Lowering& l, int output) {
    using namespace HWY_NAMESPACE::tex_noise;
    if (!l.fades_noise()) return;
    const ValueRef one = l.constant(Type::Float, 1);
    const NodeType& type = *l.statics().type;
    std::vector<ValueRef> params, globals;
    for (int i = 0; i < static_cast<int>(type.params.size()); ++i) {
        const Type t = type.params[i].type;
        if (channels(t) > 0) params.push_back(tex_noise_uses(l.statics(), i) ? l.input(i) : l.constant(t, 0));
    }
    for (const int p : {kVector, kW})
        for (const int direction : {1, 2})
            globals.push_back(tex_noise_uses(l.statics(), p) ? l.displaced_input(p, direction, one) : l.constant(type.params[p].type, 0));
    globals.push_back(one);
    l.result(l.call(params, globals, output));
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
    n.globals = {Global::Dpdx, Global::Dpdy, Global::PixelFootprint, Global::FootprintArea, Global::RayLength};
    n.uses_global = [](const Statics&, int) { return false; };  // in their place come the fade's values
    n.lower = lower_tex_noise;
    n.uses = tex_noise_uses;
    n.prepare = prepare_texture_mapping;
    return n;
}
}  // namespace alder
#endif
