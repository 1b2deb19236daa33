// Reading an object of a JSON document member by member.
#include "render/import/json_reader.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/schema.h"

namespace alder {

using nlohmann::json;

void add_error(Diagnostics& d, std::string pointer, std::string code, std::string found, std::string expected, std::string suggest) {
    if (d.errors.size() >= kMaxDiagnostics) return;
    d.errors.push_back({std::move(pointer), std::move(code), std::move(found), std::move(expected), std::move(suggest)});
}

void add_warning(Diagnostics& d, std::string pointer, std::string code, std::string found, std::string expected) {
    if (d.warnings.size() >= kMaxDiagnostics) return;
    d.warnings.push_back({std::move(pointer), std::move(code), std::move(found), std::move(expected), ""});
}

std::string describe(const json& j) {
    switch (j.type()) {
        case json::value_t::null: return "null";
        case json::value_t::object: return "an object";
        case json::value_t::array: return "an array of " + std::to_string(j.size());
        case json::value_t::string: {
            const std::string& s = j.get_ref<const std::string&>();
            if (s.size() <= 40) return "\"" + s + "\"";
            size_t cut = 37;   // not within a UTF-8 sequence
            while (cut > 0 && (static_cast<unsigned char>(s[cut]) & 0xc0) == 0x80) --cut;
            return "\"" + s.substr(0, cut) + "...\"";
        }
        case json::value_t::boolean: return j.get<bool>() ? "true" : "false";
        case json::value_t::number_integer:
        case json::value_t::number_unsigned:
        case json::value_t::number_float: return j.dump();
        default: return "a value of another kind";
    }
}

JsonReader::JsonReader(const json& j, std::string pointer, Diagnostics& d, bool lenient)
    : pointer_(std::move(pointer)), d_(&d), lenient_(lenient) {
    if (j.is_object()) object_ = &j;
    else add_error(d, pointer_, "wrong-type", describe(j), "an object");
}

const json* JsonReader::member(const char* key) {
    known_.emplace_back(key);
    if (!object_) return nullptr;
    const auto i = object_->find(key);
    return i == object_->end() ? nullptr : &*i;
}

const json* JsonReader::required(const char* key, const char* expected) {
    const json* j = member(key);
    if (!j && object_) add_error(*d_, pointer_to(key), "missing-member", "nothing", expected);
    return j;
}

bool JsonReader::read_number(const json& j, const std::string& pointer, double lo, double hi, double& out) {
    if (!j.is_number()) {
        add_error(*d_, pointer, "wrong-type", describe(j), "a number");
        return false;
    }
    const double x = j.get<double>();
    if (!(x >= lo && x <= hi)) {
        add_error(*d_, pointer, "out-of-range", describe(j), "a number from " + json(lo).dump() + " to " + json(hi).dump());
        return false;
    }
    out = x;
    return true;
}

void JsonReader::number(const char* key, float& out, double lo, double hi) {
    double x = 0;
    if (const json* j = member(key); j && read_number(*j, pointer_to(key), lo, hi, x)) out = float(x);
}

void JsonReader::degrees(const char* key, float& out_radians, double lo, double hi) {
    double x = 0;
    if (const json* j = member(key); j && read_number(*j, pointer_to(key), lo, hi, x)) out_radians = float(x * std::numbers::pi / 180);
}

void JsonReader::integer(const char* key, int& out, int64_t lo, int64_t hi) {
    double x = 0;
    const json* j = member(key);
    if (!j || !read_number(*j, pointer_to(key), double(lo), double(hi), x)) return;
    if (x != std::trunc(x)) add_error(*d_, pointer_to(key), "wrong-type", describe(*j), "a whole number");
    else out = int(x);
}

void JsonReader::integer(const char* key, uint32_t& out, int64_t lo, int64_t hi) {
    double x = 0;
    const json* j = member(key);
    if (!j || !read_number(*j, pointer_to(key), double(lo), double(hi), x)) return;
    if (x != std::trunc(x)) add_error(*d_, pointer_to(key), "wrong-type", describe(*j), "a whole number");
    else out = uint32_t(x);
}

void JsonReader::boolean(const char* key, bool& out) {
    const json* j = member(key);
    if (!j) return;
    if (j->is_boolean()) out = j->get<bool>();
    else add_error(*d_, pointer_to(key), "wrong-type", describe(*j), "true or false");
}

void JsonReader::text(const char* key, std::string& out) {
    const json* j = member(key);
    if (!j) return;
    if (j->is_string()) out = j->get<std::string>();
    else add_error(*d_, pointer_to(key), "wrong-type", describe(*j), "a string");
}

void JsonReader::numbers(const char* key, std::span<float> out) {
    const json* j = member(key);
    if (!j) return;
    if (!j->is_array() || j->size() != out.size()) {
        add_error(*d_, pointer_to(key), "wrong-type", describe(*j), "an array of " + std::to_string(out.size()) + " numbers");
        return;
    }
    for (size_t i = 0; i < out.size(); ++i) {
        double x = 0;
        if (read_number((*j)[i], pointer_to(key) + "/" + std::to_string(i), -3e38, 3e38, x)) out[i] = float(x);
    }
}

void JsonReader::vector(const char* key, Vec3f& out) {
    float v[3] = {out.x, out.y, out.z};
    numbers(key, v);
    out = {v[0], v[1], v[2]};
}

void JsonReader::choice(const char* key, std::span<const char* const> names, int& out) {
    const json* j = member(key);
    if (!j) return;
    std::string all;
    for (size_t i = 0; i < names.size(); ++i) {
        if (j->is_string() && j->get_ref<const std::string&>() == names[i]) {
            out = int(i);
            return;
        }
        all += std::string(i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
    }
    const std::vector<std::string> known(names.begin(), names.end());
    const std::string found = j->is_string() ? j->get<std::string>() : describe(*j);
    add_error(*d_, pointer_to(key), "unknown-value", found, all, nearest_name(found, known));
}

void JsonReader::transform(const char* key, Transform& out) {
    const json* j = member(key);
    if (!j) return;
    const bool sixteen = j->is_array() && j->size() == 16;
    if (!sixteen && !(j->is_array() && j->size() == 12)) {
        add_error(*d_, pointer_to(key), "wrong-type", describe(*j), "16 numbers (4 x 4, row by row) or the first 12 of them");
        return;
    }
    double x = 0;
    for (size_t i = 0; i < 12; ++i) {
        if (read_number((*j)[i], pointer_to(key) + "/" + std::to_string(i), -3e38, 3e38, x)) out.m[i] = float(x);
    }
    for (size_t i = 12; sixteen && i < 16; ++i) {
        const double last = i == 15 ? 1 : 0;
        if (read_number((*j)[i], pointer_to(key) + "/" + std::to_string(i), -3e38, 3e38, x) && x != last) {
            add_error(*d_, pointer_to(key) + "/" + std::to_string(i), "out-of-range", describe((*j)[i]), "0 0 0 1 as the last row");
        }
    }
}

void JsonReader::finish() {
    if (!object_) return;
    for (const auto& [key, value] : object_->items()) {
        if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
        if (lenient_) {
            add_warning(*d_, pointer_to(key), "unknown-member", key, "a member that this object knows");
        } else {
            std::string all;
            for (const std::string& k : known_) all += (all.empty() ? "" : ", ") + k;
            add_error(*d_, pointer_to(key), "unknown-member", key, "one of: " + all, nearest_name(key, known_));
        }
    }
}

}  // namespace alder
