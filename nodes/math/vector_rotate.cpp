// Vector Rotate: turns a vector about a centre, by an axis and an angle or by Euler angles (Blender's node).
// Rotation about an axis: Rodrigues' formula.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/math/vector_rotate.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/math/cycles-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

template <class F>
HWY_INLINE Vec3<F> rotate_about(Vec3<F> p, Vec3<F> axis, F angle_rad) {
    const F c = cos(angle_rad), s = sin(angle_rad), m = F(1) - c;
    return {(c + m * axis.x * axis.x) * p.x + (m * axis.x * axis.y - axis.z * s) * p.y + (m * axis.x * axis.z + axis.y * s) * p.z,
            (m * axis.x * axis.y + axis.z * s) * p.x + (c + m * axis.y * axis.y) * p.y + (m * axis.y * axis.z - axis.x * s) * p.z,
            (m * axis.x * axis.z - axis.y * s) * p.x + (m * axis.y * axis.z + axis.x * s) * p.y + (c + m * axis.z * axis.z) * p.z};
}

/// Channels: vector 0, centre 3, axis 6, angle 9, Euler angles 10. kind: 0 any axis, 1 ... 3 X, Y, Z. A zero axis leaves the vector.
template <int kind, bool invert>
struct RotateAxis {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> v = k.v(0), center = k.v(3);
        const F angle = invert ? -k.f(9) : k.f(9);
        if constexpr (kind == 0) {
            const Vec3<F> axis = k.v(6);
            const F l = length(axis);
            k.set(0, select<F>(l != F(0), rotate_about(v - center, axis / l, angle) + center, v));
        } else {
            const Vec3<F> axis(F(kind == 1 ? 1 : 0), F(kind == 2 ? 1 : 0), F(kind == 3 ? 1 : 0));
            k.set(0, rotate_about(v - center, axis, angle) + center);
        }
    }
};
template <bool invert>
struct RotateEuler {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> center = k.v(3), p = k.v(0) - center;
        const Rotation<F> r(k.v(10));
        k.set(0, (invert ? r.apply_inverse(p) : r.apply(p)) + center);
    }
};
template <class F, bool invert>
HWY_INLINE void vector_rotate_dispatch(const Call<F>& c) {
    switch (c.statics().e(5)) {
        case 0: return c.template each<RotateAxis<0, invert>>();
        case 1: return c.template each<RotateAxis<1, invert>>();
        case 2: return c.template each<RotateAxis<2, invert>>();
        case 3: return c.template each<RotateAxis<3, invert>>();
        default: return c.template each<RotateEuler<invert>>();
    }
}
template <class F>
void vector_rotate(const Call<F>& c) {
    if (c.statics().e(6)) vector_rotate_dispatch<F, true>(c);
    else vector_rotate_dispatch<F, false>(c);
}
ALDER_KERNEL(vector_rotate)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(vector_rotate)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeVectorRotate";
    n.category = "Vector";
    n.summary = "turns a vector about a centre";
    n.help = "Angles are in radians. A zero axis leaves the vector as it is.";
    n.aliases = {"vector_rotate"};
    n.params.push_back(vector("Vector", 0, 0, 0));
    n.params.push_back(vector("Center", 0, 0, 0));
    n.params.push_back(vector("Axis", 0, 0, 1).range(-1, 1));
    n.params.push_back(f("Angle", 0).doc("radians"));
    n.params.push_back(vector("Rotation", 0, 0, 0).doc("Euler angles XYZ, radians"));
    n.params.push_back(choice("rotation_type",
                              std::vector<Item>{{"AXIS_ANGLE", "Axis Angle", "axis"}, {"X_AXIS", "X Axis", "x_axis"}, {"Y_AXIS", "Y Axis", "y_axis"},
                                                {"Z_AXIS", "Z Axis", "z_axis"}, {"EULER_XYZ", "Euler", "euler_xyz"}},
                              "AXIS_ANGLE").alias("rotate_type"));
    n.params.push_back(b("invert", false).no_link());
    n.outputs = {{"Vector", Type::Vector}};
    n.kernel = vector_rotate_kernel();
    n.cost_ns = 10;
    n.uses = [](const Statics& s, int param) {
        const int type = s.e(5);
        return param == 2 ? type == 0 : param == 3 ? type != 4 : param == 4 ? type == 4 : true;
    };
    return n;
}
}  // namespace alder
#endif
