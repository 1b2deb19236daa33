// Parameter tables of alSurface and alLayer: one row a parameter, known at compile time, so that a kernel's channel numbers
// are constants and a misspelt name does not compile.
#pragma once
#include <array>
#include <cstddef>
#include <string_view>

#include "nodes/schema.h"

namespace alder {

struct AlParam {
    std::string_view name;
    Type type = Type::Float;
    std::array<double, 3> number{};
    std::string_view text;   ///< default of String and Enum
    std::string_view items;  ///< Enum: the items, separated by '|'
    std::string_view group, label, help;
    bool takes_links = true, only_linked = false;
    bool has_range = false;
    double lo = 0, hi = 1;

    constexpr AlParam range(double low, double high) const {
        AlParam p = *this;
        p.has_range = true;
        p.lo = low;
        p.hi = high;
        return p;
    }
    /// The constant has no effect, only a link.
    constexpr AlParam link_only() const {
        AlParam p = *this;
        p.only_linked = true;
        return p;
    }
    /// Takes no link.
    constexpr AlParam fixed() const {
        AlParam p = *this;
        p.takes_links = false;
        return p;
    }
};

namespace al {
using Text = std::string_view;
constexpr AlParam f(Text name, double d, Text group, Text label, Text help) {
    return {.name = name, .type = Type::Float, .number = {d}, .group = group, .label = label, .help = help};
}
constexpr AlParam i(Text name, int d, Text group, Text label, Text help) {
    return {.name = name, .type = Type::Int, .number = {double(d)}, .group = group, .label = label, .help = help};
}
constexpr AlParam b(Text name, bool d, Text group, Text label, Text help) {
    return {.name = name, .type = Type::Bool, .number = {double(d)}, .group = group, .label = label, .help = help};
}
constexpr AlParam color(Text name, double r, double g, double bl, Text group, Text label, Text help) {
    return {.name = name, .type = Type::Color, .number = {r, g, bl}, .group = group, .label = label, .help = help};
}
constexpr AlParam vector(Text name, double x, double y, double z, Text group, Text label, Text help) {
    return {.name = name, .type = Type::Vector, .number = {x, y, z}, .group = group, .label = label, .help = help};
}
constexpr AlParam string(Text name, Text d, Text group, Text label, Text help) {
    AlParam p{.name = name, .type = Type::String, .text = d, .group = group, .label = label, .help = help};
    return p.fixed();
}
constexpr AlParam choice(Text name, Text items, Text d, Text group, Text label, Text help) {
    AlParam p{.name = name, .type = Type::Enum, .text = d, .items = items, .group = group, .label = label, .help = help};
    return p.fixed();
}
constexpr AlParam closure(Text name, Text group, Text label, Text help) {
    return {.name = name, .type = Type::Closure, .group = group, .label = label, .help = help};
}

/// The 60 AOVs that alSurface and alLayer name, in order: parameter "aov_X", default name X.
struct Aov {
    std::string_view parameter, label;
    std::string_view clamp_parameter = "";  ///< of alSurface; empty = none
    constexpr std::string_view name() const { return parameter.substr(4); }
};
inline constexpr Aov kAovs[] = {
    {"aov_diffuse_color", "Diffuse color", "aov_diffuse_color_clamp"},
    {"aov_direct_diffuse", "Direct diffuse", "aov_direct_diffuse_clamp"},
    {"aov_direct_diffuse_raw", "Direct diffuse (raw)", "aov_direct_diffuse_raw_clamp"},
    {"aov_indirect_diffuse", "Indirect diffuse", "aov_indirect_diffuse_clamp"},
    {"aov_indirect_diffuse_raw", "Indirect diffuse (raw)", "aov_indirect_diffuse_raw_clamp"},
    {"aov_direct_backlight", "Direct backlight", "aov_direct_backlight_clamp"},
    {"aov_indirect_backlight", "Indirect backlight", "aov_indirect_backlight_clamp"},
    {"aov_direct_specular", "Direct specular", "aov_direct_specular_clamp"},
    {"aov_indirect_specular", "Indirect specular", "aov_indirect_specular_clamp"},
    {"aov_direct_specular_2", "Direct specular 2", "aov_direct_specular_2_clamp"},
    {"aov_indirect_specular_2", "Indirect specular 2", "aov_indirect_specular_2_clamp"},
    {"aov_single_scatter", "Single scatter", "aov_single_scatter_clamp"},
    {"aov_sss", "SSS", "aov_sss_clamp"},
    {"aov_refraction", "Refraction", "aov_refraction_clamp"},
    {"aov_emission", "Emission", "aov_emission_clamp"},
    {"aov_uv", "UV"},
    {"aov_depth", "Depth"},
    {"aov_light_group_1", "Light group [1]", "aov_light_group_1_clamp"},
    {"aov_light_group_2", "Light group [2]", "aov_light_group_2_clamp"},
    {"aov_light_group_3", "Light group [3]", "aov_light_group_3_clamp"},
    {"aov_light_group_4", "Light group [4]", "aov_light_group_4_clamp"},
    {"aov_light_group_5", "Light group [5]", "aov_light_group_5_clamp"},
    {"aov_light_group_6", "Light group [6]", "aov_light_group_6_clamp"},
    {"aov_light_group_7", "Light group [7]", "aov_light_group_7_clamp"},
    {"aov_light_group_8", "Light group [8]", "aov_light_group_8_clamp"},
    {"aov_light_group_9", "Light group [9]", "aov_light_group_9_clamp"},
    {"aov_light_group_10", "Light group [10]", "aov_light_group_10_clamp"},
    {"aov_light_group_11", "Light group [11]", "aov_light_group_11_clamp"},
    {"aov_light_group_12", "Light group [12]", "aov_light_group_12_clamp"},
    {"aov_light_group_13", "Light group [13]", "aov_light_group_13_clamp"},
    {"aov_light_group_14", "Light group [14]", "aov_light_group_14_clamp"},
    {"aov_light_group_15", "Light group [15]", "aov_light_group_15_clamp"},
    {"aov_light_group_16", "Light group [16]", "aov_light_group_16_clamp"},
    {"aov_id_1", "ID [1]"},
    {"aov_id_2", "ID [2]"},
    {"aov_id_3", "ID [3]"},
    {"aov_id_4", "ID [4]"},
    {"aov_id_5", "ID [5]"},
    {"aov_id_6", "ID [6]"},
    {"aov_id_7", "ID [7]"},
    {"aov_id_8", "ID [8]"},
    {"aov_crypto_asset", "Crypto Asset"},
    {"aov_crypto_object", "Crypto Object"},
    {"aov_crypto_material", "Crypto Material"},
    {"aov_shadow_group_1", "Shadow group [1]"},
    {"aov_shadow_group_2", "Shadow group [2]"},
    {"aov_shadow_group_3", "Shadow group [3]"},
    {"aov_shadow_group_4", "Shadow group [4]"},
    {"aov_shadow_group_5", "Shadow group [5]"},
    {"aov_shadow_group_6", "Shadow group [6]"},
    {"aov_shadow_group_7", "Shadow group [7]"},
    {"aov_shadow_group_8", "Shadow group [8]"},
    {"aov_shadow_group_9", ""},
    {"aov_shadow_group_10", ""},
    {"aov_shadow_group_11", ""},
    {"aov_shadow_group_12", ""},
    {"aov_shadow_group_13", ""},
    {"aov_shadow_group_14", ""},
    {"aov_shadow_group_15", ""},
    {"aov_shadow_group_16", ""},
};
inline constexpr size_t kAovCount = std::size(kAovs);

constexpr std::array<AlParam, kAovCount> aov_params() {
    std::array<AlParam, kAovCount> rows{};
    for (size_t k = 0; k < kAovCount; ++k)
        rows[k] = string(kAovs[k].parameter, kAovs[k].name(), kAovs[k].label.empty() ? "" : "AOVs", kAovs[k].label,
                         "name of the AOV; no effect on the picture, whose layers keep the default names");
    return rows;
}

template <size_t... n>
constexpr auto concat(const std::array<AlParam, n>&... parts) {
    std::array<AlParam, (n + ...)> all{};
    size_t at = 0;
    const auto append = [&](const auto& part) {
        for (const AlParam& p : part) all[at++] = p;
    };
    (append(parts), ...);
    return all;
}

/// Index of a row; a name that is not there stops the compilation.
template <size_t n>
consteval int index_of(const std::array<AlParam, n>& rows, std::string_view name) {
    for (size_t k = 0; k < n; ++k)
        if (rows[k].name == name) return static_cast<int>(k);
    throw "no such parameter";
}
/// First channel of a row in OpCall::in.
template <size_t n>
consteval int channel_of(const std::array<AlParam, n>& rows, std::string_view name) {
    int c = 0;
    for (const AlParam& p : rows) {
        if (p.name == name) return c;
        c += channels(p.type);
    }
    throw "no such parameter";
}
/// First channel after all rows: where the node's globals begin.
template <size_t n>
consteval int channel_count(const std::array<AlParam, n>& rows) {
    int c = 0;
    for (const AlParam& p : rows) c += channels(p.type);
    return c;
}

/// The row as the schema has it.
inline Param make_param(const AlParam& row) {
    Param p;
    p.name = row.name;
    p.type = row.type;
    for (size_t k = 0; k < 3; ++k) p.number[k] = row.number[k];
    p.text = row.text;
    for (std::string_view rest = row.items; !rest.empty();) {
        const size_t end = std::min(rest.find('|'), rest.size());
        const std::string item(rest.substr(0, end));
        p.items.push_back({item, item, {}});
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    p.takes_links = row.takes_links;
    p.link_only = row.only_linked;
    if (row.has_range) p.range(row.lo, row.hi);
    p.group = row.group;
    p.label = row.label;
    p.help = row.help;
    return p;
}
}  // namespace al
}  // namespace alder
