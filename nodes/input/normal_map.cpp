// Normal Map: a normal from a colour, in tangent, object or world space (Blender's node).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/input/normal_map.cpp"
#include "hwy/foreach_target.h"

#include "nodes/input/space-inl.h"
#include "nodes/math/cycles-inl.h"
#include "nodes/math/finite-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Colour 0 ... 1 to a vector -1 ... 1.
template <class F>
HWY_INLINE Vec3<F> unpack_normal(Vec3<F> c) { return F(2) * (c - Vec3<F>(F(0.5))); }

/// Channels: strength 0, colour 1, N 4, backfacing 7, columns of world to object 8, columns of object to world 17, normal as
/// interpolated in object space 26, tangent as stored 29, its sign 32.
/// The frame is built in object space from the interpolated normal before it is normalised: the shorter it is, the more the map tilts.
struct TangentNormal {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F strength = k.f(0);
        const Vec3<F> shading = k.v(4), tangent = k.v(29);
        const Mask<F> back = k.f(7) != F(0);
        Vec3<F> c = unpack_normal(k.v(1));
        c = {c.x * strength, c.y * strength, F(1) + cycles_saturate(strength) * (c.z - F(1))};

        const Vec3<F> stored = k.v(26);
        const Vec3<F> derived = safe_normalize_any(matrix3(k, 17).transposed(select<F>(back, -shading, shading)));
        const Vec3<F> normal = select<F>(is_zero(stored), derived, stored);

        const Vec3<F> bitangent = k.f(32) * cross(normal, tangent);
        const Vec3<F> local = safe_normalize_any(c.x * tangent + c.y * bitangent + c.z * normal);
        const Vec3<F> n = normalize_any(matrix3(k, 8).transposed(local));
        const Vec3<F> turned = select<F>(back, -n, n);
        // No tangent: the map has no effect.
        k.set(0, select<F>(is_zero(tangent) | is_zero(turned), shading, turned));
    }
};
/// Channels: strength 0, colour 1, N 4, backfacing 7, columns of world to object 8 (object space only).
template <bool object_space, bool blender_axes>
struct SpaceNormal {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F strength = k.f(0);
        const Vec3<F> shading = k.v(4);
        Vec3<F> n = unpack_normal(k.v(1));
        if constexpr (blender_axes) n = {n.x, -n.y, -n.z};
        if constexpr (object_space) n = normalize_any(matrix3(k, 8).transposed(n));
        else n = safe_normalize_any(n);
        n = select<F>(k.f(7) != F(0), -n, n);
        const Vec3<F> blended = safe_normalize_any(shading + (n - shading) * second_max(strength, F(0)));
        n = select<F>(strength != F(1), blended, n);
        k.set(0, select<F>(is_zero(n), shading, n));
    }
};
template <class F>
void tangent_normal(const Call<F>& c) { c.template each<TangentNormal>(); }
template <class F>
void object_space_normal(const Call<F>& c) { c.template each<SpaceNormal<true, false>>(); }
template <class F>
void world_space_normal(const Call<F>& c) { c.template each<SpaceNormal<false, false>>(); }
template <class F>
void blender_object_normal(const Call<F>& c) { c.template each<SpaceNormal<true, true>>(); }
template <class F>
void blender_world_normal(const Call<F>& c) { c.template each<SpaceNormal<false, true>>(); }
ALDER_KERNEL(tangent_normal)
ALDER_KERNEL(object_space_normal)
ALDER_KERNEL(world_space_normal)
ALDER_KERNEL(blender_object_normal)
ALDER_KERNEL(blender_world_normal)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "graph/lowering.h"

namespace alder {
ALDER_KERNEL_EXPORT(tangent_normal)
ALDER_KERNEL_EXPORT(object_space_normal)
ALDER_KERNEL_EXPORT(world_space_normal)
ALDER_KERNEL_EXPORT(blender_object_normal)
ALDER_KERNEL_EXPORT(blender_world_normal)

enum { kStrength, kColor, kSpace, kUvMap };
enum { kTangent, kObject, kWorld, kBlenderObject, kBlenderWorld };

static void lower_normal_map(Lowering& l, int) {
    std::vector<ValueRef> operands{l.input(kStrength), l.input(kColor), l.global(Global::N), l.global(Global::Backfacing)};
    const auto add = [&](std::initializer_list<Global> globals) {
        for (Global g : globals) operands.push_back(l.global(g));
    };
    const int space = l.statics().e(kSpace);
    if (space == kTangent || space == kObject || space == kBlenderObject) add({Global::WorldToObjectX, Global::WorldToObjectY, Global::WorldToObjectZ});
    if (space == kTangent) {
        add({Global::ObjectToWorldX, Global::ObjectToWorldY, Global::ObjectToWorldZ, Global::NormalObject});
        const std::string& map = l.statics().text[kUvMap];
        if (map.empty()) {
            add({Global::TangentObject, Global::TangentSign});
        } else {
            operands.push_back(l.attribute(map + ".tangent", Type::Vector));
            operands.push_back(l.attribute(map + ".tangent_sign", Type::Float));
        }
    }
    switch (space) {
        case kTangent: return l.result(l.op("tangent_normal", tangent_normal_kernel(), operands, Type::Vector));
        case kObject: return l.result(l.op("object_space_normal", object_space_normal_kernel(), operands, Type::Vector));
        case kWorld: return l.result(l.op("world_space_normal", world_space_normal_kernel(), operands, Type::Vector));
        case kBlenderObject: return l.result(l.op("blender_object_normal", blender_object_normal_kernel(), operands, Type::Vector));
        default: return l.result(l.op("blender_world_normal", blender_world_normal_kernel(), operands, Type::Vector));
    }
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeNormalMap";
    n.category = "Vector";
    n.summary = "a normal from a colour, in tangent, object or world space";
    n.help = "Tangents are those of the UV map, its attributes NAME.tangent and NAME.tangent_sign; without them the normal stays as it is.";
    n.aliases = {"normal_map"};
    n.params.push_back(f("Strength", 1).range(0, 10));
    n.params.push_back(color("Color", 0.5, 0.5, 1));
    n.params.push_back(choice("space",
                              std::vector<Item>{{"TANGENT", "Tangent Space", "tangent"}, {"OBJECT", "Object Space", "object"}, {"WORLD", "World Space", "world"},
                                                {"BLENDER_OBJECT", "Blender Object Space", "blender_object"}, {"BLENDER_WORLD", "Blender World Space", "blender_world"}},
                              "TANGENT"));
    n.params.push_back(string("uv_map").doc("empty: the active UV map"));
    n.outputs = {{"Normal", Type::Vector}};
    n.cost_ns = 8;
    n.uses = [](const Statics& s, int param) { return param != kUvMap || s.e(kSpace) == kTangent; };
    n.lower = lower_normal_map;
    return n;
}
}  // namespace alder
#endif
