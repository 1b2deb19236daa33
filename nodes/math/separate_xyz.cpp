// Separate XYZ and Combine XYZ: a vector's components one by one (Blender's nodes).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/math/separate_xyz.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

// Three channels in, three out: the same copy either way.
struct CopyComponents {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, k.v(0)); }
};
template <class F>
void copy_components(const Call<F>& c) { c.template each<CopyComponents>(); }
ALDER_KERNEL(copy_components)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(copy_components)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeSeparateXYZ";
    n.category = "Converter";
    n.summary = "the components of a vector";
    n.aliases = {"separate_xyz"};
    n.params.push_back(vector("Vector", 0, 0, 0).range(-10000, 10000));
    n.outputs = {{"X", Type::Float}, {"Y", Type::Float}, {"Z", Type::Float}};
    n.kernel = copy_components_kernel();
    n.cost_ns = 0.5f;
    return n;
}
ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeCombineXYZ";
    n.category = "Converter";
    n.summary = "a vector from its components";
    n.aliases = {"combine_xyz"};
    n.params.push_back(f("X", 0).range(-10000, 10000));
    n.params.push_back(f("Y", 0).range(-10000, 10000));
    n.params.push_back(f("Z", 0).range(-10000, 10000));
    n.outputs = {{"Vector", Type::Vector}};
    n.kernel = copy_components_kernel();
    n.cost_ns = 0.5f;
    return n;
}
}  // namespace alder
#endif
