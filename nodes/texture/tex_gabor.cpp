// Gabor Texture: noise of one chosen frequency and direction, with its phase and intensity. Follows Cycles' SVM.
// Lagae et al., "Procedural Noise using Sparse Gabor Convolution", SIGGRAPH 2009 (kernel: eq. 6); Tavernier et al., "Making Gabor
// Noise Fast and Normalized", Eurographics 2019 (a fixed number of impulses a cell, weights of +-1); Tricard et al., "Procedural
// Phasor Noise", SIGGRAPH 2019 (phase and intensity of the complex sum: eq. 8 and 9).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/texture/tex_gabor.cpp"
#include "hwy/foreach_target.h"

#include "nodes/math/cycles-inl.h"
#include "nodes/noise/hash-inl.h"
#include "nodes/texture/texture_mapping-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

namespace tex_gabor {
enum Parameter { kMapping, kType, kVector, kScale, kFrequency, kAnisotropy, kOrientation2, kOrientation3 };
enum Channel { kVectorIn = 0, kScaleIn = 3, kFrequencyIn, kAnisotropyIn, kOrientation2In, kOrientation3In };
enum Out { kValueOut, kPhaseOut, kIntensityOut };
constexpr float kPi = 3.141592653589793f, kTwoPi = 6.283185307179586f;
constexpr int kImpulses = 8;  ///< a cell
/// Six standard deviations of the sum, sqrt(impulses · E[weight²] · ∫kernel²), E[weight²] = 1/2, ∫kernel² at high frequency
/// 1/4 in two and 1/(4 sqrt 2) in three dimensions.
constexpr float kNorm2 = 6.0f, kNorm3 = 5.0453785f;

/// The complex sum of kernels: real (cosine) and imaginary (sine) part.
template <class F>
struct Phasor {
    F re, im;
};

/// One impulse: its envelope, a Gaussian under a Hann window that ends at distance 1, at the angle of the wave.
template <class F>
HWY_INLINE void add_impulse(Phasor<F>& sum, Mask<F> near, F weight, F distance_squared, F angle) {
    const F hann = F(0.5) + F(0.5) * cos(F(kPi) * distance_squared);
    const F envelope = exp(F(-kPi) * distance_squared) * hann;
    sum.re = select(near, sum.re + weight * (envelope * cos(angle)), sum.re);
    sum.im = select(near, sum.im + weight * (envelope * sin(angle)), sum.im);
}

template <class F>
HWY_INLINE F random_sign(Int<F> hash) {
    return select(uint_to_unit<F>(hash) < F(0.5), F(-1), F(1));
}

/// Sum over one cell. Hashes are of the bits of the cell's whole coordinates and a running number.
template <class F>
HWY_INLINE void add_cell_2d(Phasor<F>& total, F cell_x, F cell_y, F px, F py, F frequency, F isotropy, F orientation) {
    Phasor<F> sum{F(0), F(0)};
    const Int<F> hx = float_bits(cell_x), hy = float_bits(cell_y);
    for (int i = 0; i < kImpulses; ++i) {
        const Int<F> at_orientation = float_bits(F(3 * i)), at_center = float_bits(F(3 * i + 1)), at_weight = float_bits(F(3 * i + 2));
        const F x = px - uint_to_unit<F>(hash_uint3(hx, hy, at_center)), y = py - uint_to_unit<F>(hash_uint3(at_center, hx, hy));
        const F distance_squared = x * x + y * y;
        const Mask<F> near = !(distance_squared >= F(1));
        if (!any(near)) continue;
        F turn = orientation;
        if (any(isotropy != F(0))) turn = orientation + (uint_to_unit<F>(hash_uint3(hx, hy, at_orientation)) - F(0.5)) * F(kPi) * isotropy;
        const F wx = frequency * cos(turn), wy = frequency * sin(turn);
        add_impulse(sum, near, random_sign<F>(hash_uint3(hx, hy, at_weight)), distance_squared, F(kTwoPi) * (x * wx + y * wy));
    }
    total.re = total.re + sum.re;
    total.im = total.im + sum.im;
}

/// A direction in three dimensions, and its angles where some lane turns it.
template <class F>
struct Orientation3 {
    Vec3<F> direction;
    F isotropy, inclination, azimuth;
    Mask<F> turns;
    HWY_INLINE Orientation3() {}

    HWY_INLINE Vec3<F> turned(Int<F> hx, Int<F> hy, Int<F> hz, Int<F> number) const {
        if (!any(turns)) return direction;
        const F a = inclination + uint_to_unit<F>(hash_uint4(hx, hy, hz, number)) * F(kPi) * isotropy;
        const F b = azimuth + uint_to_unit<F>(hash_uint4(hz, hx, number, hy)) * F(kPi) * isotropy;
        const F s = sin(a);
        return select<F>(turns, Vec3<F>(s * cos(b), s * sin(b), cos(a)), direction);
    }
};

template <class F>
HWY_INLINE void add_cell_3d(Phasor<F>& total, Vec3<F> cell, Vec3<F> p, F frequency, const Orientation3<F>& orientation) {
    Phasor<F> sum{F(0), F(0)};
    const Int<F> hx = float_bits(cell.x), hy = float_bits(cell.y), hz = float_bits(cell.z);
    for (int i = 0; i < kImpulses; ++i) {
        const Int<F> at_orientation = float_bits(F(3 * i)), at_center = float_bits(F(3 * i + 1)), at_weight = float_bits(F(3 * i + 2));
        const Vec3<F> center(uint_to_unit<F>(hash_uint4(hx, hy, hz, at_center)), uint_to_unit<F>(hash_uint4(hz, hx, at_center, hy)),
                             uint_to_unit<F>(hash_uint4(at_center, hz, hy, hx)));
        const Vec3<F> d = p - center;
        const F distance_squared = dot(d, d);
        const Mask<F> near = !(distance_squared >= F(1));
        if (!any(near)) continue;
        const Vec3<F> wave = frequency * orientation.turned(hx, hy, hz, at_orientation);
        add_impulse(sum, near, random_sign<F>(hash_uint4(hx, hy, hz, at_weight)), distance_squared, F(kTwoPi) * dot(d, wave));
    }
    total.re = total.re + sum.re;
    total.im = total.im + sum.im;
}
}  // namespace tex_gabor

