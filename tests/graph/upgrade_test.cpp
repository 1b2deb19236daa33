// Documents of older Blender versions: what they are rewritten to, and that they then evaluate.
#include "graph/upgrade.h"

#include <gtest/gtest.h>

#include <cmath>

#include "graph/document.h"
#include "tests/graph/test_nodes.h"

namespace alder::test {
namespace {

using nlohmann::json;

json upgraded(const char* text) {
    const auto r = upgraded_document(json::parse(text));
    return r ? *r : json();
}
json principled(const char* params) {
    const json doc = {{"nodes", {{"p", {{"type", "ShaderNodeBsdfPrincipled"}, {"params", json::parse(params)}}}, {"t", {{"type", "ShaderNodeTexNoise"}}}}}};
    const auto r = upgraded_document(doc);
    return r ? *r : doc;
}

TEST(Upgrade, current_documents_are_left_alone) {
    EXPECT_FALSE(upgraded_document(json::parse(R"({"nodes": {"n": {"type": "ShaderNodeTexNoise", "params": {"Roughness": 3}}}})")));
    EXPECT_FALSE(upgraded_document(json::parse(R"({"nodes": {"p": {"type": "ShaderNodeBsdfPrincipled", "params": {"Subsurface Weight": 0.5, "Coat Weight": 1}}}})")));
    EXPECT_FALSE(upgraded_document(json::parse("[1]")));
    EXPECT_FALSE(upgraded_document(json::parse(R"({"nodes": 5})")));
}

TEST(Upgrade, musgrave_with_constants_is_a_noise_with_one_octave_less) {
    const json d = upgraded(R"({"nodes": {"m": {"type": "ShaderNodeTexMusgrave", "params": {"musgrave_type": "HETERO_TERRAIN", "musgrave_dimensions": "4D",
                                  "Detail": 3.5, "Dimension": 0.5, "Lacunarity": 4, "Offset": 0.2}}}})");
    const json& m = d["nodes"]["m"];
    EXPECT_EQ(m["type"], "ShaderNodeTexNoise");
    const json& p = m["params"];
    EXPECT_EQ(p["noise_type"], "HETERO_TERRAIN");
    EXPECT_EQ(p["noise_dimensions"], "4D");
    EXPECT_EQ(p["normalize"], false);
    EXPECT_EQ(p["Detail"], 2.5);
    EXPECT_DOUBLE_EQ(p["Roughness"], 0.5);  // 4^-0.5
    EXPECT_EQ(p["Offset"], 0.2);
    EXPECT_FALSE(p.contains("Dimension"));
    EXPECT_EQ(d["nodes"].size(), 1u);
}

TEST(Upgrade, musgrave_below_one_octave_is_faded_behind_its_output) {
    for (const char* type : {"FBM", "MULTIFRACTAL"}) {
        const json doc = {{"nodes", {{"m", {{"type", "ShaderNodeTexMusgrave"}, {"params", {{"musgrave_type", type}, {"Detail", 0.25}, {"Vector", {0.3, 0.7, 0.1}}, {"Scale", 3}}}}},
                                     {"r", {{"type", "ShaderNodeMath"}, {"params", {{"operation", "ADD"}, {"Value", {{"node", "m"}}}, {"Value_001", 0}}}}}}}};
        const json noise = {{"nodes", {{"n", {{"type", "ShaderNodeTexNoise"}, {"params", {{"noise_type", type}, {"Detail", 0}, {"normalize", false}, {"Roughness", 0.25}, {"Vector", {0.3, 0.7, 0.1}}, {"Scale", 3}}}}}}}};
        Diagnostics d;
        const auto m = material(doc, d), n = material(noise, d);
        ASSERT_TRUE(m && n) << (d.errors.empty() ? "" : d.errors[0].line());
        const float old = run(*m, "r", {0})[0], fractal = run(*n, "n.Fac", {0})[0];
        EXPECT_NEAR(old, type[0] == 'F' ? 0.25f * fractal : 0.25f * fractal + 0.75f, 1e-6f) << type;
    }
}

