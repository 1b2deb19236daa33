// Bump, through the compiler: heights of known slope, the reference tables (whose heights are formulas), and its switches.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "render/evaluate.h"

namespace alder {
namespace {

using nlohmann::json;

json evaluate(const json& request) {
    EvaluateOptions options;
    options.threads = 1;
    options.points.resolve_file = [](const std::string& f, std::string&) { return f; };
    Diagnostics d;
    const json answer = evaluate_request(request, options, d);
    EXPECT_TRUE(d.ok()) << (d.errors.empty() ? "" : d.errors[0].line());
    return answer;
}

json link(const char* node, const char* output) { return {{"node", node}, {"output", output}}; }

/// A graph whose node "height" gives b . P + c, times a.
json plane_height(double a, const json& b, double c) {
    return {{"position", {{"type", "ShaderNodeNewGeometry"}}},
            {"dot", {{"type", "ShaderNodeVectorMath"}, {"params", {{"operation", "DOT_PRODUCT"}, {"Vector", link("position", "Position")}, {"Vector_001", b}}}}},
            {"shifted", {{"type", "ShaderNodeMath"}, {"params", {{"operation", "ADD"}, {"Value", link("dot", "Value")}, {"Value_001", c}}}}},
            {"height", {{"type", "ShaderNodeMath"}, {"params", {{"operation", "MULTIPLY"}, {"Value", link("shifted", "Value")}, {"Value_001", a}}}}}};
}

json bump_request(json nodes, json params, const json& points) {
    params["Height"] = link("height", "Value");
    nodes["bump"] = {{"type", "ShaderNodeBump"}, {"params", params}};
    return {{"graph", {{"version", 1}, {"nodes", nodes}}}, {"points", points}, {"outputs", {"bump.Normal"}}};
}

std::vector<double> normal(const json& request) { return evaluate(request)["outputs"]["bump.Normal"][0].get<std::vector<double>>(); }

const json kPoint = {{"count", 1}, {"P", {0.3, 0.2, 0}}, {"N", {0, 0, 1}}, {"Ng", {0, 0, 1}}, {"dPdx", {0.01, 0, 0}}, {"dPdy", {0, 0.01, 0}}};

TEST(bump_node, a_slope_tilts_the_normal_by_its_gradient) {
    // Height 0.5 x + 0.25 y in scene units: the normal of z = h(x, y) is (-0.5, -0.25, 1), normalised.
    const auto n = normal(bump_request(plane_height(1, {0.5, 0.25, 0}, 3), {{"Distance", 1.0}, {"Filter Width", 1.0}}, kPoint));
    const double l = std::sqrt(1 + 0.25 + 0.0625);
    EXPECT_NEAR(n[0], -0.5 / l, 1e-4);
    EXPECT_NEAR(n[1], -0.25 / l, 1e-4);
    EXPECT_NEAR(n[2], 1 / l, 1e-4);
}

TEST(bump_node, invert_tilts_the_other_way_and_strength_zero_leaves_the_normal) {
    const json height = plane_height(1, {0.5, 0, 0}, 0);
    EXPECT_GT(normal(bump_request(height, {{"Distance", 1.0}, {"Filter Width", 1.0}, {"invert", true}}, kPoint))[0], 0.4);
    const auto flat = normal(bump_request(height, {{"Distance", 1.0}, {"Strength", 0.0}}, kPoint));
    EXPECT_NEAR(flat[0], 0, 1e-6);
    EXPECT_NEAR(flat[2], 1, 1e-6);
}

TEST(bump_node, without_a_height_the_normal_stays) {
    const json request = {{"graph", {{"version", 1}, {"nodes", {{"bump", {{"type", "ShaderNodeBump"}, {"params", {{"Height", 0.7}}}}}}}}},
                          {"points", kPoint}, {"outputs", {"bump.Normal"}}};
    EXPECT_EQ(normal(request)[2], 1);
}

TEST(bump_node, no_footprint_leaves_the_normal) {
    json point = kPoint;
    point["dPdx"] = point["dPdy"] = {0, 0, 0};
    EXPECT_EQ(normal(bump_request(plane_height(1, {0.5, 0, 0}, 0), {{"Distance", 1.0}}, point))[2], 1);
}

// ---- reference tables ------------------------------------------------------------------------------------------------

json load(const std::filesystem::path& path) {
    gzFile f = gzopen(path.c_str(), "rb");
    if (!f) return nullptr;
    std::string text;
    char block[65536];
    for (int n; (n = gzread(f, block, sizeof block)) > 0;) text.append(block, static_cast<size_t>(n));
    gzclose(f);
    return json::parse(text, nullptr, false);
}

TEST(bump_node, agrees_with_the_reference_for_heights_that_are_formulas) {
    const char* env = std::getenv("ALDER_REFERENCE");
    const auto folder = (env ? std::filesystem::path(env) : std::filesystem::path(ALDER_SOURCE_DIR) / "tests/reference") / "cycles_nodes";
    const json table = load(folder / "ShaderNodeBump.json.gz");
    if (table.is_null()) GTEST_SKIP() << "no reference table in " << folder;
    int cases = 0;
    for (const json& c : table["cases"]) {
        const json &context = c["context"], &height = context["height"];
        if (height["kind"] != "linear" && height["kind"] != "sine") continue;
        json nodes = plane_height(height["kind"] == "linear" ? height["a"].get<double>() : 1.0, height["b"], height["c"]);
        if (height["kind"] == "sine") {
            nodes["sine"] = {{"type", "ShaderNodeMath"}, {"params", {{"operation", "SINE"}, {"Value", link("shifted", "Value")}}}};
            nodes["height"]["params"] = {{"operation", "MULTIPLY"}, {"Value", link("sine", "Value")}, {"Value_001", height["a"]}};
        }
        json params = c["properties"], points = {{"count", c["points"]}};
        for (const auto& [name, value] : c["inputs"].items()) {
            params[name] = value;
            if (!value.is_array()) continue;
            params[name] = {{"attribute", "in:" + name}};
            points["attributes"]["in:" + name] = value;
        }
        for (const auto& [name, value] : context["fields"].items())
            if (name != "height") points[name] = value;
        points["surface"] = {{"mesh_file", (folder / context["mesh"].get<std::string>()).string()}, {"camera", context["camera"]},
                             {"camera_to_world", context["camera_to_world"]}, {"object_to_world", context["object_to_world"]}};
        const json got = evaluate(bump_request(nodes, params, points))["outputs"]["bump.Normal"];
        const json& want = c["outputs"]["Normal"];
        ASSERT_EQ(got.size(), want.size());
        size_t outside = 0;
        double worst = 0;
        for (size_t i = 0; i < want.size(); ++i) {
            double error = 0;
            for (int k = 0; k < 3; ++k) error = std::max(error, std::fabs(got[i][k].get<double>() - want[i][k].get<double>()));
            outside += error > 2e-4;
            worst = std::max(worst, error);
        }
        EXPECT_LE(outside, static_cast<size_t>(std::ceil(0.005 * static_cast<double>(want.size())))) << "case " << cases << " " << height["kind"] << ", worst " << worst;
        ++cases;
    }
    EXPECT_GT(cases, 0);
}

}  // namespace
}  // namespace alder
