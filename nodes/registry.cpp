// The node registry: collects the declarations that node files make at start-up and answers by name.
#include <algorithm>
#include <map>
#include <mutex>
#include <unordered_map>

#include "nodes/schema.h"

namespace alder {
namespace {

std::vector<NodeType (*)()>& makers() {
    static std::vector<NodeType (*)()> list;
    return list;
}

struct Registry {
    std::vector<std::unique_ptr<NodeType>> owned;
    std::vector<const NodeType*> sorted;
    std::unordered_map<std::string_view, const NodeType*> by_name;

    Registry() {
        for (auto make : makers()) owned.push_back(std::make_unique<NodeType>(make()));
        for (auto& n : owned) {
            sorted.push_back(n.get());
            by_name.emplace(n->name, n.get());
        }
        for (auto& n : owned)
            for (auto& a : n->aliases) by_name.emplace(a, n.get());
        std::sort(sorted.begin(), sorted.end(), [](auto* a, auto* b) { return a->name < b->name; });
    }
};
const Registry& registry() {
    static const Registry r;
    return r;
}

struct GlobalRow {
    Global global;
    int channels;
    const char* name;
};
// Names are those of the reference tables where these have one.
constexpr GlobalRow kGlobals[] = {
    {Global::P, 3, "P"}, {Global::N, 3, "N"}, {Global::Ng, 3, "Ng"}, {Global::I, 3, "I"}, {Global::Po, 3, "Po"},
    {Global::NormalObject, 3, "normal_object"}, {Global::Ns, 3, "Ns"}, {Global::Uv, 3, "uv"}, {Global::Generated, 3, "generated"}, {Global::Dpdu, 3, "dPdu"},
    {Global::Dpdv, 3, "dPdv"}, {Global::Dpdx, 3, "dPdx"}, {Global::Dpdy, 3, "dPdy"}, {Global::Duvdx, 3, "duvdx"},
    {Global::Duvdy, 3, "duvdy"}, {Global::Dpodx, 3, "dPodx"}, {Global::Dpody, 3, "dPody"},
    {Global::Dgendx, 3, "dgendx"}, {Global::Dgendy, 3, "dgendy"}, {Global::Tangent, 3, "T"}, {Global::TangentSign, 1, "tangent_sign"},
    {Global::TangentObject, 3, "tangent_object"}, {Global::Direction, 3, "direction"}, {Global::Window, 3, "window"},
    {Global::Reflection, 3, nullptr},
    {Global::ObjectToWorldX, 3, nullptr}, {Global::ObjectToWorldY, 3, nullptr}, {Global::ObjectToWorldZ, 3, nullptr},
    {Global::ObjectToWorldT, 3, nullptr}, {Global::WorldToObjectX, 3, nullptr}, {Global::WorldToObjectY, 3, nullptr},
    {Global::WorldToObjectZ, 3, nullptr}, {Global::WorldToObjectT, 3, nullptr}, {Global::WorldToCameraX, 3, nullptr},
    {Global::WorldToCameraY, 3, nullptr}, {Global::WorldToCameraZ, 3, nullptr}, {Global::WorldToCameraT, 3, nullptr},
    {Global::ObjectLocation, 3, "object_location"}, {Global::Ld, 3, "Ld"}, {Global::Rd, 3, "Rd"}, {Global::Ro, 3, "Ro"},
    {Global::Nf, 3, "Nf"}, {Global::Ngf, 3, "Ngf"}, {Global::Nu, 3, "Nu"}, {Global::Ngu, 3, "Ngu"},
    {Global::ObjectColor, 3, "object_color"}, {Global::FibreTangent, 3, "fibre_tangent"}, {Global::FibreNormal, 3, "fibre_normal"},
    {Global::Backfacing, 1, "backfacing"}, {Global::RayLength, 1, "ray_length"}, {Global::RayDepth, 1, "Rr"},
    {Global::DiffuseDepth, 1, "Rr_diff"}, {Global::GlossyDepth, 1, "Rr_gloss"}, {Global::TransmissionDepth, 1, "Rr_refr"},
    {Global::TransparentDepth, 1, "transparent_depth"}, {Global::IsCameraRay, 1, "is_camera_ray"},
    {Global::IsShadowRay, 1, "is_shadow_ray"}, {Global::IsDiffuseRay, 1, "is_diffuse_ray"},
    {Global::IsGlossyRay, 1, "is_glossy_ray"}, {Global::IsSingularRay, 1, "is_singular_ray"},
    {Global::IsReflectionRay, 1, "is_reflection_ray"}, {Global::IsTransmissionRay, 1, "is_transmission_ray"},
    {Global::IsVolumeRay, 1, "is_volume_ray"}, {Global::FaceIndex, 1, "fi"}, {Global::FootprintArea, 1, "area"},
    {Global::ObjectIndex, 1, "object_index"}, {Global::MaterialIndex, 1, "material_index"},
    {Global::ObjectRandom, 1, "object_random"}, {Global::IslandRandom, 1, "island_random"},
    {Global::Pointiness, 1, "pointiness"}, {Global::BarycentricU, 1, "barycentric_u"},
    {Global::BarycentricV, 1, "barycentric_v"}, {Global::Time, 1, "time"}, {Global::PixelFootprint, 1, "pixel_footprint"},
    {Global::PreviousAlpha, 1, "previous_alpha"}, {Global::IsStrand, 1, "is_strand"}, {Global::FibreOffset, 1, "h"},
    {Global::FibreCoverage, 1, "pixel_coverage"}, {Global::FibreRandom, 1, "fibre_random"}, {Global::EdgeDistance, 1, "edge_distance"},
};
static_assert(std::size(kGlobals) == static_cast<size_t>(Global::kCount));

/// Letters apart, ignoring case; neighbours exchanged count once (optimal string alignment).
int edit_distance(std::string_view a, std::string_view b) {
    const auto same = [](char x, char y) { return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y)); };
    std::vector<std::vector<int>> d(a.size() + 1, std::vector<int>(b.size() + 1));
    for (size_t i = 0; i <= a.size(); ++i) d[i][0] = static_cast<int>(i);
    for (size_t j = 0; j <= b.size(); ++j) d[0][j] = static_cast<int>(j);
    for (size_t i = 1; i <= a.size(); ++i)
        for (size_t j = 1; j <= b.size(); ++j) {
            d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (same(a[i - 1], b[j - 1]) ? 0 : 1)});
            if (i > 1 && j > 1 && same(a[i - 1], b[j - 2]) && same(a[i - 2], b[j - 1])) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
        }
    return d[a.size()][b.size()];
}

}  // namespace