TEST(Upgrade, musgrave_with_links_gets_math_nodes) {
    const char* text = R"({"nodes": {
        "x": {"type": "ShaderNodeMath", "params": {"operation": "ADD", "Value": {"attribute": "x"}, "Value_001": 0}},
        "m": {"type": "ShaderNodeTexMusgrave", "params": {"musgrave_type": "FBM", "Detail": {"node": "x"}, "Dimension": {"node": "x"}, "Lacunarity": {"node": "x"},
              "Vector": [0.3, 0.7, 0.1]}}},
        "outputs": {"aovs": {"a": {"node": "m", "output": "Fac"}}}})";
    const json d = upgraded(text);
    EXPECT_EQ(d["outputs"]["aovs"]["a"]["node"], "m (multiply)");
    EXPECT_EQ(d["nodes"]["m"]["params"]["Roughness"]["node"], "m (roughness)");
    EXPECT_EQ(d["nodes"]["m"]["params"]["Detail"]["node"], "m (minimum)");
    Diagnostics diagnostics;
    const auto m = material(json::parse(text), diagnostics);
    ASSERT_TRUE(m) << diagnostics.errors[0].line();
    const auto p = m->program({.aovs = {"a"}}, diagnostics);
    ASSERT_TRUE(p);
    const json noise = {{"nodes", {{"n", {{"type", "ShaderNodeTexNoise"}, {"params", {{"noise_type", "FBM"}, {"Detail", 1.5}, {"normalize", false}, {"Roughness", std::pow(2.5, -2.5)},
                                                                                 {"Lacunarity", 2.5}, {"Vector", {0.3, 0.7, 0.1}}}}}}}}};
    const auto n = material(noise, diagnostics);
    ASSERT_TRUE(n);
    EXPECT_NEAR(run(*p, p->outputs()[0].register_first, {2.5f})[0], run(*n, "n.Fac", {0})[0], 1e-5f);
}

TEST(Upgrade, edits_of_an_upgraded_document_use_its_own_names) {
    Diagnostics d;
    const json doc = {{"nodes", {{"m", {{"type", "ShaderNodeTexMusgrave"}, {"params", {{"Detail", 3}, {"Dimension", 1}, {"Vector", {0.31, 0.72, 0.13}}}}}}}}};
    json edited = doc;
    edited["nodes"]["m"]["params"]["Dimension"] = 0.5;
    const auto a = material(doc, d), b = material(edited, d);
    ASSERT_TRUE(a && b);
    const auto c = a->with_param("/nodes/m/params/Dimension", 0.5, d);
    ASSERT_TRUE(c) << d.errors[0].line();
    EXPECT_EQ(run(*c, "m.Fac", {0})[0], run(*b, "m.Fac", {0})[0]);
    EXPECT_NE(run(*c, "m.Fac", {0})[0], run(*a, "m.Fac", {0})[0]);
}

TEST(Upgrade, principled_sockets_of_3x) {
    const json d = principled(R"({"Base Color": [0.2, 0.4, 0.6], "Specular": 0.3, "Specular Tint": 0.5, "Metallic": 0.25, "Sheen": 0.5, "Sheen Tint": 0.5, "Clearcoat": 0.8,
                                  "Clearcoat Roughness": 0.1, "Transmission": 0.7, "Transmission Roughness": 0.2, "Emission": [1, 2, 3], "Subsurface": 0})");
    const json& p = d["nodes"]["p"]["params"];
    EXPECT_EQ(p["Specular IOR Level"], 0.3);
    for (int i = 0; i < 3; ++i) {
        const double base = 0.2 * (i + 1), mixed = 0.75 * base + 0.25;
        EXPECT_NEAR(p["Specular Tint"][i].get<double>(), 0.5 + 0.5 * mixed, 1e-12);
    }
    EXPECT_NEAR(p["Sheen Weight"].get<double>(), 0.1, 1e-12);
    EXPECT_EQ(p["Sheen Tint"], json({1, 1, 1}));
    EXPECT_EQ(p["Sheen Roughness"], 0.5);
    EXPECT_NEAR(p["Coat Weight"].get<double>(), 0.2, 1e-12);
    EXPECT_EQ(p["Coat IOR"], 1.5);
    EXPECT_EQ(p["Coat Roughness"], 0.1);
    EXPECT_EQ(p["Transmission Weight"], 0.7);
    EXPECT_EQ(p["Emission Color"], json({1, 2, 3}));
    EXPECT_EQ(p["Emission Strength"], 1);
    EXPECT_EQ(p["Subsurface Weight"], 0);
    EXPECT_EQ(p["Subsurface Scale"], 0.05);
    for (const char* gone : {"Specular", "Sheen", "Clearcoat", "Transmission", "Transmission Roughness", "Emission", "Subsurface"}) EXPECT_FALSE(p.contains(gone)) << gone;
}

