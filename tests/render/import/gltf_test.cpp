// glTF: a file written by Blender comes back as Blender says it was; broken files are errors that name the place.
#include "render/import/gltf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "nodes/schema.h"
#include "render/geometry/mesh_build.h"

namespace alder {
namespace {

using nlohmann::json;

const std::string kSample = std::string(ALDER_SOURCE_DIR) + "/tests/data/gltf_sample.glb";

json facts() { return json::parse(std::ifstream(std::string(ALDER_SOURCE_DIR) + "/tests/data/gltf_sample.json")); }
std::vector<uint8_t> sample_bytes() {
    std::ifstream in(kSample, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// Materials do not matter to geometry: all are replaced by one that every build has.
SceneLoadOptions plain(std::initializer_list<const char*> names) {
    SceneLoadOptions o;
    for (const char* n : names) {
        o.material_overrides[n] = json::parse(R"({"version": 1, "nodes": {"s": {"type": "alSurface"}}, "outputs": {"surface": {"node": "s"}}})");
    }
    return o;
}

std::shared_ptr<const Scene> load_sample() {
    Diagnostics d;
    const auto s = load_scene(kSample, plain({"painted", "glass", "lacquer"}), d);
    EXPECT_TRUE(s) << (d.errors.empty() ? "" : d.errors[0].line());
    return s;
}

void expect_matrix(const Transform& t, const json& expected, const std::string& what) {
    for (int i = 0; i < 12; ++i) EXPECT_NEAR(t.m[i], expected[i].get<float>(), 2e-6f * (1 + std::abs(expected[i].get<float>()))) << what << " " << i;
}

TEST(Gltf, objects_stand_where_blender_had_them) {
    const auto s = load_sample();
    ASSERT_TRUE(s);
    const json f = facts();
    ASSERT_EQ(s->instances.size(), f["objects"].size());
    EXPECT_EQ(s->meshes.size(), 2u) << "two objects share one mesh";
    for (const Instance& i : s->instances) {
        const json& o = f["objects"][i.name];
        ASSERT_FALSE(o.is_null()) << i.name;
        expect_matrix(i.object_to_world, o["matrix"], i.name);
        const Mesh& m = *s->meshes[i.mesh];
        Vec3f lo(1e9f), hi(-1e9f);
        double area = 0;
        std::vector<double> by_material(i.materials.size(), 0);
        for (const Vec3f& p : m.positions) {
            const Vec3f w = i.object_to_world.point(p);
            for (int k = 0; k < 3; ++k) {
                lo[k] = std::min(lo[k], w[k]);
                hi[k] = std::max(hi[k], w[k]);
            }
        }
        for (uint32_t t = 0; t < m.triangles.size(); ++t) {
            const auto& v = m.triangles[t];
            const double a = 0.5 * length(cross(m.positions[v[1]] - m.positions[v[0]], m.positions[v[2]] - m.positions[v[0]]));
            area += a;
            by_material[m.face_material.empty() ? 0 : m.face_material[t]] += a;
        }
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(lo[k], o["min"][k].get<float>(), 1e-5f) << i.name;
            EXPECT_NEAR(hi[k], o["max"][k].get<float>(), 1e-5f) << i.name;
        }
        EXPECT_NEAR(area, o["area"].get<double>(), 2e-2 * area) << i.name;   // polygons of the ball are not quite flat
        ASSERT_EQ(i.materials.size(), o["materials"].size());
        for (size_t k = 0; k < i.materials.size(); ++k) {
            EXPECT_EQ(s->materials[i.materials[k]].name, o["materials"][k].get<std::string>());
            EXPECT_NEAR(by_material[k], o["area_by_material"][k].get<double>(), 2e-2 * area);
        }
    }
}

TEST(Gltf, lights_and_camera_are_blenders) {
    const auto s = load_sample();
    ASSERT_TRUE(s);
    const json f = facts();
    ASSERT_EQ(s->lights.size(), 3u);
    for (const Light& l : s->lights) {
        const json& o = f["lights"][l.name];
        ASSERT_FALSE(o.is_null()) << l.name;
        EXPECT_NEAR(l.strength, o["energy"].get<float>(), 1e-4f * l.strength) << l.name;
        EXPECT_NEAR(l.color.y, o["color"][1].get<float>(), 1e-6f);
        expect_matrix(l.to_world, o["matrix"], l.name);
        if (l.kind == LightKind::Spot) {
            EXPECT_NEAR(l.spot_angle, 50 * M_PI / 180, 1e-5);
            EXPECT_NEAR(l.spot_blend, 0.3f, 1e-5f);
        }
    }
    expect_matrix(s->camera.to_world, f["camera"]["matrix"], "camera");
    EXPECT_NEAR(s->camera.fov_x, f["camera"]["angle_x"].get<float>(), 1e-5f);
    EXPECT_EQ(s->settings.width, 960);
    EXPECT_EQ(s->settings.height, 720);
}

TEST(Gltf, uv_start_at_the_bottom_and_normals_are_smooth_where_blenders_were) {
    const auto s = load_sample();
    ASSERT_TRUE(s);
    const json f = facts();
    const auto ball = std::find_if(s->meshes.begin(), s->meshes.end(), [](const auto& m) { return m->name == "Sphere"; });
    ASSERT_NE(ball, s->meshes.end());
    const Mesh& m = **ball;
    size_t checked = 0;
    for (uint32_t t = 0; t < m.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const Vec3f p = m.positions[m.triangles[t][k]];
            const auto uv = m.uv[t * 3 + k];
            bool found = false;
            for (const json& known : f["ball_uv"]) {
                const json &q = known[0], &w = known[1];
                if (std::abs(q[0].get<float>() - p.x) + std::abs(q[1].get<float>() - p.y) + std::abs(q[2].get<float>() - p.z) > 1e-5f) continue;
                found |= std::abs(w[0].get<float>() - uv[0]) + std::abs(w[1].get<float>() - uv[1]) < 1e-5f;
            }
            EXPECT_TRUE(found) << "corner " << k << " of triangle " << t << " has uv " << uv[0] << " " << uv[1];
            EXPECT_NEAR(dot(corner_normal(m, t, k), p), length(p), 0.02f) << "a smooth sphere";
            checked += found;
        }
    }
    EXPECT_EQ(checked, m.triangles.size() * 3);
    const auto second = std::find_if(m.attributes.begin(), m.attributes.end(), [](const Attribute& a) { return a.name == "UVMap.001"; });
    ASSERT_NE(second, m.attributes.end());
    EXPECT_EQ(second->domain, Domain::Corner);
    for (size_t c = 0; c < m.uv.size(); ++c) {
        EXPECT_NEAR(second->values[c * 2], m.uv[c][0] * 2, 1e-5f);
        EXPECT_NEAR(second->values[c * 2 + 1], m.uv[c][1] * 3, 1e-5f);
    }
}

TEST(Gltf, materials_become_principled_graphs) {
    SceneSource source;
    Diagnostics d;
    ASSERT_TRUE(open_scene(kSample, {}, source, d)) << d.errors[0].line();
    const json& m = source.document["materials"];
    ASSERT_EQ(m.size(), 3u);
    const json& glass = m["glass"]["nodes"]["Principled BSDF"]["params"];
    EXPECT_NEAR(glass["IOR"].get<float>(), 1.33f, 1e-6f);
    EXPECT_EQ(glass["Transmission Weight"], 1);
    EXPECT_NEAR(glass["Roughness"].get<float>(), 0.1f, 1e-6f);
    EXPECT_NEAR(glass["Base Color"][1].get<float>(), 0.95f, 1e-6f);
    EXPECT_EQ(glass["Metallic"], 0);
    EXPECT_FALSE(glass.contains("Alpha"));
    const json& lacquer = m["lacquer"]["nodes"]["Principled BSDF"]["params"];
    EXPECT_NEAR(lacquer["Coat Weight"].get<float>(), 0.6f, 1e-6f);
    EXPECT_NEAR(lacquer["Coat Roughness"].get<float>(), 0.2f, 1e-6f);
    EXPECT_NEAR(lacquer["Emission Strength"].get<float>(), 3, 1e-6f);
    EXPECT_NEAR(lacquer["Emission Color"][1].get<float>(), 0.2f, 1e-6f);
    const json& nodes = m["painted"]["nodes"];
    const json& painted = nodes["Principled BSDF"]["params"];
    const json& color = nodes[painted["Base Color"]["node"].get<std::string>()];
    EXPECT_EQ(color["type"], "ShaderNodeTexImage");
    EXPECT_EQ(color["params"]["image"]["colorspace"], "sRGB");
    const json& split = nodes[painted["Roughness"]["node"].get<std::string>()];
    EXPECT_EQ(split["type"], "ShaderNodeSeparateColor");
    EXPECT_EQ(painted["Roughness"]["output"], "Green");
    EXPECT_EQ(painted["Metallic"]["output"], "Blue");
    const json& rough = nodes[split["params"]["Color"]["node"].get<std::string>()];
    EXPECT_EQ(rough["params"]["image"]["colorspace"], "Non-Color");
    const json& normal = nodes[painted["Normal"]["node"].get<std::string>()];
    EXPECT_EQ(normal["params"]["uv_map"], "UVMap.001");
    EXPECT_EQ(normal["params"]["Strength"], 0.75);
    // Images inside the file become files.
    for (const json* image : {&color["params"]["image"], &rough["params"]["image"]}) {
        std::string error;
        const std::string path = source.resolve_image(*image, error);
        ASSERT_FALSE(path.empty()) << error;
        std::ifstream in(path, std::ios::binary);
        char magic[4] = {};
        in.read(magic, 4);
        EXPECT_EQ(std::string(magic + 1, 3), "PNG");
    }
    for (const char* type : {"ShaderNodeBsdfPrincipled", "ShaderNodeTexImage", "ShaderNodeSeparateColor", "ShaderNodeNormalMap", "ShaderNodeUVMap"}) {
        if (!find_node(type)) GTEST_SKIP() << type << " is not in this build: the graphs are not compiled";
    }
    Diagnostics d2;
    EXPECT_TRUE(load_scene(kSample, {}, d2)) << d2.errors.at(0).line();
}

// ---- documents made by hand ----------------------------------------------------------------------------------------------

json data_buffer(const std::vector<uint8_t>& bytes) {
    return {{"byteLength", bytes.size()}, {"uri", "data:application/octet-stream;base64," + encode_base64(bytes.data(), bytes.size())}};
}

/// One triangle: positions as floats, indices as bytes.
json triangle_file() {
    const float p[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    std::vector<uint8_t> b(40);
    std::memcpy(b.data(), p, 36);
    b[36] = 0, b[37] = 1, b[38] = 2;
    return {{"asset", {{"version", "2.0"}}},
            {"buffers", {data_buffer(b)}},
            {"bufferViews", {{{"buffer", 0}, {"byteLength", 36}}, {{"buffer", 0}, {"byteOffset", 36}, {"byteLength", 3}}}},
            {"accessors", {{{"bufferView", 0}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}}, {{"bufferView", 1}, {"componentType", 5121}, {"count", 3}, {"type", "SCALAR"}}}},
            {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}}}},
            {"nodes", {{{"mesh", 0}}}},
            {"scenes", {{{"nodes", {0}}}}}};
}

