// Scene documents: everything a Scene holds comes back; every fault is named with its place, all at once.
#include "render/import/scene_document.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "render/import/container.h"

namespace alder {
namespace {

using nlohmann::json;

const json kGraph = json::parse(R"({"version": 1, "nodes": {"s": {"type": "alSurface", "params": {"diffuseColor": [0.8, 0.2, 0.1]}}},
                                    "outputs": {"surface": {"node": "s"}}})");

json minimal() {
    return {{"alder_scene", 1},
            {"cameras", {{"cam", {{"look_at", {{"from", {0, -5, 1}}, {"to", {0, 0, 1}}}}, {"fov_degrees", 40}}}}},
            {"materials", {{"red", kGraph}}},
            {"meshes", {{"tri", {{"positions", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, {"triangles", {{0, 1, 2}}}}}}},
            {"instances", {{"a", {{"mesh", "tri"}, {"material", "red"}}}}}};
}

std::shared_ptr<const Scene> load(const json& document, Diagnostics& d, SceneLoadOptions options = {}) {
    return scene_from_json(document, options, d);
}

/// Loads, expects faults, and returns them as "pointer code" lines.
std::vector<std::string> faults(const json& document, SceneLoadOptions options = {}) {
    Diagnostics d;
    EXPECT_EQ(load(document, d, options), nullptr);
    std::vector<std::string> out;
    for (const Diagnostic& e : d.errors) {
        out.push_back(e.pointer + " " + e.code);
        EXPECT_FALSE(e.expected.empty()) << e.line();
    }
    return out;
}

std::string scratch(const std::string& name) {
    const std::filesystem::path dir = std::filesystem::path(ALDER_BINARY_DIR) / "test_scratch" / "scene";
    std::filesystem::create_directories(dir);
    return (dir / name).string();
}

Scene full_scene() {
    Scene s;
    s.name = "everything";
    auto mesh = std::make_shared<Mesh>();
    mesh->name = "grid";
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 5; ++x) mesh->positions.push_back(Vec3f(x * 0.3f, y / 3.0f, std::sin(float(x * y))));
    for (uint32_t y = 0; y < 4; ++y)
        for (uint32_t x = 0; x < 4; ++x) {
            const uint32_t a = y * 5 + x;
            mesh->triangles.push_back({a, a + 1, a + 6});
            mesh->triangles.push_back({a, a + 6, a + 5});
        }
    for (size_t c = 0; c < 96; ++c) {
        mesh->uv.push_back({float(c) / 7, -float(c) / 3});
        mesh->corner_normals.push_back(Vec3f(0, float(c) * 0.01f, 1));
        mesh->tangents.push_back(Vec3f(1, float(c), 0));
        mesh->tangent_signs.push_back(c % 2 ? 1.0f : -1.0f);
    }
    for (uint32_t f = 0; f < 32; ++f) {
        mesh->smooth.push_back(f % 3 == 0);
        mesh->face_material.push_back(f % 2);
    }
    for (size_t p = 0; p < 25; ++p) mesh->vertex_normals.push_back(Vec3f(0, 0, float(p)));
    mesh->generated_bounds = {Vec3f(-1, -2, -3), Vec3f(4, 5, 6.1f)};
    mesh->attributes = {{"heat", Domain::Face, 1, std::vector<float>(32, 0.1f)}, {"one", Domain::Mesh, 2, {3, 4}},
                        {"tint", Domain::Corner, 4, std::vector<float>(384, 1 / 3.0f)}, {"wear", Domain::Point, 3, std::vector<float>(75, -2)}};
    s.meshes.push_back(mesh);
    Diagnostics d;
    s.materials = {{"red", build_material(kGraph, {}, d), 3}, {"also red", build_material(kGraph, {}, d), 0}};
    Instance i;
    i.name = "grid object";
    i.object_to_world = {{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11.5f, 12}};
    i.materials = {0, 1};
    i.visibility = kVisibleAll & ~uint32_t(kVisibleGlossy | kVisibleShadow);
    i.random = 0.3f;
    i.pass_index = 7;
    i.color = {0.1f, 0.2f, 0.3f};
    i.light_group = 8;
    s.instances.push_back(i);
    i.name = "leaf";
    for (int k = 0; k < 50; ++k) {
        i.object_to_world.m[3] = float(k) / 3;
        i.random = float(k) / 50;
        s.instances.push_back(i);
    }
    for (const LightKind kind : {LightKind::Point, LightKind::Spot, LightKind::Sun, LightKind::Area}) {
        Light l;
        l.name = "light " + std::to_string(int(kind));
        l.kind = kind;
        l.strength = 12.3f;
        l.radius = 0.7f;
        l.spot_angle = 1.1f;
        l.spot_blend = 0.4f;
        l.angle = 0.01f;
        l.shape = Light::Shape::Ellipse;
        l.size_x = 0.3f;
        l.size_y = 0.7f;
        l.color = {1, 0.5f, 0.25f};
        l.cast_shadow = false;
        l.normalize = false;
        l.light_group = 2;
        l.visibility = kVisibleCamera;
        s.lights.push_back(l);
    }
    s.lights[0].graph = s.materials[0].graph;
    s.world.graph = s.materials[0].graph;
    s.world.light_group = 4;
    s.world.visibility = kVisibleDiffuse;
    s.world.importance_resolution = 333;
    s.camera.name = "main";
    s.camera.kind = Camera::Kind::Orthographic;
    s.camera.to_world = i.object_to_world;
    s.camera.ortho_scale = 3.3f;
    s.camera.near_clip = 0.2f;
    s.camera.far_clip = 77.7f;
    s.camera.shift_x = 0.1f;
    s.camera.shift_y = -0.2f;
    s.camera.aperture_radius = 0.05f;
    s.camera.focus_distance = 2.2f;
    Camera second;
    second.name = "second";
    second.fov_x = 1.23f;
    s.other_cameras = {second};
    s.settings = {640, 360, 123, 4000000000u, 11, 10, 9, 8, 6, 7, 1.5f, 2.5f, true, 1.5f, RenderSettings::Filter::BlackmanHarris, false, false};
    return s;
}

void expect_same(const Mesh& a, const Mesh& b) {
    const auto same = [](const std::vector<Vec3f>& x, const std::vector<Vec3f>& y) {
        return x.size() == y.size() && std::equal(x.begin(), x.end(), y.begin(), [](Vec3f p, Vec3f q) { return p.x == q.x && p.y == q.y && p.z == q.z; });
    };
    EXPECT_EQ(a.name, b.name);
    EXPECT_TRUE(same(a.positions, b.positions));
    EXPECT_TRUE(same(a.vertex_normals, b.vertex_normals));
    EXPECT_TRUE(same(a.corner_normals, b.corner_normals));
    EXPECT_TRUE(same(a.tangents, b.tangents));
    EXPECT_TRUE(same({a.generated_bounds[0], a.generated_bounds[1]}, {b.generated_bounds[0], b.generated_bounds[1]}));
    EXPECT_EQ(a.triangles, b.triangles);
    EXPECT_EQ(a.smooth, b.smooth);
    EXPECT_EQ(a.face_material, b.face_material);
    EXPECT_EQ(a.uv, b.uv);
    EXPECT_EQ(a.tangent_signs, b.tangent_signs);
    ASSERT_EQ(a.attributes.size(), b.attributes.size());
    for (size_t i = 0; i < a.attributes.size(); ++i) {
        EXPECT_EQ(a.attributes[i].name, b.attributes[i].name);
        EXPECT_EQ(a.attributes[i].domain, b.attributes[i].domain);
        EXPECT_EQ(a.attributes[i].channels, b.attributes[i].channels);
        EXPECT_EQ(a.attributes[i].values, b.attributes[i].values);
    }
}

TEST(SceneDocument, everything_a_scene_holds_comes_back_from_a_container) {
    const Scene s = full_scene();
    std::string error;
    const std::string path = scratch("full.alder");
    ASSERT_TRUE(write_scene(path, s, error)) << error;
    Diagnostics d;
    const auto back = load_scene(path, {}, d);
    ASSERT_TRUE(back) << (d.errors.empty() ? "" : d.errors[0].line());
    EXPECT_EQ(back->name, s.name);
    ASSERT_EQ(back->meshes.size(), 1u);
    expect_same(*back->meshes[0], *s.meshes[0]);
    ASSERT_EQ(back->materials.size(), 2u);
    const auto red = std::find_if(back->materials.begin(), back->materials.end(), [](const SceneMaterial& m) { return m.name == "red"; });
    ASSERT_NE(red, back->materials.end());
    EXPECT_EQ(red->pass_index, 3);
    EXPECT_EQ(red->graph->digest(), s.materials[0].graph->digest());
    ASSERT_EQ(back->instances.size(), s.instances.size());
    for (size_t i = 0; i < s.instances.size(); ++i) {
        const Instance &a = s.instances[i], &b = back->instances[i];
        EXPECT_EQ(a.name, b.name);
        EXPECT_EQ(a.object_to_world.m, b.object_to_world.m);
        EXPECT_EQ(a.visibility, b.visibility);
        EXPECT_EQ(a.random, b.random);
        EXPECT_EQ(a.pass_index, b.pass_index);
        EXPECT_EQ(a.color.y, b.color.y);
        EXPECT_EQ(a.light_group, b.light_group);
        ASSERT_EQ(b.materials.size(), 2u);
        EXPECT_EQ(back->materials[b.materials[0]].name, "red");
    }
    ASSERT_EQ(back->lights.size(), 4u);
    for (size_t i = 0; i < 4; ++i) {
        const Light &a = s.lights[i], &b = back->lights[i];
        EXPECT_EQ(a.kind, b.kind);
        EXPECT_EQ(a.strength, b.strength);
        EXPECT_EQ(a.radius, b.radius);
        EXPECT_EQ(a.spot_angle, b.spot_angle);
        EXPECT_EQ(a.spot_blend, b.spot_blend);
        EXPECT_EQ(a.angle, b.angle);
        EXPECT_EQ(a.shape, b.shape);
        EXPECT_EQ(a.size_x, b.size_x);
        EXPECT_EQ(a.size_y, b.size_y);
        EXPECT_EQ(a.spread, b.spread);
        EXPECT_EQ(a.color.z, b.color.z);
        EXPECT_EQ(a.cast_shadow, b.cast_shadow);
        EXPECT_EQ(a.normalize, b.normalize);
        EXPECT_EQ(a.light_group, b.light_group);
        EXPECT_EQ(a.visibility, b.visibility);
        EXPECT_EQ(a.graph != nullptr, b.graph != nullptr);
    }
    EXPECT_TRUE(back->world.graph);
    EXPECT_EQ(back->world.light_group, 4);
    EXPECT_EQ(back->world.visibility, s.world.visibility);
    EXPECT_EQ(back->world.importance_resolution, 333);
    const Camera &c = s.camera, &k = back->camera;
    EXPECT_EQ(k.name, "main");
    EXPECT_EQ(k.kind, c.kind);
    EXPECT_EQ(k.to_world.m, c.to_world.m);
    EXPECT_EQ(k.fov_x, c.fov_x);
    EXPECT_EQ(k.ortho_scale, c.ortho_scale);
    EXPECT_EQ(k.near_clip, c.near_clip);
    EXPECT_EQ(k.far_clip, c.far_clip);
    EXPECT_EQ(k.shift_x, c.shift_x);
    EXPECT_EQ(k.shift_y, c.shift_y);
    EXPECT_EQ(k.aperture_radius, c.aperture_radius);
    EXPECT_EQ(k.focus_distance, c.focus_distance);
    ASSERT_EQ(back->other_cameras.size(), 1u);
    EXPECT_EQ(back->other_cameras[0].fov_x, 1.23f);
    const RenderSettings &x = s.settings, &y = back->settings;
    EXPECT_EQ(std::tie(x.width, x.height, x.samples, x.seed, x.max_bounces, x.diffuse_bounces, x.glossy_bounces, x.transmission_bounces),
              std::tie(y.width, y.height, y.samples, y.seed, y.max_bounces, y.diffuse_bounces, y.glossy_bounces, y.transmission_bounces));
    EXPECT_EQ(std::tie(x.volume_bounces, x.transparent_bounces, x.clamp_direct, x.clamp_indirect, x.film_transparent, x.filter_width, x.filter, x.caustics_reflective, x.caustics_refractive),
              std::tie(y.volume_bounces, y.transparent_bounces, y.clamp_direct, y.clamp_indirect, y.film_transparent, y.filter_width, y.filter, y.caustics_reflective, y.caustics_refractive));
    // And written again it is the same file.
    const std::string again = scratch("again.alder");
    ASSERT_TRUE(write_scene(again, *back, error)) << error;
    Diagnostics d2;
    const auto twice = load_scene(again, {}, d2);
    ASSERT_TRUE(twice);
    std::vector<uint8_t> b1, b2;
    EXPECT_EQ(scene_to_json(*back, "b", b1), scene_to_json(*twice, "b", b2));
    EXPECT_EQ(b1, b2);
}

TEST(SceneDocument, small_documents_need_little_and_get_the_rest_derived) {
    Diagnostics d;
    json doc = minimal();
    const auto s = load(doc, d);
    ASSERT_TRUE(s) << d.errors[0].line();
    EXPECT_EQ(s->meshes[0]->vertex_normals.size(), 3u);
    EXPECT_EQ(s->meshes[0]->vertex_normals[1].z, 1);
    EXPECT_EQ(s->meshes[0]->generated_bounds[1].x, 1);
    EXPECT_NEAR(s->camera.fov_x, 0.6981317f, 1e-6f);
    const Vec3f forward = s->camera.to_world.vector({0, 0, -1}), up = s->camera.to_world.vector({0, 1, 0});
    EXPECT_NEAR(forward.y, 1, 1e-6f);
    EXPECT_NEAR(up.z, 1, 1e-6f);
    doc["instances"]["a"].erase("material");
    Diagnostics d2;
    // Without a material: Blender's grey, if this build has its node.
    const auto grey = load(doc, d2);
    if (grey) {
        EXPECT_EQ(grey->materials[grey->instances[0].materials[0]].name, "");
    }
}

TEST(SceneDocument, arrays_may_be_written_out_base64_or_buffers_of_several_types) {
    std::vector<uint8_t> buffer(2, 0xee);   // an odd beginning: no alignment is asked for
    const auto append = [&](const void* p, size_t n) {
        const size_t at = buffer.size();
        buffer.insert(buffer.end(), static_cast<const uint8_t*>(p), static_cast<const uint8_t*>(p) + n);
        return at;
    };
    const double positions[] = {0, 0, 0, 1, 0, 0, 0, 0.1, 0};
    const uint16_t triangles[] = {0, 1, 2};
    const uint16_t halves[] = {0x3c00, 0xc000, 0x0001};   // 1, -2, smallest denormal
    json doc = minimal();
    json& mesh = doc["meshes"]["tri"];
    mesh["positions"] = {{"buffer", "b"}, {"type", "f64"}, {"offset", append(positions, sizeof(positions))}, {"count", 3}};
    mesh["triangles"] = {{"buffer", "b"}, {"type", "u16"}, {"offset", append(triangles, sizeof(triangles))}, {"count", 1}};
    mesh["attributes"]["h"] = {{"domain", "point"}, {"channels", 1}, {"values", {{"base64", encode_base64(halves, sizeof(halves))}, {"type", "f16"}}}};
    mesh["attributes"]["flat"] = {{"channels", 2}, {"values", {1, 2, 3, 4, 5, 6}}};
    SceneLoadOptions options;
    options.read_buffer = [&](const std::string& name, std::vector<uint8_t>& bytes, std::string&) { return name == "b" && (bytes = buffer, true); };
    Diagnostics d;
    const auto s = load(doc, d, options);
    ASSERT_TRUE(s) << d.errors[0].line();
    const Mesh& m = *s->meshes[0];
    EXPECT_EQ(m.positions[2].y, 0.1f);
    EXPECT_EQ(m.triangles[0], (std::array<uint32_t, 3>{0, 1, 2}));
    EXPECT_EQ(m.attributes[1].values, (std::vector<float>{1, -2, 5.9604645e-8f}));
    EXPECT_EQ(m.attributes[0].values, (std::vector<float>{1, 2, 3, 4, 5, 6}));
}

TEST(SceneDocument, all_faults_are_reported_at_once_with_their_places) {
    json doc = minimal();
    doc["camera"] = "cma";
    doc["settings"] = {{"resolution", {0, 10}}, {"samples", 1.5}, {"sed", 1}};
    doc["meshes"]["tri"]["triangles"] = {{0, 1, 3}};
    doc["meshes"]["other/one"] = {{"positions", {{0, 0, 0}, {1, 0}}}, {"triangles", json::array()}};
    doc["instances"]["a"]["material"] = "rde";
    doc["instances"]["b"] = {{"mesh", "tir"}, {"transform", {1, 2, 3}}};
    doc["lights"]["l"] = {{"type", "lamp"}, {"strength", "bright"}, {"light_group", 9}};
    doc["materials"]["broken"] = {{"version", 1}, {"nodes", {{"x", {{"type", "alSurfaec"}}}}}, {"outputs", {{"surface", {{"node", "x"}}}}}};
    const std::vector<std::string> f = faults(doc);
    for (const char* expected :
         {"/camera unknown-camera", "/settings/resolution out-of-range", "/settings/samples wrong-type", "/settings/sed unknown-member",
          "/meshes/tri/triangles/0 out-of-range", "/meshes/other~1one/positions/1 wrong-type", "/instances/a/material unknown-material",
          "/instances/b/mesh unknown-mesh", "/instances/b/transform wrong-type", "/lights/l/type unknown-value", "/lights/l/strength wrong-type",
          "/lights/l/light_group out-of-range"}) {
        EXPECT_NE(std::find(f.begin(), f.end(), expected), f.end()) << expected;
    }
    EXPECT_TRUE(std::any_of(f.begin(), f.end(), [](const std::string& s) { return s.starts_with("/materials/broken/nodes/x"); }));
    Diagnostics d;
    load(doc, d);
    for (const Diagnostic& e : d.errors) {
        const std::string wanted = e.pointer == "/camera" ? "cam" : e.pointer == "/settings/sed" ? "seed" : e.pointer == "/instances/a/material" ? "red" : e.suggest;
        EXPECT_EQ(e.suggest, wanted) << e.pointer;
    }
}

TEST(SceneDocument, wrong_arrays_are_refused_before_they_are_used) {
    const auto with = [](const char* member, const json& value) {
        json doc = minimal();
        doc["meshes"]["tri"][member] = value;
        SceneLoadOptions options;
        options.read_buffer = [](const std::string& name, std::vector<uint8_t>& bytes, std::string& error) {
            bytes.assign(36, 0x7f);
            error = "not here";
            return name == "b";
        };
        return faults(doc, options);
    };
    EXPECT_EQ(with("uv", {{0, 0}, {1, 1}})[0], "/meshes/tri/uv wrong-length");
    EXPECT_EQ(with("normals", {{"buffer", "nope"}})[0], "/meshes/tri/normals/buffer asset-missing");
    EXPECT_EQ(with("normals", {{"buffer", "b"}, {"offset", 37}})[0], "/meshes/tri/normals/offset out-of-range");
    EXPECT_EQ(with("normals", {{"buffer", "b"}, {"count", 18446744073709551615ull}})[0], "/meshes/tri/normals/count out-of-range");
    EXPECT_EQ(with("normals", {{"buffer", "b"}, {"offset", -1}})[0], "/meshes/tri/normals/offset wrong-type");
    EXPECT_EQ(with("normals", {{"buffer", "b"}, {"type", "f31"}})[0], "/meshes/tri/normals/type unknown-value");
    EXPECT_EQ(with("normals", {{"base64", "####"}})[0], "/meshes/tri/normals/base64 wrong-value");
    EXPECT_EQ(with("normals", {{"base64", "AAA"}})[0], "/meshes/tri/normals wrong-value");
    EXPECT_EQ(with("normals", "AAAA")[0], "/meshes/tri/normals wrong-type");
    EXPECT_EQ(with("triangles", {{"buffer", "b"}, {"type", "f32"}})[0], "/meshes/tri/triangles/type wrong-type");
    EXPECT_EQ(with("triangles", {{0, 1, -1}})[0], "/meshes/tri/triangles/0 out-of-range");
    EXPECT_EQ(with("triangles", {{0, 1, 0.5}})[0], "/meshes/tri/triangles/0 out-of-range");
    EXPECT_EQ(with("face_material", {4})[0], "/instances/a/materials wrong-length");
    const uint32_t nan = 0x7fc00000;
    const float bad[9] = {0, 0, 0, 0, std::bit_cast<float>(nan), 0, 0, 0, 0};
    EXPECT_EQ(with("normals", {{"base64", encode_base64(bad, sizeof(bad))}})[0], "/meshes/tri/normals/1 nonfinite");
    SceneLoadOptions small;
    small.limits.array_bytes = 40;
    EXPECT_EQ(faults(minimal(), small)[0], "/meshes/tri/triangles limit-exceeded");
    small = {};
    small.limits.instances = 0;
    EXPECT_EQ(faults(minimal(), small)[0], "/instances limit-exceeded");
}

TEST(SceneDocument, what_is_not_there_yet_says_so_or_is_left_out_if_lenient) {
    json doc = minimal();
    doc["volumes"]["smoke"] = {{"density", 1}};
    doc["instances"]["a"]["shadow_catcher"] = true;
    doc["flavour"] = "sweet";
    const std::vector<std::string> f = faults(doc);
    EXPECT_EQ(f, (std::vector<std::string>{"/instances/a/shadow_catcher unsupported", "/volumes unsupported", "/flavour unknown-member"}));
    Diagnostics d;
    const auto s = load(doc, d, {.lenient = true});
    ASSERT_TRUE(s);
    EXPECT_EQ(s->warnings.size(), 3u);
    Diagnostics d2;
    EXPECT_FALSE(load({{"alder_scene", 2}}, d2));
    EXPECT_FALSE(load(json::array(), d2));
    EXPECT_FALSE(load({{"meshes", 1}}, d2));
}

TEST(SceneDocument, curves_points_and_motion_come_back_as_they_were) {
    json doc = minimal();
    doc["curves"]["tri"] = {{"positions", {0, 0, 0, 1, 0, 0, 2, 1, 0, 5, 5, 5, 6, 5, 5}}, {"counts", {3, 2}}, {"radii", {0.1, 0.2, 0.3, 0.4, 0.5}}, {"form", "ribbon"},
                            {"subdivisions", 3}, {"normals", {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}},
                            {"attributes", {{"root", {{"domain", "curve"}, {"channels", 2}, {"values", {1, 2, 3, 4}}}}}}};
    doc["points"]["dust"] = {{"positions", {0, 0, 0, 1, 1, 1}}, {"motion", {{"steps", 2}, {"positions", {0, 0, 0, 1, 1, 1, 0, 0, 1, 1, 1, 2}}, {"radii", {1, 2, 3, 4}}}}};
    doc["meshes"]["tri"]["motion"] = {{"steps", 3}, {"positions", {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, 0, 0, 2, 1, 0, 2, 0, 1, 2}}};
    doc["instances"]["hair"] = {{"curves", "tri"}, {"holdout", true}};
    doc["instances"]["cloud"] = {{"points", "dust"}, {"transforms", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0}},
                                 {"motion", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 2, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 3, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 4, 0, 1, 0, 0, 0, 0, 1, 0}}};
    doc["settings"]["shutter_curve"] = {0, 1, 0};
    doc["settings"]["exposure"] = 2;
    doc["settings"]["filter_glossy"] = 0.5;
    json& camera = doc["cameras"].begin().value();
    camera["motion"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0};
    camera["type"] = "panoramic";
    camera["panorama"] = "fisheye_equisolid";
    camera["fisheye_lens_mm"] = 12;
    camera["aperture_blades"] = 5;
    camera["aperture_rotation_degrees"] = 30;
    Diagnostics d;
    const auto check = [](const Scene& s) {
        ASSERT_EQ(s.meshes.size(), 3u);
        const Mesh &mesh = *s.meshes[0], &curves = *s.meshes[1], &points = *s.meshes[2];
        EXPECT_EQ(mesh.motion_steps, 3);
        EXPECT_EQ(mesh.motion_normals.size(), 9u);
        EXPECT_EQ(curves.shape, Shape::Curves);
        EXPECT_EQ(curves.curve_first, (std::vector<uint32_t>{0, 3, 5}));
        EXPECT_EQ(curves.curve_form, CurveForm::Ribbon);
        EXPECT_EQ(curves.curve_subdivisions, 3);
        EXPECT_EQ(curves.curve_normals.size(), 5u);
        EXPECT_FLOAT_EQ(curves.radii[4], 0.5f);
        EXPECT_EQ(curves.attributes.at(0).domain, Domain::Curve);
        EXPECT_EQ(points.shape, Shape::Spheres);
        EXPECT_EQ(points.motion_radii, (std::vector<float>{1, 2, 3, 4}));
        EXPECT_FLOAT_EQ(points.radii[0], 0.005f);
        int clouds = 0;
        for (const Instance& i : s.instances) {
            if (s.meshes[i.mesh]->shape == Shape::Curves) { EXPECT_TRUE(i.holdout); }
            if (s.meshes[i.mesh]->shape != Shape::Spheres) continue;
            ASSERT_EQ(i.motion.size(), 2u);
            EXPECT_EQ(i.motion[1].m[3], i.object_to_world.m[3] == 0 ? 2 : 4);
            ++clouds;
        }
        EXPECT_EQ(clouds, 2);
        EXPECT_EQ(s.settings.shutter_curve, (std::vector<float>{0, 1, 0}));
        EXPECT_EQ(s.settings.exposure, 2);
        EXPECT_EQ(s.settings.filter_glossy, 0.5f);
        EXPECT_EQ(s.camera.motion.size(), 2u);
        EXPECT_EQ(s.camera.panorama, Camera::Panorama::FisheyeEquisolid);
        EXPECT_EQ(s.camera.fisheye_lens, 12);
        EXPECT_EQ(s.camera.aperture_blades, 5);
        EXPECT_NEAR(s.camera.aperture_rotation, 0.5235988f, 1e-6);
    };
    const auto s = load(doc, d);
    for (const Diagnostic& e : d.errors) ADD_FAILURE() << e.line();
    ASSERT_TRUE(s);
    check(*s);
    std::vector<uint8_t> buffer;
    const json written = scene_to_json(*s, "b", buffer);
    SceneLoadOptions options;
    options.read_buffer = [&](const std::string&, std::vector<uint8_t>& bytes, std::string&) {
        bytes = buffer;
        return true;
    };
    const auto again = load(written, d, options);
    for (const Diagnostic& e : d.errors) ADD_FAILURE() << e.line();
    ASSERT_TRUE(again);
    check(*again);
    std::vector<uint8_t> second;
    EXPECT_EQ(scene_to_json(*again, "b", second).dump(), written.dump());
}

