// Lanes of a kernel as the points of nodes/input/scene_query.h.
#if defined(ALDER_NODES_INPUT_SCENE_QUERY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_INPUT_SCENE_QUERY_INL_H_
#undef ALDER_NODES_INPUT_SCENE_QUERY_INL_H_
#else
#define ALDER_NODES_INPUT_SCENE_QUERY_INL_H_
#endif

#include "nodes/input/scene_query.h"
#include "nodes/kernel-inl.h"
#include "nodes/noise/hash-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

// Channels of the surface that kernels with rays end with, from `first`: P 0, Ng 3, N 6, I 9, instance 12, position error 13, backfacing 14.
enum { kSurfaceChannels = 15 };

/// Lanes of the surface channels in memory, and one lane of them as a point.
template <class F>
struct PointLanes {
    alignas(64) float v[kSurfaceChannels][kMostLanes<F>];
    alignas(64) int32_t seed[kMostLanes<F>];

    HWY_INLINE void load(Lanes<F> k, int first) {
        for (int c = 0; c < kSurfaceChannels; ++c) store_floats(k.f(first + c), v[c]);
        // Random by where the point is and whence it is seen: the same for any thread, another for every sample of a pixel.
        const Vec3<F> p = k.v(first), i = k.v(first + 9);
        const Int<F> h = hash_uint4(float_bits(p.x), float_bits(p.y), float_bits(p.z), float_bits(i.x));
        store_ints<F>(hash_uint3(h, float_bits(i.y), float_bits(i.z)), seed);
    }
    HWY_INLINE SceneQuery::Point point(size_t lane) const {
        SceneQuery::Point r;
        for (int c = 0; c < 3; ++c) {
            r.p[c] = v[c][lane];
            r.ng[c] = v[3 + c][lane];
            r.n[c] = v[6 + c][lane];
        }
        r.instance = v[12][lane] >= 0 && v[12][lane] < 16777216 ? static_cast<int>(v[12][lane]) : -1;
        r.position_error = v[13][lane];
        r.backfacing = v[14][lane] != 0;
        r.seed = static_cast<uint32_t>(seed[lane]);
        return r;
    }
    static HWY_INLINE size_t count(Lanes<F> k) {
        const size_t width = NumOf<F>::width();
        return k.i + width <= k.call.n ? width : k.call.n - k.i;
    }
};

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
