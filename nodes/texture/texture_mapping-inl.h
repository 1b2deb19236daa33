// Applies a texture node's built-in placement (texture_mapping.h) to its Vector.
#if defined(ALDER_NODES_TEXTURE_TEXTURE_MAPPING_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_TEXTURE_TEXTURE_MAPPING_INL_H_
#undef ALDER_NODES_TEXTURE_TEXTURE_MAPPING_INL_H_
#else
#define ALDER_NODES_TEXTURE_TEXTURE_MAPPING_INL_H_
#endif

#include "nodes/kernel-inl.h"
#include "nodes/texture/texture_mapping.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

template <class F>
HWY_INLINE Vec3<F> apply_mapping(const TextureMapping& m, Vec3<F> v) {
    Vec3<F> r;
    for (int i = 0; i < 3; ++i) {
        const float* const row = m.matrix[i];
        r[i] = mad(v.x, F(row[0]), mad(v.y, F(row[1]), mad(v.z, F(row[2]), F(row[3]))));
    }
    return m.normalize ? safe_normalize(r) : r;
}

/// The node's Vector (at `channel`) with the placement applied, where there is one.
template <class F>
HWY_INLINE Vec3<F> mapped_vector(const Lanes<F>& k, int channel) {
    const auto* const prepared = static_cast<const PreparedTexture*>(k.statics().prepared.get());
    const Vec3<F> v = k.v(channel);
    return prepared && prepared->mapping.active ? apply_mapping(prepared->mapping, v) : v;
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
