// alLayerFloat and alLayerColor: a stack of eight layers, each blended over what is below by its alpha.
// alshaders specification, section 2.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/math/al_layer.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/math/blend-inl.h"

#ifndef ALDER_NODES_MATH_AL_LAYER_
#define ALDER_NODES_MATH_AL_LAYER_
namespace alder {
// Parameters a layer: colour, alpha, mode, name, enabled; a float layer has no mode.
constexpr int kLayers = 8, kFloatParams = 4, kColorParams = 5;
inline int layer_stride(const Statics& s) { return static_cast<int>(s.enums.size()) / kLayers; }   // 4 of 32, 5 of 41
/// Layers that count: up to the highest whose alpha is linked or not zero.
inline int layers_in_use(const Statics& s) {
    int top = kLayers;
    while (top > 0 && s.is_zero((top - 1) * layer_stride(s) + 1)) --top;
    return top;
}
}  // namespace alder
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct AlLayerFloat {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        F r(0);
        const int top = layers_in_use(k.statics());
        for (int layer = 0; layer < top; ++layer) {
            const F a = k.f(3 * layer + 1), enabled = k.f(3 * layer + 2);
            // Where alpha is 0 the layer need not have been evaluated: any other number will do.
            const F s = select(a != F(0), k.f(3 * layer), F(0));
            r = select(enabled != F(0), lerp(r, s, a), r);
        }
        k.set(0, r);
    }
};
struct AlLayerColor {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        Vec3<F> r(F(0));
        const int top = layers_in_use(k.statics());
        const Mask<F> clamped = k.f(5 * kLayers) != F(0);
        for (int layer = 0; layer < top; ++layer) {
            const F a = k.f(5 * layer + 3), enabled = k.f(5 * layer + 4);
            const BlendMode mode = static_cast<BlendMode>(k.statics().e(kColorParams * layer + 2));
            Vec3<F> s = k.v(5 * layer);
            // Soft Light is not lazy: over negative values it is NaN even where alpha is 0.
            if (mode != BlendMode::SoftLight) s = select(a != F(0), s, Vec3<F>(F(0)));
            r = select(enabled != F(0), lerp(r, blend(mode, r, s, clamped), a), r);
        }
        k.set(0, r);
    }
};
template <class F>
void al_layer_float(const Call<F>& c) { c.template each<AlLayerFloat>(); }
template <class F>
void al_layer_color(const Call<F>& c) { c.template each<AlLayerColor>(); }
ALDER_KERNEL(al_layer_float)
ALDER_KERNEL(al_layer_color)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(al_layer_float)
ALDER_KERNEL_EXPORT(al_layer_color)

/// Names are comments; switched-off layers and those above the top have no effect, clamp_result in most modes neither.
static bool layer_uses(const Statics& s, int param) {
    const int stride = layer_stride(s), layer = param / stride, part = param % stride, top = layers_in_use(s);
    const bool colors = stride == kColorParams;
    const auto off = [&](int l) { return l >= top || (!s.linked[l * stride + stride - 1] && !s.e(l * stride + stride - 1)); };
    if (layer < kLayers) return part != stride - 2 && !(off(layer) && part != stride - 1) && layer < top;
    for (int l = 0; l < top; ++l) {
        using enum BlendMode;
        if (!colors || off(l)) continue;
        switch (static_cast<BlendMode>(s.e(l * stride + 2))) {
            case Add: case LinearDodge: case Subtract: case LinearBurn: case ColorDodge: case LinearLight: case VividLight:
            case HardMix: case Reflect: case Glow: return true;
            default: break;
        }
    }
    return false;
}
/// A layer is needed where its alpha is not zero, and where it is switched on if a link decides that.
static std::vector<LazyRule> layer_lazy(const Statics& s) {
    std::vector<LazyRule> rules;
    const int stride = layer_stride(s);
    for (int layer = 0; layer < kLayers; ++layer) {
        const int first = layer * stride, enabled = first + stride - 1;
        const bool soft_light = stride == kColorParams && static_cast<BlendMode>(s.e(first + 2)) == BlendMode::SoftLight;
        if (s.linked[enabled]) {
            rules.push_back({first, enabled, LazyRule::NeededIfNonZero});
            rules.push_back({first + 1, enabled, LazyRule::NeededIfNonZero});
        }
        if (!soft_light) rules.push_back({first, first + 1, LazyRule::NeededIfNonZero});
    }
    return rules;
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alLayerFloat";
    n.system = System::AlShaders;
    n.category = "math";
    n.summary = "stack of eight float layers";
    n.help = "From 0, each enabled layer in order: result = lerp(result, layer, alpha). Layers above the highest with an alpha (linked or not "
             "zero) are not evaluated, nor is a layer where its alpha is 0.";
    for (int i = 1; i <= kLayers; ++i) {
        const std::string layer = "layer" + std::to_string(i), group = i == 1 ? "Background" : "Layer " + std::to_string(i);
        n.params.push_back(f(layer, 0).in(group).doc("value of the layer"));
        n.params.push_back(f(layer + "a", 0).range(0, 1).in(group).doc("alpha; not clamped"));
        n.params.push_back(string(layer + "name").in(group).doc("comment"));
        n.params.push_back(b(layer + "enabled", true).in(group).doc("whether the layer counts"));
    }
    n.outputs = {{"out", Type::Float}};
    n.kernel = al_layer_float_kernel();
    n.cost_ns = 2;
    n.uses = layer_uses;
    n.lazy = layer_lazy;
    return n;
}
ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alLayerColor";
    n.system = System::AlShaders;
    n.category = "math";
    n.summary = "stack of eight colour layers with blend modes";
    n.help = "From black, each enabled layer in order: result = lerp(result, mode(result, layer), alpha). Layers above the highest with an alpha "
             "(linked or not zero) are not evaluated, nor is a layer where its alpha is 0. Soft Light over negative values is NaN.";
    std::vector<Item> modes;
#define ALDER_BLEND_ITEM(name, label) modes.push_back({label, label, {}});
    ALDER_BLEND_MODES(ALDER_BLEND_ITEM)
#undef ALDER_BLEND_ITEM
    for (int i = 1; i <= kLayers; ++i) {
        const std::string layer = "layer" + std::to_string(i), group = i == 1 ? "Background" : "Layer " + std::to_string(i);
        n.params.push_back(color(layer, 0, 0, 0).in(group).doc("colour of the layer"));
        n.params.push_back(f(layer + "a", 0).range(0, 1).in(group).doc("alpha; not clamped"));
        n.params.push_back(choice(layer + "blend", modes, "Normal").in(group).doc("blend mode with what is below"));
        n.params.push_back(string(layer + "name").in(group).doc("comment"));
        n.params.push_back(b(layer + "enabled", true).in(group).doc("whether the layer counts"));
    }
    n.params.push_back(b("clamp_result", true).doc("limits the modes Add, Subtract, Color Dodge, Linear Dodge, Linear Burn, Linear Light, Vivid Light, Reflect and Glow to 0 ... 1"));
    n.outputs = {{"out", Type::Color}};
    n.kernel = al_layer_color_kernel();
    n.cost_ns = 10;
    n.uses = layer_uses;
    n.lazy = layer_lazy;
    return n;
}
}  // namespace alder
#endif
