// The node catalogue as JSON.
#include "nodes/registry_json.h"

namespace alder {
namespace {

using nlohmann::json;

constexpr double kUnlimited = 1e37;   // limits beyond are the schema's "none"

json default_json(const Param& p) {
    switch (p.type) {
        case Type::Float: return p.number[0];
        case Type::Int: return static_cast<int64_t>(p.number[0]);
        case Type::Bool: return p.number[0] != 0;
        case Type::Color:
        case Type::Vector: return json::array({p.number[0], p.number[1], p.number[2]});
        case Type::Matrix: return p.number;
        case Type::Enum:
        case Type::String: return p.text;
        case Type::Image:
        case Type::Ramp:
        case Type::Curve:
        case Type::Json: return json::parse(p.text, nullptr, false);
        case Type::Closure: return nullptr;
    }
    return nullptr;
}

bool is_number(Type t) { return t == Type::Float || t == Type::Int || t == Type::Color || t == Type::Vector; }

json param_json(const Param& p) {
    json j = {{"name", p.name}, {"type", type_name(p.type)}, {"links", p.takes_links}};
    json value = default_json(p);
    if (value.is_discarded()) value = nullptr;
    if (p.has_default_global)
        j["default"] = nullptr;   // unlinked, it reads the shading point
    else
        j["default"] = std::move(value);
    if (p.has_default_global && global_name(p.default_global)) j["default_global"] = global_name(p.default_global);
    if (is_number(p.type)) {
        if (p.min > -kUnlimited) j["min"] = p.min;
        if (p.max < kUnlimited) j["max"] = p.max;
        j["soft_min"] = p.soft_min;
        j["soft_max"] = p.soft_max;
    }
    if (p.link_only) j["link_only"] = true;
    if (!p.items.empty()) {
        json items = json::array();
        for (const Item& item : p.items) {
            json row = {{"name", item.name}, {"label", item.label.empty() ? item.name : item.label}};
            if (!item.cycles.empty()) row["cycles"] = item.cycles;
            items.push_back(std::move(row));
        }
        j["enum"] = std::move(items);
    }
    if (!p.label.empty()) j["label"] = p.label;
    if (!p.group.empty()) j["group"] = p.group;
    if (!p.help.empty()) j["help"] = p.help;
    if (!p.aliases.empty()) j["aliases"] = p.aliases;
    return j;
}

json brief_json(const NodeType& type) {
    return {{"name", type.name}, {"system", type.system == System::Cycles ? "cycles" : "alshaders"}, {"category", type.category},
            {"summary", type.summary}, {"closure", type.is_closure()}};
}

template <class F>
json list(F&& each) {
    json items = json::array();
    for (const NodeType* type : all_nodes()) items.push_back(each(*type));
    return {{"items", std::move(items)}, {"next", nullptr}};
}

}  // namespace

json node_json(const NodeType& type) {
    json j = brief_json(type);
    if (!type.help.empty()) j["help"] = type.help;
    if (!type.aliases.empty()) j["aliases"] = type.aliases;
    j["params"] = json::array();
    for (const Param& p : type.params) j["params"].push_back(param_json(p));
    j["outputs"] = json::array();
    for (const Output& o : type.outputs) {
        json row = {{"name", o.name}, {"type", type_name(o.type)}};
        if (!o.aliases.empty()) row["aliases"] = o.aliases;
        j["outputs"].push_back(std::move(row));
    }
    return j;
}

json nodes_json() { return list(node_json); }
json nodes_summary_json() { return list(brief_json); }

}  // namespace alder
