// Accel: which surface a ray meets first, and whether anything stands between two points. A thin wrapper around Embree: only
// accel.cpp and box_index.cpp include its headers, and nothing uses what Embree 4 removed (streams).
//
// Built once per set of meshes and instances, immutable afterwards, shared by scene revisions and by threads.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "render/scene.h"

namespace alder {

inline constexpr uint32_t kNothing = ~uint32_t{0};
struct Ray {
    Vec3f origin, direction;
    float t_min = 0, t_max = 0;
    float time = 0.5f;  ///< of the shutter, 0..1
    /// The thread or ball that the ray leaves, which it does not meet: threads are thinner than any safe distance from them.
    uint32_t self_instance = kNothing, self_primitive = kNothing;
};

struct Hit {
    float t = 0, u = 0, v = 0;  ///< barycentrics of the triangle's second and third corner; on threads and balls see geometry/curves.h
    uint32_t instance = kNothing, triangle = kNothing;  ///< `triangle`: index of the primitive, whatever its shape
    bool valid() const { return instance != kNothing; }
};

/// Decides for a surface that a shadow ray meets whether light may come through it.
struct ShadowFilter {
    virtual bool may_pass(uint32_t instance, uint32_t triangle) const = 0;

  protected:
    ~ShadowFilter() = default;
};

enum class Occlusion : uint8_t {
    Clear,
    Blocked,
    Filtered  ///< nothing opaque, but surfaces for which ShadowFilter::may_pass
};

class Accel {
  public:
    /// `previous`: what it built of meshes that are here too is shared; only what lies above them is built again.
    Accel(const std::vector<std::shared_ptr<const Mesh>>& meshes, const std::vector<Instance>& instances, const Accel* previous = nullptr);
    ~Accel();
    Accel(const Accel&) = delete;
    Accel& operator=(const Accel&) = delete;

    /// Nearest hit with t in (t_min, t_max] of instances visible to rays of this kind (RayVisibility bits).
    bool intersect(const Ray& ray, uint32_t visibility, Hit& hit) const;
    /// Nearest hit within one instance, whatever else is in the way and whoever may see it.
    bool intersect_instance(uint32_t instance, const Ray& ray, Hit& hit) const;
    /// Whether something that casts shadows lies in between. filter null: everything is opaque.
    Occlusion occluded(const Ray& ray, const ShadowFilter* filter) const;

    double build_seconds() const { return build_seconds_; }
    size_t meshes_built() const { return meshes_built_; }
    Vec3f bounds_min() const { return bounds_min_; }
    Vec3f bounds_max() const { return bounds_max_; }

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
    double build_seconds_ = 0;
    size_t meshes_built_ = 0;
    Vec3f bounds_min_{0, 0, 0}, bounds_max_{0, 0, 0};
};

}  // namespace alder
