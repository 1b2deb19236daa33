// Faults of graph documents: where, what was found, what was expected, and all at once.
#include "graph/document.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "graph/json_text.h"
#include "tests/graph/test_nodes.h"

namespace alder::test {
namespace {

using nlohmann::json;

Diagnostics faults(const char* text, bool lenient = false) {
    Diagnostics d;
    const auto j = parse_json(text, {}, d);
    if (j) {
        MaterialOptions o;
        o.lenient = lenient;
        o.pointer_prefix = "/graph";
        build_material(*j, o, d);
    }
    return d;
}

struct Case {
    const char* text;
    const char* pointer;
    const char* code;
    const char* suggest;
};

TEST(Document, each_fault_has_pointer_code_and_suggestion) {
    const Case cases[] = {
        {R"([])", "/graph", "wrong-type", ""},
        {R"({})", "/graph/nodes", "missing", ""},
        {R"({"version": 2, "nodes": {}})", "/graph/version", "unknown-version", ""},
        {R"({"nodes": {}, "output": {}})", "/graph/output", "unknown-member", "outputs"},
        {R"({"nodes": {"a": {"type": "TestProb"}}})", "/graph/nodes/a/type", "unknown-node", "TestProbe"},
        {R"({"nodes": {"a": {"type": "ShaderNodeEeveeSpecular"}}})", "/graph/nodes/a/type", "unsupported-node", ""},
        {R"({"nodes": {"a": {"type": "TestProbe", "params": {"inputt": 1}}}})", "/graph/nodes/a/params/inputt", "unknown-parameter", "input"},
        {R"({"nodes": {"a": {"type": "TestProbe", "params": {"input": "x"}}}})", "/graph/nodes/a/params/input", "wrong-type", ""},
        {R"({"nodes": {"a": {"type": "TestProbe", "params": {"input": {"node": "b"}}}}})", "/graph/nodes/a/params/input/node", "unknown-name", ""},
        {R"({"nodes": {"a/b": {"type": "TestProbe", "params": {"input": []}}}})", "/graph/nodes/a~1b/params/input", "wrong-type", ""},
        {R"({"nodes": {"a": {"type": "TestDiffuse", "params": {"color": [1, 2]}}}})", "/graph/nodes/a/params/color", "wrong-type", ""},
        {R"({"nodes": {"a": {"type": "TestProbe", "params": {"input": {"node": "b", "component": "q"}}}, "b": {"type": "TestProbe"}}})", "/graph/nodes/a/params/input/component", "wrong-type", ""},
        {R"({"nodes": {"a": {"type": "TestProbe", "params": {"input": {"node": "d"}}}, "d": {"type": "TestDiffuse"}}})", "/graph/nodes/a/params/input", "wrong-type", ""},
        {R"({"nodes": {"a": {"type": "TestMixClosure", "params": {"a": "white"}}, "p": {"type": "TestProbe"}}})", "/graph/nodes/a/params/a", "wrong-type", ""},
        {R"({"nodes": {"a": {"type": "TestProbe"}}, "outputs": {"surface": {"node": "a"}}})", "/graph/outputs/surface", "wrong-type", ""},
        {R"({"nodes": {"a": {"type": "TestProbe", "params": {"input": {"node": "a"}}}}})", "/graph/nodes/a/params/input", "cycle", ""},
    };
    for (const auto& c : cases) {
        const auto d = faults(c.text);
        ASSERT_EQ(d.errors.size(), 1u) << c.text;
        EXPECT_EQ(d.errors[0].pointer, c.pointer) << c.text;
        EXPECT_EQ(d.errors[0].code, c.code) << c.text;
        EXPECT_EQ(d.errors[0].suggest, c.suggest) << c.text;
        EXPECT_FALSE(d.errors[0].expected.empty()) << c.text;
    }
}

TEST(Document, all_faults_are_reported_at_once) {
    const auto d = faults(R"({"nodes": {"a": {"type": "TestProbe", "params": {"input": "x", "foo": 1}}, "b": {"type": "nope"}, "c": 3}, "outputs": {"aovs": {"w": {"node": "z"}}}})");
    EXPECT_EQ(d.errors.size(), 5u);
}

TEST(Document, lenient_turns_unknown_members_into_warnings) {
    const auto d = faults(R"({"nodes": {"a": {"type": "TestProbe", "params": {"foo": 1}, "colour": 2}}})", true);
    EXPECT_TRUE(d.ok());
    EXPECT_EQ(d.warnings.size(), 2u);
}

TEST(Document, a_cycle_names_its_path) {
    const auto d = faults(R"({"nodes": {"a": {"type": "TestProbe", "params": {"input": {"node": "b"}}}, "b": {"type": "TestProbe", "params": {"input": {"node": "c"}}},
                              "c": {"type": "TestProbe", "params": {"input": {"node": "b"}}}}})");
    ASSERT_EQ(d.errors.size(), 1u);
    EXPECT_EQ(d.errors[0].path, (std::vector<std::string>{"b", "c", "b"}));
}

