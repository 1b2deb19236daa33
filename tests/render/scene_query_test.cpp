// Rays of shading nodes: openness and rounded normals on shapes where both are known.
#include "render/scene_query.h"

#include <gtest/gtest.h>

#include <cmath>

namespace alder {
namespace {

/// Cube -1 ... 1, flat.
std::shared_ptr<Mesh> cube() {
    auto m = std::make_shared<Mesh>();
    for (int i = 0; i < 8; ++i) m->positions.push_back({i & 1 ? 1.f : -1.f, i & 2 ? 1.f : -1.f, i & 4 ? 1.f : -1.f});
    const uint32_t quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const auto& q : quads) {
        m->triangles.push_back({q[0], q[1], q[2]});
        m->triangles.push_back({q[0], q[2], q[3]});
    }
    m->smooth.assign(12, 0);
    return m;
}
Instance instance(uint32_t mesh, float x, float y, float z, float scale) {
    Instance i;
    i.mesh = mesh;
    i.materials = {0};
    i.object_to_world.m = {scale, 0, 0, x, 0, scale, 0, y, 0, 0, scale, z};
    return i;
}
SceneQuery::Point at(float x, float y, float z, float nx, float ny, float nz, int instance = 0) {
    return {{x, y, z}, {nx, ny, nz}, {nx, ny, nz}, instance, 1e-6f, false, 12345};
}

TEST(SceneQuery, outside_of_a_cube_is_open_and_inside_closed) {
    const Surfaces s({cube()}, {instance(0, 0, 0, 0, 1)});
    const SurfaceQuery q(s);
    const float up[3] = {0, 0, 1}, down[3] = {0, 0, -1};
    EXPECT_EQ(q.unoccluded(at(0.3f, 0.2f, 1, 0, 0, 1), up, 100, 256, false), 1.0f);
    EXPECT_EQ(q.unoccluded(at(0.3f, 0.2f, 1, 0, 0, 1), down, 100, 256, false), 0.0f);
    EXPECT_EQ(q.unoccluded(at(0.3f, 0.2f, 1, 0, 0, 1), down, 0.5f, 256, false), 1.0f) << "nothing within half a unit";
}

TEST(SceneQuery, a_wall_beside_the_floor_takes_half_of_what_lies_on_its_side) {
    // From the floor, an endless wall at distance d hides (1 - h / sqrt(h² + d²)) / 2 less... here of height h, along x: (1 - cos)/2
    // with cos = d / sqrt(d² + h²) for cosine-weighted rays in the plane across.
    const Surfaces s({cube()}, {instance(0, 0, 0, -1000, 1000), instance(0, 1001, 0, 1000 - 997, 1000)});
    const SurfaceQuery q(s);
    const float up[3] = {0, 0, 1};
    const float d = 1, h = 1003;
    const float open = q.unoccluded(at(0, 0, 0, 0, 0, 1), up, 1e6f, 20000, false);
    EXPECT_NEAR(open, 1 - 0.5f * (1 - d / std::sqrt(d * d + h * h)), 0.005f);
    EXPECT_EQ(q.unoccluded(at(0, 0, 0, 0, 0, 1), up, 1e6f, 500, true), 1.0f) << "only the floor itself counts";
    EXPECT_LT(q.unoccluded(at(0, 0, 0, 0, 0, 1, 1), up, 1e6f, 500, true), 0.6f) << "the wall, seen as the object's own";
}

TEST(SceneQuery, bevel_bends_towards_the_edge_and_nowhere_else) {
    const Surfaces s({cube()}, {instance(0, 0, 0, 0, 1), instance(0, 0, 0, 2.0001f, 1)});
    const SurfaceQuery q(s);
    float n[3];
    q.bevel(at(0, 0, 1, 0, 0, 1), 0.5f, 512, n);
    EXPECT_NEAR(n[2], 1, 1e-6f) << "far from every edge";
    q.bevel(at(1, 0, 0.999f, 1, 0, 0), 0.2f, 4096, n);
    EXPECT_NEAR(n[0], n[2], 0.1f) << "at the edge, halfway between both faces; the cube on top is another object";
    EXPECT_NEAR(n[1], 0, 0.05f);
    q.bevel(at(1, 0, 0.9f, 1, 0, 0), 0.2f, 4096, n);
    EXPECT_TRUE(n[2] > 0.02f && n[2] < 0.6f) << n[2];
}

TEST(SceneQuery, odd_points_have_an_answer) {
    const Surfaces s({cube()}, {instance(0, 0, 0, 0, 1)});
    const SurfaceQuery q(s);
    const float up[3] = {0, 0, 1}, zero[3] = {0, 0, 0}, nan[3] = {NAN, 0, 0};
    float n[3];
    EXPECT_EQ(q.unoccluded(at(0, 0, 1, 0, 0, 1, -1), up, 1, 16, false), 1.0f);
    EXPECT_EQ(q.unoccluded(at(0, 0, 1, 0, 0, 1), zero, 1, 16, false), 1.0f);
    EXPECT_EQ(q.unoccluded(at(0, 0, 1, 0, 0, 1), nan, 1, 16, false), 1.0f);
    EXPECT_EQ(q.unoccluded(at(NAN, 0, 1, 0, 0, 1), up, 1, 16, false), 1.0f);
    EXPECT_EQ(q.unoccluded(at(3e38f, 0, 1, 0, 0, 1), up, INFINITY, 16, true), 1.0f);
    for (float radius : {0.0f, -1.0f, INFINITY, NAN, 3e38f}) {
        q.bevel(at(0, 0, 1, 0, 0, 1), radius, 4, n);
        EXPECT_TRUE(std::isfinite(n[0] + n[1] + n[2])) << radius;
    }
    q.bevel(at(1e30f, NAN, 1, 0, 0, 1), 1, 4, n);
    EXPECT_EQ(n[2], 1.0f);
}

}  // namespace
}  // namespace alder
