// Normals, bounds and uv derivatives of triangle meshes. Tangents: tangents.cpp.
#include "render/geometry/mesh_build.h"

#include <algorithm>
#include <cmath>

namespace alder {
namespace {

/// Unit vector, or zero where there is no direction. In double: edges of tiny triangles must not underflow.
Vec3d unit_or_zero(Vec3d v) {
    const double l2 = v.x * v.x + v.y * v.y + v.z * v.z;
    if (!(l2 > 0) || !std::isfinite(l2)) return Vec3d(0, 0, 0);
    const double s = 1 / std::sqrt(l2);
    return {v.x * s, v.y * s, v.z * s};
}
Vec3d to_double(Vec3f v) { return {v.x, v.y, v.z}; }
Vec3f to_float(Vec3d v) { return {float(v.x), float(v.y), float(v.z)}; }

}  // namespace

std::vector<Vec3f> compute_vertex_normals(std::span<const Vec3f> positions,
                                          std::span<const std::array<uint32_t, 3>> triangles, NormalWeight weight) {
    std::vector<Vec3d> sum(positions.size(), Vec3d(0, 0, 0));
    for (const std::array<uint32_t, 3>& t : triangles) {
        const Vec3d p[3] = {to_double(positions[t[0]]), to_double(positions[t[1]]), to_double(positions[t[2]])};
        const Vec3d n = cross(p[1] - p[0], p[2] - p[0]);   // twice the area
        if (weight == NormalWeight::Area) {
            for (uint32_t v : t) sum[v] += n;
            continue;
        }
        const Vec3d face = unit_or_zero(n);
        for (int c = 0; c < 3; ++c) {
            const Vec3d a = unit_or_zero(p[(c + 1) % 3] - p[c]), b = unit_or_zero(p[(c + 2) % 3] - p[c]);
            sum[t[c]] += face * std::acos(std::clamp(dot(a, b), -1.0, 1.0));
        }
    }
    std::vector<Vec3f> normals(positions.size());
    for (size_t i = 0; i < sum.size(); ++i) {
        const Vec3d n = unit_or_zero(sum[i]);
        normals[i] = dot(n, n) > 0 ? to_float(n) : Vec3f(0, 0, 1);
    }
    return normals;
}

std::array<Vec3f, 2> compute_bounds(std::span<const Vec3f> positions) {
    if (positions.empty()) return {Vec3f(0, 0, 0), Vec3f(0, 0, 0)};
    Vec3f lo = positions[0], hi = positions[0];
    for (const Vec3f& p : positions) {
        lo = {std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z)};
        hi = {std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z)};
    }
    return {lo, hi};
}

Vec3f triangle_normal(const Mesh& mesh, uint32_t triangle) {
    const std::array<uint32_t, 3>& t = mesh.triangles[triangle];
    const Vec3d p = to_double(mesh.positions[t[0]]);
    return to_float(unit_or_zero(cross(to_double(mesh.positions[t[1]]) - p, to_double(mesh.positions[t[2]]) - p)));
}

Vec3f corner_normal(const Mesh& mesh, uint32_t triangle, int corner) {
    if (!mesh.corner_normals.empty()) return mesh.corner_normals[size_t(triangle) * 3 + corner];
    const bool smooth = mesh.smooth.empty() || mesh.smooth[triangle] != 0;
    if (smooth && !mesh.vertex_normals.empty()) return mesh.vertex_normals[mesh.triangles[triangle][corner]];
    return triangle_normal(mesh, triangle);
}

bool uv_derivatives(const std::array<Vec3f, 3>& p, const std::array<std::array<float, 2>, 3>& uv, Vec3f& dpdu,
                    Vec3f& dpdv) {
    const Vec3d e1 = to_double(p[1]) - to_double(p[0]), e2 = to_double(p[2]) - to_double(p[0]);
    const double du1 = double(uv[1][0]) - uv[0][0], dv1 = double(uv[1][1]) - uv[0][1];
    const double du2 = double(uv[2][0]) - uv[0][0], dv2 = double(uv[2][1]) - uv[0][1];
    const double det = du1 * dv2 - dv1 * du2;
    if (!std::isnormal(det)) {
        dpdu = to_float(e1);
        dpdv = to_float(e2);
        return false;
    }
    dpdu = to_float((e1 * dv2 - e2 * dv1) / det);
    dpdv = to_float((e2 * du1 - e1 * du2) / det);
    return true;
}

void fill_derived(Mesh& mesh, bool with_tangents) {
    if (mesh.shape == Shape::Triangles && mesh.vertex_normals.empty() && mesh.corner_normals.empty()) {
        mesh.vertex_normals = compute_vertex_normals(mesh.positions, mesh.triangles);
    }
    const Vec3f& lo = mesh.generated_bounds[0];
    const Vec3f& hi = mesh.generated_bounds[1];
    if (lo.x == 0 && lo.y == 0 && lo.z == 0 && hi.x == 0 && hi.y == 0 && hi.z == 0) {
        mesh.generated_bounds = compute_bounds(mesh.positions);
    }
    if (with_tangents && mesh.tangents.empty() && !mesh.uv.empty()) {
        Tangents t = compute_tangents(mesh);
        mesh.tangents = std::move(t.tangents);
        mesh.tangent_signs = std::move(t.signs);
    }
}

}  // namespace alder