TEST(Document, reroutes_and_frames_are_looked_through) {
    Diagnostics d;
    const auto m = material(json::parse(R"({"nodes": {"p": {"type": "TestProbe", "params": {"input": 2}}, "f": {"type": "NodeFrame"},
        "r": {"type": "NodeReroute", "params": {"Input": {"node": "p"}}}, "s": {"type": "NodeReroute", "params": {"Input": {"node": "r"}}},
        "q": {"type": "TestProbe", "params": {"input": {"node": "s"}}}}})"), d);
    ASSERT_TRUE(m) << d.errors[0].line();
    EXPECT_EQ(run(*m, "q", {0})[0], 8.0f);
}

TEST(Document, limits_are_errors_with_the_limit) {
    json nodes;
    for (int i = 0; i < 20; ++i) nodes["n" + std::to_string(i)] = {{"type", "TestProbe"}};
    Diagnostics d;
    MaterialOptions o;
    o.limits.nodes = 10;
    EXPECT_FALSE(build_material({{"nodes", nodes}}, o, d));
    ASSERT_EQ(d.errors.size(), 1u);
    EXPECT_EQ(d.errors[0].code, "limit-exceeded");
}

TEST(JsonText, refuses_what_a_plain_parser_lets_pass) {
    const std::pair<std::string, const char*> cases[] = {
        {"{\"a\": 1, \"a\": 2}", "duplicate-key"},
        {"{\"a\": 1,\n  \"b\" 2}", "malformed-json"},
        {"", "malformed-json"},
        {"NaN", "malformed-json"},
        {"{\"a\": \"\xff\"}", "malformed-json"},
        {std::string(100, '['), "limit-exceeded"},
        {std::string(200, '1') + ".5", "limit-exceeded"},
        {"\"" + std::string(2 << 20, 'x') + "\"", "limit-exceeded"},
    };
    for (const auto& [text, code] : cases) {
        Diagnostics d;
        EXPECT_FALSE(parse_json(text, {}, d));
        ASSERT_EQ(d.errors.size(), 1u);
        EXPECT_EQ(d.errors[0].code, code) << text.substr(0, 40) << ": " << d.errors[0].line();
    }
    Diagnostics d;
    parse_json("{\"a\": 1,\n  \"b\" 2}", {}, d);
    EXPECT_NE(d.errors[0].found.find("line 2"), std::string::npos) << d.errors[0].found;
    d = {};
    parse_json("{\"nodes\": {\"x\": {\"p\": 1, \"p\": 2}}}", {}, d);
    EXPECT_EQ(d.errors[0].pointer, "/nodes/x/p");
}

/// Links at Blender's output node are outputs of the document: a volume, a displacement.
TEST(Document, links_at_the_output_node_are_outputs) {
    const auto document = [](const std::string& socket) {
        return R"({"nodes": {"c": {"type": "ShaderNodeBsdfDiffuse"}, "v": {"type": "ShaderNodeVectorMath"},
                   "o": {"type": "ShaderNodeOutputMaterial", "params": {"Surface": {"node": "c"}, )" + socket + R"(}}}, "outputs": {"surface": {"node": "o"}}})";
    };
    Diagnostics d;
    const auto filled = build_material(*parse_json(document(R"("Volume": {"node": "c"})"), {}, d), {}, d);
    ASSERT_TRUE(filled) << (d.errors.empty() ? "" : d.errors[0].line());
    EXPECT_TRUE(filled->has_volume());
    EXPECT_TRUE(filled->program({.volume = true}, d)->lobes().empty()) << "a surface's closures mean nothing in a volume";
    const auto material = build_material(*parse_json(document(R"("Displacement": {"node": "v", "output": "Vector"})"), {}, d), {}, d);
    ASSERT_TRUE(material) << (d.errors.empty() ? "" : d.errors[0].line());
    EXPECT_TRUE(material->has_displacement());
}

}  // namespace
}  // namespace alder::test