struct Imported {
    SceneSource source;
    Diagnostics d;
    bool ok = false;
};
Imported import_json(const json& j) {
    Imported i;
    i.ok = import_gltf(j, {}, i.source, i.d);
    return i;
}
std::string first_fault(const json& j) {
    const Imported i = import_json(j);
    return i.ok || i.d.errors.empty() ? "no error" : i.d.errors[0].pointer + " " + i.d.errors[0].code;
}

TEST(Gltf, a_bare_triangle_gets_a_camera_and_a_white_world) {
    const Imported i = import_json(triangle_file());
    ASSERT_TRUE(i.ok) << i.d.errors[0].line();
    const json& doc = i.source.document;
    EXPECT_EQ(doc["instances"].size(), 1u);
    EXPECT_TRUE(doc["cameras"].contains("camera"));
    EXPECT_TRUE(doc["world"].contains("graph"));
    EXPECT_EQ(i.d.warnings.size(), 2u);
    // Without normals faces are flat, and y up has become z up.
    std::vector<uint8_t> buffer;
    std::string error;
    ASSERT_TRUE(i.source.read_buffer("gltf", buffer, error));
    float p[9];
    std::memcpy(p, buffer.data() + doc["meshes"]["mesh"]["positions"]["offset"].get<size_t>(), 36);
    EXPECT_EQ(std::vector<float>(p + 6, p + 9), (std::vector<float>{0, 0, 1}));
    EXPECT_TRUE(doc["meshes"]["mesh"].contains("smooth"));
}

