// Separate Color, Combine Color and their older forms: a colour as RGB, HSV or HSL numbers and back (Blender's nodes).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/color/separate_color.cpp"
#include "hwy/foreach_target.h"

#include "nodes/color/color-inl.h"
#include "nodes/kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

// Every node here has three channels in and three out.
#define ALDER_COLOR_MAP(Name, function)                                       \
    struct Name {                                                             \
        template <class F>                                                    \
        static HWY_INLINE void run(Lanes<F> k) { k.set(0, function(k.v(0))); } \
    };
ALDER_COLOR_MAP(ColorCopy, )
ALDER_COLOR_MAP(ColorToHsv, rgb_to_hsv)
ALDER_COLOR_MAP(ColorFromHsv, hsv_to_rgb)
ALDER_COLOR_MAP(ColorToHsl, rgb_to_hsl)
ALDER_COLOR_MAP(ColorFromHsl, hsl_to_rgb)
#undef ALDER_COLOR_MAP

// The mode is the last parameter: after one colour (Separate) or after three numbers (Combine).
template <class F>
void separate_color(const Call<F>& c) {
    switch (c.statics().e(1)) {
        case 0: return c.template each<ColorCopy>();
        case 1: return c.template each<ColorToHsv>();
        default: return c.template each<ColorToHsl>();
    }
}
template <class F>
void combine_color(const Call<F>& c) {
    switch (c.statics().e(3)) {
        case 0: return c.template each<ColorCopy>();
        case 1: return c.template each<ColorFromHsv>();
        default: return c.template each<ColorFromHsl>();
    }
}
template <class F>
void copy_color(const Call<F>& c) { c.template each<ColorCopy>(); }
template <class F>
void separate_hsv(const Call<F>& c) { c.template each<ColorToHsv>(); }
template <class F>
void combine_hsv(const Call<F>& c) { c.template each<ColorFromHsv>(); }
ALDER_KERNEL(separate_color)
ALDER_KERNEL(combine_color)
ALDER_KERNEL(copy_color)
ALDER_KERNEL(separate_hsv)
ALDER_KERNEL(combine_hsv)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(separate_color)
ALDER_KERNEL_EXPORT(combine_color)
ALDER_KERNEL_EXPORT(copy_color)
ALDER_KERNEL_EXPORT(separate_hsv)
ALDER_KERNEL_EXPORT(combine_hsv)

static Param color_mode() {
    return param::choice("mode", std::vector<Item>{{"RGB", "RGB", "rgb"}, {"HSV", "HSV", "hsv"}, {"HSL", "HSL", "hsl"}}, "RGB").alias("color_type");
}
static NodeType separate(const char* name, const char* cycles, const char* input, std::array<const char*, 3> outputs, const char* summary, Kernel kernel) {
    NodeType n;
    n.name = name;
    n.category = "Converter";
    n.summary = summary;
    n.aliases = {cycles};
    n.params.push_back(param::color(input, 0.8, 0.8, 0.8));
    for (const char* o : outputs) n.outputs.push_back({o, Type::Float});
    n.kernel = kernel;
    n.cost_ns = 2;
    return n;
}
static NodeType combine(const char* name, const char* cycles, std::array<const char*, 3> inputs, const char* output, const char* summary, Kernel kernel) {
    NodeType n;
    n.name = name;
    n.category = "Converter";
    n.summary = summary;
    n.aliases = {cycles};
    for (const char* i : inputs) n.params.push_back(param::f(i, 0).range(0, 1));
    n.outputs = {{output, Type::Color}};
    n.kernel = kernel;
    n.cost_ns = 2;
    return n;
}

ALDER_NODE {
    NodeType n = separate("ShaderNodeSeparateColor", "separate_color", "Color", {"Red", "Green", "Blue"}, "a colour as RGB, HSV or HSL numbers", separate_color_kernel());
    n.params.push_back(color_mode());
    return n;
}
ALDER_NODE {
    NodeType n = combine("ShaderNodeCombineColor", "combine_color", {"Red", "Green", "Blue"}, "Color", "a colour from RGB, HSV or HSL numbers", combine_color_kernel());
    n.help = "A hue outside 0 ... 1 is not wrapped.";
    n.params.push_back(color_mode());
    return n;
}
ALDER_NODE { return separate("ShaderNodeSeparateRGB", "separate_rgb", "Image", {"R", "G", "B"}, "a colour as RGB numbers (older form of Separate Color)", copy_color_kernel()); }
ALDER_NODE { return combine("ShaderNodeCombineRGB", "combine_rgb", {"R", "G", "B"}, "Image", "a colour from RGB numbers (older form of Combine Color)", copy_color_kernel()); }
ALDER_NODE { return separate("ShaderNodeSeparateHSV", "separate_hsv", "Color", {"H", "S", "V"}, "a colour as HSV numbers (older form of Separate Color)", separate_hsv_kernel()); }
ALDER_NODE { return combine("ShaderNodeCombineHSV", "combine_hsv", {"H", "S", "V"}, "Color", "a colour from HSV numbers (older form of Combine Color)", combine_hsv_kernel()); }
}  // namespace alder
#endif
