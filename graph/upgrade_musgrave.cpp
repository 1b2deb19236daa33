// Musgrave Texture, which Blender 4.1 replaced: a Noise Texture whose octaves are one fewer and whose roughness is a power of the
// lacunarity, with Math nodes where Detail, Dimension or Lacunarity are linked. Facts of Blender's versioning_410.cc.
#include <algorithm>
#include <cmath>

#include "graph/upgrade.h"
#include "graph/upgrade_tree.h"

namespace alder::upgrade {
namespace {

/// What stands for the texture's output: its own Fac, or Math nodes behind it.
struct Output {
    std::string node;
    const char* socket = "Fac";
    json link() const { return Tree::link(node, socket); }
};

/// Detail below 1 faded the only octave: multiplied by it (multifractal: towards 1).
Output faded(Tree& tree, const std::string& name, bool multifractal, json amount, json rest) {
    const std::string product = tree.math(name, "multiply", "MULTIPLY", Tree::link(name, "Fac"), std::move(amount));
    if (!multifractal) return {product, "Value"};
    return {tree.math(name, "add", "ADD", Tree::link(product, "Value"), std::move(rest)), "Value"};
}

Output detail(Tree& tree, const std::string& name, const std::string& type) {
    const bool multifractal = type == "MULTIFRACTAL", keeps_one = type == "RIDGED_MULTIFRACTAL" || type == "HETERO_TERRAIN";
    const json given = tree.params(name).contains("Detail") ? tree.params(name)["Detail"] : json(2.0);
    if (is_link(given)) {
        const json one_less = keeps_one ? Tree::link(tree.math(name, "greater", "GREATER_THAN", given, 1.0), "Value") : json(1.0);
        const std::string octaves = tree.math(name, "subtract", "SUBTRACT", given, one_less);
        tree.params(name)["Detail"] = Tree::link(tree.math(name, "minimum", "MINIMUM", Tree::link(octaves, "Value"), 14.0), "Value");
        if (keeps_one) return {name};
        const std::string amount = tree.add(name, "clamp", "ShaderNodeClamp", {{"Value", given}, {"Min", 0.0}, {"Max", 1.0}});
        json rest;
        if (multifractal) {
            const std::string r = tree.math(name, "rest", "SUBTRACT", 1.0, given);
            tree.params(r)["use_clamp"] = true;
            rest = Tree::link(r, "Value");
        }
        return faded(tree, name, multifractal, Tree::link(amount, "Result"), rest);
    }
    const double octaves = tree.number(name, "Detail", 2);
    if (octaves >= 1) {
        tree.params(name)["Detail"] = std::min(octaves - 1, 14.0);
        return {name};
    }
    if (keeps_one) return {name};
    tree.params(name)["Detail"] = 0.0;
    return faded(tree, name, multifractal, octaves, 1 - octaves);
}

/// Roughness = Lacunarity ^ -Dimension, both kept above 1e-5 where they are constants.
void roughness(Tree& tree, const std::string& name) {
    json& p = tree.params(name);
    const json dimension = p.contains("Dimension") ? p["Dimension"] : json(2.0), lacunarity = p.contains("Lacunarity") ? p["Lacunarity"] : json(2.0);
    p.erase("Dimension");
    const double d = std::max(dimension.is_number() ? dimension.get<double>() : 2.0, 1e-5);
    const double l = std::max(lacunarity.is_number() ? lacunarity.get<double>() : 2.0, 1e-5);
    json base = l;
    if (is_link(lacunarity)) base = Tree::link(tree.math(name, "lacunarity", "MAXIMUM", lacunarity, -1e-5), "Value");
    tree.params(name)["Lacunarity"] = base;
    if (!is_link(dimension) && !is_link(lacunarity)) {
        tree.params(name)["Roughness"] = std::pow(l, -d);
        return;
    }
    json exponent = -d;
    if (is_link(dimension)) {
        const std::string positive = tree.math(name, "dimension", "MAXIMUM", dimension, -1e-5);
        exponent = Tree::link(tree.math(name, "negative", "MULTIPLY", Tree::link(positive, "Value"), -1.0), "Value");
    }
    tree.params(name)["Roughness"] = Tree::link(tree.math(name, "roughness", "POWER", base, exponent), "Value");
}

/// Makes what read the texture read `output`.
void redirect(json& value, const std::string& name, const Output& output) {
    if (value.is_object() && value.contains("node")) {
        if (value["node"] != name) return;
        value["node"] = output.node;
        value["output"] = output.socket;
        return;
    }
    if (value.is_structured())
        for (auto& v : value) redirect(v, name, output);
}

}  // namespace

void musgrave(Tree& tree, const std::string& name) {
    for (const auto& [from, to] : {std::pair("musgrave_dimensions", "noise_dimensions"), {"dimensions", "noise_dimensions"},
                                   {"musgrave_type", "noise_type"}, {"type", "noise_type"}})
        tree.rename(name, from, to);
    json& p = tree.params(name);
    std::string type = "FBM";
    if (p.contains("noise_type") && p["noise_type"].is_string()) {
        type = p["noise_type"].get<std::string>();
        std::transform(type.begin(), type.end(), type.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
        p["noise_type"] = type;
    }
    p["normalize"] = false;
    tree.nodes()[name]["type"] = "ShaderNodeTexNoise";

    json before = tree.nodes();
    const Output output = detail(tree, name, type);
    roughness(tree, name);
    // Readers of before only: the new nodes read the texture itself.
    for (auto& [reader, node] : tree.nodes().items())
        if (before.contains(reader) && node.is_object() && node.contains("params")) redirect(node["params"], name, output);
    tree.nodes()[name]["upgraded_output"] = {{"node", output.node}, {"output", output.socket}};
}

}  // namespace alder::upgrade
