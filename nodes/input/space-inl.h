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
};
/// Three columns, nine channels from `channel` on.
template <class F>
HWY_INLINE Matrix3<F> matrix3(Lanes<F> k, int channel) { return {k.v(channel), k.v(channel + 3), k.v(channel + 6)}; }

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
