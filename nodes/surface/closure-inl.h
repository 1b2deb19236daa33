// What the kernels of Cycles' closure nodes share: writing lobes, the normal that reflections need, tangents.
#if defined(ALDER_NODES_SURFACE_CLOSURE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_SURFACE_CLOSURE_INL_H_
#undef ALDER_NODES_SURFACE_CLOSURE_INL_H_
#else
#define ALDER_NODES_SURFACE_CLOSURE_INL_H_
#endif

#include "nodes/kernel-inl.h"
#include "nodes/surface/energy-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Cycles drops closures whose mean weight is below this.
inline constexpr double kWeightCutoff = 1e-5;

template <class F>
HWY_INLINE Vec3<F> max0(Vec3<F> v) { return {max(v.x, F(0)), max(v.y, F(0)), max(v.z, F(0))}; }
template <class F>
HWY_INLINE Vec3<F> min1(Vec3<F> v) { return {min(v.x, F(1)), min(v.y, F(1)), min(v.z, F(1))}; }
template <class F>
HWY_INLINE Vec3<F> saturate(Vec3<F> v) { return {saturate(v.x), saturate(v.y), saturate(v.z)}; }

/// Where a lobe of this weight exists (false for NaN), its weight with negative channels cut off being `w`.
template <class F>
HWY_INLINE Mask<F> kept(Vec3<F> w) { return (w.x + w.y + w.z) * F(1.0 / 3) >= F(kWeightCutoff); }
/// The weight of a lobe as Cycles allocates it: 0 where it is dropped.
template <class F>
HWY_INLINE Vec3<F> allocate(Vec3<F> w) {
    w = max0(w);
    return select(kept(w), w, Vec3<F>(F(0)));
}

/// Output channels of lobe `index` of the node's set.
template <class F>
struct LobeOut {
    const Lanes<F>& k;
    const LobeSpec& spec;
    int first;
    HWY_INLINE LobeOut(const Lanes<F>& lanes, int index)
        : k(lanes), spec(lanes.statics().lobes[index]), first(lanes.statics().lobe_offset[index]) {}
    HWY_INLINE bool wanted() const { return k.wants(first) || k.wants(first + 1) || k.wants(first + 2); }
    HWY_INLINE void weight(Vec3<F> w) const { k.set(first, w); }
    HWY_INLINE void normal(Vec3<F> n) const { k.set(first + 3, n); }
    HWY_INLINE void tangent(Vec3<F> t) const {
        if (spec.has_tangent()) k.set(first + 6, t);
    }
    HWY_INLINE void param(int i, F x) const { k.set(first + (spec.has_tangent() ? 9 : 6) + i, x); }
    HWY_INLINE void param(int i, Vec3<F> x) const {
        for (int c = 0; c < 3; ++c) param(i + c, x[c]);
    }
};

/// A Normal socket: unit length; the surface's own normal where it is zero.
template <class F>
HWY_INLINE Vec3<F> socket_normal(Vec3<F> n, Vec3<F> surface) {
    const F l = length(n);
    const Mask<F> usable = l != F(0);
    return select(usable, n * (F(1) / select(usable, l, F(1))), surface);
}

/// Tilts n towards ng until the mirrored view direction is just above the surface (Cycles' ensure_valid_specular_reflection):
/// n' = sqrt(1-z²) x + z ng, x the direction of n in the surface, 4 a z⁴ - 2 b z² + c = 0.
template <class F>
HWY_INLINE Vec3<F> reflecting_normal(Vec3<F> n, Vec3<F> ng, Vec3<F> view) {
    const F vz = dot(view, ng);
    const Vec3<F> r = n * (F(2) * dot(n, view)) - view;
    const F t = min(F(0.9) * vz, F(0.01));
    const Mask<F> tilt = dot(ng, r) < t;
    if (!any(tilt)) return n;
    const Vec3<F> x = socket_normal(n - ng * dot(n, ng), n);
    const F vx = dot(view, x);
    const F a = max(vx * vx + vz * vz, F(1e-20)), b = F(2) * (a + vz * t), c = sqr(t + vz);
    const F root = safe_sqrt(b * b - F(4) * a * c);
    const F z2 = F(0.25) * (b + select(vx < F(0), root, -root)) / a;
    return select(tilt, x * safe_sqrt(F(1) - z2) + ng * safe_sqrt(z2), n);
}

/// p turned about a unit axis.
template <class F>
HWY_INLINE Vec3<F> rotated(Vec3<F> p, Vec3<F> axis, F turns) {
    const F angle = turns * F(6.28318530717958648);
    const F c = cos(angle), s = sin(angle);
    return p * c + cross(axis, p) * s + axis * (dot(axis, p) * (F(1) - c));
}

/// Widths of the Principled and Metallic BSDFs: alpha = roughness², stretched by anisotropy.
template <class F>
struct StretchedWidths {
    F x, y;
    HWY_INLINE StretchedWidths(F roughness, F anisotropy) {
        const F alpha = sqr(roughness), aspect = sqrt(F(1) - F(0.9) * anisotropy);
        x = min(alpha / aspect, F(1));
        y = alpha * aspect;
    }
};

/// Emits width(s) of a microfacet lobe.
template <class F>
HWY_INLINE void emit_widths(const LobeOut<F>& out, const MicrofacetLayout& at, F x, F y) {
    out.param(at.alpha_x, x);
    if (at.alpha_y != at.alpha_x) out.param(at.alpha_y, y);
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
