// Closures without scattering: Emission, Background, Transparent, Holdout.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/surface/emission.cpp"
#include "hwy/foreach_target.h"

#include "nodes/surface/closure-inl.h"
#include "nodes/surface/cycles_params.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct EmissionClosure {  // Color 0, Strength 3
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { LobeOut<F>(k, 0).weight(k.v(0) * k.f(3)); }
};
template <class F>
void emission_closure(const Call<F>& c) { c.template each<EmissionClosure>(); }
ALDER_KERNEL(emission_closure)

struct TransparentClosure {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { LobeOut<F>(k, 0).weight(allocate(k.v(0))); }
};
template <class F>
void transparent_closure(const Call<F>& c) { c.template each<TransparentClosure>(); }
ALDER_KERNEL(transparent_closure)

struct HoldoutClosure {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { LobeOut<F>(k, 0).weight(Vec3<F>(F(1))); }
};
template <class F>
void holdout_closure(const Call<F>& c) { c.template each<HoldoutClosure>(); }
ALDER_KERNEL(holdout_closure)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(emission_closure)
ALDER_KERNEL_EXPORT(transparent_closure)
ALDER_KERNEL_EXPORT(holdout_closure)

static NodeType emitting_node(const char* name, const char* alias, const char* summary, const char* output, double grey) {
    using namespace param;
    NodeType n = cycles_bsdf_node(name, alias, summary, output);
    n.params = {color("Color", grey, grey, grey), f("Strength", 1).range(0, 1e6), weight_socket()};
    n.kernel = emission_closure_kernel();
    n.cost_ns = 1;
    n.uses = [](const Statics&, int p) { return p != 2; };
    n.lobes = [](const Statics&) -> std::vector<LobeSpec> {
        return {{.kind = LobeKind::Emission, .label = LobeLabel::Emission, .gates = {0, 1}}};
    };
    return n;
}

ALDER_NODE {
    return emitting_node("ShaderNodeEmission", "emission", "light of the same radiance in all directions", "Emission", 1);
}
ALDER_NODE {
    NodeType n = emitting_node("ShaderNodeBackground", "background_shader", "light of the world", "Background", 0.8);
    n.aliases.push_back("background");
    return n;
}
ALDER_NODE {
    using namespace param;
    NodeType n = cycles_bsdf_node("ShaderNodeBsdfTransparent", "transparent_bsdf", "lets light pass straight through, tinted");
    n.params = {color("Color", 1, 1, 1), weight_socket()};
    n.kernel = transparent_closure_kernel();
    n.cost_ns = 1;
    n.uses = [](const Statics&, int p) { return p == 0; };
    n.lobes = [](const Statics&) -> std::vector<LobeSpec> {
        return {{.kind = LobeKind::Transparent, .label = LobeLabel::Transparent, .gates = {0}}};
    };
    return n;
}
ALDER_NODE {
    NodeType n = cycles_bsdf_node("ShaderNodeHoldout", "holdout", "cuts a hole into the picture: black, with alpha 0", "Holdout");
    n.params = {weight_socket()};
    n.kernel = holdout_closure_kernel();
    n.cost_ns = 1;
    n.uses = [](const Statics&, int) { return false; };
    n.lobes = [](const Statics&) -> std::vector<LobeSpec> {
        return {{.kind = LobeKind::Holdout, .label = LobeLabel::Transparent}};
    };
    return n;
}
}  // namespace alder
#endif
