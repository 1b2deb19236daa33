#include "graph/json_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_set>

namespace alder {
namespace {

using nlohmann::json;

// Builds the value while checking what a plain parse does not. One object of keys per open object finds duplicates.
class Builder : public nlohmann::json_sax<json> {
  public:
    Builder(std::string_view text, const JsonLimits& limits) : text_(text), limits_(limits) {}

    std::optional<json> take() {
        if (!error_.code.empty()) return std::nullopt;
        return std::move(root_);
    }
    Diagnostic error() const { return error_; }

    bool null() override { return value(nullptr); }
    bool boolean(bool v) override { return value(v); }
    bool number_integer(number_integer_t v) override { return value(v); }
    bool number_unsigned(number_unsigned_t v) override { return value(v); }
    bool number_float(number_float_t v, const string_t& s) override {
        if (s.size() > limits_.number_chars) return fail("limit-exceeded", fmt::format("a number of {} characters", s.size()), fmt::format("at most {}", limits_.number_chars));
        return value(v);
    }
    bool string(string_t& v) override {
        if (v.size() > limits_.string_bytes) return fail("limit-exceeded", fmt::format("a string of {} bytes", v.size()), fmt::format("at most {}", limits_.string_bytes));
        return value(std::move(v));
    }
    bool binary(binary_t&) override { return fail("malformed-json", "binary value", "JSON text"); }
    bool start_object(size_t) override { return open(json::object()); }
    bool start_array(size_t) override { return open(json::array()); }
    bool end_object() override { return close(); }
    bool end_array() override { return close(); }
    bool key(string_t& k) override {
        if (k.size() > limits_.string_bytes) return fail("limit-exceeded", "a huge key", fmt::format("at most {} bytes", limits_.string_bytes));
        if (!keys_.back().insert(k).second) {
            path_.back() = k;
            return fail("duplicate-key", "\"" + k + "\" twice", "each key once");
        }
        path_.back() = k;
        key_ = std::move(k);
        return true;
    }
    bool parse_error(size_t position, const std::string&, const nlohmann::detail::exception& e) override {
        const size_t end = std::min(position ? position - 1 : 0, text_.size());
        const size_t line = 1 + std::count(text_.begin(), text_.begin() + end, '\n');
        const size_t start = text_.rfind('\n', end ? end - 1 : 0);
        const size_t column = end - (start == std::string_view::npos || end == 0 ? 0 : start + 1) + 1;
        std::string why = e.what();
        if (const auto colon = why.find("; last read"); colon != std::string::npos) why.resize(colon);
        if (const auto colon = why.rfind(": "); colon != std::string::npos) why = why.substr(colon + 2);
        if (why.size() > 200) why.resize(200);
        error_ = {"", "malformed-json", fmt::format("line {}, column {}: {}", line, column, why), "JSON (RFC 8259)", ""};
        return false;
    }

  private:
    template <class V>
    bool value(V&& v) {
        if (stack_.empty()) {
            root_ = std::forward<V>(v);
        } else if (stack_.back()->is_object()) {
            (*stack_.back())[key_] = std::forward<V>(v);
        } else {
            stack_.back()->push_back(std::forward<V>(v));
        }
        return true;
    }
    bool open(json container) {
        if (stack_.size() >= limits_.depth) return fail("limit-exceeded", fmt::format("nesting deeper than {}", limits_.depth), fmt::format("at most {} levels", limits_.depth));
        if (stack_.empty()) {
            root_ = std::move(container);
            stack_.push_back(&root_);
        } else if (stack_.back()->is_object()) {
            auto& slot = (*stack_.back())[key_];
            slot = std::move(container);
            stack_.push_back(&slot);
        } else {
            stack_.back()->push_back(std::move(container));
            stack_.push_back(&stack_.back()->back());
        }
        keys_.emplace_back();
        path_.emplace_back();
        return true;
    }
    bool close() {
        stack_.pop_back();
        keys_.pop_back();
        path_.pop_back();
        return true;
    }
    bool fail(const char* code, std::string found, std::string expected) {
        std::string pointer;
        for (const auto& p : path_)
            if (!p.empty()) pointer += "/" + pointer_token(p);
        error_ = {pointer, code, std::move(found), std::move(expected), ""};
        return false;
    }

    std::string_view text_;
    JsonLimits limits_;
    json root_;
    std::vector<json*> stack_;
    std::vector<std::unordered_set<std::string>> keys_;
    std::vector<std::string> path_;
    std::string key_;
    Diagnostic error_;
};

}  // namespace

std::optional<json> parse_json(std::string_view text, const JsonLimits& limits, Diagnostics& d) {
    Builder builder(text, limits);
    json::sax_parse(text.begin(), text.end(), &builder);
    auto result = builder.take();
    if (!result) d.errors.push_back(builder.error());
    return result;
}

std::string pointer_token(std::string_view name) {
    std::string out;
    for (char c : name) {
        if (c == '~') out += "~0";
        else if (c == '/') out += "~1";
        else out += c;
    }
    return out;
}

std::string Diagnostic::line() const {
    std::string s = pointer.empty() ? std::string("document") : pointer;
    s += ": " + code;
    if (!found.empty()) s += ": found " + found;
    if (!expected.empty()) s += ", expected " + expected;
    if (!suggest.empty()) s += " (did you mean " + suggest + "?)";
    for (size_t i = 0; i < path.size(); ++i) s += (i ? " -> " : " (") + path[i];
    if (!path.empty()) s += ")";
    return s;
}

}  // namespace alder
