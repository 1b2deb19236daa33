// alFractal: a sum of gradient noise over octaves, optionally distorted or turbulent. alshaders specification, section 4.
// Ken Perlin, "An Image Synthesizer", SIGGRAPH 1985; the noise itself is ours, Arnold's is not public.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/noise/al_fractal.cpp"
#include "hwy/foreach_target.h"

#include "nodes/math/remap-inl.h"
#include "nodes/math/remap_params.h"
#include "nodes/noise/al_fractal-inl.h"
#include "nodes/noise/arnold_basis-inl.h"

#ifndef ALDER_NODES_NOISE_AL_FRACTAL_
#define ALDER_NODES_NOISE_AL_FRACTAL_
namespace alder {
enum AlFractalParam { kMode, kSpace, kFrequency, kScale, kTime, kOctaves, kDistortion, kLacunarity, kGain, kTurbulent, kRemap, kColor1 = kRemap + 12, kColor2, kP };
constexpr int kMaxOctaves = 64;
}  // namespace alder
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Channels: frequency 0, scale 1, time 4, octaves 5, distortion 6, lacunarity 7, gain 8, turbulent 9, remap 10, colours 22, 25, P 28,
/// where noise fades P at the next pixels 31, 34, and 1 in 37.
struct AlFractal {
    template <class V, class F>
    static HWY_INLINE V sum(Lanes<F> k) {
        const bool fades = k.call.in[37].p[0] != 0;
        const Vec3<F> p = k.v(28) * k.f(0) * k.v(1);
        F reach(0);
        if (fades) reach = max(length(k.v(31) * k.f(0) * k.v(1) - p), length(k.v(34) * k.f(0) * k.v(1) - p));
        const AlFractalParams<F> f = {k.f(4), k.f(6), k.f(7), k.f(8), min(k.statics().e(kOctaves), kMaxOctaves), k.statics().e(kTurbulent) != 0, fades, reach};
        return al_fractal_sum<V>(ArnoldBasis(), p, f);
    }
};
struct AlFractalScalar {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, lerp(k.v(22), k.v(25), al_remap(k, 10, AlFractal::sum<F>(k)))); }
};
struct AlFractalVector {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> n = AlFractal::sum<Vec3<F>>(k);
        for (int i = 0; i < 3; ++i) k.set(i, al_remap(k, 10, n[i]));
    }
};
template <class F>
void al_fractal(const Call<F>& c) {
    if (c.statics().e(kMode) == 1) return c.template each<AlFractalVector>();
    c.template each<AlFractalScalar>();
}
ALDER_KERNEL(al_fractal)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "nodes/noise/pattern_point.h"

namespace alder {
ALDER_KERNEL_EXPORT(al_fractal)

static bool fractal_uses(const Statics& s, int param) {
    if (param == kColor1 || param == kColor2) return s.e(kMode) == 0;
    return pattern_point_uses(s, param, kSpace, kP);
}
static void lower_fractal(Lowering& l, int) { lower_at_pattern_point(l, kSpace, kP, true); }

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alFractal";
    n.system = System::AlShaders;
    n.category = "pattern";
    n.summary = "fractal sum of gradient noise";
    n.help = "The sum is not divided by the amplitudes; at most 64 octaves. Vector mode writes three remapped noises and leaves the colours out. "
             "The noise is ours: Arnold's is not public. Single against double precision, unclamped, median (99 % of points): "
             "3e-6 (2e-5) near the origin, 0.001 (0.006) at 1e4, 0.05 (0.2) at 1e6, 0.09 (0.4) at frequency 1e5: the fine octaves' points are rounded.";
    n.params = {choice("mode", {"scalar", "vector"}, "scalar").doc("one noise between the colours, or three noises as red, green and blue"),
                pattern_space_param("world"),
                f("frequency", 1).range(0, 10).doc("multiplies the point"),
                vector("scale", 1, 1, 1).doc("multiplies the point by component"),
                f("time", 0).range(0, 10).doc("fourth coordinate of the noise"),
                i("octaves", 8).range(1, 16).no_link().doc("number of noises summed"),
                f("distortion", 0).range(0, 2).doc("moves each octave's point by this much of a vector noise"),
                f("lacunarity", 2.121).range(1, 4).doc("frequency from one octave to the next"),
                f("gain", 0.5).range(0, 1).doc("amplitude from one octave to the next"),
                b("turbulent", false).no_link().doc("sums absolute values")};
    add_remap_params(n.params);
    n.params.push_back(color("color1", 0, 0, 0).doc("colour at 0 after the remap"));
    n.params.push_back(color("color2", 1, 1, 1).doc("colour at 1"));
    n.params.push_back(pattern_point_param());
    n.outputs = {{"out", Type::Color}};
    n.kernel = al_fractal_kernel();
    n.globals = {Global::Dpdx, Global::Dpdy, Global::PixelFootprint};
    n.uses_global = [](const Statics&, int) { return false; };  // in their place come the filter's values
    n.cost_ns = 60;
    n.uses = fractal_uses;
    n.lower = lower_fractal;
    return n;
}
}  // namespace alder
#endif