NodeRegistration::NodeRegistration(NodeType (*make)()) { makers().push_back(make); }

std::span<const NodeType* const> all_nodes() { return registry().sorted; }

const NodeType* find_node(std::string_view name) {
    const auto it = registry().by_name.find(name);
    return it == registry().by_name.end() ? nullptr : it->second;
}

std::string nearest_name(std::string_view name, std::span<const std::string> candidates) {
    if (name.size() > 128) return {};
    int best = static_cast<int>(std::min(name.size() / 3 + 2, name.size()));
    std::string found;
    for (const auto& c : candidates) {
        if (c.size() > 128) continue;
        const int d = edit_distance(name, c);
        if (d < best) {
            best = d;
            found = c;
        }
    }
    return found;
}

const char* type_name(Type t) {
    switch (t) {
        case Type::Float: return "float";
        case Type::Int: return "int";
        case Type::Bool: return "bool";
        case Type::Color: return "color";
        case Type::Vector: return "vector";
        case Type::Closure: return "closure";
        case Type::Enum: return "enum";
        case Type::String: return "string";
        case Type::Image: return "image";
        case Type::Ramp: return "ramp";
        case Type::Curve: return "curve";
        case Type::Matrix: return "matrix";
        case Type::Json: return "json";
    }
    return "?";
}

