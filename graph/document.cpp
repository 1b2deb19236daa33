// Reading of graph documents: names, types, links and cycles, with every fault reported at once.
#include "graph/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "graph/digest.h"
#include "graph/json_text.h"
#include "graph/upgrade.h"

namespace alder {
namespace {

using nlohmann::json;

std::string shown(const json& v) {
    std::string s = v.dump(-1, ' ', false, json::error_handler_t::replace);
    if (s.size() > 60) s = s.substr(0, 57) + "...";
    return s;
}

/// Numbers, and the strings that stand for what JSON cannot write.
bool number(const json& v, double& out) {
    if (v.is_number()) {
        out = v.get<double>();
        return true;
    }
    if (!v.is_string()) return false;
    const auto& s = v.get_ref<const std::string&>();
    if (s == "nan") out = std::numeric_limits<double>::quiet_NaN();
    else if (s == "inf") out = std::numeric_limits<double>::infinity();
    else if (s == "-inf") out = -std::numeric_limits<double>::infinity();
    else return false;
    return true;
}

std::string expected_of(const Param& p) {
    switch (p.type) {
        case Type::Float: return "a number or a link";
        case Type::Int: return "a whole number or a link";
        case Type::Bool: return "true or false";
        case Type::Color: return "[r, g, b] or a link";
        case Type::Vector: return "[x, y, z] or a link";
        case Type::Closure: return "a link to a surface or closure node, or a colour [r, g, b] as light emitted";
        case Type::Enum: {
            std::string s = "one of ";
            for (size_t i = 0; i < p.items.size() && i < 48; ++i) s += (i ? ", " : "") + p.items[i].name;
            return s;
        }
        case Type::String: return "a string";
        case Type::Image: return "{\"asset\": \"sha256:...\"}, {\"file\": NAME} or a file name";
        case Type::Ramp: return "a color ramp: {\"elements\": [{\"position\", \"color\"}], ...}";
        case Type::Curve: return "a curve mapping";
        case Type::Matrix: return "16 numbers";
        case Type::Json: return "a structure";
    }
    return "";
}

class Reader {
  public:
    Reader(const json& j, const MaterialOptions& o, Diagnostics& d) : json_(j), options_(o), d_(d) {}

    std::shared_ptr<const Document> read() {
        if (!json_.is_object()) {
            error("", "wrong-type", shown(json_), "a graph document (an object with \"nodes\")");
            return nullptr;
        }
        members(json_, "", {"version", "nodes", "outputs", "name", "comment", "lenient"});
        if (json_.contains("version") && json_["version"] != 1) error("/version", "unknown-version", shown(json_["version"]), "1");
        if (!json_.contains("nodes") || !json_["nodes"].is_object()) {
            error("/nodes", "missing", json_.contains("nodes") ? shown(json_["nodes"]) : "nothing", "an object of nodes by name");
            return nullptr;
        }
        if (json_["nodes"].size() > options_.limits.nodes) {
            error("/nodes", "limit-exceeded", fmt::format("{} nodes", json_["nodes"].size()), fmt::format("at most {}", options_.limits.nodes));
            return nullptr;
        }
        declare_nodes();
        for (auto& n : pending_) read_params(n);
        if (links_ > options_.limits.links)
            error("/nodes", "limit-exceeded", fmt::format("{} links", links_), fmt::format("at most {}", options_.limits.links));
        read_outputs();
        if (d_.ok()) find_cycles();
        if (d_.ok()) check_nodes();
        if (!d_.ok()) return nullptr;
        for (auto& n : pending_) document_->nodes.push_back(n.node);
        document_->digest = content_digest(json_);
        return document_;
    }

  private:
    struct Pending {
        std::shared_ptr<DocNode> node;
        const json* source;
        std::string pointer;
    };

