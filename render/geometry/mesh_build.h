// What a mesh does not bring along and the renderer needs: normals, texture space, tangents, uv derivatives.
// Pure functions of the mesh; nothing here keeps state. Meshes must have valid indices (importers check).
#pragma once
#include <span>
#include <vector>

#include "render/scene.h"

namespace alder {

enum class NormalWeight : uint8_t {
    Angle,  ///< by the corner's angle: does not depend on how polygons were cut into triangles (Blender's vertex normals)
    Area,   ///< by the triangle's area: cheaper
};
/// Unit vertex normals, one a point; (0,0,1) for points that no triangle with an area uses.
std::vector<Vec3f> compute_vertex_normals(std::span<const Vec3f> positions,
                                          std::span<const std::array<uint32_t, 3>> triangles,
                                          NormalWeight weight = NormalWeight::Angle);

/// Smallest and largest coordinates: Blender's automatic texture space. {0,0,0} twice for an empty mesh.
std::array<Vec3f, 2> compute_bounds(std::span<const Vec3f> positions);

/// Unit geometric normal of a triangle by its winding; zero where it has no area.
Vec3f triangle_normal(const Mesh& mesh, uint32_t triangle);

/// Shading normal of corner 0..2, object space: corner normal, vertex normal or (flat faces) the triangle's own.
/// A mesh without vertex normals needs fill_derived first.
Vec3f corner_normal(const Mesh& mesh, uint32_t triangle, int corner);

/// Position change by u and v over a triangle, from positions and uv of its corners. False, and any two directions that
/// span the triangle's plane, where the uv are degenerate.
bool uv_derivatives(const std::array<Vec3f, 3>& p, const std::array<std::array<float, 2>, 3>& uv, Vec3f& dpdu,
                    Vec3f& dpdv);

/// Tangents per corner (unit, perpendicular to the corner's normal) and the signs of the bitangents
/// (bitangent = sign * cross(normal, tangent)), as MikkTSpace defines them for triangles, which is what tangent-space
/// normal maps are baked against. Empty where the mesh has no uv.
struct Tangents {
    std::vector<Vec3f> tangents;
    std::vector<float> signs;
};
Tangents compute_tangents(const Mesh& mesh);
/// The same for other coordinates than the active ones (one pair a corner).
Tangents compute_tangents(const Mesh& mesh, std::span<const std::array<float, 2>> uv);

/// Fills in what is empty: vertex normals (unless corner normals are there), generated bounds (where min == max == 0),
/// and, if asked, tangents.
void fill_derived(Mesh& mesh, bool with_tangents = false);

}  // namespace alder
