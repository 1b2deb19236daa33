// Normals, texture space, uv derivatives and tangents of small meshes whose answers are known.
#include "render/geometry/mesh_build.h"

#include <gtest/gtest.h>

#include <cmath>

namespace alder {
namespace {

/// A unit cube of eight points; the two triangles of each side lie along a diagonal that favours some corners.
Mesh cube() {
    Mesh m;
    for (int i = 0; i < 8; ++i) m.positions.push_back(Vec3f(float(i & 1), float(i >> 1 & 1), float(i >> 2 & 1)));
    const uint32_t quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const auto& q : quads) {
        m.triangles.push_back({q[0], q[1], q[2]});
        m.triangles.push_back({q[0], q[2], q[3]});
    }
    return m;
}

/// A w x h grid of unit squares in the xy plane, uv = scale * position.
Mesh grid(int w, int h, float su, float sv) {
    Mesh m;
    for (int y = 0; y <= h; ++y)
        for (int x = 0; x <= w; ++x) m.positions.push_back(Vec3f(float(x), float(y), 0));
    const auto at = [&](int x, int y) { return uint32_t(y * (w + 1) + x); };
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
            m.triangles.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
            m.triangles.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
        }
    for (const auto& t : m.triangles)
        for (uint32_t v : t) m.uv.push_back({su * m.positions[v].x, sv * m.positions[v].y});
    return m;
}

void expect_vec(Vec3f a, Vec3f b, float tolerance = 1e-6f) {
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(a[k], b[k], tolerance) << "component " << k;
}

TEST(MeshBuild, angle_weighted_normals_of_a_cube_are_its_diagonals) {
    const Mesh m = cube();
    const std::vector<Vec3f> n = compute_vertex_normals(m.positions, m.triangles);
    const float s = 1 / std::sqrt(3.0f);
    for (int i = 0; i < 8; ++i) expect_vec(n[i], Vec3f(i & 1 ? s : -s, i & 2 ? s : -s, i & 4 ? s : -s));
}

TEST(MeshBuild, area_weighted_normals_depend_on_the_diagonals) {
    // Point 0 has two triangles of each of its three sides, point 1 not: the law above would not hold by accident.
    const Mesh m = cube();
    const std::vector<Vec3f> n = compute_vertex_normals(m.positions, m.triangles, NormalWeight::Area);
    expect_vec(n[0], Vec3f(-1, -1, -1) / std::sqrt(3.0f));
    EXPECT_GT(std::abs(std::abs(n[1].x) - std::abs(n[1].z)) + std::abs(std::abs(n[1].x) - std::abs(n[1].y)), 0.1f);
}

TEST(MeshBuild, normals_survive_tiny_and_degenerate_triangles) {
    const std::vector<Vec3f> p = {{0, 0, 0}, {1e-18f, 0, 0}, {0, 1e-18f, 0}, {5, 5, 5}, {9, 9, 9}};
    const std::vector<std::array<uint32_t, 3>> t = {{0, 1, 2}, {3, 3, 0}};
    const std::vector<Vec3f> n = compute_vertex_normals(p, t);
    expect_vec(n[1], Vec3f(0, 0, 1));
    expect_vec(n[3], Vec3f(0, 0, 1));   // only a triangle without area
    expect_vec(n[4], Vec3f(0, 0, 1));   // no triangle
}

TEST(MeshBuild, bounds_are_the_extremes) {
    const std::vector<Vec3f> p = {{1, -2, 3}, {-4, 5, 0.5f}};
    const auto b = compute_bounds(p);
    expect_vec(b[0], Vec3f(-4, -2, 0.5f));
    expect_vec(b[1], Vec3f(1, 5, 3));
    expect_vec(compute_bounds({})[1], Vec3f(0, 0, 0));
}