    std::string at(const std::string& pointer) const { return options_.pointer_prefix + pointer; }
    void error(const std::string& pointer, std::string code, std::string found, std::string expected, std::string suggest = {}) {
        if (d_.errors.size() < kMaxDiagnostics)
            d_.errors.push_back({at(pointer), std::move(code), std::move(found), std::move(expected), std::move(suggest)});
    }
    /// A member nobody knows: an error, or with lenient a warning.
    void unknown(const std::string& pointer, std::string code, std::string found, std::string expected, std::string suggest) {
        auto& list = options_.lenient ? d_.warnings : d_.errors;
        if (list.size() < kMaxDiagnostics) list.push_back({at(pointer), std::move(code), std::move(found), std::move(expected), std::move(suggest)});
    }
    void members(const json& object, const std::string& pointer, std::vector<std::string> known) {
        for (const auto& [key, value] : object.items())
            if (std::find(known.begin(), known.end(), key) == known.end())
                unknown(pointer + "/" + pointer_token(key), "unknown-member", key, fmt::format("one of {}", fmt::join(known, ", ")), nearest_name(key, known));
    }

    void declare_nodes() {
        for (const auto& [name, j] : json_["nodes"].items()) {
            const std::string pointer = "/nodes/" + pointer_token(name);
            if (!j.is_object() || !j.contains("type") || !j["type"].is_string()) {
                error(pointer, "wrong-type", shown(j), "{\"type\": NODE TYPE, \"params\": {...}}");
                continue;
            }
            const auto& type_name = j["type"].get_ref<const std::string&>();
            if (type_name == "NodeFrame") continue;
            if (type_name == "NodeReroute") {
                reroutes_[name] = &j;
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
            auto node = std::make_shared<DocNode>();
            node->name = name;
            node->type = type;
            node->params.resize(type->params.size());
            index_[name] = static_cast<int>(pending_.size());
            pending_.push_back({node, &j, pointer});
        }
    }

    void read_params(Pending& p) {
        members(*p.source, p.pointer, {"type", "params", "label", "name", "comment"});
        if (!p.source->contains("params")) return;
        const json& params = (*p.source)["params"];
        const std::string base = p.pointer + "/params";
        if (!params.is_object()) return error(base, "wrong-type", shown(params), "an object of parameters by name");
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

    void read_value(const Param& param, const json& value, const std::string& pointer, DocValue& out) {
        const bool link = value.is_object() && value.contains("node");
        const bool attribute = value.is_object() && value.contains("attribute") && value.size() == 1;
        if (!link && !attribute) {
            if (param.type == Type::Closure) {
                if (value.is_null()) return;
                Param color = param;
                color.type = Type::Color;
                Diagnostics local;
                if (!read_constant(color, value, at(pointer), options_, out, local)) error(pointer, "wrong-type", shown(value), expected_of(param));
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
            if (!value["attribute"].is_string()) return error(pointer + "/attribute", "wrong-type", shown(value["attribute"]), "an attribute name");
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

    /// `preferred`: the output meant where none is named and the node has several.
    bool read_link(const json& value, const std::string& pointer, DocLink& out, int depth = 0, const char* preferred = nullptr) {
        if (!value.is_object() || !value.contains("node") || !value["node"].is_string()) {
            error(pointer, "wrong-type", shown(value), "a link {\"node\": NAME, \"output\": SOCKET}");
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
                error(pointer + "/output", "wrong-type", shown(value["output"]), "an output name");
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
                error(pointer + "/component", "wrong-type", shown(value["component"]), "one of r, g, b, a, x, y, z");
                return false;
            }
            out.component = k < 4 ? static_cast<int>(k) : static_cast<int>(k) - 4;
        }
        return true;
    }

    void read_outputs() {
        document_ = std::make_shared<Document>();
        if (!json_.contains("outputs")) return;
        const json& o = json_["outputs"];
        if (!o.is_object()) return error("/outputs", "wrong-type", shown(o), "an object: surface, displacement, volume, aovs");
        members(o, "/outputs", {"surface", "displacement", "volume", "aovs"});
        auto& out = document_->outputs;
        const auto closure = [&](const char* name, DocLink& link) {
            if (!o.contains(name) || o[name].is_null()) return;
            const std::string pointer = std::string("/outputs/") + name;
            if (read_link(o[name], pointer, link, 0, "Surface") && pending_[link.node].node->type->outputs[link.output].type != Type::Closure) {
                error(pointer, "wrong-type", pending_[link.node].node->type->name, "a surface or closure node");
                link.node = -1;
            }
        };
        closure("surface", out.surface);
        if (o.contains("volume") && !o["volume"].is_null())
            error("/outputs/volume", "unsupported", "a volume", "a graph without volume output: volumes are not available in this version");
        if (o.contains("displacement") && !o["displacement"].is_null()) 
            read_link(o["displacement"], "/outputs/displacement", out.displacement, 0, "Displacement");
        if (!o.contains("aovs")) return;
        if (!o["aovs"].is_object()) return error("/outputs/aovs", "wrong-type", shown(o["aovs"]), "links by AOV name");
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
    void find_cycles() {
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

    void check_nodes() {
        for (const auto& p : pending_) check_node(*p.node, at(p.pointer), d_);
    }

    const json& json_;
    const MaterialOptions& options_;
    Diagnostics& d_;
    std::shared_ptr<Document> document_;
    std::vector<Pending> pending_;
    std::unordered_map<std::string, int> index_;
    std::unordered_map<std::string, const json*> reroutes_;
    std::vector<std::string> declared_bad_;
    size_t links_ = 0;
};

}  // namespace

bool read_constant(const Param& param, const json& value, const std::string& pointer, const MaterialOptions& options, DocValue& out,
                   Diagnostics& d) {
    const auto wrong = [&](std::string suggest = {}) {
        d.errors.push_back({pointer, "wrong-type", shown(value), expected_of(param), std::move(suggest)});
        return false;
    };
    out = DocValue();
    out.kind = DocValue::Constant;
    switch (param.type) {
        case Type::Float:
            if (!number(value, out.number[0])) return wrong();
            break;
        case Type::Int:
            if (!number(value, out.number[0]) || (std::isfinite(out.number[0]) && std::floor(out.number[0]) != out.number[0])) return wrong();
            break;
        case Type::Bool:
            if (value.is_boolean()) out.number[0] = value.get<bool>() ? 1 : 0;
            else if (value == 0 || value == 1) out.number[0] = value.get<int>();
            else return wrong();
            out.item = out.number[0] != 0;
            break;
        case Type::Color:
        case Type::Vector:
            if (!value.is_array() || value.size() < 3 || value.size() > 4 || (param.type == Type::Vector && value.size() == 4)) return wrong();
            for (size_t i = 0; i < value.size(); ++i)
                if (!number(value[i], out.number[i])) return wrong();
            break;
        case Type::Matrix: {
            std::vector<json> flat;
            if (!value.is_array()) return wrong();
            for (const auto& row : value) {
                if (row.is_array()) flat.insert(flat.end(), row.begin(), row.end());
                else flat.push_back(row);
            }
            if (flat.size() != 16) return wrong();
            for (size_t i = 0; i < 16; ++i)
                if (!number(flat[i], out.number[i])) return wrong();
            break;
        }
        case Type::Enum: {
            if (!value.is_string()) return wrong();
            const auto& s = value.get_ref<const std::string&>();
            out.item = -1;
            for (int pass = 0; pass < 3 && out.item < 0; ++pass)
                for (size_t i = 0; i < param.items.size(); ++i) {
                    const auto& item = param.items[i];
                    if (s == (pass == 0 ? item.name : pass == 1 ? item.cycles : item.label) && !s.empty()) {
                        out.item = static_cast<int>(i);
                        break;
                    }
                }
            if (out.item < 0) {
                std::vector<std::string> names;
                for (const auto& item : param.items) names.push_back(item.name);
                return wrong(nearest_name(s, names));
            }
            break;
        }
        case Type::String:
            if (value.is_null()) out.text = "";
            else if (value.is_string()) out.text = value.get<std::string>();
            else return wrong();
            break;
        case Type::Image: {
            json image = value;
            // A file that may as well be written out (an IES profile) says so by an item "text"; a file name has no line breaks.
            const bool written_out = !param.items.empty() && value.is_string() && value.get_ref<const std::string&>().find('\n') != std::string::npos;
            if (value.is_string()) image = {{written_out ? "text" : "file", value}};
            if (value.is_null() || value == "") {
                out.text = "null";
                break;
            }
            if (!param.items.empty() && image.is_object() && image.contains("text") && image["text"].is_string()) {
                out.text = image.dump(-1, ' ', false, json::error_handler_t::replace);
                break;
            }
            if (!image.is_object() || !(image.contains("file") || image.contains("asset"))) return wrong();
            if (options.resolve_image) {
                std::string why;
                const std::string path = options.resolve_image(image, why);
                if (path.empty()) {
                    d.errors.push_back({pointer, "asset-missing", shown(value), why.empty() ? "an image that can be read" : why, ""});
                    return false;
                }
                image["file"] = path;
            }
            out.text = image.dump();
            break;
        }
        case Type::Ramp:
        case Type::Curve:
            if (!value.is_object() && !value.is_array() && !value.is_null()) return wrong();
            out.text = value.dump();
            break;
        case Type::Json: out.text = value.dump(); break;
        case Type::Closure: return wrong();
    }
    if (param.hard && !is_static(param.type)) {
        for (int i = 0; i < channels(param.type); ++i)
            if (out.number[i] < param.min || out.number[i] > param.max) {
                d.errors.push_back({pointer, "out-of-range", shown(value), fmt::format("{} ... {}", param.min, param.max), ""});
                return false;
            }
    }
    return true;
}

void check_node(const DocNode& n, const std::string& pointer, Diagnostics& d) {
    const NodeType& type = *n.type;
    if (!type.check) return;
    std::vector<const double*> constant;
    for (size_t i = 0; i < type.params.size(); ++i) {
        const auto& v = n.params[i];
        constant.push_back(v.kind == DocValue::Constant ? v.number.data() : v.kind == DocValue::Default ? type.params[i].number.data() : nullptr);
    }
    std::vector<std::string> faults;
    type.check(make_statics(n), constant, faults);
    for (const auto& f : faults) {
        const auto colon = f.find(':');
        const int param = colon == std::string::npos ? -1 : type.param_index(f.substr(0, colon));
        const std::string why = param >= 0 ? f.substr(std::min(f.size(), colon + 2)) : f;
        if (d.errors.size() < kMaxDiagnostics)
            d.errors.push_back({pointer + (param >= 0 ? "/params/" + pointer_token(type.params[param].name) : ""), "unsupported",
                                param >= 0 ? type.params[param].name : type.name, why, ""});
    }
}

Statics make_statics(const DocNode& n) {
    Statics s;
    s.type = n.type;
    const size_t count = n.type->params.size();
    s.enums.assign(count, 0);
    s.text.assign(count, "");
    s.linked.assign(count, false);
    s.zero.assign(count, false);
    s.one.assign(count, false);
    s.at_default.assign(count, false);
    for (size_t i = 0; i < count; ++i) {
        const Param& p = n.type->params[i];
        const DocValue& v = n.params[i];
        s.linked[i] = v.kind == DocValue::Link || v.kind == DocValue::Attribute;
        const bool given = v.kind == DocValue::Constant;
        if (const int n_channels = channels(p.type); n_channels > 0 && !s.linked[i]) {
            const auto& number = given ? v.number : p.number;
            const auto end = number.begin() + n_channels;
            s.at_default[i] = !given || (!p.has_default_global && std::equal(number.begin(), end, p.number.begin()));
            const bool constant = !p.has_default_global || given;
            s.zero[i] = constant && std::all_of(number.begin(), end, [](double x) { return x == 0; });
            s.one[i] = constant && std::all_of(number.begin(), end, [](double x) { return x == 1; });
        }
        if (p.type == Type::Enum) {
            s.enums[i] = v.item;
            if (!given)
                for (size_t k = 0; k < p.items.size(); ++k)
                    if (p.items[k].name == p.text) s.enums[i] = static_cast<int>(k);
        } else if (p.type == Type::Bool) {  // a Bool decides structure: editing one compiles again
            s.enums[i] = !s.linked[i] && (given ? v.number[0] : p.number[0]) != 0;
        } else if (p.type == Type::Int && !p.takes_links) {
            s.enums[i] = static_cast<int>(given ? v.number[0] : p.number[0]);
        } else if (p.type == Type::Matrix) {
            s.text[i] = json(given ? v.number : p.number).dump();
        } else if (channels(p.type) > 0 && !p.takes_links) {  // for NodeType::prepare(): numbers fixed when the graph is compiled
            const auto& number = given ? v.number : p.number;
            s.text[i] = fmt::format("{}", fmt::join(number.begin(), number.begin() + channels(p.type), " "));
        } else if (is_static(p.type)) {
            s.text[i] = given ? v.text : p.text;
        }
    }
    return s;
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
    auto document = Reader(upgraded ? *upgraded : j, options, d).read();
    if (document && upgraded) std::const_pointer_cast<Document>(document)->upgraded = true;
    return document;
}

}  // namespace alder
