// Attribute, Color Attribute, UV Map and Object Info: data of the geometry and of the object (Blender's nodes).
//
// Attributes are asked for by name; what goes beyond three numbers of one of them has a name of its own:
//   NAME.alpha     fourth component, 1 where there is none or no such attribute
//   NAME.exists    1 where the geometry has the attribute, else 0
//   object:NAME, instancer:NAME, view_layer:NAME    custom properties of the object, its instancer, the scene
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/input/attribute.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct Product {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, k.f(0) * k.f(1)); }
};
template <class F>
void product(const Call<F>& c) { c.template each<Product>(); }
ALDER_KERNEL(product)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "graph/lowering.h"

namespace alder {
ALDER_KERNEL_EXPORT(product)

/// 0 without the attribute.
static ValueRef alpha_or_zero(Lowering& l, const std::string& name) {
    const ValueRef operands[] = {l.attribute(name + ".alpha", Type::Float), l.attribute(name + ".exists", Type::Float)};
    return l.op("product", product_kernel(), operands, Type::Float);
}

static void lower_attribute(Lowering& l, int output) {
    const Statics& s = l.statics();
    const int type = s.e(0);
    const char* const prefix[] = {"", "object:", "instancer:", "view_layer:"};
    const std::string name = prefix[type] + s.text[1];
    if (s.text[1].empty()) return l.result(l.constant(s.type->outputs[output].type, output == 3 && type == 0 ? 1 : 0));
    switch (output) {
        case 0: return l.result(l.attribute(name, Type::Color));
        case 1: return l.result(l.attribute(name, Type::Vector));
        case 2: return l.result(l.attribute(name, Type::Float));
        default: return l.result(type == 0 ? l.attribute(name + ".alpha", Type::Float) : alpha_or_zero(l, name));
    }
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeAttribute";
    n.category = "Input";
    n.summary = "an attribute of the geometry, the object, its instancer or the scene";
    n.help = "A missing attribute is 0. Fac is the mean of a colour or vector, and the first of two numbers.";
    n.aliases = {"attribute"};
    n.params.push_back(choice("attribute_type", {"GEOMETRY", "OBJECT", "INSTANCER", "VIEW_LAYER"}, "GEOMETRY"));
    n.params.push_back(string("attribute_name").alias("attribute"));
    n.outputs = {{"Color", Type::Color}, {"Vector", Type::Vector}, {"Fac", Type::Float}, {"Alpha", Type::Float}};
    n.lower = lower_attribute;
    return n;
}
ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeVertexColor";
    n.category = "Input";
    n.summary = "a colour attribute of the geometry";
    n.help = "A missing attribute is black and transparent.";
    n.aliases = {"vertex_color"};
    n.params.push_back(string("layer_name").doc("empty: the geometry's first colour attribute"));
    n.outputs = {{"Color", Type::Color}, {"Alpha", Type::Float}};
    n.lower = [](Lowering& l, int output) {
        const std::string& name = l.statics().text[0];
        l.result(output == 0 ? l.attribute(name, Type::Color) : alpha_or_zero(l, name));
    };
    return n;
}
ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeUVMap";
    n.category = "Input";
    n.summary = "coordinates of a UV map";
    n.aliases = {"uvmap"};
    n.params.push_back(string("uv_map").alias("attribute").doc("empty: the active UV map"));
    n.params.push_back(b("from_instancer", false).no_link().alias("from_dupli"));
    n.outputs = {{"UV", Type::Vector}};
    n.lower = [](Lowering& l, int) {
        const std::string& name = l.statics().text[0];
        if (l.statics().e(1)) return l.result(l.attribute("instancer_uv", Type::Vector));
        l.result(name.empty() ? l.global(Global::Uv) : l.attribute(name, Type::Vector));
    };
    return n;
}
ALDER_NODE {
    NodeType n;
    n.name = "ShaderNodeObjectInfo";
    n.category = "Input";
    n.summary = "location, colour, numbers and a random number of the object";
    n.aliases = {"object_info"};
    n.outputs = {{"Location", Type::Vector}, {"Color", Type::Color}, {"Alpha", Type::Float}, {"Object Index", Type::Float}, {"Material Index", Type::Float}, {"Random", Type::Float}};
    n.lower = [](Lowering& l, int output) {
        switch (output) {
            case 0: return l.result(l.global(Global::ObjectLocation));
            case 1: return l.result(l.global(Global::ObjectColor));
            case 2: return l.result(l.attribute_or("object_alpha", Type::Float, l.constant(Type::Float, 1)));
            case 3: return l.result(l.global(Global::ObjectIndex));
            case 4: return l.result(l.global(Global::MaterialIndex));
            default: return l.result(l.global(Global::ObjectRandom));
        }
    };
    return n;
}
}  // namespace alder
#endif
