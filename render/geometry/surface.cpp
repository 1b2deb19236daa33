// Surfaces: from a hit to position, normals and a safe distance for the next ray.
#include "render/geometry/surface.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "render/geometry/mesh_build.h"
#include "render/sampling.h"

namespace alder {
namespace {

using Meshes = std::vector<std::shared_ptr<const Mesh>>;

/// The meshes with normals: those that bring none get vertex normals unless every face is flat. `done`: of some that have been.
Meshes with_normals(Meshes meshes, const Meshes* sources, const Meshes* done) {
    std::unordered_map<const Mesh*, std::shared_ptr<const Mesh>> known;
    if (sources)
        for (size_t i = 0; i < sources->size(); ++i) known.emplace((*sources)[i].get(), (*done)[i]);
    for (auto& mesh : meshes) {
        if (const auto it = known.find(mesh.get()); it != known.end()) {
            mesh = it->second;
            continue;
        }
        if (mesh->shape != Shape::Triangles || !mesh->corner_normals.empty() || !mesh->vertex_normals.empty()) continue;
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

Surfaces::Surfaces(Meshes meshes, std::vector<Instance> instances, const Surfaces* previous)
    : sources_(std::move(meshes)), meshes_(with_normals(sources_, previous ? &previous->sources_ : nullptr, previous ? &previous->meshes_ : nullptr)),
      instances_(std::move(instances)), accel_(meshes_, instances_, previous ? &previous->accel_ : nullptr) {
    std::unordered_map<const Mesh*, std::shared_ptr<const MeshTables>> known;
    if (previous)
        for (size_t i = 0; i < previous->meshes_.size(); ++i) known.emplace(previous->meshes_[i].get(), previous->tables_[i]);
    for (const auto& m : meshes_) {
        const auto it = known.find(m.get());
        tables_.push_back(it != known.end() ? it->second : std::make_shared<MeshTables>(m));
    }
    frames_.reserve(instances_.size());
    motion_.resize(instances_.size());
    for (size_t i = 0; i < instances_.size(); ++i) {
        frames_.push_back(frame_of(instances_[i].object_to_world));
        if (instances_[i].motion.size() > 1) motion_[i] = motion_keys(instances_[i].motion);
        anything_moves_ = anything_moves_ || !motion_[i].empty() || meshes_[instances_[i].mesh]->moves();
    }
}

InstanceFrame Surfaces::frame_at(uint32_t instance, float time) const {
    return motion_[instance].empty() ? frames_[instance] : frame_of(transform_at(motion_[instance], time));
}

std::array<Vec3f, 3> Surfaces::world_triangle(uint32_t instance, uint32_t triangle, float time) const {
    const Mesh& mesh = mesh_of(instance);
    const auto& t = mesh.triangles[triangle];
    const Transform m = motion_[instance].empty() ? frames_[instance].object_to_world : transform_at(motion_[instance], time);
    return {m.point(position_at(mesh, t[0], time)), m.point(position_at(mesh, t[1], time)), m.point(position_at(mesh, t[2], time))};
}

CurvePoint Surfaces::curve_point(uint32_t instance, uint32_t segment, float u, float time) const {
    const Mesh& mesh = mesh_of(instance);
    return alder::curve_point(curve_keys(mesh, tables_of(instance).curves().segments[segment], time), mesh.curve_form, u);
}

ShadingPoint Surfaces::point(uint32_t instance, uint32_t triangle, float u, float v, Vec3f direction, float distance, float time) const {
    const Mesh& mesh = mesh_of(instance);
    ShadingPoint s;
    s.instance = instance;
    s.triangle = triangle;
    s.u = u;
    s.v = v;
    s.distance = distance;
    s.wo = -direction;
    s.time = time;
    InstanceFrame moved;
    const bool moves = !motion_[instance].empty();
    if (moves) moved = frame_at(instance, time);
    const InstanceFrame& frame = moves ? moved : frames_[instance];
    if (mesh.shape == Shape::Triangles) triangle_point(mesh, frame, s);
    else thread_point(mesh, frame, s);
    return s;
}

void Surfaces::triangle_point(const Mesh& mesh, const InstanceFrame& frame, ShadingPoint& s) const {
    const auto& t = mesh.triangles[s.triangle];
    const Vec3f p0 = position_at(mesh, t[0], s.time), p1 = position_at(mesh, t[1], s.time), p2 = position_at(mesh, t[2], s.time);
    const float u = s.u, v = s.v, w = 1 - u - v;
    // Interpolated from the corners: exact to a few ulp of the coordinates, where origin + t * direction would carry the
    // rounding of a long ray.
    s.p = frame.object_to_world.point(p0 * w + p1 * u + p2 * v);
    const float size = frame.stretch * std::max({max_abs(p0), max_abs(p1), max_abs(p2)});
    s.error = kRelativeError * (size + max_abs(s.p)) + frame.position_error;

    Vec3f ng = safe_normalize(frame.normal(cross(p1 - p0, p2 - p0)));
    if (is_black(ng) || !is_finite(ng)) ng = s.wo;
    Vec3f n = ng;
    if (mesh.smooth.empty() || mesh.smooth[s.triangle]) {
        Vec3f sum(0.f);
        if (!mesh.motion_normals.empty()) {
            const auto [step, along] = motion_span(static_cast<size_t>(mesh.motion_steps), s.time);
            const Vec3f* const normals = mesh.motion_normals.data() + step * mesh.positions.size();
            const float weight[3] = {w, u, v};
            for (int k = 0; k < 3; ++k) sum += (normals[t[k]] * (1 - along) + normals[mesh.positions.size() + t[k]] * along) * weight[k];
        } else if (!mesh.corner_normals.empty()) {
            const Vec3f* const normals = mesh.corner_normals.data() + size_t{3} * s.triangle;
            sum = normals[0] * w + normals[1] * u + normals[2] * v;
        } else if (!mesh.vertex_normals.empty()) {
            sum = mesh.vertex_normals[t[0]] * w + mesh.vertex_normals[t[1]] * u + mesh.vertex_normals[t[2]] * v;
        }
        const Vec3f smooth = safe_normalize(frame.normal(sum));
        if (!is_black(smooth) && is_finite(smooth)) n = smooth;
    }
    s.backfacing = dot(ng, s.wo) < 0;
    s.ng = s.backfacing ? -ng : ng;
    s.n = s.backfacing ? -n : n;
}

/// How far the surface is from the axis of a straight piece: a cone that touches the balls around both ends, and these balls.
float cone_distance(const CurveKeys& keys, float u) {
    const float size = length(keys.p[2] - keys.p[1]), r0 = std::max(keys.radius[1], 0.f), r1 = std::max(keys.radius[2], 0.f);
    const float sine = size > 0 ? std::clamp((r0 - r1) / size, -1.f, 1.f) : 0.f, x = u * size;
    if (x < r0 * sine || !(size > 0)) return safe_sqrt(r0 * r0 - x * x);
    if (x > size + r1 * sine) return safe_sqrt(r1 * r1 - sqr(x - size));
    const float cosine = safe_sqrt(1 - sine * sine);
    return cosine > 0 ? (r0 - x * sine) / cosine : 0.f;
}

/// Threads and balls: rays meet them from outside only. A ribbon's normal is that of the thread it stands for.
void Surfaces::thread_point(const Mesh& mesh, const InstanceFrame& frame, ShadingPoint& s) const {
    Vec3f center, outward;
    float radius;
    if (mesh.shape == Shape::Spheres) {
        center = position_at(mesh, s.triangle, s.time);
        radius = radius_at(mesh, s.triangle, s.time);
        outward = decode_direction(s.u, s.v);
        s.n = safe_normalize(frame.normal(outward));
    } else {
        const CurveKeys keys = curve_keys(mesh, tables_of(s.instance).curves().segments[s.triangle], s.time);
        const CurvePoint c = alder::curve_point(keys, mesh.curve_form, s.u);
        center = c.center;
        radius = c.radius;
        if (mesh.curve_form == CurveForm::Linear) {
            outward = around_curve(c.tangent, s.v);
            radius = cone_distance(keys, s.u);
            const float u = std::clamp(s.u, 0.f, 1.f);
            s.n = safe_normalize(frame.normal(center + outward * radius - (keys.p[1] * (1 - u) + keys.p[2] * u)));
            s.u = u;
        } else if (mesh.curve_form == CurveForm::Ribbon) {
            const Vec3f tangent = safe_normalize(c.tangent), view = safe_normalize(frame.world_to_object.vector(s.wo));
            const Vec3f across = safe_normalize(cross(tangent, view));
            const float sine = std::clamp(s.v, -1.f, 1.f);
            s.n = safe_normalize(frame.normal(across * sine - safe_normalize(cross(tangent, across)) * safe_sqrt(1 - sine * sine)));
            outward = across * sine;
        } else {
            outward = around_curve(c.tangent, s.v);
            s.n = safe_normalize(frame.normal(outward));
        }
    }
    s.p = frame.object_to_world.point(center + outward * radius);
    s.error = kRelativeError * (frame.stretch * (max_abs(center) + std::abs(radius)) + max_abs(s.p)) + frame.position_error;
    if (is_black(s.n) || !is_finite(s.n)) s.n = s.wo;
    s.ng = s.n;
}

}  // namespace alder
