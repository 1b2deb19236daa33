// Light Falloff: a light's strength that falls with distance squared, with distance, or not at all (Blender's node).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/input/light_falloff.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Channels: strength 0, smooth 1, ray length 2. Distant lights keep their strength: their distance has no end.
struct LightFalloff {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F strength = k.f(0), smooth = k.f(1), distance = k.f(2);
        const F squared = distance * distance;
        const Mask<F> distant = distance >= F(3.402823466e38);
        const F soft = select(smooth > F(0), squared / (smooth + squared), F(1));
        const F factor[3] = {F(1), distance, squared};
        for (int i = 0; i < 3; ++i) k.set(i, select(distant, strength, strength * factor[i] * soft));
    }
};
template <class F>
void light_falloff(const Call<F>& c) { c.template each<LightFalloff>(); }
ALDER_KERNEL(light_falloff)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(light_falloff)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeLightFalloff";
    n.category = "Color";
    n.summary = "a light's strength by distance: quadratic, linear or constant";
    n.help = "Smooth reduces the strength close to the light. The distance is the length of the ray.";
    n.aliases = {"light_falloff"};
    n.params.push_back(f("Strength", 100).range(0, 1e6));
    n.params.push_back(f("Smooth", 0).range(0, 1000));
    n.outputs = {{"Quadratic", Type::Float}, {"Linear", Type::Float}, {"Constant", Type::Float}};
    n.globals = {Global::RayLength};
    n.kernel = light_falloff_kernel();
    return n;
}
}  // namespace alder
#endif