TEST(Upgrade, principled_subsurface_becomes_a_mix_of_colours) {
    const json d = principled(R"({"Base Color": [1, 0, 0], "Subsurface": 0.25, "Subsurface Color": [0, 1, 0], "subsurface_method": "RANDOM_WALK_FIXED_RADIUS"})");
    const json& p = d["nodes"]["p"]["params"];
    EXPECT_EQ(p["Base Color"], json({0.75, 0.25, 0.0}));
    EXPECT_EQ(p["Subsurface Weight"], 1);
    EXPECT_EQ(p["Subsurface Scale"], 0.25);
    EXPECT_EQ(p["subsurface_method"], "RANDOM_WALK_SKIN") << "one step after the other would be wrong twice";
}

TEST(Upgrade, principled_links_get_mix_nodes) {
    const json d = principled(R"({"Base Color": {"node": "t", "output": "Color"}, "Subsurface": {"node": "t", "output": "Fac"}, "Sheen": {"node": "t", "output": "Fac"},
                                  "Clearcoat": {"node": "t", "output": "Fac"}, "Specular Tint": 1.0, "Metallic": 0.5})");
    const json& p = d["nodes"]["p"]["params"];
    EXPECT_EQ(p["Base Color"]["node"], "p (subsurface color)");
    EXPECT_EQ(d["nodes"]["p (subsurface color)"]["params"]["A_Color"]["node"], "t");
    EXPECT_EQ(d["nodes"]["p (subsurface color)"]["params"]["B_Color"], json({0.8, 0.8, 0.8}));
    EXPECT_EQ(p["Subsurface Scale"]["node"], "t");
    EXPECT_EQ(p["Subsurface Weight"], 1);
    EXPECT_EQ(p["Sheen Tint"], json({0.2, 0.2, 0.2}));
    EXPECT_EQ(p["Coat IOR"], 1.2);
    EXPECT_EQ(p["Specular Tint"]["node"], "p (specular tint)");
    EXPECT_EQ(d["nodes"]["p (specular tint)"]["params"]["B_Color"]["node"], "p (metallic tint)");
}

TEST(Upgrade, velvet_sharp_and_old_falloffs) {
    const json d = upgraded(R"({"nodes": {"v": {"type": "ShaderNodeBsdfVelvet", "params": {"Sigma": 0.3}}, "w": {"type": "ShaderNodeBsdfVelvet"},
        "g": {"type": "ShaderNodeBsdfGlass", "params": {"distribution": "SHARP", "Roughness": {"node": "x"}}},
        "s": {"type": "ShaderNodeSubsurfaceScattering", "params": {"falloff": "GAUSSIAN", "Sharpness": 0.5}}}})");
    EXPECT_EQ(d["nodes"]["v"]["type"], "ShaderNodeBsdfSheen");
    EXPECT_EQ(d["nodes"]["v"]["params"], json({{"distribution", "ASHIKHMIN"}, {"Roughness", 0.3}}));
    EXPECT_EQ(d["nodes"]["w"]["params"]["Roughness"], 1.0);
    EXPECT_EQ(d["nodes"]["g"]["params"], json({{"distribution", "GGX"}, {"Roughness", 0.0}}));
    EXPECT_EQ(d["nodes"]["s"]["params"], json({{"falloff", "RANDOM_WALK"}}));
}