TEST(Gltf, strips_and_fans_keep_their_orientation) {
    const float p[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};   // a strip over a square
    std::vector<uint8_t> b(48);
    std::memcpy(b.data(), p, 48);
    json j = triangle_file();
    j["buffers"][0] = data_buffer(b);
    j["bufferViews"] = {{{"buffer", 0}, {"byteLength", 48}}};
    j["accessors"] = {{{"bufferView", 0}, {"componentType", 5126}, {"count", 4}, {"type", "VEC3"}}};
    for (const int mode : {5, 6}) {
        j["meshes"][0]["primitives"][0] = {{"attributes", {{"POSITION", 0}}}, {"mode", mode}};
        const Imported i = import_json(j);
        ASSERT_TRUE(i.ok);
        const json& t = i.source.document["meshes"]["mesh"]["triangles"];
        ASSERT_EQ(t["count"], 2);
        std::vector<uint8_t> buffer;
        std::string error;
        i.source.read_buffer("gltf", buffer, error);
        uint32_t v[6];
        std::memcpy(v, buffer.data() + t["offset"].get<size_t>(), 24);
        if (mode == 5) EXPECT_EQ(std::vector<uint32_t>(v, v + 6), (std::vector<uint32_t>{0, 1, 2, 2, 1, 3}));
        else EXPECT_EQ(std::vector<uint32_t>(v, v + 6), (std::vector<uint32_t>{0, 1, 2, 0, 2, 3}));
    }
}

