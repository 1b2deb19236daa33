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

std::string Members::pointer(const std::string& name) const { return pointer_ + "/" + pointer_token(name); }

void Members::fault(const std::string& name, const char* code, std::string found, std::string expected, std::string suggest) {
    d_.errors.push_back({pointer(name), code, std::move(found), std::move(expected), std::move(suggest)});
}

const nlohmann::json* Members::find(const std::string& name) {
    known_.push_back(name);
    if (!object_) return nullptr;
    const auto it = object_->find(name);
    return it == object_->end() || it->is_null() ? nullptr : &*it;
}

const nlohmann::json* Members::require(const std::string& name, const char* what) {
    const auto* value = find(name);
    if (!value && object_) fault(name, "missing-member", "nothing", what);
    return value;
}

bool Members::number(const std::string& name, double& out, double low, double high) {
    const auto* value = find(name);
    if (!value) return false;
    if (!value->is_number() || !(value->get<double>() >= low && value->get<double>() <= high)) {
        fault(name, value->is_number() ? "out-of-range" : "wrong-type", brief(*value), fmt::format("a number from {} to {}", low, high));
        return false;
    }
    out = value->get<double>();
    return true;
}

bool Members::integer(const std::string& name, int64_t& out, int64_t low, int64_t high) {
    const auto* value = find(name);
    if (!value) return false;
    const bool whole = value->is_number_integer() || (value->is_number_float() && std::floor(value->get<double>()) == value->get<double>());
    const double x = value->is_number() ? value->get<double>() : 0;
    if (!whole || !(x >= static_cast<double>(low) && x <= static_cast<double>(high))) {
        fault(name, whole ? "out-of-range" : "wrong-type", brief(*value), fmt::format("a whole number from {} to {}", low, high));
        return false;
    }
    out = value->is_number_float() ? static_cast<int64_t>(x) : value->get<int64_t>();
    return true;
}

bool Members::boolean(const std::string& name, bool& out) {
    const auto* value = find(name);
    if (!value) return false;
    if (!value->is_boolean()) {
        fault(name, "wrong-type", brief(*value), "true or false");
        return false;
    }
    out = value->get<bool>();
    return true;
}

bool Members::text(const std::string& name, std::string& out) {
    const auto* value = find(name);
    if (!value) return false;
    if (!value->is_string()) {
        fault(name, "wrong-type", brief(*value), "a string");
        return false;
    }
    out = value->get<std::string>();
    return true;
}

bool Members::choice(const std::string& name, std::string& out, std::initializer_list<const char*> choices) {
    std::string value;
    if (!text(name, value)) return false;
    const std::vector<std::string> names(choices.begin(), choices.end());
    if (std::find(names.begin(), names.end(), value) == names.end()) {
        fault(name, "unknown-value", "\"" + value + "\"", fmt::format("one of {}", fmt::join(names, ", ")), nearest_name(value, names));
        return false;
    }
    out = std::move(value);
    return true;
}

bool Members::texts(const std::string& name, std::vector<std::string>& out, size_t most) {
    const auto* value = find(name);
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
