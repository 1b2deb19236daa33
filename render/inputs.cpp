// Program inputs: one loop over the batch per global.
#include "render/inputs.h"

#include <algorithm>
#include <cmath>

#include "nodes/input/scene_query.h"
#include "render/sampling.h"

namespace alder {
namespace {

const InstanceFrame kIdentityFrame = [] {
    InstanceFrame f;
    f.normal_to_world = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    return f;
}();

Vec3f column(const Transform& t, int c) { return {t.m[c], t.m[4 + c], t.m[8 + c]}; }

struct UvTriangle {
    Vec3f uv[3];
    bool present = false;
};

/// Number `c` of `wanted` from a stored value of `have` numbers: 1 spreads; a colour to one is its mean; a missing third is 0,
/// a missing alpha 1 (Cycles' Attribute node).
float converted(const float* v, int have, int wanted, int c) {
    if (wanted == 1) return have <= 2 ? v[0] : (v[0] + v[1] + v[2]) / 3;
    if (c == 3) return have == 4 ? v[3] : 1;
    return have == 1 ? v[0] : c < have ? v[c] : 0;
}

/// Access to one batch: geometry behind each point, with the world and lamps (no instance) as identity.
struct Batch {
    const InputScene& scene;
    std::span<const ShadingPoint> points;
    const RayHistory* const* history;
    std::span<const InstanceFrame> moved;  ///< by point; empty: nothing moves

    const ShadingPoint& at(size_t i) const { return points[i]; }
    bool on_mesh(size_t i) const { return points[i].instance != kNothing; }
    /// False within a body (medium points), where there is nothing to interpolate on.
    bool on_surface(size_t i) const { return on_mesh(i) && points[i].triangle != kNothing; }
    bool on_triangle(size_t i) const { return on_surface(i) && mesh(i).shape == Shape::Triangles; }
    bool on_curve(size_t i) const { return on_surface(i) && mesh(i).shape == Shape::Curves; }
    bool on_sphere(size_t i) const { return on_surface(i) && mesh(i).shape == Shape::Spheres; }
    const InstanceFrame& frame(size_t i) const { return on_mesh(i) && !moved.empty() ? moved[i] : on_mesh(i) ? scene.surfaces->frame(points[i].instance) : points[i].lamp ? *points[i].lamp : kIdentityFrame; }
    const Mesh& mesh(size_t i) const { return scene.surfaces->mesh_of(points[i].instance); }
    const Instance& instance(size_t i) const { return scene.surfaces->instances()[points[i].instance]; }

