// What a PointSet holds after parsing, and how globals follow from it. Private to points*.cpp.
#pragma once
#include <map>

#include "graph/point_mesh.h"
#include "graph/points.h"

namespace alder {

/// Affine matrix: columns x, y, z and translation t.
struct PointMatrix {
    Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, t{0, 0, 0};
    Vec3d vector(Vec3d v) const { return x * v.x + y * v.y + z * v.z; }
    Vec3d point(Vec3d p) const { return vector(p) + t; }
    /// Transposed 3x3 times v: with the inverse matrix, the transform of a normal.
    Vec3d transposed(Vec3d v) const { return {dot(x, v), dot(y, v), dot(z, v)}; }
    double determinant() const { return dot(x, cross(y, z)); }
    /// All zero where the matrix is singular.
    PointMatrix inverse() const;
};

struct PointField {
    int channels = 1;
    bool per_point = false;
    std::vector<float> values;
    double at(uint32_t i, int c) const { return values[(per_point ? size_t{i} : 0) * channels + c]; }
    Vec3d vec(uint32_t i) const { return {at(i, 0), channels > 1 ? at(i, 1) : 0, channels > 2 ? at(i, 2) : 0}; }
};

struct PointCamera {
    bool present = false, orthographic = false, has_view = false;
    PointMatrix to_world, from_world;  ///< Cycles' camera space: looks along +Z
    double half_width = 1, half_height = 1;  ///< of the view at depth 1 (perspective) or of the view (orthographic)
    double width_pixels = 1, height_pixels = 1;
    double clip_start = 0.1;
    double pixel_footprint = -1;  ///< negative: derived
};

struct PointData {
    uint32_t count = 0;
    bool world = false;
    std::map<std::string, PointField, std::less<>> fields, attributes;
    PointMatrix object_to_world, world_to_object;
    /// Where Po lives: the object itself, or a reference object that the request names (Texture Coordinate's Object output).
    PointMatrix reference_to_world, world_to_reference;
    bool has_reference = false;
    PointCamera camera;
    std::string ray = "camera";
    std::shared_ptr<const PointMesh> mesh;

    const PointField* field(std::string_view name) const {
        const auto it = fields.find(name);
        return it == fields.end() ? nullptr : &it->second;
    }
    std::string active_uv() const { return mesh ? mesh->active_uv : std::string(); }
    bool on_mesh() const { return mesh && field("triangle") && field("barycentric"); }
    /// Whether anything but attributes differs from point to point.
    bool varies() const;

    // One value at point i. Vectors are in world space unless the name says otherwise.
    Vec3d value(Global g, uint32_t i) const;
    double scalar(Global g, uint32_t i) const;
    Vec3d p(uint32_t i) const;
    Vec3d p_object(uint32_t i) const;
    Vec3d to_viewer(uint32_t i) const;
    Vec3d n(uint32_t i) const;
    Vec3d n_unturned(uint32_t i) const;
    Vec3d ng(uint32_t i) const;
    Vec3d ng_unturned(uint32_t i) const;
    bool backfacing(uint32_t i) const;
    Vec3d uv(uint32_t i) const;
    Vec3d generated(uint32_t i) const;
    Vec3d texspace_size() const;
    Vec3d dpdu(uint32_t i) const;
    Vec3d tangent(uint32_t i) const;
    Vec3d dpdx(uint32_t i, bool y) const;
    Vec3d dgendx(uint32_t i, bool y) const;
    Vec3d normal_object(uint32_t i) const;
    Vec3d duvdx(uint32_t i, bool y) const;
    Vec3d window(uint32_t i) const;
    double ray_length(uint32_t i) const;
    double footprint(uint32_t i) const;
    double edge_distance(uint32_t i) const;
    bool is_strand(uint32_t i) const;
    Vec3d fibre_tangent(uint32_t i) const;
    double fibre_offset(uint32_t i) const;
    double ray_kind(Global g, uint32_t i) const;

    struct Corners {
        uint32_t triangle;
        double w0, w1;
        std::array<Vec3d, 3> p;  ///< world space
        std::array<Vec3d, 3> uv;
        bool has_uv;
    };
    Corners corners(uint32_t i) const;
    Vec3d mesh_ng(const Corners& c) const;
    bool uv_gradient(const Corners& c, Vec3d& du, Vec3d& dv) const;
};

}  // namespace alder
