// alRemapColor: gamma, saturation, hue, contrast, exposure and gain of a colour; blended with the input by a mask.
// alshaders specification, section 2.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/math/al_remap_color.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/math/al_color-inl.h"
#include "nodes/math/remap-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct AlRemapColor {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> input = k.v(0);
        const F gamma = k.f(3), saturation = k.f(4), hue = k.f(5), contrast = k.f(6), pivot = k.f(7), mask = k.f(10);
        Vec3<F> c = input;
        const Mask<F> has_gamma = gamma != F(1), has_saturation = saturation != F(1), has_hue = hue != F(0);
        if (any(has_gamma)) c = select(has_gamma, al_powc(c, F(1) / gamma), c);
        if (any(has_saturation)) c = select(has_saturation, al_saturate(c, saturation), c);
        if (any(has_hue)) c = select(has_hue, al_turn_hue(c, hue), c);
        c = {al_contrast(c.x, contrast, pivot), al_contrast(c.y, contrast, pivot), al_contrast(c.z, contrast, pivot)};
        c = c * exp2(k.f(9)) * k.f(8);
        c = select(mask < F(1), lerp(input, c, mask), c);
        k.set(0, select(mask <= F(0), input, c));
    }
};
template <class F>
void al_remap_color(const Call<F>& c) { c.template each<AlRemapColor>(); }
ALDER_KERNEL(al_remap_color)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(al_remap_color)

/// The correction matters only where the mask is positive.
static std::vector<LazyRule> masked(const Statics&) {
    std::vector<LazyRule> rules;
    for (int param = 1; param <= 7; ++param) rules.push_back({param, 8, LazyRule::NeededIfPositive});
    return rules;
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alRemapColor";
    n.system = System::AlShaders;
    n.category = "math";
    n.summary = "colour correction chain";
    n.help = "In this order: gamma, saturation, hue, contrast, exposure and gain. Gamma turns negative channels into 0; nothing else clamps.";
    n.params.push_back(color("input", 0.18, 0.18, 0.18).doc("colour to correct"));
    n.params.push_back(f("gamma", 1).range(0.1, 5).doc("exponent 1/gamma on each channel; 1 leaves the colour, negative channels too"));
    n.params.push_back(f("saturation", 1).range(0, 2).doc("0 is grey of the same luminance; above 1 exaggerates"));
    n.params.push_back(f("hueOffset", 0).range(-1, 1).doc("turn of the hue; 1 is a whole turn"));
    n.params.push_back(f("contrast", 1).range(0, 2).in("Contrast").doc("slope about the pivot"));
    n.params.push_back(f("contrastPivot", 0.18).range(0, 1).in("Contrast").doc("value that contrast leaves unchanged"));
    n.params.push_back(f("gain", 1).range(0, 2).doc("multiplies the result"));
    n.params.push_back(f("exposure", 0).range(-5, 5).doc("multiplies the result by 2^exposure"));
    n.params.push_back(f("mask", 1).range(0, 1).doc("0 and below leaves the input, 1 and above is the full correction"));
    n.outputs = {{"out", Type::Color}};
    n.kernel = al_remap_color_kernel();
    n.cost_ns = 5;
    n.lazy = masked;
    return n;
}
}  // namespace alder
#endif