    Vec3f unturned(size_t i, Vec3f n) const { return points[i].backfacing ? -n : n; }
    Vec3f p_object(size_t i) const {
        if (!on_mesh(i)) {
            const ShadingPoint& s = points[i];
            if (!s.lamp) return s.p;
            const Transform& m = s.lamp->world_to_object;
            return s.distance < std::numeric_limits<float>::max() ? m.point(s.p) : m.vector(s.p);  // a sun's position is a direction
        }
        const ShadingPoint& s = points[i];
        if (!on_triangle(i)) return frame(i).world_to_object.point(s.p);
        const Mesh& m = mesh(i);
        const auto& t = m.triangles[s.triangle];
        return position_at(m, t[0], s.time) * (1 - s.u - s.v) + position_at(m, t[1], s.time) * s.u + position_at(m, t[2], s.time) * s.v;
    }
    std::array<Vec3f, 3> world_triangle(size_t i) const { return scene.surfaces->world_triangle(points[i].instance, points[i].triangle, points[i].time); }
    /// A curve's axis, in object space.
    CurvePoint axis(size_t i) const {
        const ShadingPoint& s = points[i];
        return scene.surfaces->curve_point(s.instance, s.triangle, s.u, s.time);
    }
    CurveSegment segment(size_t i) const { return scene.surfaces->tables_of(points[i].instance).curves().segments[points[i].triangle]; }
    /// Radius interpolated between the ends of the segment (or of the sphere), in object space.
    float thread_radius(size_t i) const {
        const ShadingPoint& s = points[i];
        if (on_sphere(i)) return radius_at(mesh(i), s.triangle, s.time);
        const uint32_t p = segment(i).point;
        return radius_at(mesh(i), p, s.time) * (1 - s.u) + radius_at(mesh(i), p + 1, s.time) * s.u;
    }
    /// The same in world space: by the length of the diagonal, as Cycles has it for uneven scales.
    float world_radius(size_t i) const { return thread_radius(i) * length(frame(i).object_to_world.vector(Vec3f(0.57735027f))); }
    /// The first pair of numbers stored per curve, as Cycles takes a curve's UV.
    Vec3f curve_uv(size_t i) const {
        for (const Attribute& a : mesh(i).attributes) {
            const size_t k = 2 * size_t{segment(i).curve};
            if (a.domain == Domain::Curve && a.channels == 2 && k + 1 < a.values.size()) return {a.values[k], a.values[k + 1], 0};
        }
        return Vec3f(0.f);
    }
    UvTriangle uv_corners(size_t i) const {
        UvTriangle r;
        if (!on_triangle(i)) return r;
        const Mesh& m = mesh(i);
        if (m.uv.size() < 3 * m.triangles.size()) return r;
        r.present = true;
        for (int k = 0; k < 3; ++k) {
            const auto& uv = m.uv[size_t{3} * points[i].triangle + k];
            r.uv[k] = {uv[0], uv[1], 0};
        }
        return r;
    }
    Vec3f uv(size_t i) const {
        const ShadingPoint& s = points[i];
        if (!on_mesh(i)) return {s.u, s.v, 0};
        if (on_curve(i)) return curve_uv(i);
        const UvTriangle t = uv_corners(i);
        if (!t.present) return Vec3f(0.f);
        return t.uv[0] * (1 - s.u - s.v) + t.uv[1] * s.u + t.uv[2] * s.v;
    }
    /// Texture space: Blender's "generated" coordinates. A side without extent counts as 1 long.
    Vec3f generated_scale(size_t i) const {
        const auto& b = mesh(i).generated_bounds;
        Vec3f d = b[1] - b[0];
        for (int k = 0; k < 3; ++k) d[k] = d[k] != 0 ? 1 / d[k] : 1.f;
        return d;
    }
    /// Where generated coordinates are taken: the shape at its frame, the root of a curve, the centre of a sphere.
    Vec3f undeformed(size_t i) const {
        const Mesh& m = mesh(i);
        const ShadingPoint& s = points[i];
        if (!on_surface(i)) return p_object(i);
        if (m.shape == Shape::Spheres) return m.positions[s.triangle];
        if (m.shape == Shape::Curves) return m.positions[m.curve_first[segment(i).curve]];
        if (!m.moves()) return p_object(i);
        const auto& t = m.triangles[s.triangle];
        return m.positions[t[0]] * (1 - s.u - s.v) + m.positions[t[1]] * s.u + m.positions[t[2]] * s.v;
    }
    Vec3f generated(size_t i) const {
        if (!on_mesh(i)) return points[i].p;
        const auto& b = mesh(i).generated_bounds;
        return (undeformed(i) - (b[0] + b[1]) * 0.5f) * generated_scale(i) + Vec3f(0.5f);
    }
    bool uv_gradient(size_t i, Vec3f& du, Vec3f& dv) const {
        const UvTriangle t = uv_corners(i);
        if (!t.present) return false;
        const auto p = world_triangle(i);
        const Vec3f e1 = p[1] - p[0], e2 = p[2] - p[0], t1 = t.uv[1] - t.uv[0], t2 = t.uv[2] - t.uv[0];
        const float det = t1.x * t2.y - t2.x * t1.y;
        if (det == 0 || !std::isfinite(1 / det)) return false;
        du = (e1 * t2.y - e2 * t1.y) * (1 / det);
        dv = (e2 * t1.x - e1 * t2.x) * (1 / det);
        return is_finite(du) && is_finite(dv);
    }
    Vec3f dpdu(size_t i) const {
        Vec3f du, dv;
        if (on_curve(i)) return frame(i).object_to_world.vector(axis(i).tangent);
        if (uv_gradient(i, du, dv)) return du;
        return on_mesh(i) ? frame_about(points[i].n).x : Vec3f(0.f);
    }
    Vec3f dpdv(size_t i) const {
        Vec3f du, dv;
        if (on_curve(i)) return cross(dpdu(i), vec3(Global::Ng, i));
        if (uv_gradient(i, du, dv)) return dv;
        return on_mesh(i) ? frame_about(points[i].n).y : Vec3f(0.f);
    }
    Vec3f dpdx(size_t i, bool y) const {
        const Frame f = cycles_frame(points[i].ng);
        return (y ? f.y : f.x) * points[i].footprint;
    }
    /// How the weights of the triangle's corners change from pixel to pixel.
    struct CornerSteps {
        float weight[3] = {};
    };
    CornerSteps corner_steps(size_t i, bool y) const {
        if (!on_triangle(i)) return {};
        const auto p = world_triangle(i);
        const Vec3f e1 = p[1] - p[0], e2 = p[2] - p[0], step = dpdx(i, y), across = cross(e1, e2);
        const float size = dot(across, across), u = dot(cross(step, e2), across) / size, v = dot(cross(e1, step), across) / size;
        if (!std::isfinite(u) || !std::isfinite(v)) return {};
        return {{-u - v, u, v}};
    }
    Vec3f duvdx(size_t i, bool y) const {
        Vec3f du, dv;
        if (!uv_gradient(i, du, dv)) return Vec3f(0.f);
        // Least squares: step = s du + t dv within the plane of the triangle.
        const Vec3f step = dpdx(i, y);
        const float a = dot(du, du), b = dot(du, dv), c = dot(dv, dv), det = a * c - b * b;
        if (!(std::abs(det) > 0)) return Vec3f(0.f);
        const float p = dot(step, du), q = dot(step, dv);
        return {(p * c - q * b) / det, (q * a - p * b) / det, 0};
    }
    Vec3f tangent_object(size_t i) const {
        if (!on_triangle(i)) return {1, 0, 0};
        const auto& table = scene.surfaces->tables_of(points[i].instance).tangents();
        const ShadingPoint& s = points[i];
        if (on_triangle(i) && !table.tangents.empty()) {
            const Vec3f* const t = table.tangents.data() + size_t{3} * s.triangle;
            return t[0] * (1 - s.u - s.v) + t[1] * s.u + t[2] * s.v;
        }
        // Without a UV map Cycles takes the rotation about the object's Z axis.
        const Vec3f g = generated(i);
        return {-(g.y - 0.5f), g.x - 0.5f, 0};
    }
    /// Stored tangent of a UV map, interpolated: `own` of the map, or the mesh's where it is null. Zero without either.
    Vec3f map_tangent(size_t i, const Tangents* own) const {
        if (!on_triangle(i)) return Vec3f(0.f);
        const ShadingPoint& s = points[i];
        const auto& corners = own ? own->tangents : scene.surfaces->tables_of(s.instance).tangents().tangents;
        if (corners.size() < 3 * (size_t{s.triangle} + 1)) return Vec3f(0.f);
        const Vec3f* const t = corners.data() + size_t{3} * s.triangle;
        return t[0] * (1 - s.u - s.v) + t[1] * s.u + t[2] * s.v;
    }
    /// Interpolated in object space, not normalised: how far it is from unit length matters to tangent-space maps.
    Vec3f normal_object(size_t i) const {
        if (!on_triangle(i)) return Vec3f(0.f);
        const ShadingPoint& s = points[i];
        const Mesh& m = mesh(i);
        if (!m.smooth.empty() && !m.smooth[s.triangle]) return Vec3f(0.f);  // flat: the node takes N
        const bool corners = !m.corner_normals.empty();
        if (!corners && m.vertex_normals.empty()) return Vec3f(0.f);
        const float weight[3] = {1 - s.u - s.v, s.u, s.v};
        Vec3f sum(0.f);
        for (int k = 0; k < 3; ++k)
            sum += safe_normalize(corners ? m.corner_normals[size_t{3} * s.triangle + k] : m.vertex_normals[m.triangles[s.triangle][k]]) * weight[k];
        return sum;
    }
    float edge_distance(size_t i) const {
        if (!on_triangle(i)) return 0;
        const auto p = world_triangle(i);
        float nearest = std::numeric_limits<float>::infinity();
        for (int k = 0; k < 3; ++k) {
            const Vec3f edge = p[(k + 1) % 3] - p[k];
            nearest = std::min(nearest, length(cross(edge, points[i].p - p[k])) / length(edge));
        }
        return nearest;
    }
    /// What Cycles' closures take where their Tangent is unlinked: around the object's Z axis, within the surface.
    Vec3f radial_tangent(size_t i) const {
        const Vec3f g = generated(i), n = points[i].n;
        const Vec3f around = frame(i).object_to_world.normal({-(g.y - 0.5f), g.x - 0.5f, 0});
        const Vec3f t = safe_normalize(cross(n, safe_normalize(cross(around, n))));
        return dot(t, t) > 0 ? t : frame_about(n).x;
    }
    float tangent_sign(size_t i) const {
        if (!on_triangle(i)) return 1;
        const auto& table = scene.surfaces->tables_of(points[i].instance).tangents();
        return table.signs.empty() ? 1 : table.signs[size_t{3} * points[i].triangle];
    }