TEST(MeshBuild, uv_derivatives_reproduce_an_affine_map) {
    // p = a u + b v + c
    const Vec3f a(1, 2, -1), b(0, 0.5f, 3), c(7, 8, 9);
    const std::array<std::array<float, 2>, 3> uv = {{{0.1f, 0.2f}, {0.7f, 0.3f}, {0.4f, 0.9f}}};
    std::array<Vec3f, 3> p;
    for (int i = 0; i < 3; ++i) p[i] = a * uv[i][0] + b * uv[i][1] + c;
    Vec3f du, dv;
    ASSERT_TRUE(uv_derivatives(p, uv, du, dv));
    expect_vec(du, a, 1e-5f);
    expect_vec(dv, b, 1e-5f);
    EXPECT_FALSE(uv_derivatives(p, {{{0, 0}, {1, 1}, {2, 2}}}, du, dv));
    EXPECT_GT(length(cross(du, dv)), 1e-3f) << "a degenerate map still spans the plane";
}

TEST(MeshBuild, corner_normals_follow_smooth_flags) {
    Mesh m = cube();
    fill_derived(m);
    m.smooth.assign(m.triangles.size(), 0);
    expect_vec(corner_normal(m, 0, 1), Vec3f(0, 0, -1));
    m.smooth[0] = 1;
    expect_vec(corner_normal(m, 0, 0), Vec3f(-1, -1, -1) / std::sqrt(3.0f));
    m.corner_normals.assign(m.triangles.size() * 3, Vec3f(1, 0, 0));
    expect_vec(corner_normal(m, 5, 2), Vec3f(1, 0, 0));
}

TEST(Tangents, point_along_u_with_the_sign_of_the_map) {
    for (const float su : {1.0f, -2.0f}) {
        for (const float sv : {0.5f, -1.0f}) {
            Mesh m = grid(3, 2, su, sv);
            fill_derived(m, true);
            ASSERT_EQ(m.tangents.size(), m.triangles.size() * 3);
            for (size_t c = 0; c < m.tangents.size(); ++c) {
                expect_vec(m.tangents[c], Vec3f(su > 0 ? 1 : -1, 0, 0));
                EXPECT_EQ(m.tangent_signs[c], su * sv > 0 ? 1 : -1) << su << " " << sv;
            }
        }
    }
}

TEST(Tangents, are_averaged_by_angle_round_a_vertex_and_split_where_uv_are) {
    // Two squares in one plane, the second turned by 90 degrees in uv. Welded uv at the shared edge would average, split uv not.
    Mesh m = grid(2, 1, 1, 1);
    for (size_t t = 0; t < m.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const Vec3f p = m.positions[m.triangles[t][k]];
            if (t >= 2) m.uv[t * 3 + k] = {p.y + 10, -p.x};
        }
    const Tangents split = compute_tangents(m);
    for (size_t c = 0; c < 6; ++c) expect_vec(split.tangents[c], Vec3f(1, 0, 0));
    for (size_t c = 6; c < 12; ++c) expect_vec(split.tangents[c], Vec3f(0, 1, 0));
}

TEST(Tangents, of_a_roof_are_perpendicular_to_smooth_normals) {
    Mesh m = grid(2, 1, 1, 1);
    for (Vec3f& p : m.positions) p.z = p.x == 1 ? 0.7f : 0;
    fill_derived(m, true);
    for (uint32_t t = 0; t < m.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(dot(m.tangents[t * 3 + k], corner_normal(m, t, k)), 0, 1e-6f);
            EXPECT_NEAR(length(m.tangents[t * 3 + k]), 1, 1e-6f);
            if (m.positions[m.triangles[t][k]].x == 1) expect_vec(m.tangents[t * 3 + k], Vec3f(1, 0, 0), 1e-5f);   // both slopes cancel
        }
}

TEST(Tangents, degenerate_uv_take_their_neighbours_tangent) {
    Mesh m = grid(3, 1, 1, 1);
    for (size_t c = 6; c < 9; ++c) m.uv[c] = {m.uv[c][0], m.uv[c][0]};   // one triangle without an area in uv
    const Tangents t = compute_tangents(m);
    for (size_t c = 0; c < t.tangents.size(); ++c) {
        EXPECT_TRUE(std::isfinite(t.tangents[c].x)) << c;
        EXPECT_NEAR(length(t.tangents[c]), 1, 1e-6f) << c;
    }
    EXPECT_TRUE(compute_tangents(cube()).tangents.empty()) << "no uv, no tangents";
}

}  // namespace
}  // namespace alder
