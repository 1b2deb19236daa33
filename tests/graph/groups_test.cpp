// Node groups: what a group gives, what its unused parts cost, and what is refused.
#include <gtest/gtest.h>

#include "graph/document.h"
#include "tests/graph/test_nodes.h"

namespace alder::test {
namespace {

using nlohmann::json;

json x() { return {{"attribute", "x"}}; }
json link(const std::string& node) { return {{"node", node}}; }
json link(const std::string& node, const std::string& output) { return {{"node", node}, {"output", output}}; }

/// twice(value) = 2 value, and an output that is a costly function of another input.
json twice() {
    return {{"inputs", {{"value", {{"type", "float"}, {"default", 3}}}, {"other", {{"type", "NodeSocketFloatFactor"}}}}},
            {"nodes",
             {{"in", {{"type", "NodeGroupInput"}}},
              {"p", {{"type", "TestProbe"}, {"params", {{"input", link("in", "value")}}}}},
              {"r", {{"type", "TestReciprocal"}, {"params", {{"input", link("in", "other")}}}}},
              {"out", {{"type", "NodeGroupOutput"}, {"params", {{"result", link("p")}, {"rest", link("r")}}}}}}}};
}
json use(json params) { return {{"type", "ShaderNodeGroup"}, {"group", "twice"}, {"params", std::move(params)}}; }
json with_twice(json nodes) { return {{"groups", {{"twice", twice()}}}, {"nodes", std::move(nodes)}}; }

std::shared_ptr<const Program> compile(const json& graph, const std::string& output, Diagnostics& d) {
    const auto m = material(graph, d);
    return m ? m->program({.outputs = {output}}, d) : nullptr;
}
std::string first(const Diagnostics& d) { return d.errors.empty() ? "no error" : d.errors[0].line(); }

TEST(Groups, give_what_their_nodes_give) {
    Diagnostics d;
    json inline_group = {{"type", "ShaderNodeGroup"}, {"graph", twice()}, {"params", {{"value", x()}}}};
    const auto m = material({{"nodes", {{"g", inline_group}}}}, d);
    ASSERT_TRUE(m) << first(d);
    EXPECT_EQ(run(*m, "g.result", {1.5f, -2.0f}), (std::vector<float>{3.0f, -4.0f}));
}

TEST(Groups, unlinked_inputs_have_the_sockets_default) {
    Diagnostics d;
    const auto m = material(with_twice({{"g", use(json::object())}, {"h", use({{"value", 5}})}}), d);
    ASSERT_TRUE(m) << first(d);
    EXPECT_EQ(run(*m, "g.result", {0})[0], 6.0f);
    EXPECT_EQ(run(*m, "h.result", {0})[0], 10.0f);
}

TEST(Groups, what_is_not_asked_for_is_not_built) {
    Diagnostics d;
    const auto p = compile(with_twice({{"g", use({{"value", x()}, {"other", link("h", "result")}})}, {"h", use({{"value", x()}})}}), "g.result", d);
    ASSERT_TRUE(p) << first(d);
    EXPECT_EQ(p->stats().ops, 1) << p->dump();
    EXPECT_EQ(p->stats().skipped.size(), 2u) << "the reciprocal, and the other group as a whole\n" << p->dump();
}

TEST(Groups, one_definition_many_uses) {
    json nodes = {{"g0", use({{"value", x()}})}};
    for (int i = 1; i < 20; ++i) nodes["g" + std::to_string(i)] = use({{"value", link("g" + std::to_string(i - 1), "result")}});
    Diagnostics d;
    const auto m = material(with_twice(nodes), d);
    ASSERT_TRUE(m) << first(d);
    EXPECT_EQ(run(*m, "g19.result", {1})[0], 1048576.0f);
    EXPECT_EQ(m->program({.outputs = {"g19.result"}}, d)->stats().ops, 20);
    // Two uses with the same inputs are one computation.
    const auto p = compile(with_twice({{"a", use({{"value", x()}})}, {"b", use({{"value", x()}})}, {"m", {{"type", "TestMix"}, {"params", {{"a", link("a", "result")}, {"b", link("b", "result")}}}}}}), "m", d);
    ASSERT_TRUE(p) << first(d);
    EXPECT_EQ(p->stats().ops, 2) << p->dump();
}

TEST(Groups, sockets_convert) {
    // A colour into a float socket is its luminance, whoever reads it inside; a float into a vector socket is on all channels.
    Diagnostics d;
    const json gray = {{"inputs", {{"v", {{"type", "float"}}}}},
                       {"outputs", {{"c", {{"type", "color"}}}}},
                       {"nodes", {{"in", {{"type", "NodeGroupInput"}}}, {"out", {{"type", "NodeGroupOutput"}, {"params", {{"c", link("in", "v")}}}}}}}};
    const auto m = material({{"nodes", {{"g", {{"type", "ShaderNodeGroup"}, {"graph", gray}, {"params", {{"v", link("t", "bsdf")}}}}}, {"t", {{"type", "TestDiffuse"}}}}}}, d);
    EXPECT_FALSE(m) << "a closure does not fit a float";
    ASSERT_EQ(d.errors.size(), 1u);
    EXPECT_EQ(d.errors[0].pointer, "/nodes/g/params/v");
    d = {};
    const json color = {{"attribute", "c"}};
    const json to_color = {{"inputs", {{"c", {{"type", "RGBA"}}}}}, {"outputs", {{"c", link("in", "c")}}}, {"nodes", {{"in", {{"type", "NodeGroupInput"}}}}}};
    const auto p = compile({{"nodes",
                             {{"a", {{"type", "ShaderNodeGroup"}, {"graph", to_color}, {"params", {{"c", color}}}}},
                              {"g", {{"type", "ShaderNodeGroup"}, {"graph", gray}, {"params", {{"v", link("a", "c")}}}}}}}}, "g.c", d);
    ASSERT_TRUE(p) << first(d);
    EXPECT_EQ(p->outputs()[0].type, Type::Color);
    EXPECT_EQ(p->stats().ops, 1) << "one luminance\n" << p->dump();
    EXPECT_NEAR(run(*p, p->outputs()[0].register_first + 2, {0.5f})[0], 0.5f, 1e-6f);
}

TEST(Groups, undeclared_sockets_are_what_their_links_are) {
    json g = twice();
    g.erase("inputs");
    Diagnostics d;
    const auto m = material({{"nodes", {{"g", {{"type", "ShaderNodeGroup"}, {"graph", g}, {"params", {{"value", x()}}}}}}}}, d);
    ASSERT_TRUE(m) << first(d);
    EXPECT_EQ(run(*m, "g.result", {4})[0], 8.0f);
    EXPECT_EQ(run(*m, "g.rest", {4})[0], 1.0f) << "the default of the parameter that reads it";
}

TEST(Groups, nest) {
    // Each level uses the one below twice: 2^5 probes in a row.
    json groups = {{"l0", twice()}};
    for (int i = 1; i <= 5; ++i) {
        const json below = {{"type", "ShaderNodeGroup"}, {"group", "l" + std::to_string(i - 1)}};
        json a = below, b = below;
        a["params"] = {{"value", link("in", "value")}};
        b["params"] = {{"value", link("a", "result")}};
        groups["l" + std::to_string(i)] = {{"inputs", {{"value", {{"type", "float"}}}}},
                                           {"outputs", {{"result", link("b", "result")}}},
                                           {"nodes", {{"in", {{"type", "NodeGroupInput"}}}, {"a", a}, {"b", b}}}};
    }
    Diagnostics d;
    const json graph = {{"groups", groups}, {"nodes", {{"g", {{"type", "ShaderNodeGroup"}, {"group", "l5"}, {"params", {{"value", x()}}}}}}}};
    const auto m = material(graph, d);
    ASSERT_TRUE(m) << first(d);
    EXPECT_EQ(run(*m, "g.result", {1})[0], 4294967296.0f);
    const auto p = m->program({.outputs = {"g.result"}}, d);
    EXPECT_EQ(p->stats().ops, 32);
    EXPECT_NE(p->dump().find("# g/a/b/a/a/b/p"), std::string::npos) << p->dump();
}

TEST(Groups, closures_pass_in_and_out) {
    // mixed(shader) = half the shader given, half one of its own; one output hands its input through, one is not linked.
    const json mixed = {{"inputs", {{"mix", {{"type", "float"}, {"default", 0.5}}}, {"shader", {{"type", "shader"}}}}},
                        {"outputs", {{"mixed", {{"type", "shader"}}}, {"same", {{"type", "shader"}}}, {"none", {{"type", "shader"}}}}},
                        {"nodes",
                         {{"in", {{"type", "NodeGroupInput"}}},
                          {"own", {{"type", "TestDiffuse"}, {"params", {{"color", {0.5, 0.5, 0.5}}}}}},
                          {"m", {{"type", "TestMixClosure"}, {"params", {{"mix", link("in", "mix")}, {"a", link("in", "shader")}, {"b", link("own")}}}}},
                          {"out", {{"type", "NodeGroupOutput"}, {"params", {{"mixed", link("m")}, {"same", link("in", "shader")}}}}}}}};
    const auto graph = [&](const char* output, json params) {
        return json{{"groups", {{"mixed", mixed}}},
                    {"nodes", {{"d", {{"type", "TestDiffuse"}, {"params", {{"sigma", x()}}}}}, {"g", {{"type", "ShaderNodeGroup"}, {"group", "mixed"}, {"params", params}}}}},
                    {"outputs", {{"surface", link("g", output)}}}};
    };
    Diagnostics d;
    auto p = material(graph("mixed", {{"shader", link("d")}}), d)->program({.surface = LobeFilter::Surface}, d);
    ASSERT_EQ(p->lobes().size(), 2u) << p->dump();
    std::map<std::string, float> weight;
    for (const auto& l : p->lobes()) weight[l.node] = run(*p, l.register_first, {0.1f})[0];
    EXPECT_NEAR(weight["d"], 0.4f, 1e-6f);
    EXPECT_NEAR(weight["g/own"], 0.25f, 1e-6f);
    p = material(graph("mixed", {{"shader", link("d")}, {"mix", 1.0}}), d)->program({.surface = LobeFilter::Surface}, d);
    ASSERT_EQ(p->lobes().size(), 1u) << "a constant weight of 0 through the group's socket\n" << p->dump();
    EXPECT_EQ(p->lobes()[0].node, "g/own");
    p = material(graph("same", {{"shader", link("d")}}), d)->program({.surface = LobeFilter::Surface}, d);
    ASSERT_EQ(p->lobes().size(), 1u);
    EXPECT_EQ(p->lobes()[0].node, "d");
    EXPECT_EQ(material(graph("none", {{"shader", link("d")}}), d)->program({.surface = LobeFilter::Surface}, d)->lobes().size(), 0u);
    EXPECT_EQ(material(graph("same", json::object()), d)->program({.surface = LobeFilter::Surface}, d)->lobes().size(), 0u);
    EXPECT_TRUE(d.ok()) << first(d);
}

TEST(Groups, an_edit_of_an_input_keeps_the_program) {
    Diagnostics d;
    const json graph = with_twice({{"g", use({{"value", 5}})}, {"m", {{"type", "TestMix"}, {"params", {{"mix", x()}, {"a", link("g", "result")}, {"b", 0}}}}}});
    const auto base = material(graph, d);
    ASSERT_TRUE(base) << first(d);
    EXPECT_EQ(run(*base, "m", {0.5f})[0], 5.0f);
    const auto edited = base->with_param("/nodes/g/params/value", 7, d);
    ASSERT_TRUE(edited) << first(d);
    EXPECT_EQ(run(*edited, "m", {0.5f})[0], 7.0f);
    const auto inner = base->with_param("/groups/twice/nodes/p/params/input", 1, d);
    ASSERT_TRUE(inner) << first(d);
    EXPECT_EQ(run(*inner, "m", {0.5f})[0], 1.0f);
    EXPECT_FALSE(base->with_param("/groups/twice/nodes/q/params/input", 1, d));
    EXPECT_EQ(d.errors[0].pointer, "/groups/twice/nodes/q");
}

/// The first fault of a document: pointer and code.
std::pair<std::string, std::string> fault(const json& graph) {
    Diagnostics d;
    MaterialOptions o;
    EXPECT_FALSE(read_document(graph, o, d));
    return d.errors.empty() ? std::pair<std::string, std::string>() : std::pair(d.errors[0].pointer, d.errors[0].code);
}
using Fault = std::pair<std::string, std::string>;

TEST(Groups, inside_themselves_are_refused) {
    const json self = {{"nodes", {{"again", {{"type", "ShaderNodeGroup"}, {"group", "b"}}}}}};
    const json b = {{"nodes", {{"a", {{"type", "ShaderNodeGroup"}, {"group", "a"}}}}}};
    Diagnostics d;
    EXPECT_FALSE(read_document({{"groups", {{"a", self}, {"b", b}}}, {"nodes", {{"g", {{"type", "ShaderNodeGroup"}, {"group", "a"}}}}}}, {}, d));
    ASSERT_EQ(d.errors.size(), 1u);
    EXPECT_EQ(d.errors[0].pointer, "/groups/b/nodes/a/group");
    EXPECT_EQ(d.errors[0].code, "cycle");
    EXPECT_EQ(d.errors[0].path, (std::vector<std::string>{"a", "b", "a"}));
}

TEST(Groups, that_multiply_without_bound_are_refused) {
    json groups = {{"l0", twice()}};
    for (int i = 1; i <= 20; ++i) {
        json nodes;
        for (int k = 0; k < 10; ++k) nodes["n" + std::to_string(k)] = {{"type", "ShaderNodeGroup"}, {"group", "l" + std::to_string(i - 1)}};
        groups["l" + std::to_string(i)] = {{"nodes", nodes}};
    }
    const auto f = fault({{"groups", groups}, {"nodes", {{"g", {{"type", "ShaderNodeGroup"}, {"group", "l20"}}}}}});
    EXPECT_EQ(f.second, "limit-exceeded");
    EXPECT_EQ(f.first.substr(0, 9), "/groups/l");
    json deep = twice();
    for (int i = 0; i < 40; ++i) deep = {{"nodes", {{"g", {{"type", "ShaderNodeGroup"}, {"graph", deep}}}}}};
    EXPECT_EQ(fault({{"nodes", {{"g", {{"type", "ShaderNodeGroup"}, {"graph", deep}}}}}}).second, "limit-exceeded");
}

TEST(Groups, faults_have_their_place) {
    EXPECT_EQ(fault(with_twice({{"g", use({{"valeu", 1}})}})), Fault("/nodes/g/params/valeu", "unknown-parameter"));
    EXPECT_EQ(fault(with_twice({{"g", use({{"value", "much"}})}})), Fault("/nodes/g/params/value", "wrong-type"));
    EXPECT_EQ(fault(with_twice({{"g", {{"type", "ShaderNodeGroup"}, {"group", "twise"}}}})), Fault("/nodes/g/group", "unknown-name"));
    EXPECT_EQ(fault(with_twice({{"g", {{"type", "ShaderNodeGroup"}}}})), Fault("/nodes/g", "wrong-type"));
    EXPECT_EQ(fault(with_twice({{"i", {{"type", "NodeGroupInput"}}}})), Fault("/nodes/i/type", "misplaced-node"));
    EXPECT_EQ(fault(with_twice({{"g", use({{"value", link("g", "result")}})}})), Fault("/nodes/g/params/value", "cycle"));
    json inner = twice();
    inner["nodes"]["p"]["params"]["input"] = link("in", "valeu");
    EXPECT_EQ(fault({{"nodes", {{"g", {{"type", "ShaderNodeGroup"}, {"graph", inner}}}}}}), Fault("/nodes/g/graph/nodes/p/params/input/output", "unknown-output"));
    EXPECT_EQ(fault({{"groups", {{"unused", inner}}}, {"nodes", json::object()}}), Fault("/groups/unused/nodes/p/params/input/output", "unknown-output"));
    inner = twice();
    inner["inputs"]["value"]["type"] = "number";
    EXPECT_EQ(fault({{"groups", {{"unused", inner}}}, {"nodes", json::object()}}), Fault("/groups/unused/inputs/value/type", "wrong-type"));
    inner = twice();
    inner["nodes"]["r"]["params"]["input"] = link("r");
    EXPECT_EQ(fault({{"groups", {{"unused", inner}}}, {"nodes", json::object()}}), Fault("/groups/unused/nodes/r/params/input", "cycle"));
}

TEST(Groups, reroutes_lead_through_them) {
    json g = twice();
    g["nodes"]["way"] = {{"type", "NodeReroute"}, {"params", {{"Input", link("in", "value")}}}};
    g["nodes"]["p"]["params"]["input"] = link("way");
    g.erase("inputs");
    Diagnostics d;
    const auto m = material({{"nodes", {{"g", {{"type", "ShaderNodeGroup"}, {"graph", g}, {"params", {{"value", 2}}}}}}}}, d);
    ASSERT_TRUE(m) << first(d);
    EXPECT_EQ(run(*m, "g.result", {0})[0], 4.0f);
}

}  // namespace
}  // namespace alder::test
