// Closure arithmetic and outputs: Mix Shader, Add Shader, and the output nodes of materials, worlds and lights.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/surface/mix_shader.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct MixWeight {  // how much of the second closure
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, saturate(k.f(0))); }
};
template <class F>
void mix_weight(const Call<F>& c) { c.template each<MixWeight>(); }
ALDER_KERNEL(mix_weight)

struct MixRest {  // and of the first
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, F(1) - saturate(k.f(0))); }
};
template <class F>
void mix_rest(const Call<F>& c) { c.template each<MixRest>(); }
ALDER_KERNEL(mix_rest)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "graph/lowering.h"
#include "nodes/surface/cycles_params.h"

namespace alder {
ALDER_KERNEL_EXPORT(mix_weight)
ALDER_KERNEL_EXPORT(mix_rest)

ALDER_NODE {
    using namespace param;
    NodeType n = cycles_bsdf_node("ShaderNodeMixShader", "mix_closure", "blends two shaders", "Shader");
    n.outputs[0].aliases = {"Closure"};
    n.params = {f("Fac", 0.5).range(0, 1).doc("0 is the first shader, 1 the second; limited to that range"),
                closure("Shader").alias("Closure1"), closure("Shader_001").alias("Closure2")};
    n.lower = [](Lowering& l, int) {
        const ValueRef fac[] = {l.input(0)};
        l.pass_closure(1, l.op("mix_rest", mix_rest_kernel(), fac, Type::Float));
        l.pass_closure(2, l.op("mix_weight", mix_weight_kernel(), fac, Type::Float));
    };
    return n;
}

ALDER_NODE {
    using namespace param;
    NodeType n = cycles_bsdf_node("ShaderNodeAddShader", "add_closure", "sum of two shaders", "Shader");
    n.outputs[0].aliases = {"Closure"};
    n.params = {closure("Shader").alias("Closure1"), closure("Shader_001").alias("Closure2")};
    n.lower = [](Lowering& l, int) {
        l.pass_closure(0, {});
        l.pass_closure(1, {});
    };
    return n;
}

/// Output nodes pass their inputs on, so that a document's outputs may name them in place of what feeds them.
static NodeType output_node(const char* name, const char* summary, bool active) {
    using namespace param;
    NodeType n;
    n.name = name;
    n.system = System::Cycles;
    n.category = "output";
    n.summary = summary;
    n.params = {closure("Surface"), b("is_active_output", active).doc("has no effect: the document's outputs decide").no_link(),
                choice("target", {"ALL", "EEVEE", "CYCLES"}, "ALL").doc("has no effect")};
    n.outputs = {{"Surface", Type::Closure}};
    n.uses = [](const Statics&, int p) { return p == 0; };
    n.lower = [](Lowering& l, int) { l.pass_closure(0, {}); };
    return n;
}
ALDER_NODE {
    using namespace param;
    NodeType n = output_node("ShaderNodeOutputMaterial", "end of a material", false);
    n.params.push_back(closure("Volume"));
    n.params.push_back(vector("Displacement", 0, 0, 0));
    n.params.push_back(f("Thickness", 0).doc("has no effect"));
    n.outputs = {{"Surface", Type::Closure}, {"Volume", Type::Closure}, {"Displacement", Type::Vector}};
    n.uses = [](const Statics&, int p) { return p == 0 || p == 3 || p == 4; };
    n.lower = [](Lowering& l, int output) {
        if (output == 2) l.result(l.input(4));
        else l.pass_closure(output == 0 ? 0 : 3, {});
    };
    return n;
}
ALDER_NODE {
    NodeType n = output_node("ShaderNodeOutputWorld", "end of the world's shader", true);
    n.params.push_back(param::closure("Volume"));
    n.outputs = {{"Surface", Type::Closure}, {"Volume", Type::Closure}};
    n.uses = [](const Statics&, int p) { return p == 0 || p == 3; };
    n.lower = [](Lowering& l, int output) { l.pass_closure(output == 0 ? 0 : 3, {}); };
    return n;
}
ALDER_NODE { return output_node("ShaderNodeOutputLight", "end of a light's shader", true); }
}  // namespace alder
#endif
