// True displacement: meshes whose vertices their materials' displacement moves, before anything else is built from them.
#pragma once
#include <memory>
#include <vector>

#include "render/scene.h"

namespace alder {

/// Whether a material moves vertices.
bool displaces(const SceneMaterial& material);
/// Puts displaced copies in place of the meshes of instances whose materials displace: one for each mesh with its materials, moved as
/// the first instance that shows it is (Cycles). Faults of programs are in `d`.
void displace(const Scene& scene, const EvalContext& context, std::vector<std::shared_ptr<const Mesh>>& meshes, std::vector<Instance>& instances,
              Diagnostics& d);

}  // namespace alder
