// Preview stages: complete scenes, shared geometry, errors that say what there is.
#include "render/stages.h"

#include <gtest/gtest.h>

namespace alder {
namespace {

TEST(Stages, every_named_stage_is_a_complete_scene) {
    for (const std::string_view name : stage_names()) {
        Diagnostics d;
        const auto s = make_stage(name, nullptr, 128, d);
        ASSERT_TRUE(s) << name << ": " << (d.errors.empty() ? "" : d.errors[0].line());
        EXPECT_EQ(s->settings.width, 128);
        EXPECT_EQ(s->settings.height, 128);
        EXPECT_EQ(s->materials[0].name, "subject");
        for (const SceneMaterial& m : s->materials) EXPECT_TRUE(m.graph && (m.graph->has_surface() || (name == "volume" && m.graph->has_volume()))) << m.name;
        EXPECT_TRUE(s->world.graph);
        bool subject = false;
        size_t triangles = 0;
        for (const Instance& i : s->instances) {
            ASSERT_LT(i.mesh, s->meshes.size());
            ASSERT_LT(i.materials.at(0), s->materials.size());
            subject |= i.materials[0] == 0;
            triangles += s->meshes[i.mesh]->primitive_count();
        }
        EXPECT_TRUE(subject) << name;
        EXPECT_LE(triangles, 100000u) << name;
        EXPECT_GT(s->camera.to_world.vector(Vec3f(0, 0, -1)).y, 0.9f) << "seen from the front";
        int groups = 0;
        for (const Light& l : s->lights) {
            groups |= 1 << l.light_group;
            EXPECT_FALSE(l.visibility & kVisibleCamera) << l.name;
            // Lights shine along their -Z: towards the subject.
            const Vec3f from = l.to_world.point(Vec3f(0, 0, 0)), along = l.to_world.vector(Vec3f(0, 0, -1));
            EXPECT_GT(dot(along, Vec3f(0, 0, 1.1f) - from), 0) << l.name;
        }
        EXPECT_EQ(groups, 1 << 1 | 1 << 2 | 1 << 3) << "key, fill, rim";
    }
}

TEST(Stages, material_zero_is_the_posted_one_and_geometry_is_shared) {
    Diagnostics d;
    const auto red = build_material(nlohmann::json::parse(R"({"version": 1, "nodes": {"s": {"type": "alSurface", "params": {"diffuseColor": [1, 0, 0]}}},
                                                            "outputs": {"surface": {"node": "s"}}})"), {}, d);
    ASSERT_TRUE(red);
    const auto a = make_stage("shaderball", red, 64, d), b = make_stage("shaderball", nullptr, 256, d);
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->materials[0].graph, red);
    EXPECT_NE(b->materials[0].graph, red);
    ASSERT_EQ(a->meshes.size(), b->meshes.size());
    for (size_t i = 0; i < a->meshes.size(); ++i) EXPECT_EQ(a->meshes[i], b->meshes[i]);
}

TEST(Stages, unknown_stages_are_errors) {
    Diagnostics d;
    EXPECT_FALSE(make_stage("shaderbal", nullptr, 64, d));
    ASSERT_EQ(d.errors.size(), 1u);
    EXPECT_EQ(d.errors[0].suggest, "shaderball");
    EXPECT_NE(d.errors[0].line().find("cloth, hair, volume"), std::string::npos) << d.errors[0].line();
    EXPECT_FALSE(make_stage("shaderbal", nullptr, 64));
}

}  // namespace
}  // namespace alder