TEST(SceneDocument, faults_of_curves_and_motion_are_named) {
    const auto with = [](const char* where, const json& value) {
        json doc = minimal();
        doc[json::json_pointer(where)] = value;
        const auto f = faults(doc);
        return f.empty() ? std::string("none") : f[0];
    };
    EXPECT_EQ(with("/curves", {{"h", {{"positions", {0, 0, 0}}}}}), "/curves/h/counts missing-member");
    EXPECT_EQ(with("/curves", {{"h", {{"positions", {0, 0, 0}}, {"counts", {2}}}}}), "/curves/h/counts wrong-length");
    EXPECT_EQ(with("/curves", {{"h", {{"positions", {0, 0, 0}}, {"counts", {1, 0}}}}}), "/curves/h/counts wrong-length");
    EXPECT_EQ(with("/curves", {{"h", {{"positions", {0, 0, 0}}, {"counts", {1}}, {"radii", {1, 2}}}}}), "/curves/h/radii wrong-length");
    EXPECT_EQ(with("/points", {{"p", {{"positions", {0, 0, 0}}, {"attributes", {{"x", {{"domain", "face"}, {"channels", 1}, {"values", {1}}}}}}}}}),
              "/points/p/attributes/x/domain wrong-value");
    EXPECT_EQ(with("/instances/a/motion", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}), "/instances/a/motion wrong-length");
    EXPECT_EQ(with("/instances/a/curves", "tri"), "/instances/a wrong-value");
    EXPECT_EQ(with("/meshes/tri/motion", {{"steps", 1}, {"positions", {0}}}), "/meshes/tri/motion/steps out-of-range");
}

