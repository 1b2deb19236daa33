// LightTable: every emitter of a scene and the choice among them: lamps, the world, and mesh triangles that emit.
//
// The choice among emitters is LightSelector's. Immutable, thread safe.
#pragma once
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "render/box_index.h"
#include "render/geometry/surface.h"
#include "render/light/environment.h"
#include "render/light/lamp.h"
#include "render/light/selector.h"
#include "render/programs.h"

namespace alder {

/// The world's emission.
struct WorldLight {
    std::shared_ptr<const SceneProgram> program;  ///< null: constant
    Vec3f constant{0, 0, 0};
    EnvironmentMap map;  ///< usable where the world is sampled
    int light_group = 0;
    uint32_t visibility = kVisibleAll;
    std::shared_ptr<const SceneProgram> volume;  ///< what fills the world; null: nothing
    bool is_black() const { return !program && constant.x == 0 && constant.y == 0 && constant.z == 0; }
};
/// Evaluates the world on a grid (in parallel) unless it is constant. Faults of the graph are in `d`.
std::shared_ptr<const WorldLight> build_world(const World& world, const Surfaces& surfaces, const CameraModel& camera,
                                              const EvalContext& context, Diagnostics& d);

struct LightSample {
    Vec3f wi{0, 0, 1};
    float distance = 0;        ///< infinite for suns and the world
    float pdf = 0;             ///< by solid angle, choice of the emitter included
    bool is_delta = false;     ///< cannot be met by a scattered ray
    Vec3f radiance{0, 0, 0};   ///< to be multiplied by the program's emission, if there is one
    const SceneProgram* program = nullptr;
    ShadingPoint point;        ///< on the emitter; for the program and for the end of the shadow ray
    int light_group = 0;
    uint32_t visibility = kVisibleAll;
    bool cast_shadow = true;
};

class LightTable {
  public:
    LightTable(const Surfaces& surfaces, std::span<const std::shared_ptr<const MaterialPrograms>> materials,
               std::span<const Light> lights, std::span<const std::shared_ptr<const SceneProgram>> light_programs,
               std::shared_ptr<const WorldLight> world, const CameraModel& camera, const EvalContext& context);

    bool empty() const { return emitters_.empty(); }
    /// Chooses an emitter and a direction to it from p. False: none.
    bool sample(Vec3f p, float u_pick, float u1, float u2, float time, LightSample& s) const;

    /// Density with which sample(origin) would have chosen the direction to this point of a mesh; 0 where it emits nothing.
    float mesh_pdf(Vec3f origin, const ShadingPoint& hit) const;
    float world_pdf(Vec3f origin, Vec3f direction) const;
    /// The same from the density of a lamp's own sampling.
    float lamp_pdf(Vec3f origin, uint32_t lamp, float own_pdf) const;

    bool has_visible_lamps() const { return !visible_.empty(); }
    /// Lamps that the ray may meet, ascending; `found` is memory for them.
    std::span<const uint32_t> lamps_along(const Ray& ray, std::vector<uint32_t>& found) const;
    const Lamp& lamp(uint32_t i) const { return lamps_[i]; }
    const SceneProgram* lamp_program(uint32_t i) const { return lamp_programs_[i].get(); }
    const WorldLight& world() const { return *world_; }
    size_t emitter_count() const { return emitters_.size(); }

  private:
    enum class Kind : uint8_t { Lamp, World, Mesh };
    struct Emitter {
        Kind kind;
        uint32_t index;
    };
    static constexpr uint32_t kNotSampled = ~uint32_t{0};
    /// The triangles of one instance that have one emitting material.
    struct MeshEmitter {
        uint32_t instance;
        const MaterialPrograms* material;
        std::vector<uint32_t> triangles;
        std::vector<float> cdf;  ///< triangles + 1
    };
    void add(Kind kind, size_t index, const EmitterBounds& bounds);
    void add_meshes(const CameraModel& camera, const EvalContext& context, std::span<const std::shared_ptr<const MaterialPrograms>> materials);
    void add_mesh_emitter(MeshEmitter e, const std::vector<float>& areas, const std::vector<float>& brightness);
    EmitterBounds bounds_of(const MeshEmitter& e, double power) const;
    bool sample_mesh(const MeshEmitter& e, Vec3f p, float u_pick, float u1, float u2, float time, LightSample& s) const;

    const Surfaces* surfaces_;
    std::vector<Lamp> lamps_;
    std::vector<std::shared_ptr<const SceneProgram>> lamp_programs_;
    std::shared_ptr<const WorldLight> world_;
    std::vector<MeshEmitter> meshes_;
    std::vector<Emitter> emitters_;
    LightSelector selector_;
    std::vector<uint32_t> visible_;         ///< lamps that a ray can meet
    std::optional<BoxIndex> visible_boxes_; ///< of those with a place, where they are many
    std::vector<uint32_t> visible_local_, visible_suns_;
    std::vector<uint32_t> lamp_emitter_;  ///< by lamp: index into emitters_, or kNotSampled
    uint32_t world_emitter_ = kNotSampled;
    /// Of a triangle: its emitter, and the density by area once that is chosen.
    struct TriangleDensity {
        uint32_t emitter = kNotSampled;
        float density = 0;
    };
    std::vector<std::vector<TriangleDensity>> area_density_;  ///< by instance; empty where it does not emit
    float scene_radius_ = 1;
    std::vector<EmitterBounds> bounds_;  ///< while building
};

}  // namespace alder
