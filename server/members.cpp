// Members: reads the members of one JSON object of a request, collecting every fault with its pointer.
#include "server/members.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "graph/json_text.h"
#include "nodes/schema.h"

namespace alder {

std::string brief(const nlohmann::json& value) {
    if (value.is_array()) return fmt::format("an array of {}", value.size());
    if (value.is_object()) return "an object";
    std::string text = value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    if (text.size() > 60) {
        size_t end = 57;
        while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;   // whole code points
        text = text.substr(0, end) + "...";
    }
    return text;
}

Members::Members(const nlohmann::json& object, std::string pointer, Diagnostics& d)
    : object_(object.is_object() ? &object : nullptr), pointer_(std::move(pointer)), d_(d) {
    if (!object_) d_.errors.push_back({pointer_, "wrong-type", brief(object), "an object", {}});
}

nlohmann::json Members::describing(const std::function<void(Members&)>& read) {
    nlohmann::json schema = {{"type", "object"}, {"properties", nlohmann::json::object()}};
    Diagnostics unused;
    Members m(schema, unused);
    read(m);
    return schema;
}

void Members::describe(const std::string& name, nlohmann::json schema) {
    if (schema.is_null()) schema = nlohmann::json::object();
    (*schema_)["properties"][name] = std::move(schema);
}

namespace {

/// What may be absent may be null as well.
nlohmann::json or_null(const nlohmann::json& schema) {
    if (schema.is_null() || schema.empty()) return schema;
    if (const auto type = schema.find("type"); type != schema.end() && type->is_string()) {
        if (*type == "null") return schema;
        nlohmann::json wider = schema;
        wider["type"] = {*type, "null"};
        if (const auto names = wider.find("enum"); names != wider.end()) names->push_back(nullptr);
        return wider;
    }
    return {{"anyOf", {schema, {{"type", "null"}}}}};
}

}  // namespace

bool whole_number(const nlohmann::json& value, int64_t low, int64_t high, int64_t& out) {
    if (!value.is_number()) return false;
    const double x = value.get<double>();
    if (std::floor(x) != x || !(x >= static_cast<double>(low) && x <= static_cast<double>(high))) return false;
    out = value.is_number_float() ? static_cast<int64_t>(x) : value.get<int64_t>();
    return true;
}

std::string Members::pointer(const std::string& name) const { return pointer_ + "/" + pointer_token(name); }

void Members::fault(const std::string& name, const char* code, std::string found, std::string expected, std::string suggest) {
    if (schema_) return;   // nothing is there to be wrong
    d_.errors.push_back({pointer(name), code, std::move(found), std::move(expected), std::move(suggest)});
}

const nlohmann::json* Members::find(const std::string& name, const nlohmann::json& schema) {
    if (schema_) return describe(name, or_null(schema)), nullptr;
    known_.push_back(name);
    if (!object_) return nullptr;
    const auto it = object_->find(name);
    return it == object_->end() || it->is_null() ? nullptr : &*it;
}

const nlohmann::json* Members::require(const std::string& name, const char* what, const nlohmann::json& schema) {
    if (schema_) {
        describe(name, schema);
        (*schema_)["required"].push_back(name);
        return nullptr;
    }
    const auto* value = find(name);
    if (!value && object_) fault(name, "missing-member", "nothing", what);
    return value;
}

bool Members::object(const std::string& name, const std::function<void(Members&)>& read) {
    const auto* value = schema_ ? find(name, describing(read)) : find(name);
    if (!value) return false;
    Members m(*value, pointer(name), d_);
    read(m);
    return true;
}

bool Members::number(const std::string& name, double& out, double low, double high) {
    const auto* value = find(name, schema_ ? nlohmann::json{{"type", "number"}, {"minimum", low}, {"maximum", high}} : nullptr);
    if (!value) return false;
    if (!value->is_number() || !(value->get<double>() >= low && value->get<double>() <= high)) {
        fault(name, value->is_number() ? "out-of-range" : "wrong-type", brief(*value), fmt::format("a number from {} to {}", low, high));
        return false;
    }
    out = value->get<double>();
    return true;
}

bool Members::integer(const std::string& name, int64_t& out, int64_t low, int64_t high) {
    const auto* value = find(name, schema_ ? nlohmann::json{{"type", "integer"}, {"minimum", low}, {"maximum", high}} : nullptr);
    if (!value || whole_number(*value, low, high, out)) return value != nullptr;
    const bool whole = value->is_number() && std::floor(value->get<double>()) == value->get<double>();
    fault(name, whole ? "out-of-range" : "wrong-type", brief(*value), fmt::format("a whole number from {} to {}", low, high));
    return false;
}

bool Members::boolean(const std::string& name, bool& out) {
    const auto* value = find(name, schema_ ? nlohmann::json{{"type", "boolean"}} : nullptr);
    if (!value) return false;
    if (!value->is_boolean()) {
        fault(name, "wrong-type", brief(*value), "true or false");
        return false;
    }
    out = value->get<bool>();
    return true;
}

bool Members::text(const std::string& name, std::string& out) {
    const auto* value = find(name, schema_ ? nlohmann::json{{"type", "string"}} : nullptr);
    if (!value) return false;
    if (!value->is_string()) {
        fault(name, "wrong-type", brief(*value), "a string");
        return false;
    }
    out = value->get<std::string>();
    return true;
}

bool Members::choice(const std::string& name, std::string& out, const std::vector<std::string>& names) {
    if (schema_) return find(name, {{"type", "string"}, {"enum", names}}) != nullptr;
    std::string value;
    if (!text(name, value)) return false;
    if (std::find(names.begin(), names.end(), value) == names.end()) {
        fault(name, "unknown-value", "\"" + value + "\"", fmt::format("one of {}", fmt::join(names, ", ")), nearest_name(value, names));
        return false;
    }
    out = std::move(value);
    return true;
}

bool Members::texts(const std::string& name, std::vector<std::string>& out, size_t most) {
    const auto* value = find(name, schema_ ? nlohmann::json{{"type", "array"}, {"items", {{"type", "string"}}}, {"maxItems", most}} : nullptr);
    if (!value) return false;
    const bool fits = value->is_array() && value->size() <= most &&
                      std::all_of(value->begin(), value->end(), [](const auto& v) { return v.is_string(); });
    if (!fits) {
        fault(name, "wrong-type", brief(*value), fmt::format("an array of at most {} strings", most));
        return false;
    }
    out.clear();
    for (const auto& v : *value) out.push_back(v.template get<std::string>());
    return true;
}

void Members::finish(bool lenient) {
    if (schema_) (*schema_)["additionalProperties"] = false;
    if (!object_) return;
    for (const auto& [name, value] : object_->items()) {
        if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
        auto& list = lenient ? d_.warnings : d_.errors;
        if (list.size() >= kMaxDiagnostics) return;
        list.push_back({pointer(name), "unknown-member", "\"" + name + "\"", fmt::format("one of {}", fmt::join(known_, ", ")),
                        nearest_name(name, known_)});
    }
}

}  // namespace alder
