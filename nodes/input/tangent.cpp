// Tangent: a direction within the surface, around an axis of the object or along a UV map (Blender's node).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/input/tangent.cpp"
#include "hwy/foreach_target.h"

#include "nodes/input/space-inl.h"
#include "nodes/math/cycles-inl.h"
#include "nodes/math/finite-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Object-space direction (taken as a normal, as Cycles does) to the plane perpendicular to N. Columns of world to object from 6.
template <class F>
HWY_INLINE Vec3<F> surface_tangent(Lanes<F> k, Vec3<F> direction) {
    const Vec3<F> n = k.v(3), world = normalize_any(matrix3(k, 6).transposed(direction));
    return cross(n, normalize_any(cross(world, n)));
}
/// Generated coordinates 0, N 3: around the axis through the middle of the texture space.
template <int axis>
struct AroundAxis {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> g = k.v(0) - Vec3<F>(F(0.5));
        k.set(0, surface_tangent(k, axis == 0 ? Vec3<F>(F(0), -g.z, g.y) : axis == 1 ? Vec3<F>(-g.z, F(0), g.x) : Vec3<F>(-g.y, g.x, F(0))));
    }
};
/// Stored tangent 0, N 3. Zero without one.
struct AlongUv {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> stored = k.v(0);
        k.set(0, select<F>(is_zero(stored), Vec3<F>(F(0)), surface_tangent(k, stored)));
    }
};
template <class F>
void around_x(const Call<F>& c) { c.template each<AroundAxis<0>>(); }
template <class F>
void around_y(const Call<F>& c) { c.template each<AroundAxis<1>>(); }
template <class F>
void around_z(const Call<F>& c) { c.template each<AroundAxis<2>>(); }
template <class F>
void along_uv(const Call<F>& c) { c.template each<AlongUv>(); }
ALDER_KERNEL(around_x)
ALDER_KERNEL(around_y)
ALDER_KERNEL(around_z)
ALDER_KERNEL(along_uv)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "graph/lowering.h"

namespace alder {
ALDER_KERNEL_EXPORT(around_x)
ALDER_KERNEL_EXPORT(around_y)
ALDER_KERNEL_EXPORT(around_z)
ALDER_KERNEL_EXPORT(along_uv)

enum { kDirectionType, kAxis, kUvMap };

static void lower_tangent(Lowering& l, int) {
    const Statics& s = l.statics();
    const bool along = s.e(kDirectionType) == 1;
    const std::string& map = s.text[kUvMap];
    const ValueRef direction = !along ? l.global(Global::Generated) : map.empty() ? l.global(Global::TangentObject) : l.attribute(map + ".tangent", Type::Vector);
    const ValueRef operands[] = {direction, l.global(Global::N), l.global(Global::WorldToObjectX), l.global(Global::WorldToObjectY), l.global(Global::WorldToObjectZ)};
    if (along) return l.result(l.op("along_uv", along_uv_kernel(), operands, Type::Vector));
    switch (s.e(kAxis)) {
        case 0: return l.result(l.op("around_x", around_x_kernel(), operands, Type::Vector));
        case 1: return l.result(l.op("around_y", around_y_kernel(), operands, Type::Vector));
        default: return l.result(l.op("around_z", around_z_kernel(), operands, Type::Vector));
    }
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeTangent";
    n.category = "Input";
    n.summary = "a direction within the surface, for anisotropy";
    n.help = "Radial: around an axis of the object through the middle of its generated coordinates. UV Map: along u.";
    n.aliases = {"tangent"};
    n.params.push_back(choice("direction_type", std::vector<Item>{{"RADIAL", "Radial", "radial"}, {"UV_MAP", "UV Map", "uv_map"}}, "RADIAL"));
    n.params.push_back(choice("axis", std::vector<Item>{{"X", "X", "x"}, {"Y", "Y", "y"}, {"Z", "Z", "z"}}, "Z"));
    n.params.push_back(string("uv_map").alias("attribute").doc("empty: the active UV map"));
    n.outputs = {{"Tangent", Type::Vector}};
    n.cost_ns = 5;
    n.uses = [](const Statics& s, int param) { return param == kAxis ? s.e(kDirectionType) == 0 : param == kUvMap ? s.e(kDirectionType) == 1 : true; };
    n.lower = lower_tangent;
    return n;
}
}  // namespace alder
#endif
