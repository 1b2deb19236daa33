// Constants of graph documents: what the user wrote for one parameter, checked against the schema.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "graph/document_reader.h"
#include "graph/json_text.h"

namespace alder {

using nlohmann::json;

std::string shown_json(const json& v) {
    std::string s = v.dump(-1, ' ', false, json::error_handler_t::replace);
    if (s.size() > 60) s = s.substr(0, 57) + "...";
    return s;
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

namespace {

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

}  // namespace

bool read_constant(const Param& param, const json& value, const std::string& pointer, const MaterialOptions& options, DocValue& out,
                   Diagnostics& d) {
    const auto wrong = [&](std::string suggest = {}) {
        d.errors.push_back({pointer, "wrong-type", shown_json(value), expected_of(param), std::move(suggest)});
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
                    d.errors.push_back({pointer, "asset-missing", shown_json(value), why.empty() ? "an image that can be read" : why, ""});
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
                d.errors.push_back({pointer, "out-of-range", shown_json(value), fmt::format("{} ... {}", param.min, param.max), ""});
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

}  // namespace alder
