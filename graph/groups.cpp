// Node groups in documents: a group is a graph with an interface, written where it is used or named under "groups".
//
//   {"type": "ShaderNodeGroup", "params": {"Scale": 3}, "graph": {"nodes": {...}, "inputs": {...}, "outputs": {...}}}
//   {"type": "ShaderNodeGroup", "params": {"Scale": 3}, "group": NAME}        with {"groups": {NAME: {"nodes": ...}}} in the document
//
// Inside, NodeGroupInput has the group's inputs as outputs, and the parameters of NodeGroupOutput (or the links under "outputs") are
// what the group gives. The builder writes a group out where something asks for it; here its definition is read and checked, once.
#include <fmt/format.h>

#include <algorithm>

#include "graph/document_reader.h"
#include "graph/json_text.h"
#include "graph/upgrade.h"

namespace alder {

using nlohmann::json;

namespace {

constexpr const char* kSocketTypes = "float, int, bool, color, vector or shader";

/// Plain names, Blender's socket classes (NodeSocketFloatFactor), and its socket types (RGBA).
bool socket_type(const std::string& name, Type& out) {
    static constexpr std::pair<std::string_view, Type> kPlain[] = {
        {"float", Type::Float}, {"int", Type::Int}, {"bool", Type::Bool}, {"color", Type::Color}, {"vector", Type::Vector}, {"shader", Type::Closure},
        {"closure", Type::Closure}, {"VALUE", Type::Float}, {"INT", Type::Int}, {"BOOLEAN", Type::Bool}, {"RGBA", Type::Color}, {"VECTOR", Type::Vector},
        {"SHADER", Type::Closure}};
    for (const auto& [text, type] : kPlain)
        if (name == text) return out = type, true;
    static constexpr std::pair<std::string_view, Type> kClasses[] = {
        {"NodeSocketFloat", Type::Float}, {"NodeSocketInt", Type::Int}, {"NodeSocketBool", Type::Bool}, {"NodeSocketColor", Type::Color},
        {"NodeSocketVector", Type::Vector}, {"NodeSocketShader", Type::Closure}};
    for (const auto& [text, type] : kClasses)
        if (name.starts_with(text)) return out = type, true;
    return false;
}

Param socket(const std::string& id, Type type) {
    Param p;
    p.name = id;
    p.type = type;
    return p;
}

NodeType interface(const char* name, std::vector<Param> params, const std::vector<Param>& outputs) {
    NodeType t;
    t.name = name;
    t.params = std::move(params);
    for (const auto& p : outputs) t.outputs.push_back({p.name, p.type, p.aliases});
    return t;
}

bool is_link(const json& value) { return value.is_object() && value.contains("node"); }

}  // namespace

void Reader::declare_group(const std::string& name, const json& j, const std::string& pointer) {
    std::shared_ptr<const DocGroup> group;
    const bool inlined = j.contains("graph") && j["graph"].is_object();
    const char* const member = j.contains("group") ? "group" : "graph";
    if (inlined && !j.contains("group")) {
        group = read_group(j["graph"], base_ + pointer + "/graph", name, false);   // upgraded with the graph around it
    } else if (!inlined && j.contains(member) && j[member].is_string()) {
        group = named_group(j[member], pointer + "/" + member);
    } else {
        error(pointer, "wrong-type", j.contains(member) ? (inlined ? "both \"graph\" and \"group\"" : shown_json(j[member])) : "nothing",
              "\"graph\", the group's graph, or \"group\", a name under the document's \"groups\"");
    }
    if (!group) return declared_bad_.push_back(name);
    add_node(name, &group->type, &j, pointer, DocNode::Group, group);
}

std::shared_ptr<const DocGroup> Reader::named_group(const std::string& name, const std::string& pointer) {
    if (!groups_.named || !groups_.named->is_object() || !groups_.named->contains(name)) {
        std::vector<std::string> names;
        if (groups_.named && groups_.named->is_object())
            for (const auto& [known, j] : groups_.named->items()) names.push_back(known);
        error(pointer, "unknown-name", name, "a group of the document's \"groups\"", nearest_name(name, names));
        return nullptr;
    }
    if (const auto it = std::find(groups_.open.begin(), groups_.open.end(), name); it != groups_.open.end()) {
        error(pointer, "cycle", "group " + name + " inside itself", "groups that do not contain themselves");
        if (!d_.errors.empty() && d_.errors.back().pointer == at(pointer)) {
            d_.errors.back().path.assign(it, groups_.open.end());
            d_.errors.back().path.push_back(name);
        }
        return nullptr;
    }
    if (const auto it = groups_.done.find(name); it != groups_.done.end()) return it->second;
    groups_.open.push_back(name);
    auto group = read_group((*groups_.named)[name], "/groups/" + pointer_token(name), name, true);
    groups_.open.pop_back();
    return groups_.done[name] = group;
}

/// Definitions that nothing uses are checked too.
void Reader::read_all_groups() {
    if (!groups_.named) return;
    if (!groups_.named->is_object()) return error("/groups", "wrong-type", shown_json(*groups_.named), "an object of graphs by name");
    for (const auto& [name, j] : groups_.named->items()) named_group(name, "/groups/" + pointer_token(name));
}

std::shared_ptr<const DocGroup> Reader::read_group(const json& j, const std::string& base, const std::string& name, bool dated_by_document) {
    auto group = std::make_shared<DocGroup>();
    group->pointer = base;
    group->type.summary = name;
    json dated;
    const bool date = dated_by_document && groups_.version && j.is_object() && !j.contains("blender_version");
    if (date) (dated = j)["blender_version"] = *groups_.version;
    const auto upgraded = upgraded_document(date ? dated : j);
    Reader reader(upgraded ? *upgraded : j, base, options_, groups_, d_, group.get());
    if (groups_.depth >= options_.limits.depth) {
        reader.error("", "limit-exceeded", fmt::format("{} groups inside each other", groups_.depth + 1), fmt::format("at most {}", options_.limits.depth));
        return nullptr;
    }
    ++groups_.depth;
    const bool good = reader.read_group_graph();
    --groups_.depth;
    return good ? group : nullptr;
}

bool Reader::read_group_graph() {
    const size_t before = d_.errors.size();
    if (!read_nodes()) return false;
    if (d_.errors.size() == before) find_cycles();
    if (d_.errors.size() == before) check_nodes();
    if (d_.errors.size() == before) count_expanded();
    if (d_.errors.size() != before || before >= kMaxDiagnostics) return false;
    for (auto& n : pending_) group_->nodes.push_back(n.node);
    return true;
}

/// Groups multiply: ten levels that each use the next ten times are 10^10 nodes. Counted without writing anything out.
void Reader::count_expanded() {
    size_t sum = 0;
    for (const auto& n : pending_) {
        sum += 1 + (n.node->group ? n.node->group->expanded : 0);
        if (sum <= options_.limits.expanded) continue;
        error(n.pointer, "limit-exceeded", "a group that makes more than " + std::to_string(options_.limits.expanded) + " nodes of this graph",
              fmt::format("at most {} nodes with all groups written out", options_.limits.expanded));
        return;
    }
    (group_ ? group_->expanded : document_->expanded) = sum;
}

// ---- the interface ----------------------------------------------------------------------------------------------------

/// Sockets as "inputs" and "outputs" declare them; without these, as the graph's own links show them.
void Reader::declare_interface() {
    add_group_inputs(json_.contains("inputs") ? declared_sockets("inputs") : inferred_inputs());

    std::vector<const GroupEnd*> ends;
    for (const auto& e : group_ends_)
        if ((*e.source)["type"] == "NodeGroupOutput") ends.push_back(&e);
    const auto is_active = [](const GroupEnd* e) {
        return e->source->contains("params") && (*e->source)["params"].is_object() && (*e->source)["params"].value("is_active_output", json()) == true;
    };
    if (ends.size() > 1) {
        const auto active = std::find_if(ends.begin(), ends.end(), is_active);
        if (active == ends.end())
            return error(ends[1]->pointer, "duplicate-key", "a second NodeGroupOutput", "one, or \"is_active_output\": true in that which counts");
        ends = {*active};
    }
    const bool has_outputs = json_.contains("outputs") && json_["outputs"].is_object();
    bool links = false;
    if (has_outputs)
        for (const auto& [id, j] : json_["outputs"].items()) links |= !(j.is_object() && j.contains("type"));
    GroupEnd end{"", nullptr, "/outputs"};
    if (!ends.empty()) {
        end = *ends[0];
        if (links) return error("/outputs", "duplicate-key", "values beside a NodeGroupOutput", "sockets with their \"type\": the values are that node's parameters");
    } else {
        output_source_ = {{"type", "NodeGroupOutput"}, {"params", links ? json_["outputs"] : json::object()}};
        end.source = &output_source_;
    }
    std::vector<Param> sockets;
    if (json_.contains("outputs") && !links) sockets = declared_sockets("outputs");
    else if (end.source->contains("params")) sockets = inferred_outputs((*end.source)["params"]);
    for (auto& p : sockets) group_->type.outputs.push_back({p.name, p.type, p.aliases});
    sockets.push_back(param::b("is_active_output", true).no_link());
    group_->output = interface("NodeGroupOutput", std::move(sockets), {});
    group_->output_node = static_cast<int>(pending_.size());
    const auto known = index_;
    add_node(end.name, &group_->output, end.source, end.pointer, DocNode::GroupOutput);
    if (ends.empty()) {  // nobody wrote this node: it has no name to link to
        pending_.back().params_at = "/outputs";
        index_ = known;
    }
}

void Reader::add_group_inputs(const std::vector<Param>& sockets) {
    auto label = group_->type.summary;
    group_->type = interface("ShaderNodeGroup", sockets, {});
    group_->type.summary = std::move(label);
    group_->input = interface("NodeGroupInput", {}, sockets);
    for (const auto& e : group_ends_)
        if ((*e.source)["type"] == "NodeGroupInput") add_node(e.name, &group_->input, e.source, e.pointer, DocNode::GroupInput);
}

std::vector<Param> Reader::declared_sockets(const char* member) {
    const std::string base = std::string("/") + member;
    std::vector<Param> sockets;
    if (!json_[member].is_object()) {
        error(base, "wrong-type", shown_json(json_[member]), "sockets by name");
        return sockets;
    }
    for (const auto& [id, j] : json_[member].items()) {
        Param p;
        if (read_socket(id, j, base + "/" + pointer_token(id), p)) sockets.push_back(std::move(p));
    }
    return sockets;
}

bool Reader::read_socket(const std::string& id, const json& j, const std::string& pointer, Param& out) {
    if (!j.is_object() || !j.contains("type") || !j["type"].is_string()) {
        error(pointer, "wrong-type", shown_json(j), std::string("{\"type\": TYPE, \"default\": VALUE}, TYPE being ") + kSocketTypes);
        return false;
    }
    members(j, pointer, {"type", "name", "default", "min", "max", "description"});
    Type type;
    if (!socket_type(j["type"], type)) {
        error(pointer + "/type", "wrong-type", j["type"], kSocketTypes);
        return false;
    }
    out = socket(id, type);
    if (j.contains("name") && j["name"].is_string() && j["name"] != id) out.aliases.push_back(j["name"]);
    if (!j.contains("default") || j["default"].is_null()) return true;
    DocValue v;
    Diagnostics local;
    if (type == Type::Closure) {
        error(pointer + "/default", "wrong-type", shown_json(j["default"]), "nothing: a shader input that is not linked has no shader");
        return false;
    }
    if (!read_constant(out, j["default"], at(pointer + "/default"), options_, v, local)) {
        for (auto& e : local.errors)
            if (d_.errors.size() < kMaxDiagnostics) d_.errors.push_back(std::move(e));
        return false;
    }
    out.number = v.number;
    return true;
}

const json* Reader::behind_reroutes(const json* link) const {
    for (int depth = 0; depth < 1000 && is_link(*link) && (*link)["node"].is_string(); ++depth) {
        const auto it = reroutes_.find((*link)["node"]);
        if (it == reroutes_.end()) return link;
        const json* params = it->second->contains("params") ? &(*it->second)["params"] : nullptr;
        if (!params || !params->is_object() || !params->contains("Input")) return nullptr;
        link = &(*params)["Input"];
    }
    return nullptr;
}

/// An input that is not declared has the type and default of the first parameter that reads it, three channels before one.
std::vector<Param> Reader::inferred_inputs() const {
    std::vector<std::string> names;
    for (const auto& e : group_ends_)
        if ((*e.source)["type"] == "NodeGroupInput") names.push_back(e.name);
    std::vector<Param> sockets;
    const auto meet = [&](const json& value, const Param* reader) {
        if (!is_link(value)) return;
        const json* link = behind_reroutes(&value);
        if (!link || !is_link(*link) || !link->contains("output") || !(*link)["output"].is_string()) return;
        if (!(*link)["node"].is_string() || std::find(names.begin(), names.end(), (*link)["node"].get<std::string>()) == names.end()) return;
        const auto& id = (*link)["output"].get_ref<const std::string&>();
        const bool part = link->contains("component") || value.contains("component");
        Param p = socket(id, part ? Type::Color : reader ? reader->type : Type::Color);
        if (reader && !part) p.number = reader->number;
        const auto it = std::find_if(sockets.begin(), sockets.end(), [&](const Param& s) { return s.name == id; });
        if (it == sockets.end()) sockets.push_back(std::move(p));
        else if (channels(p.type) > channels(it->type) && it->type != Type::Closure) *it = std::move(p);
    };
    for (const auto& n : pending_) {
        if (!n.source->contains("params") || !(*n.source)["params"].is_object()) continue;
        for (const auto& [name, value] : (*n.source)["params"].items()) {
            const int i = n.node->type->param_index(name);
            if (i >= 0) meet(value, &n.node->type->params[i]);
        }
    }
    // Handed straight on to an output: a colour, unless something else reads it too.
    for (const auto& e : group_ends_)
        if ((*e.source)["type"] == "NodeGroupOutput" && e.source->contains("params") && (*e.source)["params"].is_object())
            for (const auto& [name, value] : (*e.source)["params"].items()) meet(value, nullptr);
    if (json_.contains("outputs") && json_["outputs"].is_object())
        for (const auto& [name, value] : json_["outputs"].items()) meet(value, nullptr);
    return sockets;
}

/// An output that is not declared has the type of what feeds it.
std::vector<Param> Reader::inferred_outputs(const json& params) {
    std::vector<Param> sockets;
    if (!params.is_object()) return sockets;
    for (const auto& [id, value] : params.items()) {
        if (id == "is_active_output") continue;
        Type type = value.is_number() ? Type::Float : value.is_boolean() ? Type::Bool : Type::Color;
        if (value.is_object() && value.contains("attribute")) type = Type::Color;
        if (is_link(value)) {
            const size_t errors = d_.errors.size(), warnings = d_.warnings.size();
            DocLink link;
            if (read_link(value, "/outputs", link))
                type = link.component >= 0 ? Type::Float : pending_[link.node].node->type->outputs[link.output].type;
            d_.errors.resize(errors);  // reported when the parameter is read
            d_.warnings.resize(warnings);
        }
        sockets.push_back(socket(id, type));
    }
    return sockets;
}

}  // namespace alder
