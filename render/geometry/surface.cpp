// Surfaces: from a hit to position, normals and a safe distance for the next ray.
#include "render/geometry/surface.h"

#include <algorithm>
#include <cmath>

#include "render/geometry/mesh_build.h"
#include "render/sampling.h"

namespace alder {
namespace {

/// The meshes with normals: those that bring none get vertex normals unless every face is flat.
std::vector<std::shared_ptr<const Mesh>> with_normals(std::vector<std::shared_ptr<const Mesh>> meshes) {
    for (auto& mesh : meshes) {
        if (!mesh->corner_normals.empty() || !mesh->vertex_normals.empty()) continue;
        const auto& smooth = mesh->smooth;
        if (!smooth.empty() && std::none_of(smooth.begin(), smooth.end(), [](uint8_t s) { return s != 0; })) continue;
        auto copy = std::make_shared<Mesh>(*mesh);
        copy->vertex_normals = compute_vertex_normals(copy->positions, copy->triangles);
        mesh = copy;
    }
    return meshes;
}

/// Relative size of the rounding errors we step over: a hit is found by Embree in object space on a ray transformed there and
/// back, some 2 x 8 roundings of half an ulp (2^-24) each, in the size of the coordinates that take part. Closed rooms from
/// 1e-3 to 1e5 units were tight with an eighth of it (2^-23) already: the rest is margin for uneven scales.
constexpr float kRelativeError = 0x1p-20f;

}  // namespace

InstanceFrame frame_of(const Transform& t) {
    InstanceFrame f;
    f.object_to_world = t;
    f.world_to_object = t.inverse();
    const Vec3f columns[3] = {t.normal({1, 0, 0}), t.normal({0, 1, 0}), t.normal({0, 0, 1})};
    for (int c = 0; c < 3; ++c) {
        f.normal_to_world[c] = columns[c].x;
        f.normal_to_world[3 + c] = columns[c].y;
        f.normal_to_world[6 + c] = columns[c].z;
    }
    f.stretch = 0;
    float translation = 0;
    for (int row = 0; row < 3; ++row) {
        f.stretch = std::max(f.stretch, std::abs(t.m[row * 4]) + std::abs(t.m[row * 4 + 1]) + std::abs(t.m[row * 4 + 2]));
        translation = std::max(translation, std::abs(t.m[row * 4 + 3]));
    }
    f.position_error = kRelativeError * translation;
    return f;
}

Surfaces::Surfaces(std::vector<std::shared_ptr<const Mesh>> meshes, std::vector<Instance> instances)
    : meshes_(with_normals(std::move(meshes))), instances_(std::move(instances)), accel_(meshes_, instances_) {
    for (const auto& m : meshes_) tables_.push_back(std::make_unique<MeshTables>(m));
    frames_.reserve(instances_.size());
    for (const Instance& i : instances_) frames_.push_back(frame_of(i.object_to_world));
}

std::array<Vec3f, 3> Surfaces::world_triangle(uint32_t instance, uint32_t triangle) const {
    const Mesh& mesh = mesh_of(instance);
    const auto& t = mesh.triangles[triangle];
    const Transform& m = frames_[instance].object_to_world;
    return {m.point(mesh.positions[t[0]]), m.point(mesh.positions[t[1]]), m.point(mesh.positions[t[2]])};
}

ShadingPoint Surfaces::point(uint32_t instance, uint32_t triangle, float u, float v, Vec3f direction, float distance) const {
    const Mesh& mesh = mesh_of(instance);
    const InstanceFrame& frame = frames_[instance];
    const auto& t = mesh.triangles[triangle];
    const Vec3f p0 = mesh.positions[t[0]], p1 = mesh.positions[t[1]], p2 = mesh.positions[t[2]];
    const float w = 1 - u - v;

    ShadingPoint s;
    s.instance = instance;
    s.triangle = triangle;
    s.u = u;
    s.v = v;
    s.distance = distance;
    s.wo = -direction;
    // Interpolated from the corners: exact to a few ulp of the coordinates, where origin + t * direction would carry the
    // rounding of a long ray.
    s.p = frame.object_to_world.point(p0 * w + p1 * u + p2 * v);
    const float size = frame.stretch * std::max({max_abs(p0), max_abs(p1), max_abs(p2)});
    s.error = kRelativeError * (size + max_abs(s.p)) + frame.position_error;

    Vec3f ng = safe_normalize(frame.normal(cross(p1 - p0, p2 - p0)));
    if (is_black(ng) || !is_finite(ng)) ng = s.wo;
    Vec3f n = ng;
    if (mesh.smooth.empty() || mesh.smooth[triangle]) {
        const bool corners = !mesh.corner_normals.empty();
        if (corners || !mesh.vertex_normals.empty()) {
            const Vec3f* const normals = corners ? mesh.corner_normals.data() + size_t{3} * triangle : mesh.vertex_normals.data();
            const Vec3f sum = corners ? normals[0] * w + normals[1] * u + normals[2] * v
                                      : normals[t[0]] * w + normals[t[1]] * u + normals[t[2]] * v;
            const Vec3f smooth = safe_normalize(frame.normal(sum));
            if (!is_black(smooth) && is_finite(smooth)) n = smooth;
        }
    }
    s.backfacing = dot(ng, s.wo) < 0;
    s.ng = s.backfacing ? -ng : ng;
    s.n = s.backfacing ? -n : n;
    return s;
}

}  // namespace alder
