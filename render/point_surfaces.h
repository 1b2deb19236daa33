// The mesh of an evaluation request as surfaces that rays can meet, for nodes that look around themselves.
#pragma once
#include <memory>

#include "graph/points.h"
#include "render/scene_query.h"

namespace alder {

/// Immutable; thread safe.
class PointSurfaces {
  public:
    /// Null where the program reads nothing of the scene or the points lie on no mesh.
    static std::unique_ptr<PointSurfaces> make(const Program* program, const PointSet& points);
    const SceneQuery& query() const { return query_; }

  private:
    explicit PointSurfaces(std::shared_ptr<const Mesh> mesh);
    Surfaces surfaces_;
    SurfaceQuery query_;
};

}  // namespace alder
