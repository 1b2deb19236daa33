// alLayer: thresholds, weights, debug modes and AOVs, compiled and run as a renderer would.
#include <fstream>

#include "graph/material.h"
#include "tests/nodes/surface/al_fixture.h"

namespace alder {
namespace {

using namespace testing;

std::shared_ptr<const Material> compile(const json& layer, const json& more = json::object()) {
    json nodes = {{"coated", {{"type", "alSurface"}, {"params", {{"id1", {1, 2, 3}}}}}},
                  {"matt", {{"type", "alSurface"}, {"params", {{"specular1Strength", 0}, {"opacity", {0.5, 0.5, 0.5}}}}}},
                  {"layer", {{"type", "alLayer"}, {"params", layer}}}};
    nodes.update(more);
    Diagnostics d;
    auto m = build_material({{"version", 1}, {"nodes", nodes}, {"outputs", {{"surface", {{"node", "layer"}}}}}}, {}, d);
    EXPECT_TRUE(m) << (d.errors.empty() ? "" : d.errors[0].line());
    return m;
}
json link(const char* node) { return {{"node", node}}; }
json layers(json mix) { return {{"layer1", link("coated")}, {"layer2", link("matt")}, {"mix", mix}}; }

struct LobeWeight {
    LobeSpec spec;
    std::string node;
    float weight;
};
/// First channel of every lobe's weight at a point seen straight on, with the attribute m.
std::vector<LobeWeight> weights(const Material& material, float m, LobeFilter filter = LobeFilter::Surface) {
    Diagnostics d;
    const auto p = material.program({.surface = filter}, d);
    EXPECT_TRUE(p);
    std::vector<std::array<float, kPadding>> values;
    for (const ProgramInput& in : p->inputs())
        for (int c = 0; c < in.channels; ++c) {
            float v = 0;
            if (in.is_attribute) v = m;
            else if (in.global == Global::I || in.global == Global::N) v = c == 2;
            else if (in.global == Global::Dpdu) v = c == 0;
            values.emplace_back().fill(v);
        }
    std::vector<Channel<float>> channels;
    for (auto& v : values) channels.push_back({v.data(), 0});
    EvalContext context;
    Executor<float> run(context);
    run.run(*p, 1, channels);
    std::vector<LobeWeight> result;
    for (const ProgramLobe& l : p->lobes()) result.push_back({l.spec, l.node, run.channel(l.register_first).p[0]});
    return result;
}
float total(const std::vector<LobeWeight>& lobes, const std::string& node, LobeLabel label) {
    float sum = 0;
    for (const auto& l : lobes)
        if (l.node == node && l.spec.label == label && !l.spec.shadow_only) sum += l.weight;
    return sum;
}

TEST(al_layer, constant_mix_at_an_end_leaves_the_other_layer_out) {
    for (const double mix : {0.0, 1e-5, -3.0})
        for (const auto& l : weights(*compile(layers(mix)), 0)) EXPECT_EQ(l.node, "coated") << mix;
    for (const double mix : {1.0, 0.99999, 4.0})
        for (const auto& l : weights(*compile(layers(mix)), 0)) EXPECT_EQ(l.node, "matt") << mix;
}

TEST(al_layer, weights_are_the_mix_of_every_lobe) {
    const auto m = compile(layers({{"attribute", "m"}}));
    const auto at0 = weights(*m, 0), at1 = weights(*m, 1);
    for (const float mix : {0.f, 1e-6f, 0.25f, 0.999995f, 1.f, 1.5f}) {
        const float w = mix >= 1 - 1e-5f ? 1 : mix <= 1e-5f ? 0 : mix;
        const auto l = weights(*m, mix);
        for (const LobeLabel label : {LobeLabel::Diffuse, LobeLabel::Specular, LobeLabel::Transparent}) {
            EXPECT_FLOAT_EQ(total(l, "coated", label), (1 - w) * total(at0, "coated", label)) << mix;
            EXPECT_FLOAT_EQ(total(l, "matt", label), w * total(at1, "matt", label)) << mix;
        }
    }
    EXPECT_FLOAT_EQ(total(at1, "matt", LobeLabel::Transparent), 0.5f);
}

TEST(al_layer, debug_shows_a_layer_or_the_mix) {
    json p = layers(0.3);
    p["debug"] = "layer2";
    for (const auto& l : weights(*compile(p), 0)) EXPECT_EQ(l.node, "matt");
    p["debug"] = "layer1";
    for (const auto& l : weights(*compile(p), 0)) EXPECT_EQ(l.node, "coated");
    p["debug"] = "mixer";
    const auto lobes = weights(*compile(p), 0);
    ASSERT_EQ(lobes.size(), 1u);
    EXPECT_EQ(lobes[0].spec.kind, LobeKind::Emission);
    EXPECT_FLOAT_EQ(lobes[0].weight, 0.3f);
}

TEST(al_layer, layers_of_layers_multiply_their_weights) {
    const auto m = compile(layers(0.5), {{"coated", {{"type", "alLayer"}, {"params", {{"layer1", link("matt")}, {"layer2", {4.0, 4.0, 4.0}}, {"mix", 0.25}}}}}});
    const auto l = weights(*m, 0);
    EXPECT_FLOAT_EQ(total(l, "matt", LobeLabel::Transparent), 0.5f * (0.5f + 0.5f * 0.75f)) << "reached on two ways, emitted once";
    EXPECT_FLOAT_EQ(total(l, "coated", LobeLabel::Emission), 0.5f);
}

TEST(al_layer, ids_are_blended_like_the_surfaces) {
    const auto m = compile(layers(0.25));
    Diagnostics d;
    const auto p = m->program({.aovs = {"id_1"}}, d);
    ASSERT_TRUE(p);
    EvalContext context;
    Executor<float> run(context);
    std::vector<Channel<float>> none;
    run.run(*p, 1, none);
    for (int c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(run.channel(p->outputs()[0].register_first + c).p[0], 0.75f * (c + 1));
}

TEST(al_layer, schema_is_the_catalogues) {
    std::ifstream f(std::string(ALDER_SOURCE_DIR) + "/tests/data/alshaders/surface_catalogue.json");
    const json all = json::parse(f);
    const NodeType& type = *find_node("alLayer");
    for (const json& n : all["nodes"]) {
        if (n["name"] != "alLayer") continue;
        const json& rows = n["parameters"];
        ASSERT_EQ(rows.size(), type.params.size());
        for (size_t k = 0; k < rows.size(); ++k) {
            const Param& p = type.params[k];
            EXPECT_EQ(p.name, rows[k]["name"]);
            EXPECT_EQ(p.takes_links, rows[k]["takesLinks"].get<bool>()) << p.name;
            EXPECT_EQ(p.text, rows[k]["default"].is_string() ? rows[k]["default"].get<std::string>() : "") << p.name;
            const json ui = rows[k].value("ui", json::object());
            EXPECT_EQ(p.label, ui.value("label", "")) << p.name;
            EXPECT_EQ(p.group, ui.value("group", "")) << p.name;
        }
    }
}

TEST(al_layer, blends_constant_layers_as_the_original) {
    const json table = load_table("alLayer");
    if (table.is_null()) GTEST_SKIP() << "no table alLayer in " << reference_folder();
    int compared = 0;
    for (const json& c : table["cases"]) {
        const auto m = compile(c["params"]);
        ASSERT_TRUE(m);
        Diagnostics d;
        const auto p = m->program({.outputs = {"layer"}}, d);
        ASSERT_TRUE(p);
        EvalContext context;
        Executor<double> run(context);
        std::vector<Channel<double>> none;
        run.run(*p, 1, none);
        for (int i = 0; i < 3; ++i) {
            const double want = number(c["output"][i]), got = run.channel(p->outputs()[0].register_first + i).p[0];
            EXPECT_NEAR(got, want, 2e-6 * std::max(std::abs(want), largest(vec3(c["params"].value("layer2", json::array({1, 1, 1})))))) << c["params"];
            ++compared;
        }
    }
    EXPECT_GT(compared, 100);
}

}  // namespace
}  // namespace alder
