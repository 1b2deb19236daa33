// Program inputs: gathers, for a batch of shading points, exactly the globals and attributes that a program reads.
//
// InputPlan is made once per program and scene (attribute names become pointers); InputGather belongs to one thread and owns
// the channels' memory.
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "graph/program.h"
#include "render/camera.h"
#include "render/geometry/mesh_build.h"
#include "render/geometry/surface.h"

namespace alder {

/// Kinds of a ray, one bit each: the answers of the Light Path node.
enum RayKind : uint32_t {
    kRayCamera = 1, kRayShadow = 2, kRayDiffuse = 4, kRayGlossy = 8, kRaySingular = 16, kRayReflection = 32,
    kRayTransmission = 64, kRayVolume = 128
};

/// What a path has been through on its way to a point.
struct RayHistory {
    Vec3f origin, direction;
    uint32_t kinds = kRayCamera;
    uint16_t depth = 0, diffuse = 0, glossy = 0, transmission = 0, transparent = 0, volume = 0;
    float previous_alpha = 0;  ///< width of the lobe that cast the ray (alShaders' roughness message)
    float time = 0.5f;         ///< of the shutter, 0..1
};

/// What inputs depend on besides the points.
struct InputScene {
    const Surfaces* surfaces = nullptr;
    const CameraModel* camera = nullptr;
    std::span<const int> material_pass_index;  ///< by index into Scene::materials
};

class InputPlan {
  public:
    /// in_volume: points lie within bodies, where only attributes of the whole mesh have a value.
    InputPlan(const Program& program, const Surfaces& surfaces, bool in_volume = false);
    /// What of an attribute is read, by the suffix of its name (nodes/input/attribute.cpp).
    enum class Part : uint8_t {
        Value,
        Exists,       ///< ".exists": whether the mesh has it
        Alpha,        ///< ".alpha": fourth component, else 1
        Tangent,      ///< ".tangent" of a UV map: as stored, object space
        TangentSign,  ///< ".tangent_sign"
        Instance,       ///< "scene:instance" (nodes/input/scene_query.h); negative: none
        PositionError,  ///< "scene:position_error"
        StepX,        ///< ":dx": change from pixel to pixel in x (alTriplanar)
        StepY,        ///< ":dy"
        // What curves and spheres know of themselves (nodes/input/particle_info.cpp); zero elsewhere
        IsStrand, Intercept, CurveLength, Thickness, TangentNormal, CurveRandom, SpherePosition, SphereRadius, SphereRandom,
    };
    struct Entry {
        ProgramInput input;
        std::vector<const Attribute*> attribute_by_mesh;
        Part part = Part::Value;
        /// Tangents of UV maps that are not the active one; null: the mesh's own tangents serve.
        std::vector<std::shared_ptr<const Tangents>> tangents_by_mesh;
    };
    const std::vector<Entry>& entries() const { return entries_; }
    int channels() const { return channels_; }

  private:
    std::vector<Entry> entries_;
    int channels_ = 0;
};

class InputGather {
  public:
    /// Channels for points[0..n). history[i] belongs to points[i]. Valid until the next call.
    std::span<const Channel<float>> gather(const InputPlan& plan, const InputScene& scene, std::span<const ShadingPoint> points,
                                           const RayHistory* const* history);

  private:
    struct Fill;
    std::vector<float> memory_;
    std::vector<Channel<float>> channels_;
    std::vector<InstanceFrame> moved_;  ///< by point, where something of the batch moves
};

}  // namespace alder
