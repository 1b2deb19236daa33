// alGaborNoise: waves of random place and direction under Gaussian envelopes, with control over frequency and direction.
// alshaders specification, section 4; Lagae et al., "Procedural Noise using Sparse Gabor Convolution", SIGGRAPH 2009.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/noise/al_gabor_noise.cpp"
#include "hwy/foreach_target.h"

#include "nodes/math/remap-inl.h"
#include "nodes/math/remap_params.h"
#include "nodes/noise/gabor_noise-inl.h"

#ifndef ALDER_NODES_NOISE_AL_GABOR_NOISE_
#define ALDER_NODES_NOISE_AL_GABOR_NOISE_
namespace alder {
enum AlGaborNoiseParam { kSpace, kFrequency, kAnisotropy, kDirection, kFilter, kBandwidth, kImpulses, kTurbulent, kRemap, kColor1 = kRemap + 12, kColor2, kP };
}  // namespace alder
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Channels: frequency 0, direction 1, filter 4, bandwidth 5, impulses 6, turbulent 7, remap 8, colours 20, 23, P 26.
struct AlGaborNoise {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const GaborParams<F> g(k.v(1), k.f(5), k.f(6));
        F n = gabor_noise<false>(k.v(26) * k.f(0), g, k.statics().e(kAnisotropy));
        if (k.statics().e(kTurbulent)) n = abs(n);
        k.set(0, lerp(k.v(20), k.v(23), al_remap(k, 8, n)));
    }
};
template <class F>
void al_gabor_noise(const Call<F>& c) { c.template each<AlGaborNoise>(); }
ALDER_KERNEL(al_gabor_noise)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "nodes/noise/pattern_point.h"

namespace alder {
ALDER_KERNEL_EXPORT(al_gabor_noise)

static bool gabor_noise_uses(const Statics& s, int param) {
    if (param == kDirection) return s.e(kAnisotropy) != 0;
    return param != kFilter && pattern_point_uses(s, param, kSpace, kP);
}
static void lower_gabor_noise(Lowering& l, int) { lower_at_pattern_point(l, kSpace, kP); }

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alGaborNoise";
    n.system = System::AlShaders;
    n.category = "pattern";
    n.summary = "noise of waves with a chosen frequency and direction";
    n.help = "Sparse Gabor convolution: 1 to 32 waves within the reach of an envelope, the mean of which is `impulses`. The noise is the original's own, "
             "number for number, save two defects: it read the bits of `impulses` as an integer, so that any value above 0 acted as 32 "
             "(set 32 for the look of old scenes), and the cosine of its random directions was never negative, so that isotropic and "
             "hybrid waves all pointed to one side. Both are mended. `filter` has no effect, as in the original. Single against double precision, unclamped, median (99 % of points): "
             "2e-6 (1e-5) near the origin, 0.001 (0.007) at 1e4, 0.09 (0.5) at 1e6, 0.1 (0.6) at frequency 1e5: the point over the radius is rounded.";
    n.params = {pattern_space_param("world"),
                f("frequency", 1).range(0, 10).doc("multiplies the point"),
                choice("anisotropy", {"isotropic", "anisotropic", "hybrid"}, "isotropic")
                    .doc("waves of length 1 in all directions; all along anisotropyDirection; all directions of the plane z = 0, as long as anisotropyDirection"),
                vector("anisotropyDirection", 0, 1, 0).doc("frequency vector of the waves: direction, and waves a unit as its length"),
                b("filter", false).no_link().doc("has no effect"),
                f("bandwidth", 1).range(0.01, 4).doc("width of the frequency band in octaves: wide means narrow envelopes; limited to 0.01 ... 100"),
                f("impulses", 8).range(1, 32).no_link().doc("mean number of waves within reach of a point; limited to 1 ... 32"),
                b("turbulent", false).no_link().doc("absolute value")};
    add_remap_params(n.params);
    n.params.push_back(color("color1", 0, 0, 0).doc("colour at 0 after the remap"));
    n.params.push_back(color("color2", 1, 1, 1).doc("colour at 1"));
    n.params.push_back(pattern_point_param());
    n.outputs = {{"out", Type::Color}};
    n.kernel = al_gabor_noise_kernel();
    n.cost_ns = 1500;
    n.uses = gabor_noise_uses;
    n.lower = lower_gabor_noise;
    return n;
}
}  // namespace alder
#endif
