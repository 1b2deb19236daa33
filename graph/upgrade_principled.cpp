// Principled BSDF of Blender 3.x: the sockets that Blender 4.0 renamed, rescaled or gave another meaning.
// Facts of Blender's versioning_400.cc; the mixes that it builds of nodes are built here of the same nodes.
#include <array>
#include <utility>

#include "graph/upgrade.h"
#include "graph/upgrade_tree.h"

namespace alder::upgrade {
namespace {

using Rgb = std::array<double, 3>;

struct Renaming {
    const char *from, *to;
};
constexpr Renaming kRenamed[] = {{"Emission", "Emission Color"},
                                 {"Specular", "Specular IOR Level"},
                                 {"Subsurface", "Subsurface Weight"},
                                 {"Transmission", "Transmission Weight"},
                                 {"Clearcoat", "Coat Weight"},
                                 {"Clearcoat Roughness", "Coat Roughness"},
                                 {"Clearcoat Normal", "Coat Normal"},
                                 {"Coat", "Coat Weight"},
                                 {"Sheen", "Sheen Weight"}};
constexpr const char* kOnlyOld[] = {"Emission", "Specular", "Subsurface", "Subsurface Color", "Transmission", "Transmission Roughness",
                                    "Clearcoat", "Clearcoat Roughness", "Clearcoat Normal", "Sheen"};

Rgb color(const json& params, const char* name, Rgb absent) {
    const auto it = params.find(name);
    if (it == params.end() || !it->is_array() || it->size() < 3) return absent;
    for (int i = 0; i < 3; ++i)
        if ((*it)[i].is_number()) absent[i] = (*it)[i].get<double>();
    return absent;
}
Rgb mixed(Rgb a, Rgb b, double t) {
    for (int i = 0; i < 3; ++i) a[i] = (1 - t) * a[i] + t * b[i];
    return a;
}
json mix_node(Tree& tree, const std::string& name, const char* what, json a, json b, json factor) {
    return Tree::link(tree.add(name, what, "ShaderNodeMix", {{"data_type", "RGBA"}, {"A_Color", std::move(a)}, {"B_Color", std::move(b)}, {"Factor_Float", std::move(factor)}}),
                      "Result_Color");
}
/// The parameter's value or link, `absent` where it has none.
json value_of(const json& params, const char* name, json absent) {
    const auto it = params.find(name);
    return it == params.end() ? absent : *it;
}
bool linked(const json& params, const char* name) {
    const auto it = params.find(name);
    return it != params.end() && is_link(*it);
}

/// Sheen became five times as strong, and its tint a colour.
void sheen(Tree& tree, const std::string& name) {
    json& p = tree.params(name);
    if (p.contains("Sheen Roughness")) return;
    if (linked(p, "Sheen")) {
        p["Sheen Tint"] = {0.2, 0.2, 0.2};
    } else {
        if (p.contains("Sheen")) p["Sheen"] = tree.number(name, "Sheen", 0) * 0.2;
        p["Sheen Tint"] = {1, 1, 1};
    }
    p["Sheen Roughness"] = 0.5;
}
/// The coat became four times as strong; a lower index quarters a linked one.
void coat(Tree& tree, const std::string& name) {
    json& p = tree.params(name);
    if (p.contains("Coat IOR") || !p.contains("Clearcoat")) return;
    p["Coat IOR"] = linked(p, "Clearcoat") ? 1.2 : 1.5;
    if (!linked(p, "Clearcoat")) p["Clearcoat"] = tree.number(name, "Clearcoat", 0) * 0.25;
}
/// Subsurface was the scale and at once the mix from Base Color to Subsurface Color; now its weight is 1.
void subsurface(Tree& tree, const std::string& name) {
    json& p = tree.params(name);
    if (p.contains("Subsurface Scale")) return;
    const double amount = tree.number(name, "Subsurface", 0);
    if (!linked(p, "Subsurface") && amount == 0) {
        p["Subsurface Scale"] = 0.05;
        p.erase("Subsurface Color");
        return;
    }
    const Rgb grey{0.8, 0.8, 0.8};
    p["Subsurface Scale"] = value_of(p, "Subsurface", amount);
    if (linked(p, "Subsurface") || linked(p, "Subsurface Color") || linked(p, "Base Color")) {
        const json mix = mix_node(tree, name, "subsurface color", value_of(p, "Base Color", grey), value_of(p, "Subsurface Color", grey), value_of(p, "Subsurface", amount));
        tree.params(name)["Base Color"] = mix;
    } else {
        p["Base Color"] = mixed(color(p, "Base Color", grey), color(p, "Subsurface Color", grey), amount);
    }
    json& q = tree.params(name);
    q["Subsurface"] = 1;
    q.erase("Subsurface Color");
}
/// The tint is a colour now: mix(white, mix(base, white, metallic), old tint).
void specular_tint(Tree& tree, const std::string& name) {
    json& p = tree.params(name);
    const auto it = p.find("Specular Tint");
    if (it == p.end() || it->is_array()) return;
    const Rgb white{1, 1, 1}, grey{0.8, 0.8, 0.8};
    const double amount = tree.number(name, "Specular Tint", 0), metallic = tree.number(name, "Metallic", 0);
    const json tint = *it;
    if (!is_link(tint) && amount <= 0) {
        p["Specular Tint"] = white;
        return;
    }
    json base = mixed(color(p, "Base Color", grey), white, metallic);
    bool dynamic = is_link(tint);
    if (linked(p, "Metallic") || (linked(p, "Base Color") && metallic > 0)) {
        base = mix_node(tree, name, "metallic tint", value_of(p, "Base Color", grey), white, value_of(p, "Metallic", metallic));
        dynamic = true;
    } else if (linked(p, "Base Color")) {
        base = p["Base Color"];
        dynamic = true;
    }
    const json result = dynamic ? mix_node(tree, name, "specular tint", white, base, tint) : json(mixed(white, base.get<Rgb>(), amount));
    tree.params(name)["Specular Tint"] = result;
}

}  // namespace

void principled(Tree& tree, const std::string& name) {
    json& p = tree.params(name);
    bool old = false;
    for (const char* socket : kOnlyOld) old |= p.contains(socket);
    if (!old) return;
    p.erase("Transmission Roughness");
    sheen(tree, name);
    coat(tree, name);
    subsurface(tree, name);
    specular_tint(tree, name);
    json& q = tree.params(name);
    // What 3.x called random walk is the skin variant now (upgrade.cpp has the other names).
    if (!q.contains("subsurface_method") || q["subsurface_method"] == "RANDOM_WALK") q["subsurface_method"] = "RANDOM_WALK_SKIN";
    // 3.x: black with strength 1, GGX without multiple scattering and an index of 1.45 where nothing is said.
    if (q.contains("Emission")) {
        if (!q.contains("Emission Strength")) q["Emission Strength"] = 1;
    } else if (q.contains("Emission Strength") && !q.contains("Emission Color")) {
        q["Emission Color"] = {0, 0, 0};
    }
    if (!q.contains("distribution")) q["distribution"] = "GGX";
    if (!q.contains("IOR")) q["IOR"] = 1.45;
    for (const Renaming& r : kRenamed) tree.rename(name, r.from, r.to);
}

}  // namespace alder::upgrade
