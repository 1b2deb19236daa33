// Reading of graph documents: names, types, links and cycles, with every fault reported at once.
#include "graph/document.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/digest.h"
#include "graph/document_reader.h"
#include "graph/json_text.h"
#include "graph/upgrade.h"

namespace alder {

using nlohmann::json;

std::shared_ptr<const Document> Reader::read() {
    if (!read_nodes()) return nullptr;
    read_all_groups();
    read_outputs();
    if (d_.ok()) find_cycles();
    if (d_.ok()) check_nodes();
    if (d_.ok()) count_expanded();
    if (!d_.ok()) return nullptr;
    for (auto& n : pending_) document_->nodes.push_back(n.node);
    document_->digest = content_digest(json_);
    return document_;
}

/// Nodes, parameters and links; false where there is nothing to go on with.
bool Reader::read_nodes() {
    if (!json_.is_object()) {
        error("", "wrong-type", shown_json(json_), "a graph document (an object with \"nodes\")");
        return false;
    }
    if (group_) members(json_, "", {"version", "nodes", "inputs", "outputs", "name", "comment"});
    else members(json_, "", {"version", "nodes", "outputs", "groups", "name", "comment", "lenient"});
    if (json_.contains("version") && json_["version"] != 1) error("/version", "unknown-version", shown_json(json_["version"]), "1");
    if (!json_.contains("nodes") || !json_["nodes"].is_object()) {
        error("/nodes", "missing", json_.contains("nodes") ? shown_json(json_["nodes"]) : "nothing", "an object of nodes by name");
        return false;
    }
    if (json_["nodes"].size() > options_.limits.nodes) {
        error("/nodes", "limit-exceeded", fmt::format("{} nodes", json_["nodes"].size()), fmt::format("at most {}", options_.limits.nodes));
        return false;
    }
    declare_nodes();
    if (group_) declare_interface();
    for (auto& n : pending_) read_params(n);
    if (links_ > options_.limits.links)
        error("/nodes", "limit-exceeded", fmt::format("{} links", links_), fmt::format("at most {}", options_.limits.links));
    return true;
}

void Reader::error(const std::string& pointer, std::string code, std::string found, std::string expected, std::string suggest) {
    if (d_.errors.size() < kMaxDiagnostics)
        d_.errors.push_back({at(pointer), std::move(code), std::move(found), std::move(expected), std::move(suggest)});
}
void Reader::unknown(const std::string& pointer, std::string code, std::string found, std::string expected, std::string suggest) {
    auto& list = options_.lenient ? d_.warnings : d_.errors;
    if (list.size() < kMaxDiagnostics) list.push_back({at(pointer), std::move(code), std::move(found), std::move(expected), std::move(suggest)});
}
void Reader::members(const json& object, const std::string& pointer, std::vector<std::string> known) {
    for (const auto& [key, value] : object.items())
        if (std::find(known.begin(), known.end(), key) == known.end())
            unknown(pointer + "/" + pointer_token(key), "unknown-member", key, fmt::format("one of {}", fmt::join(known, ", ")), nearest_name(key, known));
}

void Reader::declare_nodes() {
    for (const auto& [name, j] : json_["nodes"].items()) {
        const std::string pointer = "/nodes/" + pointer_token(name);
        if (!j.is_object() || !j.contains("type") || !j["type"].is_string()) {
            error(pointer, "wrong-type", shown_json(j), "{\"type\": NODE TYPE, \"params\": {...}}");
            continue;
        }
        const auto& type_name = j["type"].get_ref<const std::string&>();
        if (type_name == "NodeFrame") continue;
        if (type_name == "NodeReroute") {
            reroutes_[name] = &j;
            continue;
        }
        if (type_name == "ShaderNodeGroup") {
            declare_group(name, j, pointer);
            continue;
        }
        if (type_name == "NodeGroupInput" || type_name == "NodeGroupOutput") {
            if (group_) group_ends_.push_back({name, &j, pointer});
            else {
                error(pointer + "/type", "misplaced-node", type_name, "a node of a material: this one stands inside a group's graph");
                declared_bad_.push_back(name);
            }
            continue;
        }
        const NodeType* type = find_node(type_name);
        if (!type) {
            if (is_known_but_unavailable(type_name)) {
                error(pointer + "/type", "unsupported-node", type_name, "a node that this version has; see /v1/nodes");
            } else {
                std::vector<std::string> names;
                for (const auto* n : all_nodes()) names.push_back(n->name);
                error(pointer + "/type", "unknown-node", type_name, "a node type", nearest_name(type_name, names));
            }
            declared_bad_.push_back(name);
            continue;
        }
        add_node(name, type, &j, pointer);
    }
}

void Reader::add_node(const std::string& name, const NodeType* type, const json* j, const std::string& pointer, DocNode::Role role,
                      std::shared_ptr<const DocGroup> group) {
    auto node = std::make_shared<DocNode>();
    node->name = name;
    node->type = type;
    node->role = role;
    node->group = std::move(group);
    node->params.resize(type->params.size());
    index_[name] = static_cast<int>(pending_.size());
    pending_.push_back({node, j, pointer, pointer + "/params"});
}

/// alImage: the first #### of the file name becomes the parameter `frame`, in four digits.
static json with_frame(const json& value, const NodeType& type, const json& params) {
    const int frame = type.param_index("frame");
    const bool file = value.is_object() && value.contains("file") && value["file"].is_string();
    if (frame < 0 || !(value.is_string() || file)) return value;
    std::string name = (file ? value["file"] : value).get<std::string>();
    const size_t at = name.find("####");
    if (at == std::string::npos) return value;
    const auto given = params.find("frame");
    const bool number = given != params.end() && given->is_number() && std::fabs(given->get<double>()) < 1e9;
    const int n = static_cast<int>(number ? given->get<double>() : type.params[frame].number[0]);
    name.replace(at, 4, fmt::format("{:04d}", n));
    json named = value;
    (file ? named["file"] : named) = name;
    return named;
}

void Reader::read_params(Pending& p) {
    if (p.node->group) members(*p.source, p.pointer, {"type", "params", "label", "name", "comment", "graph", "group"});
    else members(*p.source, p.pointer, {"type", "params", "label", "name", "comment"});
    if (!p.source->contains("params")) return;
    const json& params = (*p.source)["params"];
    const std::string& base = p.params_at;
    if (!params.is_object()) return error(base, "wrong-type", shown_json(params), "an object of parameters by name");
    std::vector<std::string> seen(p.node->params.size());
    for (const auto& [name, value] : params.items()) {
        const std::string pointer = base + "/" + pointer_token(name);
        const int i = p.node->type->param_index(name);
        if (i < 0) {
            std::vector<std::string> names;
            for (const auto& q : p.node->type->params) names.push_back(q.name);
            unknown(pointer, "unknown-parameter", name, "a parameter of " + p.node->type->name, nearest_name(name, names));
            continue;
        }
        if (!seen[i].empty()) {
            error(pointer, "duplicate-key", name + " and " + seen[i], "one name for the same parameter");
            continue;
        }
        seen[i] = name;
        const Param& param = p.node->type->params[i];
        read_value(param, param.type == Type::Image ? with_frame(value, *p.node->type, params) : value, pointer, p.node->params[i]);
    }
}

void Reader::read_value(const Param& param, const json& value, const std::string& pointer, DocValue& out) {
    const bool link = value.is_object() && value.contains("node");
    const bool attribute = value.is_object() && value.contains("attribute") && value.size() == 1;
    if (!link && !attribute) {
        if (param.type == Type::Closure) {
            if (value.is_null()) return;
            Param color = param;
            color.type = Type::Color;
            Diagnostics local;
            if (!read_constant(color, value, at(pointer), options_, out, local)) error(pointer, "wrong-type", shown_json(value), expected_of(param));
            return;
        }
        Diagnostics local;
        if (!read_constant(param, value, at(pointer), options_, out, local))
            for (auto& e : local.errors)
                if (d_.errors.size() < kMaxDiagnostics) d_.errors.push_back(e);
        for (auto& w : local.warnings) d_.warnings.push_back(w);
        return;
    }
    if (!param.takes_links) return error(pointer, "no-link", "a link", expected_of(param) + " (this parameter is fixed when the graph is compiled)");
    ++links_;
    if (attribute) {
        if (!value["attribute"].is_string()) return error(pointer + "/attribute", "wrong-type", shown_json(value["attribute"]), "an attribute name");
        out.kind = DocValue::Attribute;
        out.text = value["attribute"];
        return;
    }
    if (!read_link(value, pointer, out.link)) return;
    const auto& from = pending_[out.link.node].node->type->outputs[out.link.output];
    if (from.type == Type::Closure && param.type != Type::Closure)
        return error(pointer, "wrong-type", fmt::format("a {} from {}", type_name(from.type), pending_[out.link.node].node->name), expected_of(param));
    out.kind = DocValue::Link;
}

bool Reader::read_link(const json& value, const std::string& pointer, DocLink& out, int depth, const char* preferred) {
    if (!value.is_object() || !value.contains("node") || !value["node"].is_string()) {
        error(pointer, "wrong-type", shown_json(value), "a link {\"node\": NAME, \"output\": SOCKET}");
        return false;
    }
    members(value, pointer, {"node", "output", "component"});
    const auto& name = value["node"].get_ref<const std::string&>();
    if (const auto r = reroutes_.find(name); r != reroutes_.end()) {
        const json* params = r->second->contains("params") ? &(*r->second)["params"] : nullptr;
        if (depth > 1000 || !params || !params->is_object() || !params->contains("Input")) {
            error(pointer, depth > 1000 ? "cycle" : "unlinked", "reroute " + name, "a reroute with a linked Input");
            return false;
        }
        if (!read_link((*params)["Input"], "/nodes/" + pointer_token(name) + "/params/Input", out, depth + 1, preferred)) return false;
    } else {
        const auto it = index_.find(name);
        if (it == index_.end()) {
            if (std::find(declared_bad_.begin(), declared_bad_.end(), name) != declared_bad_.end()) return false;  // reported there
            std::vector<std::string> names;
            for (const auto& n : pending_) names.push_back(n.node->name);
            error(pointer + "/node", "unknown-name", name, "a node of this graph", nearest_name(name, names));
            return false;
        }
        out.node = it->second;
        const NodeType* type = pending_[out.node].node->type;
        out.output = 0;
        if (value.contains("output") && value["output"].is_string()) {
            const auto& output = value["output"].get_ref<const std::string&>();
            out.output = type->output_index(output);
            if (out.output < 0 && type->system == System::AlShaders) out.output = 0;
            if (out.output < 0) {
                std::vector<std::string> names;
                for (const auto& o : type->outputs) names.push_back(o.name);
                error(pointer + "/output", "unknown-output", output, fmt::format("one of {}", fmt::join(names, ", ")), nearest_name(output, names));
                return false;
            }
        } else if (value.contains("output")) {
            error(pointer + "/output", "wrong-type", shown_json(value["output"]), "an output name");
            return false;
        } else if (preferred && type->output_index(preferred) >= 0) {
            out.output = type->output_index(preferred);
        } else if (type->outputs.size() != 1 && type->system == System::Cycles) {
            std::vector<std::string> names;
            for (const auto& o : type->outputs) names.push_back(o.name);
            error(pointer, "missing-output", name, fmt::format("\"output\", one of {}", fmt::join(names, ", ")));
            return false;
        }
    }
    if (value.contains("component")) {
        static const std::string kLetters = "rgbaxyz";
        const auto c = value["component"].is_string() ? value["component"].get<std::string>() : std::string();
        const auto k = c.size() == 1 ? kLetters.find(c[0]) : std::string::npos;
        if (k == std::string::npos) {
            error(pointer + "/component", "wrong-type", shown_json(value["component"]), "one of r, g, b, a, x, y, z");
            return false;
        }
        out.component = k < 4 ? static_cast<int>(k) : static_cast<int>(k) - 4;
    }
    return true;
}

/// What is linked to Blender's output node beside the surface counts as an output of the document.
void Reader::read_output_node(const Pending& p, DocOutputs& out) {
    if (!p.node->type->name.starts_with("ShaderNodeOutput")) return;
    const auto& params = p.node->type->params;
    for (size_t i = 0; i < params.size() && i < p.node->params.size(); ++i) {
        if (p.node->params[i].kind != DocValue::Link) continue;
        if (params[i].name != "Displacement" && params[i].name != "Volume") continue;
        const int socket = p.node->type->output_index(params[i].name);
        if (socket >= 0) (params[i].name == "Volume" ? out.volume : out.displacement) = {out.surface.node, socket};
    }
    // A volume without a surface has a boundary that nothing stops at, not a black one.
    const int surface = p.node->type->param_index("Surface");
    const bool empty = surface >= 0 && p.node->params[surface].kind == DocValue::Default;
    if (empty && out.volume.node >= 0) out.surface = {};
}

void Reader::read_outputs() {
    document_ = std::make_shared<Document>();
    if (!json_.contains("outputs")) return;
    const json& o = json_["outputs"];
    if (!o.is_object()) return error("/outputs", "wrong-type", shown_json(o), "an object: surface, displacement, volume, aovs");
    members(o, "/outputs", {"surface", "displacement", "volume", "aovs"});
    auto& out = document_->outputs;
    const auto closure = [&](const char* name, DocLink& link, const char* preferred) {
        if (!o.contains(name) || o[name].is_null()) return;
        const std::string pointer = std::string("/outputs/") + name;
        if (read_link(o[name], pointer, link, 0, preferred) && pending_[link.node].node->type->outputs[link.output].type != Type::Closure) {
            error(pointer, "wrong-type", pending_[link.node].node->type->name, "a surface, volume or closure node");
            link.node = -1;
        }
    };
    closure("surface", out.surface, "Surface");
    if (out.surface.node >= 0) read_output_node(pending_[out.surface.node], out);
    closure("volume", out.volume, "Volume");
    if (o.contains("displacement") && !o["displacement"].is_null())
        read_link(o["displacement"], "/outputs/displacement", out.displacement, 0, "Displacement");
    if (!o.contains("aovs")) return;
    if (!o["aovs"].is_object()) return error("/outputs/aovs", "wrong-type", shown_json(o["aovs"]), "links by AOV name");
    for (const auto& [name, value] : o["aovs"].items()) {
        DocLink link;
        const std::string pointer = "/outputs/aovs/" + pointer_token(name);
        if (!read_link(value, pointer, link)) continue;
        if (pending_[link.node].node->type->outputs[link.output].type == Type::Closure) {
            error(pointer, "wrong-type", "a closure", "a value: float, color or vector");
            continue;
        }
        out.aovs.emplace_back(name, link);
    }
}

/// Depth first without recursion; the path from the node met again is the cycle.
void Reader::find_cycles() {
    enum : char { kWhite, kGrey, kBlack };
    std::vector<char> color(pending_.size(), kWhite);
    struct Frame {
        int node;
        size_t param;
    };
    for (size_t root = 0; root < pending_.size(); ++root) {
        if (color[root] != kWhite) continue;
        std::vector<Frame> stack{{static_cast<int>(root), 0}};
        color[root] = kGrey;
        while (!stack.empty()) {
            Frame& top = stack.back();
            const auto& params = pending_[top.node].node->params;
            while (top.param < params.size() && params[top.param].kind != DocValue::Link) ++top.param;
            if (top.param == params.size()) {
                color[top.node] = kBlack;
                stack.pop_back();
                continue;
            }
            const int here = top.node;
            const size_t param = top.param++;
            const int to = params[param].link.node;
            if (color[to] == kWhite) {
                color[to] = kGrey;
                stack.push_back({to, 0});
            } else if (color[to] == kGrey) {
                Diagnostic e{at(pending_[here].pointer + "/params/" + pointer_token(pending_[here].node->type->params[param].name)), "cycle",
                             "a link that closes a cycle", "a graph without cycles", ""};
                size_t i = stack.size();
                while (i > 0 && stack[i - 1].node != to) --i;
                for (i = i ? i - 1 : 0; i < stack.size(); ++i) e.path.push_back(pending_[stack[i].node].node->name);
                e.path.push_back(pending_[to].node->name);
                if (e.path.size() > 32) e.path.resize(32);
                if (d_.errors.size() < kMaxDiagnostics) d_.errors.push_back(e);
            }
        }
    }
}

void Reader::check_nodes() {
    for (const auto& p : pending_) check_node(*p.node, at(p.pointer), d_);
}

int Document::node_index(const std::string& name) const {
    for (size_t i = 0; i < nodes.size(); ++i)
        if (nodes[i]->name == name) return static_cast<int>(i);
    return -1;
}

bool Document::find_output(const std::string& text, DocLink& link) const {
    for (size_t dot = text.rfind('.'); dot != std::string::npos && dot > 0; dot = text.rfind('.', dot - 1)) {
        const int n = node_index(text.substr(0, dot));
        if (n < 0) continue;
        const int o = nodes[n]->type->output_index(text.substr(dot + 1));
        if (o >= 0) {
            link = {n, o, -1};
            return true;
        }
    }
    const int n = node_index(text);
    if (n < 0 || (nodes[n]->type->outputs.size() != 1 && nodes[n]->type->system != System::AlShaders)) return false;
    link = {n, 0, -1};
    return true;
}

std::shared_ptr<const Document> read_document(const json& j, const MaterialOptions& options, Diagnostics& d) {
    const auto upgraded = upgraded_document(j);
    const json& current = upgraded ? *upgraded : j;
    GroupTable groups;
    if (current.is_object() && current.contains("groups")) groups.named = &current["groups"];
    if (j.is_object() && j.contains("blender_version")) groups.version = &j["blender_version"];
    auto document = Reader(current, "", options, groups, d).read();
    if (document && upgraded) std::const_pointer_cast<Document>(document)->upgraded = true;
    return document;
}

}  // namespace alder
