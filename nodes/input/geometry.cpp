// Geometry: position, normals, tangent and other facts about the shading point (Blender's node).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/input/geometry.cpp"
#include "hwy/foreach_target.h"

#include <limits>

#include "nodes/input/space-inl.h"
#include "nodes/math/finite-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Tangent around the object's Z axis, from generated coordinates. Channels: generated 0, N 3, columns of world to object 6,
/// ray length 15. The world has no tangent: NaN, as in Cycles, known by the length of its rays.
struct RadialTangent {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> g = k.v(0), n = k.v(3);
        const Vec3<F> around = normalize_any(matrix3(k, 6).transposed(Vec3<F>(-(g.y - F(0.5)), g.x - F(0.5), F(0))));
        const Vec3<F> tangent = cross(n, normalize_any(cross(around, n)));
        k.set(0, select<F>(k.f(15) < F(1e38), tangent, Vec3<F>(F(std::numeric_limits<float>::quiet_NaN()))));
    }
};
struct Parametric {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, Vec3<F>(k.f(0), k.f(1), F(0))); }
};
template <class F>
void radial_tangent(const Call<F>& c) { c.template each<RadialTangent>(); }
template <class F>
void parametric(const Call<F>& c) { c.template each<Parametric>(); }
ALDER_KERNEL(radial_tangent)
ALDER_KERNEL(parametric)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "graph/lowering.h"

namespace alder {
ALDER_KERNEL_EXPORT(radial_tangent)
ALDER_KERNEL_EXPORT(parametric)

static ValueRef radial_tangent(Lowering& l) {
    const ValueRef operands[] = {l.global(Global::Generated), l.global(Global::N), l.global(Global::WorldToObjectX),
                                 l.global(Global::WorldToObjectY), l.global(Global::WorldToObjectZ), l.global(Global::RayLength)};
    return l.op("radial_tangent", radial_tangent_kernel(), operands, Type::Vector);
}

static void lower_geometry(Lowering& l, int output) {
    switch (output) {
        case 0: return l.result(l.global(Global::P));
        case 1: return l.result(l.global(Global::N));
        case 2: return l.result(radial_tangent(l));
        case 3: return l.result(l.global(Global::Ng));
        case 4: return l.result(l.global(Global::I));
        case 5: {
            const ValueRef operands[] = {l.global(Global::BarycentricU), l.global(Global::BarycentricV)};
            return l.result(l.op("parametric", parametric_kernel(), operands, Type::Vector));
        }
        case 6: return l.result(l.global(Global::Backfacing));
        case 7: return l.result(l.global(Global::Pointiness));
        default: return l.result(l.global(Global::IslandRandom));
    }
}

ALDER_NODE {
    NodeType n;
    n.name = "ShaderNodeNewGeometry";
    n.category = "Input";
    n.summary = "position, normals, tangent and other facts about the shading point";
    n.help = "All in world space. Normal and True Normal point towards the viewer. Tangent runs around the object's Z axis.";
    n.aliases = {"geometry"};
    for (const char* o : {"Position", "Normal", "Tangent", "True Normal", "Incoming", "Parametric"}) n.outputs.push_back({o, Type::Vector});
    for (const char* o : {"Backfacing", "Pointiness", "Random Per Island"}) n.outputs.push_back({o, Type::Float});
    n.cost_ns = 1;
    n.lower = lower_geometry;
    return n;
}
}  // namespace alder
#endif