int channels(Global g) { return kGlobals[static_cast<size_t>(g)].channels; }
const char* global_name(Global g) { return kGlobals[static_cast<size_t>(g)].name; }
bool global_from_name(std::string_view name, Global& out) {
    for (const auto& row : kGlobals)
        if (row.name && name == row.name) {
            out = row.global;
            return true;
        }
    return false;
}

int NodeType::param_index(std::string_view n) const {
    for (size_t i = 0; i < params.size(); ++i)
        if (params[i].name == n) return static_cast<int>(i);
    for (size_t i = 0; i < params.size(); ++i)
        for (const auto& a : params[i].aliases)
            if (a == n) return static_cast<int>(i);
    return -1;
}
int NodeType::output_index(std::string_view n) const {
    for (size_t i = 0; i < outputs.size(); ++i)
        if (outputs[i].name == n) return static_cast<int>(i);
    for (size_t i = 0; i < outputs.size(); ++i)
        for (const auto& a : outputs[i].aliases)
            if (a == n) return static_cast<int>(i);
    return -1;
}
int NodeType::channel_of(int param) const {
    int c = 0;
    for (int i = 0; i < param; ++i) c += channels(params[i].type);
    return c;
}
int NodeType::channel_of_global(int index) const {
    int c = channel_of(static_cast<int>(params.size()));
    for (int i = 0; i < index; ++i) c += alder::channels(globals[i]);
    return c;
}

namespace param {
static Param make(std::string name, Type type) {
    Param p;
    p.name = std::move(name);
    p.type = type;
    if (is_static(type) || type == Type::Closure) p.takes_links = type == Type::Closure;
    return p;
}
Param f(std::string name, double def) {
    Param p = make(std::move(name), Type::Float);
    p.number[0] = def;
    return p;
}
Param i(std::string name, int def) {
    Param p = make(std::move(name), Type::Int);
    p.number[0] = def;
    return p;
}
Param b(std::string name, bool def) {
    Param p = make(std::move(name), Type::Bool);
    p.number[0] = def;
    return p;
}
Param color(std::string name, double r, double g, double bl) {
    Param p = make(std::move(name), Type::Color);
    p.number = {r, g, bl};
    return p;
}
Param vector(std::string name, double x, double y, double z) {
    Param p = make(std::move(name), Type::Vector);
    p.number = {x, y, z};
    return p;
}
Param closure(std::string name) { return make(std::move(name), Type::Closure); }
Param choice(std::string name, std::vector<Item> items, std::string def) {
    Param p = make(std::move(name), Type::Enum);
    p.items = std::move(items);
    p.text = std::move(def);
    return p;
}
Param choice(std::string name, std::initializer_list<const char*> items, std::string def) {
    std::vector<Item> list;
    for (auto* s : items) list.push_back({s, s, {}});
    return choice(std::move(name), std::move(list), std::move(def));
}
Param string(std::string name, std::string def) {
    Param p = make(std::move(name), Type::String);
    p.text = std::move(def);
    return p;
}
Param image(std::string name) {
    Param p = make(std::move(name), Type::Image);
    p.text = "null";
    return p;
}
Param ramp(std::string name) {
    Param p = make(std::move(name), Type::Ramp);
    p.text = "null";
    return p;
}
Param curve(std::string name) {
    Param p = make(std::move(name), Type::Curve);
    p.text = "null";
    return p;
}
Param matrix(std::string name) {
    Param p = make(std::move(name), Type::Matrix);
    p.number = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    return p;
}
Param json(std::string name, std::string def) {
    Param p = make(std::move(name), Type::Json);
    p.text = std::move(def);
    return p;
}
}  // namespace param

}  // namespace alder
