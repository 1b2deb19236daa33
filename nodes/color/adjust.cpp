// Hue/Saturation/Value, Brightness/Contrast, Gamma, Invert Color and RGB to BW: corrections of one colour (Blender's nodes).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/color/adjust.cpp"
#include "hwy/foreach_target.h"

#include "nodes/color/color-inl.h"
#include "nodes/kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// The blend with the input comes first, negative values are removed afterwards.
struct HueSaturation {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F hue = k.f(0), saturation = k.f(1), value = k.f(2), fac = k.f(3);
        const Vec3<F> input = k.v(4), hsv = rgb_to_hsv(input);
        const Vec3<F> c = hsv_to_rgb(Vec3<F>(fract(hsv.x + hue + F(0.5)), cycles_saturate(hsv.y * saturation), hsv.z * value));
        for (int i = 0; i < 3; ++i) k.set(i, second_max(fac * c[i] + (F(1) - fac) * input[i], F(0)));
    }
};
struct BrightContrast {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F bright = k.f(3), contrast = k.f(4);
        const F scale = F(1) + contrast, offset = bright - contrast * F(0.5);
        for (int i = 0; i < 3; ++i) k.set(i, second_max(scale * k.f(i) + offset, F(0)));
    }
};
/// Components at or below 0 stay as they are; gamma 0 gives white.
struct Gamma {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F gamma = k.f(3);
        for (int i = 0; i < 3; ++i) {
            const F c = k.f(i);
            k.set(i, select(gamma == F(0), F(1), select(c > F(0), pow(c, gamma), c)));
        }
    }
};
struct Invert {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F fac = k.f(0);
        for (int i = 0; i < 3; ++i) k.set(i, fac * (F(1) - k.f(1 + i)) + (F(1) - fac) * k.f(1 + i));
    }
};
struct RgbToBw {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, luminance_cycles(k.v(0))); }
};
template <class F>
void hue_saturation(const Call<F>& c) { c.template each<HueSaturation>(); }
template <class F>
void bright_contrast(const Call<F>& c) { c.template each<BrightContrast>(); }
template <class F>
void gamma_node(const Call<F>& c) { c.template each<Gamma>(); }
template <class F>
void invert(const Call<F>& c) { c.template each<Invert>(); }
template <class F>
void rgb_to_bw(const Call<F>& c) { c.template each<RgbToBw>(); }
ALDER_KERNEL(hue_saturation)
ALDER_KERNEL(bright_contrast)
ALDER_KERNEL(gamma_node)
ALDER_KERNEL(invert)
ALDER_KERNEL(rgb_to_bw)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(hue_saturation)
ALDER_KERNEL_EXPORT(bright_contrast)
ALDER_KERNEL_EXPORT(gamma_node)
ALDER_KERNEL_EXPORT(invert)
ALDER_KERNEL_EXPORT(rgb_to_bw)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeHueSaturation";
    n.category = "Color";
    n.summary = "turns the hue and scales saturation and value";
    n.help = "Hue 0.5 leaves the hue. Negative results become 0.";
    n.aliases = {"hsv"};
    n.params.push_back(f("Hue", 0.5).range(0, 1));
    n.params.push_back(f("Saturation", 1).range(0, 2));
    n.params.push_back(f("Value", 1).range(0, 2));
    n.params.push_back(f("Fac", 1).range(0, 1));
    n.params.push_back(color("Color", 0.8, 0.8, 0.8));
    n.outputs = {{"Color", Type::Color}};
    n.kernel = hue_saturation_kernel();
    n.cost_ns = 4;
    return n;
}
ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeBrightContrast";
    n.category = "Color";
    n.summary = "adds brightness and stretches about middle grey";
    n.help = "Negative results become 0.";
    n.aliases = {"brightness_contrast"};
    n.params.push_back(color("Color", 1, 1, 1));
    n.params.push_back(f("Bright", 0).range(-100, 100));
    n.params.push_back(f("Contrast", 0).range(-100, 100));
    n.outputs = {{"Color", Type::Color}};
    n.kernel = bright_contrast_kernel();
    return n;
}
ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeGamma";
    n.category = "Color";
    n.summary = "raises each component to a power";
    n.help = "Components at or below 0 stay as they are; gamma 0 gives white.";
    n.aliases = {"gamma"};
    n.params.push_back(color("Color", 1, 1, 1));
    n.params.push_back(f("Gamma", 1).range(0.001, 10));
    n.outputs = {{"Color", Type::Color}};
    n.kernel = gamma_node_kernel();
    n.cost_ns = 10;
    return n;
}
ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeInvert";
    n.category = "Color";
    n.summary = "one minus the colour, blended with the colour by Fac";
    n.aliases = {"invert"};
    n.params.push_back(f("Fac", 1).range(0, 1));
    n.params.push_back(color("Color", 0, 0, 0));
    n.outputs = {{"Color", Type::Color}};
    n.kernel = invert_kernel();
    return n;
}
ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeRGBToBW";
    n.category = "Converter";
    n.summary = "luminance of a colour";
    n.aliases = {"rgb_to_bw"};
    n.params.push_back(color("Color", 0.5, 0.5, 0.5));
    n.outputs = {{"Val", Type::Float}};
    n.kernel = rgb_to_bw_kernel();
    return n;
}
}  // namespace alder
#endif