template <bool kThree>
struct TexGabor {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        using namespace tex_gabor;
        const Vec3<F> p = mapped_vector(k, kVectorIn) * k.f(kScaleIn);
        const F isotropy = F(1) - clamp(k.f(kAnisotropyIn), F(0), F(1));
        const F frequency = second_max(F(0.001f), k.f(kFrequencyIn));
        Phasor<F> sum{F(0), F(0)};
        const F cx = floor(p.x), cy = floor(p.y), lx = p.x - cx, ly = p.y - cy;
        if constexpr (kThree) {
            const F cz = floor(p.z), lz = p.z - cz;
            Orientation3<F> o;
            o.direction = normalize(k.v(kOrientation3In));
            o.isotropy = isotropy;
            o.turns = isotropy != F(0);
            o.inclination = o.azimuth = F(0);
            if (any(o.turns)) {
                const Vec3<F> d = o.direction;
                o.inclination = acos(d.z);
                o.azimuth = select(d.y < F(0), F(-1), F(1)) * acos(d.x / sqrt(d.x * d.x + d.y * d.y));
            }
            for (int n = 0; n < 27; ++n) {
                const F i(n % 3 - 1), j(n / 3 % 3 - 1), l(n / 9 - 1);
                add_cell_3d(sum, Vec3<F>(cx + i, cy + j, cz + l), Vec3<F>(lx - i, ly - j, lz - l), frequency, o);
            }
        } else {
            const F orientation = k.f(kOrientation2In);
            for (int n = 0; n < 9; ++n) {
                const F i(n % 3 - 1), j(n / 3 - 1);
                add_cell_2d(sum, cx + i, cy + j, lx - i, ly - j, frequency, isotropy, orientation);
            }
        }
        const F norm(kThree ? kNorm3 : kNorm2);
        k.set(kValueOut, sum.im / norm * F(0.5) + F(0.5));
        if (k.wants(kPhaseOut)) k.set(kPhaseOut, (atan2(sum.im, sum.re) + F(kPi)) / F(kTwoPi));
        k.set(kIntensityOut, sqrt(sum.re * sum.re + sum.im * sum.im) / norm);
    }
};
template <class F>
void tex_gabor_kernel(const Call<F>& c) {
    if (c.statics().e(tex_gabor::kType) == 0) c.template each<TexGabor<false>>();
    else c.template each<TexGabor<true>>();
}
ALDER_KERNEL(tex_gabor_kernel)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(tex_gabor_kernel)

ALDER_NODE {
    using namespace param;
    namespace p = HWY_NAMESPACE::tex_gabor;
    NodeType n;
    n.name = "ShaderNodeTexGabor";
    n.aliases = {"gabor_texture"};
    n.system = System::Cycles;
    n.category = "texture";
    n.summary = "noise of one frequency and direction, with phase and intensity";
    n.help = "Wave packets at random places. Anisotropy 1 aligns all of them with the orientation, 0 turns each at random. Value is the wave, "
             "Phase its position within a period, Intensity its amplitude.";
    n.params = {
        texture_mapping_param(),
        choice("gabor_type", {{"2D", "2D", "2D"}, {"3D", "3D", "3D"}}, "2D").alias("type").doc("whether z matters"),
        vector("Vector", 0, 0, 0).unlinked(Global::Generated).doc("where the noise is read; unlinked: generated coordinates"),
        f("Scale", 5).range(-1000, 1000).doc("cells per unit"),
        f("Frequency", 2).range(0, 10).doc("waves per cell; at least 0.001"),
        f("Anisotropy", 1).range(0, 1).doc("1: all waves have the orientation, 0: each its own"),
        f("Orientation 2D", 0.785398185).range(-3.2, 3.2).doc("direction of the waves, radians"),
        vector("Orientation 3D", 1.41421354, 1.41421354, 0).doc("direction of the waves"),
        color_mapping_param(),
    };
    n.outputs = {{"Value", Type::Float}, {"Phase", Type::Float}, {"Intensity", Type::Float}};
    n.kernel = tex_gabor_kernel_kernel();
    n.cost_ns = 2000;
    n.uses = [](const Statics& s, int param) {
        if (param == p::kOrientation2) return s.e(p::kType) == 0;
        if (param == p::kOrientation3) return s.e(p::kType) == 1;
        return true;
    };
    n.prepare = prepare_texture_mapping;
    return n;
}
}  // namespace alder
#endif
