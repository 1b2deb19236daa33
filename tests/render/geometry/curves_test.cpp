// Curves and spheres: a hit's coordinates give back the point that the ray met; what curves know of themselves; no self-hits.
#include "render/geometry/curves.h"

#include <random>

#include "render/geometry/surface.h"
#include "render/sampling.h"
#include "tests/render/scene_kit.h"

namespace alder::testing {
namespace {

std::shared_ptr<Mesh> bent_curve(CurveForm form) {
    auto m = std::make_shared<Mesh>();
    m->shape = Shape::Curves;
    m->curve_form = form;
    m->positions = {{-1.5f, -0.2f, 0}, {-0.5f, 0.3f, 0.2f}, {0.4f, -0.1f, -0.1f}, {1.5f, 0.2f, 0.1f}, {-1, 1, 0}, {1, 1, 0}};
    m->radii = {0.05f, 0.1f, 0.08f, 0.03f, 0.1f, 0.1f};
    m->curve_first = {0, 4, 6};
    return m;
}

Surfaces surfaces_of(std::shared_ptr<const Mesh> mesh, Transform t = {}) {
    Instance i;
    i.object_to_world = t;
    i.materials = {0};
    return Surfaces({std::move(mesh)}, {i});
}

TEST(Curves, a_hit_gives_back_the_point_that_the_ray_met) {
    std::mt19937 rng(3);
    std::uniform_real_distribution<float> u(-1, 1);
    const Transform turned{{0.6f, -0.8f, 0, 1, 0.8f, 0.6f, 0, -2, 0, 0, 1.5f, 3}};
    for (const CurveForm form : {CurveForm::Round, CurveForm::Linear, CurveForm::Ribbon}) {
        for (const Transform& t : {Transform{}, turned}) {
            const auto mesh = bent_curve(form);
            mesh->curve_subdivisions = 15;
            const Surfaces s = surfaces_of(mesh, t);
            int hits = 0;
            for (int i = 0; i < 4000; ++i) {
                const Vec3f target = t.point({1.6f * u(rng), 1.1f * u(rng), 0.1f * u(rng)}), from = t.point({3 * u(rng), 3 * u(rng), 4});
                const Ray ray{from, safe_normalize(target - from), 0, 100};
                Hit hit;
                if (!s.accel().intersect(ray, kVisibleCamera, hit)) continue;
                ++hits;
                const ShadingPoint p = s.point(hit.instance, hit.triangle, hit.u, hit.v, ray.direction, hit.t);
                const Vec3f met = ray.origin + ray.direction * hit.t;
                // Ribbons are cut into flat pieces, here into sixteen, which turn against each other at bends: within a tenth of the radius.
                const float tolerance = form == CurveForm::Ribbon ? 1e-2f : 2e-3f;
                EXPECT_LT(length(p.p - met), tolerance) << "form " << int(form) << " segment " << hit.triangle << " u " << hit.u << " v " << hit.v;
                EXPECT_GT(dot(p.n, p.wo), form == CurveForm::Linear ? -0.1f : -1e-2f) << "a cone's normals lean to its axis";
                EXPECT_NEAR(length(p.n), 1, 1e-5);
            }
            EXPECT_GT(hits, 100) << "form " << int(form);
        }
    }
}

TEST(Curves, a_straight_thread_is_a_cylinder) {
    auto m = std::make_shared<Mesh>();
    m->shape = Shape::Curves;
    m->positions = {{-2, 0, 0}, {-1, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    m->radii.assign(4, 0.5f);
    m->curve_first = {0, 4};
    const Surfaces s = surfaces_of(m);
    for (const float y : {-0.4f, 0.f, 0.3f}) {
        Hit hit;
        ASSERT_TRUE(s.accel().intersect({{0.2f, y, 5}, {0, 0, -1}, 0, 100}, kVisibleCamera, hit));
        const float z = std::sqrt(0.25f - y * y);
        EXPECT_NEAR(hit.t, 5 - z, 1e-4);
        const ShadingPoint p = s.point(hit.instance, hit.triangle, hit.u, hit.v, {0, 0, -1}, hit.t);
        EXPECT_NEAR(p.n.y, y / 0.5f, 1e-3);
        EXPECT_NEAR(p.n.z, z / 0.5f, 1e-3);
    }
    Hit hit;
    EXPECT_FALSE(s.accel().intersect({{0.2f, 0, 0.1f}, {0, 0, 1}, 0, 100}, kVisibleCamera, hit)) << "from within nothing is met";
}

TEST(Curves, a_ribbon_runs_from_minus_one_to_one_across) {
    auto m = std::make_shared<Mesh>();
    m->shape = Shape::Curves;
    m->curve_form = CurveForm::Ribbon;
    m->positions = {{-2, 0, 0}, {-1, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    m->radii.assign(4, 0.5f);
    m->curve_first = {0, 4};
    const Surfaces s = surfaces_of(m);
    for (const float y : {-0.4f, 0.f, 0.3f}) {
        Hit hit;
        ASSERT_TRUE(s.accel().intersect({{0.2f, y, 5}, {0, 0, -1}, 0, 100}, kVisibleCamera, hit));
        EXPECT_NEAR(std::abs(hit.v), std::abs(y) / 0.5f, 1e-3);
        const ShadingPoint p = s.point(hit.instance, hit.triangle, hit.u, hit.v, {0, 0, -1}, hit.t);
        EXPECT_NEAR(p.p.y, y, 1e-3) << "v has the sign of the side that was met";
        EXPECT_NEAR(p.n.y, y / 0.5f, 1e-3) << "shaded as a thread";
    }
}

TEST(Curves, a_ray_does_not_meet_what_it_leaves) {
    for (const CurveForm form : {CurveForm::Round, CurveForm::Ribbon}) {
        const Surfaces s = surfaces_of(bent_curve(form));
        Ray ray{{0, 1, 5}, {0, 0, -1}, 0, 100};
        Hit hit;
        ASSERT_TRUE(s.accel().intersect(ray, kVisibleCamera, hit));
        ray.self_instance = hit.instance;
        ray.self_primitive = hit.triangle;
        Hit again;
        EXPECT_FALSE(s.accel().intersect(ray, kVisibleCamera, again));
        EXPECT_EQ(s.accel().occluded(ray, nullptr), Occlusion::Clear);
        ray.self_primitive = hit.triangle + 1;
        EXPECT_TRUE(s.accel().intersect(ray, kVisibleCamera, again));
    }
}

TEST(Spheres, are_round_and_met_from_outside) {
    auto m = std::make_shared<Mesh>();
    m->shape = Shape::Spheres;
    m->positions = {{0, 0, 0}, {3, 0, 0}};
    m->radii = {1, 0.5f};
    const Surfaces s = surfaces_of(m, scaling(2));
    std::mt19937 rng(1);
    std::uniform_real_distribution<float> u(-1.3f, 1.3f);
    for (int i = 0; i < 500; ++i) {
        const Vec3f o{u(rng), u(rng), 10};
        Hit hit;
        const bool met = s.accel().intersect({o, {0, 0, -1}, 0, 100}, kVisibleCamera, hit);
        const float r2 = o.x * o.x + o.y * o.y;
        if (std::abs(r2 - 4) > 1e-3f) { ASSERT_EQ(met, r2 < 4); }
        if (!met) continue;
        const ShadingPoint p = s.point(hit.instance, hit.triangle, hit.u, hit.v, {0, 0, -1}, hit.t);
        EXPECT_LT(length(p.p - Vec3f(o.x, o.y, std::sqrt(std::max(4 - r2, 0.f)))), 2e-3f) << r2;
        EXPECT_LT(length(p.n - p.p * 0.5f), 1e-3f);
    }
    Hit hit;
    EXPECT_FALSE(s.accel().intersect({{0.1f, 0, 0}, {0, 0, 1}, 0, 100}, kVisibleCamera, hit));
}

TEST(Curves, table_of_lengths_and_intercepts) {
    auto m = bent_curve(CurveForm::Round);
    m->positions[5] = {1, 1, 0};
    const ThreadTable t = ThreadTable::make(*m);
    ASSERT_EQ(t.segments.size(), 4u);
    EXPECT_EQ(m->primitive_count(), 4u);
    EXPECT_EQ(t.segments[3].point, 4u);
    EXPECT_EQ(t.segments[3].curve, 1u);
    EXPECT_FLOAT_EQ(t.lengths[1], 2);
    EXPECT_EQ(t.intercepts[0], 0);
    EXPECT_FLOAT_EQ(t.intercepts[3], 1);
    EXPECT_FLOAT_EQ(t.intercepts[5], 1);
}

/// Mean of an emitting node's colour where a thread or a ball fills the frame.
Vec3d seen(std::shared_ptr<const Mesh> mesh, const std::string& type, const std::string& output, Transform t = {}) {
    SceneKit kit;
    const auto material = graph({{"version", 1},
                                 {"nodes",
                                  {{"i", {{"type", type}}},
                                   {"e", {{"type", "ShaderNodeEmission"}, {"params", {{"Color", {{"node", "i"}, {"output", output}}}, {"Strength", 1.0}}}}}}},
                                 {"outputs", {{"surface", {{"node", "e"}}}}}});
    kit.add(std::move(mesh), kit.add_material(material), t);
    kit.look_at({0, 0, 5}, {0, 0, 0}, 0.2f);
    kit.scene.settings.width = kit.scene.settings.height = 4;
    return mean(kit.render());
}

TEST(Curves, info_nodes_read_what_the_geometry_knows) {
    auto m = std::make_shared<Mesh>();
    m->shape = Shape::Curves;
    m->positions = {{-3, 0, 0}, {-1, 0, 0}, {1, 0, 0}, {5, 0, 0}};
    m->radii = {0.1f, 0.1f, 0.3f, 0.1f};
    m->curve_first = {0, 4};
    EXPECT_NEAR(seen(m, "ShaderNodeHairInfo", "Is Strand").x, 1, 1e-6);
    EXPECT_NEAR(seen(m, "ShaderNodeHairInfo", "Length").x, 8, 1e-4);
    // Half way along the segment from a quarter to a half of the length, but for the spline's pace.
    EXPECT_NEAR(seen(m, "ShaderNodeHairInfo", "Intercept").x, 0.375, 0.02);
    EXPECT_NEAR(seen(m, "ShaderNodeHairInfo", "Thickness").x, 0.4, 0.03);
    EXPECT_NEAR(seen(m, "ShaderNodeHairInfo", "Tangent Normal").z, 1, 1e-3);
    EXPECT_NEAR(seen(m, "ShaderNodeHairInfo", "Random").x, element_random(0), 1e-5);
    auto ball = std::make_shared<Mesh>();
    ball->shape = Shape::Spheres;
    ball->positions = {{0.5f, 0, 0}};
    ball->radii = {1};
    EXPECT_NEAR(seen(ball, "ShaderNodePointInfo", "Radius", scaling(2)).x, 2, 1e-5);
    EXPECT_NEAR(seen(ball, "ShaderNodePointInfo", "Position", scaling(2)).x, 1, 1e-5);
    EXPECT_NEAR(seen(floor_quad(1), "ShaderNodeHairInfo", "Is Strand").x, 0, 0);
}

TEST(Curves, broken_numbers_meet_nothing_and_stop_nothing) {
    const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
    for (const float bad : {nan, inf, 1e38f, -1.f}) {
        auto m = bent_curve(CurveForm::Round);
        m->positions[1].x = bad;
        m->radii[2] = bad;
        SceneKit kit;
        kit.add(m, kit.add_material(diffuse(0.5f, 0.5f, 0.5f)));
        kit.scene.world.graph = emission(1);
        kit.scene.settings.samples = 1;
        const Image im = kit.render();
        for (const float x : im.layers[0].planes[0]) EXPECT_TRUE(std::isfinite(x)) << bad;
    }
    Scene scene;
    auto m = bent_curve(CurveForm::Round);
    m->curve_first = {0, 5, 4};
    scene.meshes.push_back(m);
    Diagnostics d;
    EXPECT_EQ(prepare_scene(std::make_shared<Scene>(scene), {}, d), nullptr);
    EXPECT_FALSE(d.ok());
}

TEST(Curves, directions_survive_their_code) {
    std::mt19937 rng(8);
    std::normal_distribution<float> g;
    for (int i = 0; i < 1000; ++i) {
        const Vec3f d = safe_normalize(Vec3f(g(rng), g(rng), g(rng)));
        float u, v;
        encode_direction(d, u, v);
        EXPECT_LT(length(decode_direction(u, v) - d), 1e-6f);
        const Vec3f t = safe_normalize(Vec3f(g(rng), g(rng), g(rng)));
        const Vec3f across = safe_normalize(cross(t, d));
        EXPECT_LT(length(around_curve(t, angle_around_curve(t, across)) - across), 1e-5f);
    }
}

}  // namespace
}  // namespace alder::testing