TEST(Gltf, hostile_files_are_errors_that_name_the_place) {
    const auto with = [](const char* pointer, const json& value) {
        json j = triangle_file();
        j[json::json_pointer(pointer)] = value;
        return first_fault(j);
    };
    EXPECT_EQ(with("/asset/version", "1.0"), "/asset/version unsupported");
    EXPECT_EQ(with("/extensionsRequired", {"KHR_draco_mesh_compression"}), "/extensionsRequired/0 unsupported");
    EXPECT_EQ(with("/accessors/0/count", 4), "/accessors/0 out-of-range");
    EXPECT_EQ(with("/accessors/0/count", 4e9), "/accessors/0/count out-of-range");
    EXPECT_EQ(with("/accessors/0/byteOffset", 4294967295u), "/accessors/0 out-of-range");
    EXPECT_EQ(with("/accessors/0/type", "VEC2"), "/meshes/0/primitives/0/attributes/POSITION wrong-type");
    EXPECT_EQ(with("/accessors/0/type", "VEC9"), "/accessors/0/type unknown-value");
    EXPECT_EQ(with("/accessors/0/componentType", 5124), "/accessors/0/componentType unknown-value");
    EXPECT_EQ(with("/accessors/0/bufferView", 7), "/accessors/0/bufferView out-of-range");
    EXPECT_EQ(with("/accessors/1/count", 2147483648u), "/accessors/1 out-of-range");
    EXPECT_EQ(with("/bufferViews/0/byteLength", 4000000000u), "/bufferViews/0 out-of-range");
    EXPECT_EQ(with("/bufferViews/0/buffer", 3), "/bufferViews/0/buffer out-of-range");
    EXPECT_EQ(with("/bufferViews/0/byteStride", 4), "/accessors/0 out-of-range") << "a stride smaller than the element";
    EXPECT_EQ(with("/buffers/0/uri", "data:,plain"), "/buffers/0/uri unsupported");
    EXPECT_EQ(with("/buffers/0/uri", "../../etc/passwd"), "/buffers/0/uri asset-missing");
    EXPECT_EQ(with("/buffers/0/uri", "http://example.com/x.bin"), "/buffers/0/uri asset-missing");
    EXPECT_EQ(with("/nodes/0/mesh", 2), "/nodes/0/mesh out-of-range");
    EXPECT_EQ(with("/nodes/0/children", {0}), "/nodes/0 cycle");
    EXPECT_EQ(with("/nodes/0/children", {77}), "/nodes out-of-range");
    EXPECT_EQ(with("/nodes/0/matrix", {1, 2, 3}), "/nodes/0/matrix wrong-type");
    EXPECT_EQ(with("/meshes/0/primitives", 5), "/meshes/0/primitives wrong-type");
    EXPECT_EQ(with("/meshes/0/primitives/0/attributes", json::object()), "/meshes/0/primitives/0/attributes/POSITION missing-member");
    EXPECT_EQ(with("/meshes/0/primitives/0/material", 0), "/nodes/0/mesh out-of-range");
    EXPECT_EQ(first_fault(json::array()), " wrong-type");
    // An index beyond the points, a point that is no number, zeros without end.
    json j = triangle_file();
    const float p[9] = {0, 0, 0, 1, NAN, 0, 0, 1, 0};
    std::vector<uint8_t> b(40);
    std::memcpy(b.data(), p, 36);
    j["buffers"][0] = data_buffer(b);
    EXPECT_EQ(first_fault(j), "/accessors/0 nonfinite");
    b.assign(40, 0);
    b[38] = 3;
    j["buffers"][0] = data_buffer(b);
    EXPECT_EQ(first_fault(j), "/accessors/1 out-of-range");
    j = triangle_file();
    j["accessors"][0].erase("bufferView");
    j["accessors"][0]["count"] = 2000000000u;
    EXPECT_EQ(first_fault(j), "/accessors/0 limit-exceeded");
    // Two hundred thousand nodes in one chain are a tree too deep, not a stack overflow.
    j = triangle_file();
    j["nodes"] = json::array();
    for (int i = 0; i < 200000; ++i) j["nodes"].push_back(i + 1 < 200000 ? json{{"children", {i + 1}}} : json::object());
    EXPECT_NE(first_fault(j), "no error");
}

