// Points, directions and normals between spaces, from the columns of an affine matrix.
#if defined(ALDER_NODES_INPUT_SPACE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_INPUT_SPACE_INL_H_
#undef ALDER_NODES_INPUT_SPACE_INL_H_
#else
#define ALDER_NODES_INPUT_SPACE_INL_H_
#endif

#include "nodes/kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

template <class F>
struct Matrix3 {
    Vec3<F> x, y, z;
    HWY_INLINE Vec3<F> apply(Vec3<F> v) const { return x * v.x + y * v.y + z * v.z; }
    /// Transposed matrix times v: of an inverse matrix, the transform of a normal.
    HWY_INLINE Vec3<F> transposed(Vec3<F> v) const { return {dot(x, v), dot(y, v), dot(z, v)}; }
    HWY_INLINE Matrix3 inverse() const {
        const Vec3<F> a = cross(y, z), b = cross(z, x), c = cross(x, y);  // rows of the inverse, times the determinant
        const F determinant = dot(x, a), scale = F(1) / select(determinant != F(0), determinant, F(1));   // what has no inverse: finite
        return {Vec3<F>(a.x, b.x, c.x) * scale, Vec3<F>(a.y, b.y, c.y) * scale, Vec3<F>(a.z, b.z, c.z) * scale};
    }
};
/// Three columns, nine channels from `channel` on.
template <class F>
HWY_INLINE Matrix3<F> matrix3(Lanes<F> k, int channel) { return {k.v(channel), k.v(channel + 3), k.v(channel + 6)}; }

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
