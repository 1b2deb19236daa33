// Query: members of a request's query, each known and used once.
#include "server/query.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "server/errors.h"

namespace alder {
namespace {

Problem wrong(const std::string& name, const std::string& expected) { return {"malformed-request", fmt::format("the query member '{}' is {}", name, expected)}; }

template <class T>
bool parse(const std::string& text, T& value) {
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
    return code == std::errc() && end == text.data() + text.size();
}

}  // namespace

nlohmann::json plain_text(size_t least) {
    nlohmann::json schema = {{"type", "string"}, {"pattern", "^[^\\u0000-\\u001f\\u007f]*$"}};
    if (least > 0) schema["minLength"] = least;
    return schema;
}

nlohmann::json Query::describing(const std::function<void(Query&)>& read) {
    nlohmann::json parameters = nlohmann::json::array();
    Query q(parameters);
    read(q);
    return parameters;
}

const std::string* Query::find(const std::string& name, const nlohmann::json& schema, bool required) {
    if (parameters_) {
        nlohmann::json p = {{"name", name}, {"in", "query"}, {"required", required}, {"schema", schema}};
        if (schema.value("type", "") == "array") p["explode"] = false;
        parameters_->push_back(std::move(p));
        return nullptr;
    }
    const std::string* found = nullptr;
    for (size_t i = 0; i < used_.size(); ++i)
        if (request_->query[i].first == name) {
            if (found) throw wrong(name, "there twice");
            used_[i] = true;
            found = &request_->query[i].second;
        }
    if (required && !found) throw wrong(name, "needed");
    return found;
}

double Query::number(const std::string& name, double otherwise, double low, double high) {
    const std::string* text = find(name, {{"type", "number"}, {"minimum", low}, {"maximum", high}});
    if (!text) return otherwise;
    double value = 0;
    if (!parse(*text, value) || !(value >= low && value <= high)) throw wrong(name, fmt::format("a number from {} to {}", low, high));
    return value;
}

int64_t Query::integer(const std::string& name, int64_t otherwise, int64_t low, int64_t high, bool required) {
    const std::string* text = find(name, {{"type", "integer"}, {"minimum", low}, {"maximum", high}}, required);
    if (!text) return otherwise;
    int64_t value = 0;
    if (!parse(*text, value) || value < low || value > high) throw wrong(name, fmt::format("a whole number from {} to {}", low, high));
    return value;
}

std::string Query::choice(const std::string& name, std::string otherwise, const std::vector<std::string>& choices) {
    const std::string* text = find(name, {{"type", "string"}, {"enum", choices}});
    if (!text) return otherwise;
    if (std::find(choices.begin(), choices.end(), *text) == choices.end()) throw wrong(name, fmt::format("one of {}", fmt::join(choices, ", ")));
    return *text;
}

std::vector<std::string> Query::list(const std::string& name) {
    std::vector<std::string> names;
    if (const std::string* text = find(name, {{"type", "array"}, {"items", plain_text()}}))
        for (size_t at = 0; at <= text->size();) {
            const size_t comma = std::min(text->find(',', at), text->size());
            if (comma > at) names.push_back(text->substr(at, comma - at));
            at = comma + 1;
        }
    return names;
}

std::vector<std::pair<std::string, std::string>> Query::prefixed(const std::string& prefix) {
    std::vector<std::pair<std::string, std::string>> found;
    for (size_t i = 0; i < used_.size(); ++i)
        if (const auto& [name, value] = request_->query[i]; name.size() > prefix.size() && name.rfind(prefix, 0) == 0) {
            used_[i] = true;
            found.emplace_back(name.substr(prefix.size()), value);
        }
    return found;
}

void Query::finish() const {
    for (size_t i = 0; i < used_.size(); ++i)
        if (!used_[i]) throw Problem{"malformed-request", fmt::format("the query member '{}' is not known here", request_->query[i].first.substr(0, 64))};
}

}  // namespace alder