TEST(Gltf, sparse_and_normalised_accessors_are_read) {
    std::vector<uint8_t> b(64);
    const int16_t p[9] = {0, 0, 0, 32767, 0, 0, 0, -32768, 0};
    std::memcpy(b.data(), p, 18);
    b[20] = 2;                                    // sparse index
    const int16_t replaced[3] = {0, 16384, 32767};
    std::memcpy(b.data() + 24, replaced, 6);
    json j = triangle_file();
    j["buffers"][0] = data_buffer(b);
    j["bufferViews"] = {{{"buffer", 0}, {"byteLength", 18}}, {{"buffer", 0}, {"byteOffset", 20}, {"byteLength", 1}}, {{"buffer", 0}, {"byteOffset", 24}, {"byteLength", 6}}};
    j["accessors"] = {{{"bufferView", 0}, {"componentType", 5122}, {"normalized", true}, {"count", 3}, {"type", "VEC3"},
                       {"sparse", {{"count", 1}, {"indices", {{"bufferView", 1}, {"componentType", 5121}}}, {"values", {{"bufferView", 2}}}}}}};
    j["meshes"][0]["primitives"][0] = {{"attributes", {{"POSITION", 0}}}};
    const Imported i = import_json(j);
    ASSERT_TRUE(i.ok) << i.d.errors[0].line();
    std::vector<uint8_t> buffer;
    std::string error;
    i.source.read_buffer("gltf", buffer, error);
    float v[9];
    std::memcpy(v, buffer.data(), 36);
    EXPECT_FLOAT_EQ(v[3], 1);
    EXPECT_FLOAT_EQ(v[7], -1);                    // -z
    EXPECT_FLOAT_EQ(v[8], 16384 / 32767.0f);      // y
    j["accessors"][0]["sparse"]["count"] = 2;
    EXPECT_NE(first_fault(j), "no error");
    b[20] = 9;
    j["accessors"][0]["sparse"]["count"] = 1;
    j["buffers"][0] = data_buffer(b);
    EXPECT_EQ(first_fault(j), "/accessors/0/sparse/indices out-of-range");
}

TEST(Gltf, truncated_and_changed_files_never_crash) {
    const std::vector<uint8_t> whole = sample_bytes();
    for (size_t n = 0; n < whole.size(); n += 211) {
        SceneSource source;
        Diagnostics d;
        EXPECT_FALSE(import_glb(std::span(whole).first(n), "", {}, source, d)) << n;
    }
    uint32_t random = 3;
    const size_t json_bytes = whole[12] | size_t(whole[13]) << 8;
    for (int i = 0; i < 400; ++i) {
        std::vector<uint8_t> bad = whole;
        for (int k = 0; k < 2; ++k) {   // digits in the JSON, mostly: offsets, counts, indices
            random = random * 1664525u + 1013904223u;
            size_t at = 20 + (random >> 8) % json_bytes;
            while (at < 20 + json_bytes && !std::isdigit(bad[at])) ++at;
            if (at < 20 + json_bytes) bad[at] = uint8_t('0' + (random >> 4) % 10);
        }
        SceneSource source;
        Diagnostics d;
        const bool ok = import_glb(bad, "", {}, source, d);
        EXPECT_NE(ok, !d.errors.empty());
    }
}

}  // namespace
}  // namespace alder
