// Shading points of an evaluation request: globals that follow from others, as a renderer would have them.
#include <cfloat>
#include <cmath>

#include "graph/points_impl.h"

namespace alder {
namespace {

constexpr double kWorldRayLength = FLT_MAX;  // what a camera ray that leaves the scene has in Cycles

Vec3d turned(Vec3d n, Vec3d to_viewer) { return dot(n, to_viewer) < 0 ? -n : n; }

/// Cycles' pair perpendicular to a unit vector: a = normalize((1,1,1) x n), b = n x a.
void orthonormals(Vec3d n, Vec3d& a, Vec3d& b) {
    a = n.x != n.y || n.x != n.z ? Vec3d{n.z - n.y, n.x - n.z, n.y - n.x} : Vec3d{n.z - n.y, n.x + n.z, -n.y - n.x};
    a = safe_normalize(a);
    b = cross(n, a);
}

}  // namespace

PointMatrix PointMatrix::inverse() const {
    const double det = determinant();
    PointMatrix m;
    if (det == 0) {
        m.x = m.y = m.z = Vec3d(0.0);
        return m;
    }
    // Rows of the inverse are the cross products of the columns over the determinant.
    const Vec3d r0 = cross(y, z) / det, r1 = cross(z, x) / det, r2 = cross(x, y) / det;
    m.x = {r0.x, r1.x, r2.x};
    m.y = {r0.y, r1.y, r2.y};
    m.z = {r0.z, r1.z, r2.z};
    m.t = -m.vector(t);
    return m;
}

bool PointData::varies() const {
    for (const auto& [name, f] : fields)
        if (f.per_point) return true;
    return false;
}

PointData::Corners PointData::corners(uint32_t i) const {
    Corners c;
    c.triangle = static_cast<uint32_t>(field("triangle")->at(i, 0));
    c.w0 = field("barycentric")->at(i, 0);
    c.w1 = field("barycentric")->at(i, 1);
    const PointMesh::Attribute* map = mesh->active_uv.empty() ? nullptr : mesh->find(mesh->active_uv);
    c.has_uv = map && map->domain == PointMesh::Domain::Corner && map->channels >= 2;
    for (int k = 0; k < 3; ++k) {
        c.p[k] = object_to_world.point(mesh->positions[mesh->triangles[c.triangle][k]]);
        const size_t e = c.has_uv ? (size_t{3} * c.triangle + k) * map->channels : 0;
        c.uv[k] = c.has_uv ? Vec3d{map->values[e], map->values[e + 1], 0} : Vec3d(0.0);
    }
    return c;
}

/// Not turned to the viewer. A mirrored object keeps its outside, so the winding counts the other way round.
Vec3d PointData::mesh_ng(const Corners& c) const {
    const Vec3d n = safe_normalize(cross(c.p[1] - c.p[0], c.p[2] - c.p[0]));
    return object_to_world.determinant() < 0 ? -n : n;
}

Vec3d PointData::p(uint32_t i) const {
    if (const auto* f = field("P")) return f->vec(i);
    if (world) return value(Global::Direction, i);
    if (const auto* f = field("Po")) return reference_to_world.point(f->vec(i));
    if (!on_mesh()) return Vec3d(0.0);
    const Corners c = corners(i);
    return c.p[0] * c.w0 + c.p[1] * c.w1 + c.p[2] * (1 - c.w0 - c.w1);
}

Vec3d PointData::p_object(uint32_t i) const {
    if (const auto* f = field("Po")) return f->vec(i);
    return world_to_reference.point(p(i));
}

Vec3d PointData::to_viewer(uint32_t i) const {
    if (const auto* f = field("I")) return f->vec(i);
    if (const auto* f = field("Rd")) return -f->vec(i);
    if (const auto* f = field("direction")) return -f->vec(i);
    if (!camera.present || world) return {0, 0, 1};
    if (camera.orthographic) return -safe_normalize(camera.to_world.z);
    return safe_normalize(camera.to_world.t - p(i));
}

bool PointData::backfacing(uint32_t i) const {
    if (const auto* f = field("backfacing")) return f->at(i, 0) != 0;
    if (on_mesh()) return dot(mesh_ng(corners(i)), to_viewer(i)) < 0;
    const auto *raw = field("Ng"), *towards = field("Ngf");
    return raw && towards && dot(raw->vec(i), towards->vec(i)) < 0;
}

/// Cycles' convention: turned on back faces. `Nf` says so of itself, `N` is taken as the request gives it.
Vec3d PointData::n(uint32_t i) const {
    for (const char* name : {"Nf", "N"})
        if (const auto* f = field(name)) return f->vec(i);
    if (world) return to_viewer(i);
    if (on_mesh()) {
        const Corners c = corners(i);
        Vec3d n = mesh_ng(c);
        if (!mesh->smooth.empty() && mesh->smooth[c.triangle] && !mesh->vertex_normals.empty()) {
            // Vertex normals are normalised in world space before they are interpolated, as Cycles does for a mesh with one user.
            const double w[3] = {c.w0, c.w1, 1 - c.w0 - c.w1};
            Vec3d sum(0.0);
            for (int k = 0; k < 3; ++k)
                sum += safe_normalize(world_to_object.transposed(mesh->vertex_normals[mesh->triangles[c.triangle][k]])) * w[k];
            if (dot(sum, sum) > 0) n = safe_normalize(sum);
        }
        return backfacing(i) ? -n : n;
    }
    for (const char* name : {"Ns", "Ngf", "Ng"})
        if (const auto* f = field(name)) return f->vec(i);
    return {0, 0, 1};
}

Vec3d PointData::n_unturned(uint32_t i) const {
    if (const auto* f = field("Nu")) return f->vec(i);
    if (const auto* f = field("N")) return field("backfacing") && backfacing(i) ? -f->vec(i) : f->vec(i);
    if (const auto* f = field("Ns")) return f->vec(i);
    return backfacing(i) ? -n(i) : n(i);
}

Vec3d PointData::ng(uint32_t i) const {
    for (const char* name : {"Ngf", "Ng"})
        if (const auto* f = field(name)) return f->vec(i);
    if (on_mesh() && !world) {
        const Vec3d n = mesh_ng(corners(i));
        return backfacing(i) ? -n : n;
    }
    return n(i);
}

Vec3d PointData::ng_unturned(uint32_t i) const {
    if (const auto* f = field("Ngu")) return f->vec(i);
    if (const auto* f = field("Ng")) return field("backfacing") && backfacing(i) ? -f->vec(i) : f->vec(i);
    return backfacing(i) ? -ng(i) : ng(i);
}

Vec3d PointData::uv(uint32_t i) const {
    if (const auto* f = field("uv")) return f->vec(i);
    const auto *u = field("u"), *v = field("v");
    if (u || v) return {u ? u->at(i, 0) : 0, v ? v->at(i, 0) : 0, 0};
    if (!on_mesh() || world) return Vec3d(0.0);
    const Corners c = corners(i);
    return c.uv[0] * c.w0 + c.uv[1] * c.w1 + c.uv[2] * (1 - c.w0 - c.w1);
}

/// Without a texture space, generated coordinates are object coordinates (as Cycles' fallback).
Vec3d PointData::generated(uint32_t i) const {
    if (const auto* f = field("generated")) return f->vec(i);
    if (world) return value(Global::Direction, i);
    if (!on_mesh()) return p_object(i);
    return (world_to_object.point(p(i)) - mesh->texspace_location) / texspace_size() + Vec3d(0.5);
}

Vec3d PointData::texspace_size() const {
    Vec3d size = mesh->texspace_size * 2.0;
    for (int k = 0; k < 3; ++k) size[k] = size[k] == 0 ? 1 : size[k];
    return size;
}

Vec3d PointData::dgendx(uint32_t i, bool y) const {
    if (const auto* f = field(y ? "dgendy" : "dgendx")) return f->vec(i);
    const Vec3d step = dpdx(i, y);
    if (world) return step;
    if (!on_mesh()) return world_to_reference.vector(step);
    return world_to_object.vector(step) / texspace_size();
}

/// Vertex normals are normalised in object space before they are interpolated; the sum is not. Zero: the node falls back on N.
Vec3d PointData::normal_object(uint32_t i) const {
    if (const auto* f = field("normal_object")) return f->vec(i);
    if (!on_mesh() || world || mesh->vertex_normals.empty()) return Vec3d(0.0);
    const Corners c = corners(i);
    const double w[3] = {c.w0, c.w1, 1 - c.w0 - c.w1};
    Vec3d sum(0.0);
    if (!mesh->smooth.empty() && mesh->smooth[c.triangle])
        for (int k = 0; k < 3; ++k) sum += safe_normalize(mesh->vertex_normals[mesh->triangles[c.triangle][k]]) * w[k];
    return dot(sum, sum) > 0 ? sum : safe_normalize(object_to_world.transposed(backfacing(i) ? -ng(i) : ng(i)));
}

/// dP/du, dP/dv over a triangle with UVs; false where the UVs are degenerate.
bool PointData::uv_gradient(const Corners& c, Vec3d& du, Vec3d& dv) const {
    const Vec3d e1 = c.p[1] - c.p[0], e2 = c.p[2] - c.p[0], t1 = c.uv[1] - c.uv[0], t2 = c.uv[2] - c.uv[0];
    const double det = t1.x * t2.y - t2.x * t1.y;
    if (!c.has_uv || det == 0) return false;
    du = (e1 * t2.y - e2 * t1.y) / det;
    dv = (e2 * t1.x - e1 * t2.x) / det;
    return true;
}

Vec3d PointData::dpdu(uint32_t i) const {
    if (const auto* f = field("dPdu")) return f->vec(i);
    if (world) return Vec3d(0.0);
    Vec3d du, dv;
    if (on_mesh() && uv_gradient(corners(i), du, dv)) return du;
    if (const auto* f = field("T")) return f->vec(i);
    return {1, 0, 0};
}

Vec3d PointData::tangent(uint32_t i) const {
    if (const auto* f = field("T")) return f->vec(i);
    if (const auto* f = field("tangent_object")) return safe_normalize(object_to_world.vector(f->vec(i)));
    return safe_normalize(dpdu(i));
}

double PointData::footprint(uint32_t i) const {
    if (const auto* f = field("pixel_footprint")) return f->at(i, 0);
    const auto *dx = field("dPdx"), *dy = field("dPdy");
    if (dx && dy) return 0.5 * (length(dx->vec(i)) + length(dy->vec(i)));
    if (camera.pixel_footprint > 0) return camera.pixel_footprint;
    if (!camera.has_view || world) return 0;
    const double pixel_x = 2 * camera.half_width / camera.width_pixels, pixel_y = 2 * camera.half_height / camera.height_pixels;
    if (camera.orthographic) return 0.5 * (pixel_x + pixel_y);
    // A ray cone: the mean turn of the unit direction per pixel step, times the distance.
    const Vec3d v = camera.from_world.point(p(i));
    if (v.z == 0) return 0;
    const Vec3d d = v / v.z, unit = safe_normalize(d);
    const Vec3d turn_x = safe_normalize(d + Vec3d{pixel_x, 0, 0}) - unit, turn_y = safe_normalize(d + Vec3d{0, pixel_y, 0}) - unit;
    return 0.5 * (length(turn_x) + length(turn_y)) * length(v);
}

double PointData::edge_distance(uint32_t i) const {
    if (const auto* f = field("edge_distance")) return f->at(i, 0);
    if (world || !on_mesh()) return 0;
    const Corners c = corners(i);
    const Vec3d position = p(i);
    double nearest = HUGE_VAL;
    for (int k = 0; k < 3; ++k) {
        const Vec3d edge = c.p[(k + 1) % 3] - c.p[k];
        nearest = std::min(nearest, length(cross(edge, position - c.p[k])) / length(edge));
    }
    return nearest;
}

/// A request that gives what only curves have, or T and no derivative, is about a curve.
bool PointData::is_strand(uint32_t i) const {
    if (const auto* f = field("is_strand")) return f->at(i, 0) != 0;
    for (const char* name : {"fibre_tangent", "fibre_normal", "h", "pixel_coverage"})
        if (field(name)) return true;
    return field("T") && !field("dPdu") && !field("dPdv") && !on_mesh();
}

Vec3d PointData::fibre_tangent(uint32_t i) const {
    for (const char* name : {"fibre_tangent", "T"})
        if (const auto* f = field(name)) return safe_normalize(f->vec(i));
    return safe_normalize(dpdu(i));
}

double PointData::fibre_offset(uint32_t i) const {
    if (const auto* f = field("h")) return f->at(i, 0);
    return -dot(n(i), safe_normalize(cross(fibre_tangent(i), to_viewer(i))));
}

Vec3d PointData::dpdx(uint32_t i, bool y) const {
    if (const auto* f = field(y ? "dPdy" : "dPdx")) return f->vec(i);
    Vec3d a, b;
    orthonormals(ng(i), a, b);
    return (y ? b : a) * footprint(i);
}

Vec3d PointData::duvdx(uint32_t i, bool y) const {
    if (const auto* f = field(y ? "duvdy" : "duvdx")) return f->vec(i);
    Vec3d du, dv;
    if (world || !on_mesh() || !uv_gradient(corners(i), du, dv)) return Vec3d(0.0);
    // Least squares: step = s du + t dv within the plane of the triangle.
    const Vec3d step = dpdx(i, y);
    const double a = dot(du, du), b = dot(du, dv), c = dot(dv, dv), det = a * c - b * b;
    if (det == 0) return Vec3d(0.0);
    const double p = dot(step, du), q = dot(step, dv);
    return {(p * c - q * b) / det, (q * a - p * b) / det, 0};
}

Vec3d PointData::window(uint32_t i) const {
    if (const auto* f = field("window")) return f->vec(i);
    if (!camera.present || !camera.has_view) return Vec3d(0.0);
    const Vec3d v = world ? camera.from_world.vector(value(Global::Direction, i)) : camera.from_world.point(p(i));
    const double depth = camera.orthographic ? 1 : v.z;
    if (depth == 0) return Vec3d(0.0);
    return {0.5 + 0.5 * v.x / (depth * camera.half_width), 0.5 + 0.5 * v.y / (depth * camera.half_height), 0};
}

/// Camera rays begin at the near clipping plane.
double PointData::ray_length(uint32_t i) const {
    for (const char* name : {"ray_length", "Rl"})
        if (const auto* f = field(name)) return f->at(i, 0);
    if (world) return kWorldRayLength;
    if (!camera.present) return 0;
    const Vec3d v = camera.from_world.point(p(i));
    if (!camera.has_view) return length(v);
    if (camera.orthographic) return v.z - camera.clip_start;
    return v.z == 0 ? 0 : length(v) * (1 - camera.clip_start / v.z);
}

/// Kinds of ray: by name (surface.ray), by Arnold's bits (Rt), or field by field; camera rays if nothing is said.
double PointData::ray_kind(Global g, uint32_t i) const {
    struct Kind {
        Global global;
        const char* name;
        int arnold_bit;
    };
    constexpr Kind kKinds[] = {{Global::IsCameraRay, "camera", 0x01},    {Global::IsShadowRay, "shadow", 0x02},
                               {Global::IsReflectionRay, "reflection", 0x04}, {Global::IsTransmissionRay, "transmission", 0x08},
                               {Global::IsDiffuseRay, "diffuse", 0x20},  {Global::IsGlossyRay, "glossy", 0x40},
                               {Global::IsSingularRay, "singular", 0},   {Global::IsVolumeRay, "volume", 0}};
    if (const auto* f = field(global_name(g))) return f->at(i, 0);
    for (const Kind& k : kKinds) {
        if (k.global != g) continue;
        if (const auto* f = field("Rt")) {
            const double bits = f->at(i, 0);
            return bits >= 0 && bits < 65536 && (static_cast<int>(bits) & k.arnold_bit) != 0 ? 1 : 0;
        }
        return ray == k.name ? 1 : 0;
    }
    return 0;
}

Vec3d PointData::value(Global g, uint32_t i) const {
    switch (g) {
        case Global::P: return p(i);
        case Global::N: return n(i);
        case Global::Ng: return ng(i);
        case Global::I: return to_viewer(i);
        case Global::Po: return p_object(i);
        case Global::Uv: return uv(i);
        case Global::Generated: return generated(i);
        case Global::Dpdu: return dpdu(i);
        case Global::Dpdx: return dpdx(i, false);
        case Global::Dpdy: return dpdx(i, true);
        case Global::Dgendx: return dgendx(i, false);
        case Global::Dgendy: return dgendx(i, true);
        case Global::NormalObject: return normal_object(i);
        case Global::Duvdx: return duvdx(i, false);
        case Global::Duvdy: return duvdx(i, true);
        case Global::Tangent: return tangent(i);
        case Global::FibreTangent: return fibre_tangent(i);
        case Global::Window: return window(i);
        case Global::Nu: return n_unturned(i);
        case Global::Ngu: return ng_unturned(i);
        case Global::ObjectToWorldX: return object_to_world.x;
        case Global::ObjectToWorldY: return object_to_world.y;
        case Global::ObjectToWorldZ: return object_to_world.z;
        case Global::ObjectToWorldT: return object_to_world.t;
        case Global::WorldToObjectX: return world_to_object.x;
        case Global::WorldToObjectY: return world_to_object.y;
        case Global::WorldToObjectZ: return world_to_object.z;
        case Global::WorldToObjectT: return world_to_object.t;
        case Global::WorldToCameraX: return camera.from_world.x;
        case Global::WorldToCameraY: return camera.from_world.y;
        case Global::WorldToCameraZ: return camera.from_world.z;
        // In the world the point is a direction from the camera, so its camera space is turned but not moved.
        case Global::WorldToCameraT: return world ? Vec3d(0.0) : camera.from_world.t;
        default: break;
    }
    if (const char* name = global_name(g))
        if (const auto* f = field(name)) return f->vec(i);
    switch (g) {
        case Global::Ns: return n_unturned(i);
        case Global::Nf: return field("backfacing") ? n(i) : turned(n(i), to_viewer(i));
        case Global::Ngf: return field("backfacing") ? ng(i) : turned(ng(i), to_viewer(i));
        case Global::Dpdv: {
            Vec3d du, dv;
            if (world) return Vec3d(0.0);
            if (on_mesh() && uv_gradient(corners(i), du, dv)) return dv;
            return cross(n(i), dpdu(i));
        }
        case Global::Dpodx: return world_to_reference.vector(dpdx(i, false));
        case Global::Dpody: return world_to_reference.vector(dpdx(i, true));
        case Global::TangentObject: return world ? Vec3d(0.0) : world_to_object.vector(tangent(i));
        case Global::Direction:
        case Global::Rd: return -to_viewer(i);
        case Global::Reflection: return n(i) * (2 * dot(n(i), to_viewer(i))) - to_viewer(i);
        case Global::ObjectLocation: return object_to_world.t;
        case Global::Ro: return camera.present ? camera.to_world.t : p(i) + to_viewer(i) * ray_length(i);
        case Global::ObjectColor: return Vec3d(1.0);
        default: return Vec3d(0.0);
    }
}

double PointData::scalar(Global g, uint32_t i) const {
    switch (g) {
        case Global::Backfacing: return backfacing(i) ? 1 : 0;
        case Global::RayLength: return ray_length(i);
        case Global::PixelFootprint: return footprint(i);
        case Global::EdgeDistance: return edge_distance(i);
        case Global::IsStrand: return is_strand(i) ? 1 : 0;
        case Global::FibreOffset: return fibre_offset(i);
        default: break;
    }
    if (g >= Global::IsCameraRay && g <= Global::IsVolumeRay) return ray_kind(g, i);
    if (const char* name = global_name(g))
        if (const auto* f = field(name)) return f->at(i, 0);
    switch (g) {
        case Global::TangentSign:
        case Global::FibreCoverage: return 1;
        case Global::RayDepth: return world ? 1 : 0;  // Cycles counts the background as a bounce
        case Global::FaceIndex: return field("triangle") ? field("triangle")->at(i, 0) : 0;
        case Global::FootprintArea: return footprint(i) * footprint(i);
        case Global::BarycentricU: return field("barycentric") ? field("barycentric")->at(i, 0) : world ? 1 : 0;
        case Global::BarycentricV: return field("barycentric") ? field("barycentric")->at(i, 1) : 0;
        default: return 0;
    }
}

}  // namespace alder
