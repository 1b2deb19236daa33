// Emission of many points at once: runs emission programs (of meshes, lamps, the world) outside the path tracer's own batches.
#pragma once
#include <span>
#include <vector>

#include "render/light/lamp.h"
#include "render/programs.h"

namespace alder {

/// The shading point of a lamp's surface, seen from p.
ShadingPoint lamp_point(const Lamp& lamp, const LampSample& s, Vec3f p);
/// The shading point of the world in a direction: at infinity, where position and normal are directions.
ShadingPoint world_point(Vec3f direction);
/// Sum of a program's emission lobes at point i of the batch run last.
Vec3f emission_of(const Program& program, const Executor<float>& executor, size_t i);

/// Owned by one thread.
class EmissionEvaluator {
  public:
    EmissionEvaluator(const InputScene& scene, const EvalContext& context) : scene_(scene), executor_(context) {}
    /// Rays are those of light sampling: no kind, one bounce deep.
    std::vector<Vec3f> operator()(const SceneProgram& program, std::span<const ShadingPoint> points);

  private:
    InputScene scene_;
    Executor<float> executor_;
    InputGather gather_;
};

}  // namespace alder
