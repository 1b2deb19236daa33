// The stages' meshes: closed where they should be, facing outwards, normals in line with the triangles, quick to make.
#include "render/stage_shapes.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <map>

#include "render/geometry/mesh_build.h"

namespace alder {
namespace {

struct Survey {
    double volume = 0;        ///< by the divergence theorem; positive = faces outwards
    double worst_normal = 1;  ///< smallest cosine between a corner's normal and its triangle's
    int open_edges = 0;
};

Survey survey(const Mesh& m) {
    Survey s;
    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    for (uint32_t t = 0; t < m.triangles.size(); ++t) {
        const auto& v = m.triangles[t];
        s.volume += double(dot(m.positions[v[0]], cross(m.positions[v[1]], m.positions[v[2]]))) / 6;
        for (int k = 0; k < 3; ++k) {
            ++edges[{v[k], v[(k + 1) % 3]}];
            s.worst_normal = std::min(s.worst_normal, double(dot(corner_normal(m, t, k), triangle_normal(m, t))));
        }
    }
    for (const auto& [e, n] : edges) {
        const auto twin = edges.find({e.second, e.first});
        if (twin == edges.end() || twin->second != n) ++s.open_edges;
    }
    return s;
}

void expect_sound(const Mesh& m) {
    ASSERT_EQ(m.uv.size(), m.triangles.size() * 3);
    ASSERT_EQ(m.vertex_normals.size(), m.positions.size());
    for (const Vec3f& n : m.vertex_normals) ASSERT_NEAR(length(n), 1, 1e-5f);
    for (const auto& t : m.triangles)
        for (uint32_t v : t) ASSERT_LT(v, m.positions.size());
    for (const auto& uv : m.uv) ASSERT_TRUE(std::isfinite(uv[0]) && std::isfinite(uv[1]));
    EXPECT_LE(m.triangles.size(), 100000u) << m.name;
    EXPECT_GT(m.generated_bounds[1].x, m.generated_bounds[0].x);
}

TEST(StageShapes, spheres_are_closed_and_face_outwards) {
    const auto sphere = make_sphere();
    expect_sound(*sphere);
    const Survey s = survey(*sphere);
    EXPECT_NEAR(s.volume, 4.18879, 0.01);
    EXPECT_GT(s.worst_normal, 0.99);
    EXPECT_EQ(s.open_edges, 0);
}

TEST(StageShapes, shader_ball_is_one_closed_surface_with_a_window) {
    const auto begin = std::chrono::steady_clock::now();
    const auto ball = make_shader_ball();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    expect_sound(*ball);
    const Survey s = survey(*ball);
    EXPECT_EQ(s.open_edges, 0);
    EXPECT_LT(s.volume, 4.15) << "the window takes something away";
    EXPECT_GT(s.volume, 3.7);
    EXPECT_GT(s.worst_normal, 0.5) << "the wall is resolved by its lines";
    float lo = 9, hi = 0;
    for (const Vec3f& p : ball->positions) {
        lo = std::min(lo, length(p));
        hi = std::max(hi, length(p));
    }
    EXPECT_NEAR(lo, 0.89f, 1e-3f);
    EXPECT_NEAR(hi, 1, 1e-5f);
    EXPECT_LT(seconds, 0.1) << "made before the first preview of a process";
    RecordProperty("milliseconds", std::to_string(seconds * 1e3));
    RecordProperty("triangles", std::to_string(ball->triangles.size()));
}

TEST(StageShapes, turned_outlines_face_outwards) {
    const OutlinePoint outline[] = {{1, 0, 0}, {1, 1, 0.1f}, {0, 1, 0}};   // a rounded cylinder without its floor
    const auto m = make_turned("cylinder", outline, 64);
    expect_sound(*m);
    const Survey s = survey(*m);
    EXPECT_NEAR(s.volume, 3.1, 0.1);
    EXPECT_GT(s.worst_normal, 0.5);
}

TEST(StageShapes, studio_and_plate_face_the_camera) {
    const auto plate = make_plate();
    expect_sound(*plate);
    for (uint32_t t = 0; t < plate->triangles.size(); ++t) EXPECT_EQ(triangle_normal(*plate, t).y, -1);
    const auto studio = make_cyclorama(10, -5, 5, 3, 8);
    expect_sound(*studio);
    for (uint32_t t = 0; t < studio->triangles.size(); ++t) {
        const Vec3f n = triangle_normal(*studio, t);
        EXPECT_TRUE(n.z > -1e-6f && n.y < 1e-6f) << t;
    }
    EXPECT_NEAR(survey(*studio).worst_normal, 1, 0.01);
}

}  // namespace
}  // namespace alder