TEST(SceneDocument, a_shading_edit_keeps_the_meshes) {
    const json before = minimal();
    json after = before;
    after["materials"]["red"]["nodes"]["s"]["params"]["diffuseColor"] = {0.1, 0.2, 0.9};
    Diagnostics d;
    const auto a = load(before, d);
    ASSERT_TRUE(a);
    SceneLoadOptions options;
    options.previous = a.get();
    options.previous_document = &before;
    const auto b = load(after, d, options);
    ASSERT_TRUE(b);
    EXPECT_EQ(a->meshes[0], b->meshes[0]);
    EXPECT_NE(a->materials[0].graph->digest(), b->materials[0].graph->digest());
    after["meshes"]["tri"]["positions"][0][0] = 0.5;
    const auto c = load(after, d, options);
    ASSERT_TRUE(c);
    EXPECT_NE(a->meshes[0], c->meshes[0]);
}

TEST(SceneDocument, graphs_posted_by_name_replace_materials) {
    SceneLoadOptions options;
    options.material_overrides["red"] = kGraph;
    options.material_overrides["red"]["nodes"]["s"]["params"]["diffuseColor"] = {0, 1, 0};
    Diagnostics d;
    const auto s = load(minimal(), d, options);
    ASSERT_TRUE(s);
    EXPECT_EQ(s->materials[0].graph->document()["nodes"]["s"]["params"]["diffuseColor"], json({0, 1, 0}));
    options.material_overrides["rad"] = kGraph;
    EXPECT_EQ(faults(minimal(), options)[0], "/materials/rad unknown-material");
}

