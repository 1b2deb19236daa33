// Bump: tilts the normal by the slope of a height, found by finite differences over a fraction of a pixel (Blender's node).
// Mikkelsen, "Bump mapping unparametrized surfaces on the GPU", 2010; differences as in Cycles: the height is evaluated at the point
// and one filter width along either step to the next pixel.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/input/bump.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/math/cycles-inl.h"
#include "nodes/math/finite-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Channels: strength 0, distance 1, filter width 2, height 3 here, 4 along x, 5 along y, normal 6, dPdx 9, dPdy 12.
template <bool invert>
struct Bump {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F strength = second_max(k.f(0), F(0)), width = k.f(2), height = k.f(3);
        const F distance = invert ? -k.f(1) : k.f(1);
        const Vec3<F> n = k.v(6), dpdx = k.v(9), dpdy = k.v(12);
        // Surface gradient: the two differences along directions within the surface that are dual to the steps.
        const Vec3<F> rx = cross(dpdy, n), ry = cross(n, dpdx);
        const F det = dot(dpdx, rx);
        const Vec3<F> gradient = finite_or_limit((k.f(4) - height) * rx + (k.f(5) - height) * ry);
        const F side = select(det < F(0), F(-1), F(1));
        // Halved before the difference, so that two limits do not overflow.
        const Vec3<F> upright = F(0.5) * finite_or_limit(width * abs(det) * n), tilt = F(0.5) * finite_or_limit(distance * side * gradient);
        const Vec3<F> bumped = safe_normalize_any(upright - tilt);
        const Vec3<F> blended = safe_normalize_any(strength * bumped + (F(1) - strength) * n);
        k.set(0, select<F>(is_zero(bumped) | is_zero(blended), n, blended));   // opposed normals cancel at strength 0.5
    }
};
template <class F>
void bump(const Call<F>& c) { c.template each<Bump<false>>(); }
template <class F>
void bump_inverted(const Call<F>& c) { c.template each<Bump<true>>(); }
ALDER_KERNEL(bump)
ALDER_KERNEL(bump_inverted)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "graph/lowering.h"

namespace alder {
ALDER_KERNEL_EXPORT(bump)
ALDER_KERNEL_EXPORT(bump_inverted)

enum { kStrength, kDistance, kFilterWidth, kHeight, kNormal, kInvert };

static void lower_bump(Lowering& l, int) {
    if (!l.linked(kHeight)) return l.result(l.input(kNormal));  // a constant height has no slope
    const ValueRef width = l.input(kFilterWidth);
    const ValueRef operands[] = {l.input(kStrength), l.input(kDistance), width, l.input(kHeight), l.displaced_input(kHeight, 1, width),
                                 l.displaced_input(kHeight, 2, width), l.input(kNormal), l.global(Global::Dpdx), l.global(Global::Dpdy)};
    const bool invert = l.statics().e(kInvert) != 0;
    l.result(l.op(invert ? "bump_inverted" : "bump", invert ? bump_inverted_kernel() : bump_kernel(), operands, Type::Vector));
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeBump";
    n.category = "Vector";
    n.summary = "tilts the normal by the slope of a height";
    n.help = "The height is evaluated three times. Filter Width is the step in pixels. Without a link to Height the normal stays as it is.";
    n.aliases = {"bump"};
    n.params.push_back(f("Strength", 1).range(0, 1));
    n.params.push_back(f("Distance", 0.00100000005).range(0, 1000).doc("height of 1 in scene units"));
    n.params.push_back(f("Filter Width", 0.100000001).range(0.001, 10).doc("step in pixels"));
    n.params.push_back(f("Height", 1).range(-1000, 1000));
    n.params.push_back(vector("Normal", 0, 0, 0).unlinked(Global::N));
    n.params.push_back(b("invert", false).no_link());
    n.outputs = {{"Normal", Type::Vector}};
    n.cost_ns = 6;
    n.lower = lower_bump;
    return n;
}
}  // namespace alder
#endif
