// alJitterColor: random saturation, hue and gain, one choice for each whole number of a signal. alshaders specification, section 2.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/math/al_jitter_color.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/math/jitter-inl.h"
#include "nodes/noise/cell_hash-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct AlJitterColor {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F signal = k.f(10);
        const F saturation = lerp(k.f(3), k.f(4), cell_noise2(signal, F(51731.132151)));
        const F hue = lerp(k.f(5), k.f(6), cell_noise2(signal, F(173.1231)));
        const F gain = lerp(k.f(7), k.f(8), cell_noise2(signal, F(413.7254)));
        k.set(0, jitter_color(k.v(0), saturation, hue, gain, k.f(9) != F(0)));
    }
};
template <class F>
void al_jitter_color(const Call<F>& c) { c.template each<AlJitterColor>(); }
ALDER_KERNEL(al_jitter_color)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(al_jitter_color)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alJitterColor";
    n.system = System::AlShaders;
    n.category = "color";
    n.summary = "random saturation, hue and gain from a signal";
    n.help = "All signals in [k, k+1) share one choice. The random numbers are ours: Arnold's are not public.";
    n.params = {color("input", 1, 1, 1).doc("colour to vary"),
                f("minSaturation", 0).range(0, 2).doc("least saturation; 1 leaves the colour"),
                f("maxSaturation", 1).range(0, 2).doc("greatest saturation"),
                f("minHueOffset", -0.1).range(-1, 1).doc("least turn of the hue; 1 is a whole turn"),
                f("maxHueOffset", 0.1).range(-1, 1).doc("greatest turn of the hue"),
                f("minGain", 0.5).range(0, 2).doc("least factor"), f("maxGain", 1.5).range(0, 2).doc("greatest factor"),
                b("clamp", true).doc("limit the result to 0 ... 1"),
                f("signal", 0).range(0, 100).doc("whose whole part picks the variation, e.g. a number for each object or leaf")};
    n.outputs = {{"out", Type::Color}};
    n.kernel = al_jitter_color_kernel();
    n.cost_ns = 8;
    return n;
}
}  // namespace alder
#endif