    Vec3f vec3(Global g, size_t i) const;
    float scalar(Global g, size_t i) const;
};

Vec3f Batch::vec3(Global g, size_t i) const {
    const ShadingPoint& s = points[i];
    switch (g) {
        case Global::P: return s.p;
        case Global::N: return s.n;
        case Global::Ng: return on_curve(i) && mesh(i).curve_form == CurveForm::Ribbon ? s.wo : s.ng;
        case Global::I: return s.wo;
        case Global::Po: return p_object(i);
        case Global::NormalObject: return normal_object(i);
        case Global::Ns:
        case Global::Nu: return unturned(i, s.n);
        case Global::Ngu: return unturned(i, s.ng);
        case Global::Nf: return dot(s.n, s.wo) < 0 ? -s.n : s.n;
        case Global::Ngf: return s.ng;
        case Global::Uv: return uv(i);
        case Global::Generated: return generated(i);
        case Global::Dpdu: return dpdu(i);
        case Global::Dpdv: return dpdv(i);
        case Global::Dpdx: return dpdx(i, false);
        case Global::Dpdy: return dpdx(i, true);
        case Global::Duvdx: return duvdx(i, false);
        case Global::Duvdy: return duvdx(i, true);
        case Global::Dpodx: return frame(i).world_to_object.vector(dpdx(i, false));
        case Global::Dpody: return frame(i).world_to_object.vector(dpdx(i, true));
        case Global::Dgendx: return on_mesh(i) ? frame(i).world_to_object.vector(dpdx(i, false)) * generated_scale(i) : dpdx(i, false);
        case Global::Dgendy: return on_mesh(i) ? frame(i).world_to_object.vector(dpdx(i, true)) * generated_scale(i) : dpdx(i, true);
        case Global::Tangent: return radial_tangent(i);
        case Global::TangentObject: return tangent_object(i);
        case Global::Direction:
        case Global::Rd: return -s.wo;
        case Global::Window: return scene.camera->window(s.p);
        case Global::Reflection: return s.n * (2 * dot(s.n, s.wo)) - s.wo;
        case Global::ObjectToWorldX: return column(frame(i).object_to_world, 0);
        case Global::ObjectToWorldY: return column(frame(i).object_to_world, 1);
        case Global::ObjectToWorldZ: return column(frame(i).object_to_world, 2);
        case Global::ObjectToWorldT:
        case Global::ObjectLocation: return column(frame(i).object_to_world, 3);
        case Global::WorldToObjectX: return column(frame(i).world_to_object, 0);
        case Global::WorldToObjectY: return column(frame(i).world_to_object, 1);
        case Global::WorldToObjectZ: return column(frame(i).world_to_object, 2);
        case Global::WorldToObjectT: return column(frame(i).world_to_object, 3);
        case Global::WorldToCameraX: return column(scene.camera->world_to_camera(), 0);
        case Global::WorldToCameraY: return column(scene.camera->world_to_camera(), 1);
        case Global::WorldToCameraZ: return column(scene.camera->world_to_camera(), 2);
        // At infinity the point is a direction: camera space is turned but not moved.
        case Global::WorldToCameraT: return on_mesh(i) ? column(scene.camera->world_to_camera(), 3) : Vec3f(0.f);
        case Global::Ro: return history[i]->origin;
        case Global::ObjectColor: return on_mesh(i) ? instance(i).color : Vec3f(1.f);
        case Global::FibreTangent: return safe_normalize(dpdu(i));
        case Global::FibreNormal: {
            if (!on_curve(i) || mesh(i).curve_normals.empty()) return Vec3f(0.f);
            const Vec3f* const n = mesh(i).curve_normals.data() + segment(i).point;
            return safe_normalize(frame(i).normal(n[0] * (1 - s.u) + n[1] * s.u));
        }
        case Global::Ld:
        default: return Vec3f(0.f);
    }
}

float Batch::scalar(Global g, size_t i) const {
    const ShadingPoint& s = points[i];
    const RayHistory& ray = *history[i];
    const auto kind = [&](uint32_t bit) { return ray.kinds & bit ? 1.f : 0.f; };
    switch (g) {
        case Global::TangentSign: return tangent_sign(i);
        case Global::Backfacing: return s.backfacing ? 1 : 0;
        case Global::RayLength: return s.distance;
        case Global::RayDepth: return ray.depth;
        case Global::DiffuseDepth: return ray.diffuse;
        case Global::GlossyDepth: return ray.glossy;
        case Global::TransmissionDepth: return ray.transmission;
        case Global::TransparentDepth: return ray.transparent;
        case Global::IsCameraRay: return kind(kRayCamera);
        case Global::IsShadowRay: return kind(kRayShadow);
        case Global::IsDiffuseRay: return kind(kRayDiffuse);
        case Global::IsGlossyRay: return kind(kRayGlossy);
        case Global::IsSingularRay: return kind(kRaySingular);
        case Global::IsReflectionRay: return kind(kRayReflection);
        case Global::IsTransmissionRay: return kind(kRayTransmission);
        case Global::IsVolumeRay: return kind(kRayVolume);
        case Global::FaceIndex: return static_cast<float>(s.triangle);
        case Global::FootprintArea: return s.footprint * s.footprint;
        case Global::ObjectIndex: return on_mesh(i) ? static_cast<float>(instance(i).pass_index) : 0.f;
        case Global::MaterialIndex: {
            if (!on_triangle(i)) return 0;
            const uint32_t m = scene.surfaces->material(s.instance, s.triangle);
            return m < scene.material_pass_index.size() ? static_cast<float>(scene.material_pass_index[m]) : 0.f;
        }
        case Global::ObjectRandom: return on_mesh(i) ? instance(i).random : 0.f;
        case Global::IslandRandom: return on_triangle(i) ? scene.surfaces->tables_of(s.instance).island_random()[s.triangle] : 0.f;
        case Global::Pointiness: {
            if (!on_triangle(i)) return 0;
            const auto& table = scene.surfaces->tables_of(s.instance).pointiness();
            const auto& t = mesh(i).triangles[s.triangle];
            return table[t[0]] * (1 - s.u - s.v) + table[t[1]] * s.u + table[t[2]] * s.v;
        }
        case Global::BarycentricU:  // Cycles' Parametric: weights of the first and second corner
            if (on_sphere(i)) return 1;
            return 1 - s.u - (on_triangle(i) || !on_mesh(i) || mesh(i).curve_form == CurveForm::Ribbon ? s.v : 0.f);
        case Global::BarycentricV: return on_sphere(i) ? 0.f : s.u;
        case Global::PixelFootprint: return s.footprint;
        case Global::EdgeDistance: return edge_distance(i);
        case Global::FibreOffset: return std::clamp(-dot(s.n, safe_normalize(cross(dpdu(i), s.wo))), -1.f, 1.f);
        case Global::FibreCoverage: return on_curve(i) && ray.kinds & kRayCamera ? 0.5f * s.footprint / thread_radius(i) : 1.f;
        case Global::IsStrand: return on_curve(i) ? 1 : 0;
        case Global::FibreRandom: return on_curve(i) ? element_random(segment(i).curve) : 0.f;
        case Global::PreviousAlpha: return ray.previous_alpha;
        case Global::Time:
        default: return 0;
    }
}

/// The same for every point of a batch from one instance.
bool is_per_instance(Global g) {
    return (g >= Global::ObjectToWorldX && g <= Global::WorldToObjectT) || g == Global::ObjectLocation ||
           g == Global::ObjectColor || g == Global::ObjectIndex || g == Global::ObjectRandom;
}
bool is_constant(Global g) {
    return (g >= Global::WorldToCameraX && g <= Global::WorldToCameraZ) || g == Global::Time || g == Global::Ld;
}

/// The sum over the corners of the triangle by `weight`; what is not stored at corners or points is weighted by their sum.
void interpolate(const Attribute& a, const Mesh& mesh, const ShadingPoint& s, const float (&weight)[3], float* out) {
    const auto read = [&](size_t element, float weight) {
        for (int c = 0; c < a.channels; ++c) {
            const size_t k = element * a.channels + c;
            out[c] += k < a.values.size() ? weight * a.values[k] : 0.f;
        }
    };
    std::fill(out, out + 4, 0.f);
    const float sum = weight[0] + weight[1] + weight[2];
    switch (a.domain) {
        case Domain::Curve: return;  // not of triangles
        case Domain::Mesh: return read(0, sum);
        case Domain::Face: return read(s.triangle, sum);
        case Domain::Point:
            for (int k = 0; k < 3; ++k) read(mesh.triangles[s.triangle][k], weight[k]);
            return;
        case Domain::Corner:
            for (int k = 0; k < 3; ++k) read(size_t{3} * s.triangle + k, weight[k]);
            return;
    }
}
void interpolate(const Attribute& a, const Batch& batch, size_t i, float* out) {
    const ShadingPoint& s = batch.at(i);
    const Mesh& mesh = batch.mesh(i);
    if (mesh.shape == Shape::Triangles) return interpolate(a, mesh, s, {1 - s.u - s.v, s.u, s.v}, out);
    std::fill(out, out + 4, 0.f);
    const auto read = [&](size_t element, float weight) {
        for (int c = 0; c < a.channels; ++c) {
            const size_t k = element * a.channels + c;
            out[c] += k < a.values.size() ? weight * a.values[k] : 0.f;
        }
    };
    if (a.domain == Domain::Mesh) return read(0, 1);
    if (mesh.shape == Shape::Spheres) return a.domain == Domain::Point ? read(s.triangle, 1) : void();
    const CurveSegment segment = batch.segment(i);
    if (a.domain == Domain::Curve) return read(segment.curve, 1);
    if (a.domain != Domain::Point) return;
    read(segment.point, 1 - s.u);
    read(segment.point + 1, s.u);
}

/// What a curve or a sphere knows of itself.
Vec3f thread_info(const Batch& batch, size_t i, InputPlan::Part part) {
    using Part = InputPlan::Part;
    const ShadingPoint& s = batch.at(i);
    if (batch.on_sphere(i)) {
        switch (part) {
            case Part::SpherePosition: return batch.frame(i).object_to_world.point(position_at(batch.mesh(i), s.triangle, s.time));
            case Part::SphereRadius: return Vec3f(batch.world_radius(i));
            case Part::SphereRandom: return Vec3f(element_random(s.triangle));
            default: return Vec3f(0.f);
        }
    }
    if (!batch.on_curve(i)) return Vec3f(0.f);
    const ThreadTable& table = batch.scene.surfaces->tables_of(s.instance).curves();
    const CurveSegment segment = batch.segment(i);
    switch (part) {
        case Part::IsStrand: return Vec3f(1.f);
        case Part::Intercept: return Vec3f(table.intercepts[segment.point] * (1 - s.u) + table.intercepts[segment.point + 1] * s.u);
        case Part::CurveLength: return Vec3f(table.lengths[segment.curve]);
        case Part::Thickness: return Vec3f(2 * batch.world_radius(i));
        case Part::TangentNormal: {
            const Vec3f t = safe_normalize(batch.dpdu(i));
            return safe_normalize(s.wo - t * dot(t, s.wo));
        }
        case Part::CurveRandom: return Vec3f(element_random(segment.curve));
        default: return Vec3f(0.f);
    }
}

}  // namespace

namespace {

InputPlan::Part part_of(std::string_view& name) {
    using Part = InputPlan::Part;
    constexpr std::pair<std::string_view, Part> kWhole[] = {
        {kSceneInstance, Part::Instance}, {kScenePositionError, Part::PositionError}, {"curve:is_strand", Part::IsStrand},
        {"curve:intercept", Part::Intercept}, {"curve:length", Part::CurveLength}, {"curve:thickness", Part::Thickness},
        {"curve:tangent_normal", Part::TangentNormal}, {"curve:random", Part::CurveRandom}, {"point:position", Part::SpherePosition},
        {"point:radius", Part::SphereRadius}, {"point:random", Part::SphereRandom}};
    for (const auto& [whole, part] : kWhole)
        if (name == whole) return part;
    constexpr std::pair<std::string_view, InputPlan::Part> kSuffixes[] = {{kExistsSuffix, InputPlan::Part::Exists},
                                                                          {".alpha", InputPlan::Part::Alpha},
                                                                          {".tangent", InputPlan::Part::Tangent},
                                                                          {".tangent_sign", InputPlan::Part::TangentSign},
                                                                          {":dx", InputPlan::Part::StepX},
                                                                          {":dy", InputPlan::Part::StepY}};
    for (const auto& [suffix, part] : kSuffixes)
        if (name.ends_with(suffix)) {
            name.remove_suffix(suffix.size());
            return part;
        }
    return InputPlan::Part::Value;
}

/// By name; the empty name is the first colour.
const Attribute* find_attribute(const Mesh& mesh, std::string_view name) {
    for (const Attribute& a : mesh.attributes)
        if (a.channels >= 1 && a.channels <= 4 && (name.empty() ? a.channels >= 3 : a.name == name)) return &a;
    return nullptr;
}

std::shared_ptr<const Tangents> tangents_of(const Mesh& mesh, const Attribute* map) {
    if (!map || map->domain != Domain::Corner || map->channels != 2) return nullptr;
    std::vector<std::array<float, 2>> uv(map->values.size() / 2);
    for (size_t i = 0; i < uv.size(); ++i) uv[i] = {map->values[2 * i], map->values[2 * i + 1]};
    if (uv.size() < 3 * mesh.triangles.size()) return nullptr;
    return std::make_shared<Tangents>(compute_tangents(mesh, uv));
}

}  // namespace

InputPlan::InputPlan(const Program& program, const Surfaces& surfaces, bool in_volume) {
    for (const ProgramInput& in : program.inputs()) {
        Entry e{in, {}};
        if (in.is_attribute) {
            e.attribute_by_mesh.assign(surfaces.meshes().size(), nullptr);
            std::string_view name = in.attribute;
            e.part = part_of(name);
            const bool tangents = e.part == Part::Tangent || e.part == Part::TangentSign;
            if (tangents) e.tangents_by_mesh.resize(surfaces.meshes().size());
            for (size_t m = 0; m < surfaces.meshes().size(); ++m) {
                e.attribute_by_mesh[m] = find_attribute(*surfaces.meshes()[m], name);
                if (in_volume && e.attribute_by_mesh[m] && e.attribute_by_mesh[m]->domain != Domain::Mesh) e.attribute_by_mesh[m] = nullptr;
                if (tangents) e.tangents_by_mesh[m] = tangents_of(*surfaces.meshes()[m], e.attribute_by_mesh[m]);
            }
        }
        channels_ += in.channels;
        entries_.push_back(std::move(e));
    }
}

std::span<const Channel<float>> InputGather::gather(const InputPlan& plan, const InputScene& scene,
                                                    std::span<const ShadingPoint> points, const RayHistory* const* history) {
    const size_t n = points.size();
    const size_t padded = (n + kPadding - 1) / kPadding * kPadding;
    if (memory_.size() < padded * plan.channels()) memory_.resize(padded * plan.channels());
    channels_.resize(plan.channels());
    bool one_instance = true;
    for (const ShadingPoint& s : points) one_instance = one_instance && s.instance == points[0].instance && s.lamp == points[0].lamp;

    bool any_moves = false;
    for (const ShadingPoint& s : points) any_moves = any_moves || (s.instance != kNothing && scene.surfaces->moves(s.instance));
    moved_.clear();
    if (any_moves)
        for (const ShadingPoint& s : points) moved_.push_back(s.instance != kNothing ? scene.surfaces->frame_at(s.instance, s.time) : kIdentityFrame);

    const Batch batch{scene, points, history, moved_};
    float* next = memory_.data();
    size_t channel = 0;
    for (const InputPlan::Entry& e : plan.entries()) {
        const int width = e.input.channels;
        const Global g = e.input.global;
        const bool uniform = e.input.is_attribute ? e.part == InputPlan::Part::Exists && one_instance : is_constant(g) || (one_instance && !any_moves && is_per_instance(g));
        const size_t count = uniform ? 1 : n, rows = uniform ? kPadding : padded;
        float* const out = next;
        if (e.input.is_attribute) {
            for (size_t i = 0; i < count; ++i) {
                const ShadingPoint& s = points[i];
                const bool on_mesh = s.instance != kNothing;
                const uint32_t m = on_mesh ? scene.surfaces->instances()[s.instance].mesh : 0;
                const Attribute* const a = on_mesh ? e.attribute_by_mesh[m] : nullptr;
                float v[4] = {};
                switch (e.part) {
                    case InputPlan::Part::Instance: out[i] = on_mesh ? static_cast<float>(s.instance) : -1.f; continue;
                    case InputPlan::Part::PositionError: out[i] = s.error; continue;
                    case InputPlan::Part::Exists: out[i] = a ? 1.f : 0.f; continue;
                    case InputPlan::Part::Alpha:
                        if (a) interpolate(*a, batch, i, v);
                        out[i] = a && a->channels == 4 ? v[3] : 1.f;
                        continue;
                    case InputPlan::Part::Tangent: {
                        const Vec3f t = on_mesh ? batch.map_tangent(i, e.tangents_by_mesh[m].get()) : Vec3f(0.f);
                        for (int c = 0; c < width && c < 3; ++c) out[rows * c + i] = t[c];
                        continue;
                    }
                    case InputPlan::Part::TangentSign:
                        out[i] = !batch.on_triangle(i) || !e.tangents_by_mesh[m] ? batch.tangent_sign(i) : e.tangents_by_mesh[m]->signs[size_t{3} * s.triangle];
                        continue;
                    case InputPlan::Part::StepX:
                    case InputPlan::Part::StepY:
                        if (a && batch.on_triangle(i)) interpolate(*a, scene.surfaces->mesh_of(s.instance), s, batch.corner_steps(i, e.part == InputPlan::Part::StepY).weight, v);
                        for (int c = 0; c < width; ++c) out[rows * c + i] = c < 3 && a ? converted(v, a->channels, width, c) : 0.f;
                        continue;
                    case InputPlan::Part::Value: break;
                    default: {
                        const Vec3f info = on_mesh ? thread_info(batch, i, e.part) : Vec3f(0.f);
                        for (int c = 0; c < width && c < 3; ++c) out[rows * c + i] = info[c];
                        continue;
                    }
                }
                if (a) interpolate(*a, batch, i, v);
                for (int c = 0; c < width; ++c) out[rows * c + i] = a ? converted(v, a->channels, width, c) : 0.f;
            }
        } else if (width == 1) {
            for (size_t i = 0; i < count; ++i) out[i] = batch.scalar(g, i);
        } else {
            for (size_t i = 0; i < count; ++i) {
                const Vec3f v = batch.vec3(g, i);
                out[i] = v.x;
                out[rows + i] = v.y;
                out[2 * rows + i] = v.z;
            }
        }
        for (int c = 0; c < width; ++c) {
            // Padding lanes repeat the last point, so that kernels meet no garbage there.
            std::fill(out + rows * c + count, out + rows * (c + 1), out[rows * c + count - 1]);
            channels_[channel++] = {out + rows * c, uniform ? 0u : 1u};
        }
        next += rows * width;
    }
    return channels_;
}

}  // namespace alder
