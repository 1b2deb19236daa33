// Content negotiation and conditional requests.
#include "server/negotiate.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "server/errors.h"

namespace alder {
namespace {

std::string_view trim(std::string_view s) {
    while (!s.empty() && (s.front() == ' ' || s.front() == '\t')) s.remove_prefix(1);
    while (!s.empty() && (s.back() == ' ' || s.back() == '\t')) s.remove_suffix(1);
    return s;
}

/// Calls f with each element of a list header, all fields of that name together.
template <class F>
void each_element(const http::Request& request, std::string_view name, char separator, F&& f) {
    for (const auto& [n, value] : request.headers) {
        if (n != name) continue;
        std::string_view rest = value;
        while (true) {
            const size_t at = rest.find(separator);
            const std::string_view element = trim(rest.substr(0, at));
            if (!element.empty()) f(element);
            if (at == std::string_view::npos) break;
            rest.remove_prefix(at + 1);
        }
    }
}

std::string lower(std::string_view s) {
    std::string out(s);
    for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return out;
}

std::string_view opaque_tag(std::string_view tag) { return tag.substr(0, 2) == "W/" ? tag.substr(2) : tag; }

bool parse_number(std::string_view text, uint64_t& out) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
    return !text.empty() && error == std::errc() && end == text.data() + text.size();
}

}  // namespace

std::string best_type(const http::Request& request, const std::vector<std::string>& offers) {
    if (!request.header("accept")) return offers.front();
    struct Rating {
        int specificity = -1;
        double quality = 0;
    };
    std::vector<Rating> ratings(offers.size());
    each_element(request, "accept", ',', [&](std::string_view element) {
        const size_t semicolon = element.find(';');
        const std::string range = lower(trim(element.substr(0, semicolon)));
        double quality = 1;
        if (semicolon != std::string_view::npos) {
            const std::string parameters = lower(element.substr(semicolon));
            if (const size_t q = parameters.find("q="); q != std::string::npos)
                quality = std::clamp(std::strtod(parameters.c_str() + q + 2, nullptr), 0.0, 1.0);
        }
        for (size_t i = 0; i < offers.size(); ++i) {
            const std::string family = offers[i].substr(0, offers[i].find('/')) + "/*";
            const int specificity = range == offers[i] ? 2 : range == family ? 1 : range == "*/*" || range == "*" ? 0 : -1;
            if (specificity > ratings[i].specificity) ratings[i] = {specificity, quality};
        }
    });
    size_t best = offers.size();
    for (size_t i = 0; i < offers.size(); ++i)
        if (ratings[i].quality > 0 && (best == offers.size() || ratings[i].quality > ratings[best].quality)) best = i;
    if (best == offers.size())
        throw Problem{"not-acceptable", fmt::format("the types available are {}", fmt::join(offers, ", "))};
    return offers[best];
}

bool none_match_names(const http::Request& request, const std::string& etag) {
    bool found = false;
    each_element(request, "if-none-match", ',', [&](std::string_view tag) { found = found || tag == "*" || opaque_tag(tag) == opaque_tag(etag); });
    return found;
}

void require_match(const http::Request& request, const std::string& etag) {
    if (!request.header("if-match")) {
        Problem p{"if-match-required", fmt::format("the current tag is {}", etag)};
        p.extra["etag"] = etag;
        throw p;
    }
    bool found = false;
    each_element(request, "if-match", ',', [&](std::string_view tag) { found = found || tag == "*" || tag == etag; });
    if (found) return;
    Problem p{"etag-mismatch", fmt::format("the current tag is {}", etag)};
    p.extra["etag"] = etag;
    p.headers.emplace_back("ETag", etag);
    throw p;
}

std::optional<ByteRange> byte_range(const http::Request& request, uint64_t size, const std::string& etag) {
    const std::string* range = request.header("range");
    if (!range) return std::nullopt;
    if (const std::string* condition = request.header("if-range"); condition && *condition != etag) return std::nullopt;
    constexpr std::string_view kUnit = "bytes=";
    if (lower(std::string_view(*range).substr(0, kUnit.size())) != kUnit) return std::nullopt;
    const std::string_view spec = trim(std::string_view(*range).substr(kUnit.size()));
    if (spec.find(',') != std::string_view::npos) return std::nullopt;
    const size_t dash = spec.find('-');
    if (dash == std::string_view::npos) return std::nullopt;
    const std::string_view from = trim(spec.substr(0, dash)), to = trim(spec.substr(dash + 1));
    uint64_t first = 0, last = 0;
    if ((!from.empty() && !parse_number(from, first)) || (!to.empty() && !parse_number(to, last)) || (from.empty() && to.empty()))
        return std::nullopt;   // not a range by the grammar: ignored, as RFC 9110, section 14.2 asks
    if (!from.empty() && !to.empty() && last < first) return std::nullopt;
    const auto refuse = [&] {
        Problem p{"range", fmt::format("the data has {} bytes", size)};
        p.headers.emplace_back("Content-Range", fmt::format("bytes */{}", size));
        throw p;
    };
    if (from.empty()) {   // the last N bytes
        if (last == 0 || size == 0) refuse();
        const uint64_t length = std::min(last, size);
        return ByteRange{size - length, length};
    }
    if (first >= size) refuse();
    const uint64_t end = to.empty() ? size - 1 : std::min(last, size - 1);
    return ByteRange{first, end - first + 1};
}

std::optional<double> preferred_wait(const http::Request& request) {
    std::optional<double> wait;
    each_element(request, "prefer", ',', [&](std::string_view element) {
        uint64_t seconds = 0;
        if (lower(element.substr(0, 5)) == "wait=" && parse_number(trim(element.substr(5)), seconds)) wait = static_cast<double>(seconds);
    });
    return wait;
}

}  // namespace alder
