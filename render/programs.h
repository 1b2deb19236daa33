// Programs of a scene's materials: what the renderer runs at a surface, at a shadow ray, and to find out what a light emits.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "render/inputs.h"
#include "render/scene.h"

namespace alder {

/// A program with its inputs resolved against the scene's meshes.
struct SceneProgram {
    std::shared_ptr<const Program> program;
    InputPlan plan;
};

struct MaterialPrograms {
    SceneMaterial material;
    std::shared_ptr<const SceneProgram> surface;   ///< all lobes; null: the surface absorbs everything
    std::shared_ptr<const SceneProgram> shadow;    ///< null: opaque to shadow rays
    std::shared_ptr<const SceneProgram> emission;  ///< null: emits nothing
    std::shared_ptr<const SceneProgram> volume;    ///< what lies within; null: nothing
    bool boundary_only = false;                    ///< no surface, but a volume: rays go through
    bool emission_constant = false;
    Vec3f emission_value{0, 0, 0};
};

/// Faults are in `d`, with the material's name as the pointer's prefix; null then.
std::shared_ptr<const MaterialPrograms> compile_material(const SceneMaterial& material, const Surfaces& surfaces, const RenderSettings& settings,
                                                         Diagnostics& d);
/// The surface program that also computes AOVs (names the material does not have are left out of `present`).
std::shared_ptr<const SceneProgram> compile_with_aovs(const SceneMaterial& material, const Surfaces& surfaces, const RenderSettings& settings,
                                                      const std::vector<std::string>& names, std::vector<std::string>& present);

/// Files of the scene's graphs that are missing or broken, as errors: for renders that are to be strict.
void require_files(const Scene& scene, Diagnostics& d);

}  // namespace alder
