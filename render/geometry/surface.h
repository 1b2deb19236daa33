// Surfaces: the meshes and instances of a scene with all that a hit needs, and the shading point derived from a hit.
//
// Immutable after construction apart from tables made on first use (tangents, islands, pointiness); thread safe; shared by
// scene revisions that differ in materials only.
#pragma once
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "render/accel.h"
#include "render/geometry/curves.h"
#include "render/geometry/motion.h"
#include "render/scene.h"

namespace alder {

/// Tables that few programs read: made when the first one asks.
class MeshTables {
  public:
    explicit MeshTables(std::shared_ptr<const Mesh> mesh) : mesh_(std::move(mesh)) {}
    struct TangentTable {
        std::vector<Vec3f> tangents;  ///< per corner, object space
        std::vector<float> signs;
    };
    const TangentTable& tangents() const;
    /// One number in 0..1 per triangle: the same over a connected part.
    const std::vector<float>& island_random() const;
    /// Per point, 0 concave .. 0.5 flat .. 1 convex.
    const std::vector<float>& pointiness() const;
    const ThreadTable& curves() const;

  private:
    std::shared_ptr<const Mesh> mesh_;
    mutable std::once_flag tangents_once_, islands_once_, pointiness_once_, curves_once_;
    mutable TangentTable tangents_;
    mutable std::vector<float> islands_, pointiness_;
    mutable ThreadTable curves_;
};

struct InstanceFrame {
    Transform object_to_world, world_to_object;
    std::array<float, 9> normal_to_world{};  ///< inverse transpose, row major
    float position_error = 0;                ///< rounding of a position through these matrices, relative to the mesh: see surface.cpp
    float stretch = 1;                       ///< largest row sum of the linear part
    Vec3f normal(Vec3f n) const {
        const auto& m = normal_to_world;
        return {m[0] * n.x + m[1] * n.y + m[2] * n.z, m[3] * n.x + m[4] * n.y + m[5] * n.z, m[6] * n.x + m[7] * n.y + m[8] * n.z};
    }
};

/// A point to be shaded. Normals are turned towards wo; `wo` points against the ray.
struct ShadingPoint {
    Vec3f p, ng, n, wo;
    float u = 0, v = 0;          ///< barycentrics as in Hit
    uint32_t instance = kNothing, triangle = 0;  ///< triangle kNothing: a point within the instance
    float time = 0.5f;           ///< of the shutter
    float distance = 0;          ///< along the ray
    float footprint = 0;         ///< half a pixel's width here (ray cone radius)
    float error = 0;             ///< bound of the rounding error of p, world units
    bool backfacing = false;
    const InstanceFrame* lamp = nullptr;  ///< of a point on a lamp: the lamp's space
};
/// What follows from an object's or a lamp's matrix.
InstanceFrame frame_of(const Transform& object_to_world);

class Surfaces {
  public:
    /// `previous`: what it made of meshes that are here too (normals, tables, BVH) is shared.
    Surfaces(std::vector<std::shared_ptr<const Mesh>> meshes, std::vector<Instance> instances, const Surfaces* previous = nullptr);

    const std::vector<Instance>& instances() const { return instances_; }
    const std::vector<std::shared_ptr<const Mesh>>& meshes() const { return meshes_; }
    /// At rest, or as it stands at its frame's time.
    const InstanceFrame& frame(uint32_t instance) const { return frames_[instance]; }
    bool moves(uint32_t instance) const { return !motion_[instance].empty(); }
    /// Whether anything depends on time.
    bool anything_moves() const { return anything_moves_; }
    InstanceFrame frame_at(uint32_t instance, float time) const;
    const Mesh& mesh_of(uint32_t instance) const { return *meshes_[instances_[instance].mesh]; }
    const MeshTables& tables_of(uint32_t instance) const { return *tables_[instances_[instance].mesh]; }
    const Accel& accel() const { return accel_; }
    /// Whether it was made of just these meshes.
    bool are_made_of(const std::vector<std::shared_ptr<const Mesh>>& meshes) const { return meshes == sources_; }

    /// Index into Scene::materials.
    uint32_t material(uint32_t instance, uint32_t triangle) const {
        const Instance& i = instances_[instance];
        const Mesh& m = *meshes_[i.mesh];
        if (i.materials.size() == 1 || m.face_material.empty()) return i.materials[0];
        return i.materials[std::min<size_t>(m.face_material[triangle], i.materials.size() - 1)];
    }
    /// All but `footprint`.
    ShadingPoint point(uint32_t instance, uint32_t triangle, float u, float v, Vec3f direction, float distance, float time = 0.5f) const;
    /// Corners in world space; the mesh must be one of triangles.
    std::array<Vec3f, 3> world_triangle(uint32_t instance, uint32_t triangle, float time = 0.5f) const;
    /// Point of a curve's axis, in object space.
    CurvePoint curve_point(uint32_t instance, uint32_t segment, float u, float time) const;

  private:
    void triangle_point(const Mesh& mesh, const InstanceFrame& frame, ShadingPoint& s) const;
    void thread_point(const Mesh& mesh, const InstanceFrame& frame, ShadingPoint& s) const;
    std::vector<std::shared_ptr<const Mesh>> sources_;  ///< as they were given, before normals
    std::vector<std::shared_ptr<const Mesh>> meshes_;
    std::vector<std::shared_ptr<const MeshTables>> tables_;
    std::vector<Instance> instances_;
    std::vector<InstanceFrame> frames_;
    std::vector<std::vector<MotionKey>> motion_;  ///< by instance; empty: at rest
    bool anything_moves_ = false;
    Accel accel_;
};

/// Start of a ray that leaves `point` on the side of `direction`, clear of the surface by its rounding error.
inline Vec3f leave_surface(const ShadingPoint& point, Vec3f direction) {
    const Vec3f step = point.ng * point.error;
    return dot(point.ng, direction) < 0 ? point.p - step : point.p + step;
}

}  // namespace alder