TEST(SceneDocument, names_never_lead_out_of_the_folder) {
    std::ofstream(scratch("secret.bin")) << std::string(36, '\0');
    std::filesystem::create_directories(scratch("inner"));
    std::filesystem::remove(scratch("inner/link.bin"));
    std::filesystem::create_symlink(scratch("secret.bin"), scratch("inner/link.bin"));
    std::ofstream(scratch("inner/own.bin")) << std::string(36, '\0');
    const auto load_with = [](const std::string& buffer) {
        json doc = minimal();
        doc["meshes"]["tri"]["positions"] = {{"buffer", buffer}, {"count", 3}};
        std::ofstream(scratch("inner/doc.json")) << doc;
        Diagnostics d;
        const auto s = load_scene(scratch("inner/doc.json"), {}, d);
        return s ? std::string("loaded") : d.errors.at(0).pointer + " " + d.errors[0].code;
    };
    EXPECT_EQ(load_with("own.bin"), "loaded");
    EXPECT_EQ(load_with("../inner/own.bin"), "loaded");
    for (const std::string& name : {std::string("../secret.bin"), scratch("secret.bin"), std::string("link.bin"), std::string("")}) {
        EXPECT_EQ(load_with(name), "/meshes/tri/positions/buffer asset-missing") << name;
    }
}

