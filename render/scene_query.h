// SurfaceQuery: answers what shading nodes ask of the surfaces around a point, with rays.
#pragma once
#include "nodes/input/scene_query.h"
#include "render/geometry/surface.h"

namespace alder {

/// Immutable; thread safe. The surfaces outlive it.
class SurfaceQuery final : public SceneQuery {
  public:
    explicit SurfaceQuery(const Surfaces& surfaces) : surfaces_(surfaces) {}
    float unoccluded(const Point& point, const float normal[3], float distance, int samples, bool only_local) const override;
    void bevel(const Point& point, float radius, int samples, float normal[3]) const override;
    bool curvature(const Point& point, const float view[3], float radius, int side, float& value) const override;

  private:
    const Surfaces& surfaces_;
};

}  // namespace alder
