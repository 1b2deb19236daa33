// Displacement and Vector Displacement: how far and where a surface moves, as a vector in world space (Blender's nodes).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/input/displacement.cpp"
#include "hwy/foreach_target.h"

#include "nodes/input/space-inl.h"
#include "nodes/math/cycles-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Channels: height 0, midlevel 1, scale 2, normal 3; columns of object to world 6 (object space only). A normal goes to object
/// space by the transposed matrix and has unit length there: the distance is measured in the object's own units.
template <bool kObject>
struct AlongNormal {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F distance = (k.f(0) - k.f(1)) * k.f(2);
        const Vec3<F> normal = k.v(3);
        if constexpr (kObject) {
            const Matrix3<F> m = matrix3(k, 6);
            k.set(0, m.apply(safe_normalize(m.transposed(normal)) * distance));
        } else {
            k.set(0, normal * distance);
        }
    }
};
enum { kTangentSpace, kObjectSpace, kWorldSpace };
/// Channels: vector 0, midlevel 3, scale 4; from object space on columns of object to world 5; tangent space also N 14, the stored
/// tangent 17, its sign 20, dPdu 21. Tangent space: x along the tangent, y along the normal, z along the bitangent.
template <int kSpace>
struct AlongVector {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F scale = k.f(4);
        Vec3<F> d = (k.v(0) - Vec3<F>(k.f(3))) * scale;
        if constexpr (kSpace == kTangentSpace) {
            const Vec3<F> normal = safe_normalize(matrix3(k, 5).transposed(k.v(14)));
            const Vec3<F> stored = k.v(17);
            const Mask<F> missing = is_zero(stored);
            const Vec3<F> tangent = select<F>(missing, safe_normalize(k.v(21)), stored);
            const Vec3<F> bitangent = safe_normalize(cross(normal, tangent)) * select(missing, F(1), k.f(20));
            d = tangent * d.x + normal * d.y + bitangent * d.z;
        }
        if constexpr (kSpace != kWorldSpace) d = matrix3(k, 5).apply(d);
        k.set(0, d);
    }
};
template <class F>
void displace_object(const Call<F>& c) { c.template each<AlongNormal<true>>(); }
template <class F>
void displace_world(const Call<F>& c) { c.template each<AlongNormal<false>>(); }
template <class F>
void displace_vector_tangent(const Call<F>& c) { c.template each<AlongVector<kTangentSpace>>(); }
template <class F>
void displace_vector_object(const Call<F>& c) { c.template each<AlongVector<kObjectSpace>>(); }
template <class F>
void displace_vector_world(const Call<F>& c) { c.template each<AlongVector<kWorldSpace>>(); }
ALDER_KERNEL(displace_object)
ALDER_KERNEL(displace_world)
ALDER_KERNEL(displace_vector_tangent)
ALDER_KERNEL(displace_vector_object)
ALDER_KERNEL(displace_vector_world)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "graph/lowering.h"

namespace alder {
ALDER_KERNEL_EXPORT(displace_object)
ALDER_KERNEL_EXPORT(displace_world)
ALDER_KERNEL_EXPORT(displace_vector_tangent)
ALDER_KERNEL_EXPORT(displace_vector_object)
ALDER_KERNEL_EXPORT(displace_vector_world)
namespace p = HWY_NAMESPACE;

static void add_object_to_world(Lowering& l, std::vector<ValueRef>& operands) {
    for (Global g : {Global::ObjectToWorldX, Global::ObjectToWorldY, Global::ObjectToWorldZ}) operands.push_back(l.global(g));
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeDisplacement";
    n.aliases = {"displacement"};
    n.category = "Displacement";
    n.summary = "moves the surface along its normal";
    n.help = "(Height - Midlevel) times Scale along the normal, in the object's units or the world's; the result is a vector in world space.";
    n.params = {
        choice("space", std::vector<Item>{{"OBJECT", "Object Space", "object"}, {"WORLD", "World Space", "world"}}, "OBJECT")
            .doc("whether the object's scale scales the displacement"),
        f("Height").range(0, 1000).doc("distance along the normal"),
        f("Midlevel", 0.5).range(0, 1000).doc("the height that does not move"),
        f("Scale", 0.00999999978).range(0, 1000).doc("multiplies the distance"),
        vector("Normal", 0, 0, 0).unlinked(Global::N).doc("the direction; unlinked: the shading normal"),
    };
    n.outputs = {{"Displacement", Type::Vector}};
    n.cost_ns = 4;
    n.lower = [](Lowering& l, int) {
        std::vector<ValueRef> operands{l.input(1), l.input(2), l.input(3), l.input(4)};
        if (l.statics().e(0) == 1) return l.result(l.op("displace_world", displace_world_kernel(), operands, Type::Vector));
        add_object_to_world(l, operands);
        l.result(l.op("displace_object", displace_object_kernel(), operands, Type::Vector));
    };
    return n;
}
ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeVectorDisplacement";
    n.aliases = {"vector_displacement"};
    n.category = "Displacement";
    n.summary = "moves the surface by a vector";
    n.help = "(Vector - Midlevel) times Scale in tangent space (x along the active UV map's tangent, y along the normal, z across), object space or "
             "world space; the result is a vector in world space.";
    n.params = {
        choice("space", std::vector<Item>{{"TANGENT", "Tangent Space", "tangent"}, {"OBJECT", "Object Space", "object"}, {"WORLD", "World Space", "world"}}, "TANGENT")
            .doc("what the vector's components run along"),
        color("Vector", 0.800000012, 0.800000012, 0.800000012).doc("displacement as a colour or vector"),
        f("Midlevel").range(0, 1000).doc("the component that does not move"),
        f("Scale", 0.00999999978).range(0, 1000).doc("multiplies the vector"),
        string("attribute").doc("UV map of the tangents; empty: the active one"),
    };
    n.outputs = {{"Displacement", Type::Vector}};
    n.cost_ns = 8;
    n.uses = [](const Statics& s, int param) { return param != 4 || s.e(0) == p::kTangentSpace; };
    n.lower = [](Lowering& l, int) {
        std::vector<ValueRef> operands{l.input(1), l.input(2), l.input(3)};
        const int space = l.statics().e(0);
        if (space == p::kWorldSpace) return l.result(l.op("displace_vector_world", displace_vector_world_kernel(), operands, Type::Vector));
        add_object_to_world(l, operands);
        if (space == p::kObjectSpace) return l.result(l.op("displace_vector_object", displace_vector_object_kernel(), operands, Type::Vector));
        operands.push_back(l.global(Global::N));
        const std::string& map = l.statics().text[4];
        operands.push_back(map.empty() ? l.global(Global::TangentObject) : l.attribute(map + ".tangent", Type::Vector));
        operands.push_back(map.empty() ? l.global(Global::TangentSign) : l.attribute(map + ".tangent_sign", Type::Float));
        operands.push_back(l.global(Global::Dpdu));
        l.result(l.op("displace_vector_tangent", displace_vector_tangent_kernel(), operands, Type::Vector));
    };
    return n;
}
}  // namespace alder
#endif