TEST(SceneDocument, the_manual_begins_with_an_example_that_works) {
    std::ifstream in(std::string(ALDER_SOURCE_DIR) + "/docs/scene-document.md");
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    const size_t begin = text.find("```json\n") + 8, end = text.find("```", begin);
    ASSERT_NE(end, std::string::npos);
    Diagnostics d;
    const auto s = load(json::parse(text.substr(begin, end - begin)), d);
    ASSERT_TRUE(s) << d.errors[0].line();
    EXPECT_EQ(s->instances.size(), 2u);
    EXPECT_EQ(s->lights.size(), 1u);
}

TEST(SceneDocument, files_are_told_apart_by_their_content) {
    const auto fault = [](const std::string& name, const std::string& content) {
        std::ofstream(scratch(name), std::ios::binary) << content;
        Diagnostics d;
        EXPECT_EQ(load_scene(scratch(name), {}, d), nullptr);
        return d.errors.at(0).code;
    };
    std::ofstream(scratch("no_extension")) << minimal();
    Diagnostics d;
    EXPECT_TRUE(load_scene(scratch("no_extension"), {}, d));
    EXPECT_EQ(fault("bad.json", "{\"alder_scene\": 1,"), "malformed-json");
    EXPECT_EQ(fault("bad.alder", "PK\3\4 and nothing else"), "unreadable");
    EXPECT_EQ(fault("bad.glb", "glTF and nothing else"), "unreadable");
    EXPECT_EQ(fault("empty.json", ""), "unreadable");
    EXPECT_EQ(fault("x.ass", "options { }"), "unsupported");
    Diagnostics d2;
    EXPECT_EQ(load_scene(scratch("not_there.json"), {}, d2), nullptr);
    EXPECT_EQ(d2.errors.at(0).code, "unreadable");
}

TEST(SceneDocument, the_writers_report_becomes_warnings) {
    json document = minimal();
    document["report"] = {{"unsupported", {{{"what", "hair curves"}, {"where", {"head", "arm"}}}, {{"what", "motion blur"}, {"where", json::array()}}}},
                          {"notes", {{{"what", "denoising"}, {"where", {"scene"}}}}}};
    Diagnostics d;
    const auto scene = load(document, d);
    ASSERT_NE(scene, nullptr);
    ASSERT_EQ(scene->warnings.size(), 2u);
    EXPECT_NE(scene->warnings[0].find("hair curves"), std::string::npos) << scene->warnings[0];
    EXPECT_NE(scene->warnings[0].find("head, arm"), std::string::npos) << scene->warnings[0];
    document["report"]["unsuported"] = json::array();
    EXPECT_EQ(faults(document), std::vector<std::string>{"/report/unsuported unknown-member"});
}

}  // namespace
}  // namespace alder
