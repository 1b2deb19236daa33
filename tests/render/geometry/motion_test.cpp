// Motion: keys and what lies between them, the shutter, and pictures of moving things with known coverage.
#include "render/geometry/motion.h"

#include <random>

#include "render/geometry/displace.h"
#include "render/geometry/surface.h"
#include "render/sampling.h"
#include "render/shutter.h"
#include "tests/render/scene_kit.h"

namespace alder::testing {
namespace {

float difference(const Transform& a, const Transform& b) {
    float d = 0;
    for (int i = 0; i < 12; ++i) d = std::max(d, std::abs(a.m[i] - b.m[i]));
    return d;
}

TEST(Motion, keys_give_back_their_matrices) {
    std::mt19937 rng(5);
    std::normal_distribution<float> g;
    for (int i = 0; i < 200; ++i) {
        Transform t;
        for (float& x : t.m) x = g(rng);  // sheared and mirrored too
        const auto keys = motion_keys(std::span(&t, 1));
        EXPECT_LT(difference(transform_of(keys[0]), t), 2e-6f * 10);
    }
}

TEST(Motion, a_turn_stays_a_turn) {
    const auto turned = [](float a) { return Transform{{std::cos(a), -std::sin(a), 0, a, std::sin(a), std::cos(a), 0, 0, 0, 0, 1, 0}}; };
    const Transform ends[3] = {turned(0), turned(1.2f), turned(2.4f)};
    const auto keys = motion_keys(ends);
    for (const float t : {0.f, 0.1f, 0.5f, 0.77f, 1.f}) EXPECT_LT(difference(transform_at(keys, t), turned(2.4f * t)), 1e-5f) << t;
    EXPECT_LT(difference(transform_at(keys, -3), ends[0]), 1e-6f);
    EXPECT_LT(difference(transform_at(keys, 9), ends[2]), 1e-5f);
    // Through nothing and back: finite, and turned as its neighbours.
    Transform none = turned(1.2f);
    for (const int k : {0, 1, 2, 4, 5, 6, 8, 9, 10}) none.m[k] = 0;
    const Transform vanishing[3] = {turned(0), none, turned(0.1f)};
    for (const float x : transform_at(motion_keys(vanishing), 0.4f).m) EXPECT_TRUE(std::isfinite(x));
}

TEST(Motion, rays_and_points_agree_on_where_things_are) {
    auto m = std::make_shared<Mesh>(*floor_quad(1));
    m->motion_steps = 2;
    for (const float z : {0.f, 2.f})
        for (const Vec3f p : m->positions) m->motion_positions.push_back(p + Vec3f(0, 0, z));
    Instance i;
    i.materials = {0};
    i.motion = {translation(0, 0, 0), translation(0, 0, 0), translation(0, 0, 4)};
    const Surfaces s({m}, {i});
    EXPECT_TRUE(s.anything_moves());
    for (const float time : {0.f, 0.3f, 0.5f, 0.9f, 1.f}) {
        const float z = 2 * time + (time > 0.5f ? 8 * (time - 0.5f) : 0.f);
        Ray ray{{0.3f, 0.2f, 20}, {0, 0, -1}, 0, 100, time};
        Hit hit;
        ASSERT_TRUE(s.accel().intersect(ray, kVisibleCamera, hit)) << time;
        EXPECT_NEAR(hit.t, 20 - z, 1e-4) << time;
        EXPECT_NEAR(s.point(hit.instance, hit.triangle, hit.u, hit.v, ray.direction, hit.t, time).p.z, z, 1e-5) << time;
        EXPECT_NEAR(s.world_triangle(0, 0, time)[1].z, z, 1e-5);
        ASSERT_TRUE(s.accel().intersect_instance(0, ray, hit));
        EXPECT_NEAR(hit.t, 20 - z, 1e-4) << time;
    }
}

TEST(Shutter, times_follow_its_opening) {
    EXPECT_EQ(Shutter({}).time(0.3f), 0.3f);
    EXPECT_EQ(Shutter({1, 1, 1}).time(0.3f), 0.3f);
    EXPECT_EQ(Shutter({0, 0}).time(0.3f), 0.3f);
    const Shutter triangle({0, 1, 0});
    const int n = 20000;
    double sum = 0, squares = 0;
    float before = -1;
    for (int i = 0; i < n; ++i) {
        const float t = triangle.time((i + 0.5f) / n);
        EXPECT_GE(t, before);
        before = t;
        sum += t;
        squares += double(t) * t;
    }
    EXPECT_NEAR(sum / n, 0.5, 1e-4);
    EXPECT_NEAR(squares / n - 0.25, 1. / 24, 1e-4) << "variance of a triangle of width 1";
    EXPECT_NEAR(Shutter({0, 2}).time(0.25f), 0.5, 1e-6);
    EXPECT_GE(Shutter({1, 0}).time(0), 0);
    EXPECT_LE(Shutter({1, 0}).time(std::nextafter(1.f, 0.f)), 1);
}

/// A glowing square of side 2 that crosses the frame: the share of the time that it covers each place.
SceneKit crossing() {
    SceneKit kit;
    Instance& i = kit.add(floor_quad(1), kit.add_material(emission(1)));
    i.motion = {translation(-4, 0, 0), translation(4, 0, 0)};
    kit.scene.camera.kind = Camera::Kind::Orthographic;
    kit.scene.camera.ortho_scale = 8;
    kit.scene.settings.width = 16;
    kit.scene.settings.height = 1;
    kit.scene.settings.samples = 4096;
    return kit;
}

TEST(Motion, a_crossing_square_covers_each_place_for_its_share_of_the_time) {
    SceneKit kit = crossing();
    RenderStats stats;
    const Image im = kit.render({}, &stats);
    const auto& row = im.layers[0].planes[0];
    // It moves 8 in the shutter's time and is 2 long: a quarter of it everywhere but at the ends.
    for (int x = 3; x < 13; ++x) EXPECT_NEAR(row[x], 0.25, 0.004) << x;
    EXPECT_NEAR(row[0], 1.25 / 8, 0.004) << "leaves the place it begins at";
    EXPECT_EQ(stats.timed_paths, stats.camera_rays);
    // Open only in the first half: it has come to the middle.
    kit.scene.settings.shutter_curve = {1, 1, 1, 0, 0};
    const Image half = kit.render();
    EXPECT_EQ(half.layers[0].planes[0][15], 0);
    EXPECT_GT(half.layers[0].planes[0][2], 0.3);
}

TEST(Motion, what_rests_takes_no_time) {
    SceneKit kit = crossing();
    kit.scene.instances[0].motion.clear();
    RenderStats stats;
    kit.render({.samples = 4}, &stats);
    EXPECT_EQ(stats.timed_paths, 0u);
}

TEST(Motion, a_moving_camera_sees_what_moving_things_show) {
    SceneKit still = crossing(), moving = crossing();
    const Transform middle = moving.scene.camera.to_world;
    moving.scene.instances[0].motion.clear();
    moving.scene.camera.motion = {translation(4, 0, 0) * middle, translation(-4, 0, 0) * middle};
    const Image a = still.render(), b = moving.render();
    for (int x = 0; x < 16; ++x) EXPECT_NEAR(a.layers[0].planes[0][x], b.layers[0].planes[0][x], 0.008) << x;
}

TEST(Motion, a_moving_light_lights_alike_however_it_is_found) {
    SceneKit kit;
    kit.add(floor_quad(20), kit.add_material(diffuse(0.8f, 0.8f, 0.8f)));
    const uint32_t glow = kit.add_material(emission(5));
    Instance& lamp = kit.add(sphere_mesh(0.5f, 8, false), glow);
    lamp.motion = {translation(-3, 0, 1) * scaling(0.5f), translation(3, 1, 2) * scaling(1.5f)};
    lamp.visibility &= ~kVisibleCamera;
    kit.look_at({0, -4, 6}, {0, 0, 0}, 40);
    kit.scene.settings.max_bounces = 1;
    kit.scene.settings.samples = 1024;
    double means[3];
    for (int s = 0; s < 3; ++s) {
        kit.scene.settings.light_strategy = RenderSettings::LightStrategy(s);
        means[s] = mean(kit.render()).x;
    }
    EXPECT_GT(means[0], 0.01);
    EXPECT_NEAR(means[1] / means[0], 1, 0.01);
    EXPECT_NEAR(means[2] / means[0], 1, 0.02);
}

TEST(Displacement, a_grid_takes_the_shape_of_its_height) {
    // Height x^2 / 4 over a grid, by a value of its own: the vertices and their normals are those of the parabola.
    auto m = std::make_shared<Mesh>();
    const int n = 40;
    Attribute height{"height", Domain::Point, 1, {}};
    for (int y = 0; y <= n; ++y)
        for (int x = 0; x <= n; ++x) {
            const float px = 2.f * x / n - 1, py = 2.f * y / n - 1;
            m->positions.push_back({px, py, 0});
            height.values.push_back(0.25f * px * px);
        }
    for (uint32_t y = 0; y < n; ++y)
        for (uint32_t x = 0; x < n; ++x) {
            const uint32_t a = y * (n + 1) + x;
            m->triangles.push_back({a, a + 1, a + n + 2});
            m->triangles.push_back({a, a + n + 2, a + n + 1});
        }
    m->attributes.push_back(height);
    SceneKit kit;
    const auto moved = graph({{"version", 1},
                              {"nodes",
                               {{"a", {{"type", "ShaderNodeAttribute"}, {"params", {{"attribute_name", "height"}}}}},
                                {"d", {{"type", "ShaderNodeDisplacement"}, {"params", {{"Height", {{"node", "a"}, {"output", "Fac"}}}, {"Midlevel", 0.0}, {"Scale", 1.0}}}}},
                                {"s", {{"type", "ShaderNodeBsdfDiffuse"}}}}},
                              {"outputs", {{"surface", {{"node", "s"}}}, {"displacement", {{"node", "d"}}}}}});
    const uint32_t material = kit.add_material(moved);
    kit.scene.materials[material].displacement = Displacement::Move;
    kit.add(m, material, scaling(2));
    auto meshes = kit.scene.meshes;
    auto instances = kit.scene.instances;
    Diagnostics d;
    displace(kit.scene, {}, meshes, instances, d);
    ASSERT_TRUE(d.ok()) << d.errors[0].line();
    ASSERT_EQ(meshes.size(), 2u);
    const Mesh& out = *meshes[instances[0].mesh];
    for (size_t i = 0; i < out.positions.size(); ++i) {
        const Vec3f p = out.positions[i];
        EXPECT_NEAR(p.z, 0.25f * p.x * p.x, 1e-5) << "in the object's space, by the node's default";
        if (std::abs(p.x) > 0.9f || std::abs(p.y) > 0.9f) continue;
        EXPECT_LT(length(out.vertex_normals[i] - safe_normalize(Vec3f(-0.5f * p.x, 0, 1))), 5e-3f);
    }
    kit.scene.materials[material].displacement = Displacement::Bump;
    auto kept = kit.scene.meshes;
    displace(kit.scene, {}, kept, instances = kit.scene.instances, d);
    EXPECT_EQ(kept.size(), 1u);
}

}  // namespace
}  // namespace alder::testing
