// alFlowNoise: simplex noise whose gradients turn with an angle and whose octaves are carried along by the coarser ones.
// alshaders specification, section 4; Perlin and Neyret, "Flow Noise", SIGGRAPH 2001 sketches.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/noise/al_flow_noise.cpp"
#include "hwy/foreach_target.h"

#include "nodes/math/remap-inl.h"
#include "nodes/math/remap_params.h"
#include "nodes/noise/flow_noise-inl.h"

#ifndef ALDER_NODES_NOISE_AL_FLOW_NOISE_
#define ALDER_NODES_NOISE_AL_FLOW_NOISE_
namespace alder {
enum AlFlowNoiseParam { kSpace, kFrequency, kOctaves, kLacunarity, kGain, kAngle, kAdvection, kTurbulent, kRemap, kColor1 = kRemap + 12, kColor2, kP };
constexpr int kMaxOctaves = 64;
}  // namespace alder
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Channels: frequency 0, octaves 1, lacunarity 2, gain 3, angle 4, advection 5, turbulent 6, remap 7, colours 19, 22, P 25.
struct AlFlowNoise {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const FlowNoiseParams<F> f = {k.f(2), k.f(3), k.f(4), k.f(5), min(k.statics().e(kOctaves), kMaxOctaves), k.statics().e(kTurbulent) != 0};
        const F n = flow_noise_sum<false>(k.v(25) * k.f(0), f);
        k.set(0, lerp(k.v(19), k.v(22), al_remap(k, 7, n)));
    }
};
template <class F>
void al_flow_noise(const Call<F>& c) { c.template each<AlFlowNoise>(); }
ALDER_KERNEL(al_flow_noise)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "nodes/noise/pattern_point.h"

namespace alder {
ALDER_KERNEL_EXPORT(al_flow_noise)

static bool flow_noise_uses(const Statics& s, int param) {
    if (param == kLacunarity || param == kGain || param == kAdvection) return s.e(kOctaves) > 1;
    return pattern_point_uses(s, param, kSpace, kP);
}
static void lower_flow_noise(Lowering& l, int) { lower_at_pattern_point(l, kSpace, kP); }

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alFlowNoise";
    n.system = System::AlShaders;
    n.category = "pattern";
    n.summary = "simplex noise with rotating gradients and advection";
    n.help = "The sum is not divided by the amplitudes; at most 64 octaves. The noise is the original's own, number for number, save one defect: "
             "it wrapped negative lattice coordinates by 255 in place of 256, which left a seam at 0 and shifted the pattern on the negative side; "
             "here the pattern goes through. Its floor of exact whole numbers, one too low from 0 down, is kept (no visible effect). "
             "Coordinates beyond 5e8 (times frequency and lacunarity) count as 5e8. Single against double precision, unclamped, median (99 % of points): "
             "6e-6 (4e-5) near the origin, 0.002 (0.009) at 1e4, 0.1 (0.5) at 1e6, 0.2 (0.9) at frequency 1e5: the fine octaves' points are rounded.";
    n.params = {pattern_space_param("UV"),
                f("frequency", 1).range(0, 10).doc("multiplies the point"),
                i("octaves", 4).range(1, 16).no_link().doc("number of noises summed"),
                f("lacunarity", 2.172).range(1, 4).doc("frequency from one octave to the next"),
                f("gain", 0.5).range(0, 1).doc("amplitude from one octave to the next"),
                f("angle", 0).range(0, 6.28318531).doc("turn of the gradients in radians; animate it for flow"),
                f("advection", 0.25).range(0, 1).doc("how far coarse octaves carry finer ones along"),
                b("turbulent", false).no_link().doc("sums absolute values")};
    add_remap_params(n.params);
    n.params.push_back(color("color1", 0, 0, 0).doc("colour at 0 after the remap"));
    n.params.push_back(color("color2", 1, 1, 1).doc("colour at 1"));
    n.params.push_back(pattern_point_param());
    n.outputs = {{"out", Type::Color}};
    n.kernel = al_flow_noise_kernel();
    n.cost_ns = 60;
    n.uses = flow_noise_uses;
    n.lower = lower_flow_noise;
    return n;
}
}  // namespace alder
#endif
