// An evaluation request's mesh in world space, as Cycles keeps a mesh with one user: normals are normalised there.
#include "render/point_surfaces.h"

#include <algorithm>

#include "graph/point_mesh.h"

namespace alder {
namespace {

Vec3f narrowed(Vec3d v) { return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; }

std::shared_ptr<const Mesh> world_mesh(const PointMesh& source, const std::array<double, 12>& m) {
    auto mesh = std::make_shared<Mesh>();
    const Vec3d x(m[0], m[4], m[8]), y(m[1], m[5], m[9]), z(m[2], m[6], m[10]), t(m[3], m[7], m[11]);
    const Vec3d cofactor_x = cross(y, z), cofactor_y = cross(z, x), cofactor_z = cross(x, y);
    const double determinant = dot(x, cofactor_x);
    for (const Vec3d& p : source.positions) mesh->positions.push_back(narrowed(x * p.x + y * p.y + z * p.z + t));
    for (const Vec3d& n : source.vertex_normals) {
        const Vec3d w = cofactor_x * n.x + cofactor_y * n.y + cofactor_z * n.z;  // inverse transpose, times the determinant
        mesh->vertex_normals.push_back(narrowed(safe_normalize(determinant < 0 ? -w : w)));
    }
    mesh->triangles = source.triangles;
    if (determinant < 0)
        for (auto& c : mesh->triangles) std::swap(c[1], c[2]);  // a mirrored object keeps its outside
    mesh->smooth = source.smooth;
    if (mesh->smooth.empty() || mesh->vertex_normals.empty()) mesh->smooth.assign(mesh->triangles.size(), 0);
    return mesh;
}
std::vector<Instance> one_instance() {
    std::vector<Instance> list(1);
    list[0].materials = {0};
    return list;
}

}  // namespace

PointSurfaces::PointSurfaces(std::shared_ptr<const Mesh> mesh) : surfaces_({std::move(mesh)}, one_instance()), query_(surfaces_) {}

std::unique_ptr<PointSurfaces> PointSurfaces::make(const Program* program, const PointSet& points) {
    if (!program) return nullptr;
    const auto& inputs = program->inputs();
    if (std::none_of(inputs.begin(), inputs.end(), [](const ProgramInput& in) { return in.is_attribute && in.attribute == kSceneInstance; })) return nullptr;
    const auto mesh = points.mesh();
    if (!mesh || mesh->triangles.empty()) return nullptr;
    return std::unique_ptr<PointSurfaces>(new PointSurfaces(world_mesh(*mesh, points.object_to_world())));
}

}  // namespace alder
