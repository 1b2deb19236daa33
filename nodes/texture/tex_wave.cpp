// Wave Texture: bands or rings with a sine, saw or triangle profile, distorted by fractal noise. Follows Cycles' SVM.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/texture/tex_wave.cpp"
#include "hwy/foreach_target.h"

#include "nodes/math/finite-inl.h"
#include "nodes/noise/fractal-inl.h"
#include "nodes/texture/texture_mapping-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

namespace tex_wave {
enum Parameter {
    kMapping, kType, kBandsDirection, kRingsDirection, kProfile,
    kVector, kScale, kDistortion, kDetail, kDetailScale, kDetailRoughness, kPhaseOffset
};
enum Channel { kVectorIn = 0, kScaleIn = 3, kDistortionIn, kDetailIn, kDetailScaleIn, kDetailRoughnessIn, kPhaseOffsetIn };
enum Out { kColorOut, kFacOut = 3 };
enum Profile { kSine, kSaw, kTriangle };
constexpr float kTwoPi = 6.283185307179586f, kHalfPi = 1.570796326794897f;

/// The coordinate that the profile runs along, before phase and distortion.
template <class F>
HWY_INLINE F wave_coordinate(const Statics& s, Vec3<F> p) {
    if (s.e(kType) == 0) {
        const int direction = s.e(kBandsDirection);
        return direction < 3 ? p[direction] * F(20) : (p.x + p.y + p.z) * F(10);
    }
    const int axis = s.e(kRingsDirection);  // rings about an axis, or spherical
    if (axis < 3) p[axis] = p[axis] * F(0);
    return length(p) * F(20);
}

/// The profile at n, to [0, 1].
template <int kProfile, class F>
HWY_INLINE F wave_profile(F n) {
    if constexpr (kProfile == kSine) return F(0.5) + F(0.5) * sin(n - F(kHalfPi));
    const F turns = n / F(kTwoPi);
    if constexpr (kProfile == kSaw) return turns - floor(turns);
    else return abs(turns - floor(turns + F(0.5))) * F(2);
}
}  // namespace tex_wave

template <int kProfile>
struct TexWave {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        using namespace tex_wave;
        const F scale = k.f(kScaleIn);
        const Vec3<F> q = mapped_vector(k, kVectorIn) * scale;
        // Whole coordinates would lie on the edge of a saw.
        const Vec3<F> p = (q + Vec3<F>(F(0.000001f))) * F(0.999999f);
        F n = wave_coordinate(k.statics(), p) + k.f(kPhaseOffsetIn);

        const F distortion = k.f(kDistortionIn);
        const Mask<F> distorted = distortion != F(0);
        if (any(distorted)) {
            FractalParams<F> fractal;
            fractal.detail = k.f(kDetailIn);
            fractal.roughness = k.f(kDetailRoughnessIn);
            fractal.lacunarity = F(2);
            fractal.normalize = true;
            const F detail_scale = k.f(kDetailScaleIn);
            Coord<3, F> c;
            ALDER_UNROLL
            for (int i = 0; i < 3; ++i) c.c[i] = p[i] * detail_scale;
            n = select(distorted, mad(distortion, fbm(c, fractal) * F(2) - F(1), n), n);
        }
        const F value = wave_profile<kProfile>(finite_or_limit(n));
        k.set(kFacOut, value);
        k.set(kColorOut, Vec3<F>(value));
    }
};
template <class F>
void tex_wave_kernel(const Call<F>& c) {
    switch (c.statics().e(tex_wave::kProfile)) {
        case tex_wave::kSine: return c.template each<TexWave<tex_wave::kSine>>();
        case tex_wave::kSaw: return c.template each<TexWave<tex_wave::kSaw>>();
        default: return c.template each<TexWave<tex_wave::kTriangle>>();
    }
}
ALDER_KERNEL(tex_wave_kernel)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(tex_wave_kernel)

ALDER_NODE {
    using namespace param;
    namespace p = HWY_NAMESPACE::tex_wave;
    NodeType n;
    n.name = "ShaderNodeTexWave";
    n.aliases = {"wave_texture"};
    n.system = System::Cycles;
    n.category = "texture";
    n.summary = "bands or rings, distorted by noise";
    n.help = "A sine, saw or triangle wave along an axis, a diagonal or the distance from an axis or point; normalised fBM noise of lacunarity 2 "
             "shifts it by Distortion.";
    n.params = {
        texture_mapping_param(),
        choice("wave_type", {{"BANDS", "Bands", "bands"}, {"RINGS", "Rings", "rings"}}, "BANDS").doc("straight or round waves"),
        choice("bands_direction", {{"X", "X", "x"}, {"Y", "Y", "y"}, {"Z", "Z", "z"}, {"DIAGONAL", "Diagonal", "diagonal"}}, "X")
            .doc("what bands run along"),
        choice("rings_direction", {{"X", "X", "x"}, {"Y", "Y", "y"}, {"Z", "Z", "z"}, {"SPHERICAL", "Spherical", "spherical"}}, "X")
            .doc("the axis that rings surround"),
        choice("wave_profile", {{"SIN", "Sine", "sine"}, {"SAW", "Saw", "saw"}, {"TRI", "Triangle", "tri"}}, "SIN")
            .alias("profile").doc("shape of one wave"),
        vector("Vector", 0, 0, 0).unlinked(Global::Generated).doc("where the waves are read; unlinked: generated coordinates"),
        f("Scale", 5).range(-1000, 1000).doc("frequency"),
        f("Distortion", 0).range(-1000, 1000).doc("how far noise shifts the waves"),
        f("Detail", 2).range(0, 15).doc("octaves of the noise beyond the first"),
        f("Detail Scale", 1).range(-1000, 1000).doc("frequency of the noise relative to the waves"),
        f("Detail Roughness", 0.5).range(0, 1).doc("strength of an octave relative to the one before"),
        f("Phase Offset", 0).range(-1000, 1000).doc("shifts the waves, in radians"),
        color_mapping_param(),
    };
    n.outputs = {{"Color", Type::Color}, {"Fac", Type::Float}};
    n.kernel = tex_wave_kernel_kernel();
    n.cost_ns = 25;
    n.uses = [](const Statics& s, int param) {
        if (param == p::kBandsDirection) return s.e(p::kType) == 0;
        if (param == p::kRingsDirection) return s.e(p::kType) == 1;
        return true;
    };
    n.prepare = prepare_texture_mapping;
    return n;
}
}  // namespace alder
#endif