TEST(Upgrade, documents_may_say_their_version) {
    const json d = upgraded(R"({"blender_version": "3.6", "nodes": {"n": {"type": "ShaderNodeTexNoise", "params": {"Roughness": 3}},
                               "s": {"type": "ShaderNodeSubsurfaceScattering", "params": {"falloff": "RANDOM_WALK"}}}})");
    EXPECT_EQ(d["nodes"]["n"]["params"]["Roughness"], 1.0);
    EXPECT_EQ(d["nodes"]["s"]["params"]["falloff"], "RANDOM_WALK_SKIN");
    EXPECT_FALSE(d.contains("blender_version"));
    const json e = upgraded(R"({"blender_version": [4, 5, 1], "nodes": {"n": {"type": "ShaderNodeTexNoise", "params": {"Roughness": 3}}}})");
    EXPECT_EQ(e["nodes"]["n"]["params"]["Roughness"], 3);
}

/// Twice would turn what the first upgrade gave once more: RANDOM_WALK_FIXED_RADIUS to RANDOM_WALK, and that to RANDOM_WALK_SKIN.
TEST(Upgrade, groups_written_out_are_upgraded_once_and_by_their_own_version) {
    const auto falloff = [](const char* version, const char* own) {
        json group = json::parse(R"({"nodes": {"s": {"type": "ShaderNodeSubsurfaceScattering", "params": {"falloff": "RANDOM_WALK_FIXED_RADIUS"}}},
                                     "outputs": {"out": {"node": "s"}}})");
        if (own) group["blender_version"] = own;
        json doc = {{"nodes", {{"g", {{"type", "ShaderNodeGroup"}, {"graph", group}}}}}, {"outputs", {{"surface", {{"node", "g"}, {"output", "out"}}}}}};
        if (version) doc["blender_version"] = version;
        Diagnostics d;
        const auto read = read_document(doc, {}, d);
        if (!read) return d.errors[0].line();
        const DocNode& node = *read->nodes[0]->group->nodes[0];
        const int param = node.type->param_index("falloff");
        return node.type->params[param].items[node.params[param].item].name;
    };
    EXPECT_EQ(falloff(nullptr, nullptr), "RANDOM_WALK");
    EXPECT_EQ(falloff("3.6", nullptr), "RANDOM_WALK");
    EXPECT_EQ(falloff("4.5", "3.6"), "RANDOM_WALK");
    EXPECT_EQ(falloff("3.6", "4.5"), "RANDOM_WALK");
}

TEST(Upgrade, aov_outputs_become_aovs) {
    Diagnostics d;
    const json doc = json::parse(R"({"nodes": {
        "c": {"type": "ShaderNodeOutputAOV", "params": {"aov_name": "tint", "Color": [0.25, 0.5, 1], "Value": 0}},
        "v": {"type": "ShaderNodeOutputAOV", "params": {"aov_name": "wear", "Color": [0, 0, 0, 1], "Value": {"attribute": "x"}}},
        "u": {"type": "ShaderNodeOutputAOV", "params": {"Color": [1, 1, 1]}}}})");
    const auto m = material(doc, d);
    ASSERT_TRUE(m) << d.errors[0].line();
    EXPECT_EQ(m->aov_names(), (std::vector<std::string>{"tint", "wear"}));
    const auto p = m->program({.aovs = {"tint", "wear"}}, d);
    ASSERT_TRUE(p);
    EXPECT_EQ(run(*p, p->outputs()[0].register_first + 1, {3})[0], 0.5f);
    EXPECT_EQ(run(*p, p->outputs()[1].register_first, {3})[0], 3.0f);
}

TEST(Upgrade, groups_are_upgraded_inside) {
    const json d = upgraded(R"({"nodes": {"g": {"type": "ShaderNodeGroup", "graph": {"nodes": {"v": {"type": "ShaderNodeBsdfVelvet"}}}}}})");
    EXPECT_EQ(d["nodes"]["g"]["graph"]["nodes"]["v"]["type"], "ShaderNodeBsdfSheen");
}

}  // namespace
}  // namespace alder::test
