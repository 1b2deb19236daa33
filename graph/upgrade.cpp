// Older graph documents brought to Blender 4.5: renamed types and settings by table, what needs more by a function per node type.
// Facts of Blender's file versioning (versioning_300.cc to versioning_450.cc).
#include "graph/upgrade.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>
#include <utility>
#include <vector>

#include "graph/upgrade_tree.h"

namespace alder {
namespace {

using nlohmann::json;
using upgrade::Tree;

/// An item of an enumeration that has another name now. `before`: only in documents that are said to be older than this version,
/// because the old name means something else today.
struct OldItem {
    std::string_view type, param, old_item, item;
    int before = 0;
};
constexpr OldItem kItems[] = {
    {"ShaderNodeSubsurfaceScattering", "falloff", "CUBIC", "RANDOM_WALK"},
    {"ShaderNodeSubsurfaceScattering", "falloff", "GAUSSIAN", "RANDOM_WALK"},
    {"ShaderNodeSubsurfaceScattering", "falloff", "RANDOM_WALK", "RANDOM_WALK_SKIN", 400},
    {"ShaderNodeSubsurfaceScattering", "falloff", "RANDOM_WALK_FIXED_RADIUS", "RANDOM_WALK"},
    {"ShaderNodeBsdfPrincipled", "subsurface_method", "RANDOM_WALK_FIXED_RADIUS", "RANDOM_WALK"},
};

/// Sockets and properties that have another name now, or (empty) went away without a successor.
struct OldParam {
    std::string_view type, old_name, name;
};
constexpr OldParam kParams[] = {
    {"ShaderNodeSubsurfaceScattering", "Sharpness", ""},
    {"ShaderNodeSubsurfaceScattering", "Texture Blur", ""},
    {"ShaderNodeOutputAOV", "name", "aov_name"},
};

bool is(const json& node, std::string_view type) { return node.is_object() && node.contains("type") && node["type"] == type; }

/// Velvet became a model of Sheen; its spread is the roughness.
void velvet(Tree& tree, const std::string& name) {
    tree.nodes()[name]["type"] = "ShaderNodeBsdfSheen";
    json& p = tree.params(name);
    p["distribution"] = "ASHIKHMIN";
    if (!p.contains("Sigma") && !p.contains("Roughness")) p["Sigma"] = 1.0;
    tree.rename(name, "Sigma", "Roughness");
}
/// The mirror-like distribution is any other with roughness 0.
void sharp(Tree& tree, const std::string& name) {
    json& p = tree.params(name);
    p["distribution"] = "GGX";
    p["Roughness"] = 0.0;
}
/// Before 4.1, Noise clamped its roughness to 0 ... 1.
void old_noise(Tree& tree, const std::string& name) {
    json& p = tree.params(name);
    if (!p.contains("Roughness")) return;
    const json given = p["Roughness"];
    if (given.is_number()) {
        p["Roughness"] = std::clamp(given.get<double>(), 0.0, 1.0);
    } else if (upgrade::is_link(given)) {
        const json clamped = Tree::link(tree.add(name, "clamp", "ShaderNodeClamp", {{"Value", given}, {"Min", 0.0}, {"Max", 1.0}}), "Result");
        tree.params(name)["Roughness"] = clamped;
    }
}

/// 100 * major + minor; 0 where the document does not say.
int version_of(const json& document) {
    const auto it = document.find("blender_version");
    if (it == document.end()) return 0;
    int major = 0, minor = 0;
    if (it->is_string()) {
        if (std::sscanf(it->get_ref<const std::string&>().c_str(), "%d.%d", &major, &minor) < 1) return 0;
    } else if (it->is_array() && it->size() >= 2 && (*it)[0].is_number_integer() && (*it)[1].is_number_integer()) {
        major = (*it)[0].get<int>();
        minor = (*it)[1].get<int>();
    }
    return major >= 1 && major < 100 && minor >= 0 && minor < 100 ? 100 * major + minor : 0;
}

bool has_old_distribution(const json& node) {
    const auto p = node.find("params");
    return p != node.end() && p->is_object() && p->contains("distribution") && (*p)["distribution"] == "SHARP";
}

/// A group that says its own version is upgraded by that, when it is read.
bool dated_itself(const json& graph) { return graph.is_object() && graph.contains("blender_version"); }

/// Whether anything has to be done: most documents are current, and a copy costs.
bool is_old(const json& document, int version) {
    if (!document.is_object() || !document.contains("nodes") || !document["nodes"].is_object()) return false;
    for (const auto& [name, node] : document["nodes"].items()) {
        if (!node.is_object()) continue;
        for (const char* type : {"ShaderNodeTexMusgrave", "musgrave_texture", "ShaderNodeBsdfVelvet", "ShaderNodeBsdfPrincipled", "principled_bsdf",
                                 "ShaderNodeOutputAOV", "aov_output", "ShaderNodeSubsurfaceScattering"})
            if (is(node, type)) return true;
        if (has_old_distribution(node)) return true;
        if (version && version < 401 && is(node, "ShaderNodeTexNoise")) return true;
        if (node.contains("graph") && is_old(node["graph"], version)) return true;
    }
    return false;
}

/// AOV Output nodes become AOVs of the document: their colour, or the value where only that is given.
void collect_aov(json& document, Tree& tree, const std::string& name) {
    const json& p = tree.params(name);
    const auto aov = p.find("aov_name");
    if (aov == p.end() || !aov->is_string() || aov->get_ref<const std::string&>().empty()) return;
    json& outputs = document["outputs"];
    if (outputs.is_null()) outputs = json::object();
    if (!outputs.is_object()) return;
    json& aovs = outputs["aovs"];
    if (aovs.is_null()) aovs = json::object();
    if (!aovs.is_object() || aovs.contains(*aov)) return;
    const auto weight = [&](const char* socket) {  // links count most, then what is not black
        const auto v = p.find(socket);
        if (v == p.end()) return 0;
        if (upgrade::is_link(*v)) return 2;
        return *v == 0 || *v == json({0, 0, 0}) || *v == json({0, 0, 0, 1}) ? 0 : 1;
    };
    const bool value = weight("Value") > weight("Color");
    aovs[aov->get<std::string>()] = Tree::link(name, value ? "Value" : "Color");
}

/// Links of the document's outputs to nodes whose result another node has now.
void redirect_outputs(json& value, const json& nodes) {
    if (value.is_object() && value.contains("node") && value["node"].is_string()) {
        const auto node = nodes.find(value["node"].get<std::string>());
        if (node == nodes.end() || !node->is_object() || !node->contains("upgraded_output")) return;
        const json target = (*node)["upgraded_output"];
        value["node"] = target["node"];
        value["output"] = target["output"];
        return;
    }
    if (value.is_structured())
        for (auto& v : value) redirect_outputs(v, nodes);
}

void upgrade_tree(json& document, int version) {
    json& nodes = document["nodes"];
    Tree tree(nodes);
    std::vector<std::string> names;
    for (const auto& [name, node] : nodes.items())
        if (node.is_object() && (!node.contains("params") || node["params"].is_object())) names.push_back(name);
    for (const auto& name : names) {
        if (is(nodes[name], "principled_bsdf")) nodes[name]["type"] = "ShaderNodeBsdfPrincipled";
        if (is(nodes[name], "aov_output")) nodes[name]["type"] = "ShaderNodeOutputAOV";
        for (const OldParam& o : kParams) {
            if (!is(nodes[name], o.type)) continue;
            if (o.name.empty()) tree.params(name).erase(std::string(o.old_name));
            else tree.rename(name, std::string(o.old_name).c_str(), std::string(o.name).c_str());
        }
        for (const OldItem& o : kItems) {
            if (!is(nodes[name], o.type) || (o.before && !(version && version < o.before))) continue;
            const auto it = tree.params(name).find(std::string(o.param));
            if (it != tree.params(name).end() && *it == o.old_item) {
                *it = o.item;
                break;
            }
        }
        if (has_old_distribution(nodes[name])) sharp(tree, name);
        if (version && version < 401 && is(nodes[name], "ShaderNodeTexNoise")) old_noise(tree, name);
        if (is(nodes[name], "ShaderNodeBsdfVelvet")) velvet(tree, name);
        else if (is(nodes[name], "ShaderNodeBsdfPrincipled")) upgrade::principled(tree, name);
        else if (is(nodes[name], "ShaderNodeTexMusgrave") || is(nodes[name], "musgrave_texture")) upgrade::musgrave(tree, name);
        else if (is(nodes[name], "ShaderNodeOutputAOV")) collect_aov(document, tree, name);
        if (nodes[name].contains("graph") && !dated_itself(nodes[name]["graph"]) && is_old(nodes[name]["graph"], version)) upgrade_tree(nodes[name]["graph"], version);
    }
    if (document.contains("outputs")) redirect_outputs(document["outputs"], nodes);
    for (auto& [name, node] : nodes.items())
        if (node.is_object()) node.erase("upgraded_output");
}

}  // namespace

std::optional<json> upgraded_document(const json& document) {
    if (!document.is_object()) return std::nullopt;
    const int version = version_of(document);
    const bool old = is_old(document, version);
    if (!old && !document.contains("blender_version")) return std::nullopt;
    json result = document;
    result.erase("blender_version");
    if (old) upgrade_tree(result, version);
    if (result == document) return std::nullopt;
    return result;
}

}  // namespace alder
