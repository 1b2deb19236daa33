// JSON text -> value, with what the plain parser lets pass refused: duplicate keys, excessive depth, huge strings and numbers.
#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "graph/diagnostic.h"

namespace alder {

struct JsonLimits {
    size_t depth = 64;
    size_t string_bytes = 1 << 20;
    size_t number_chars = 64;
};

/// Nothing and one error (code "malformed-json", "duplicate-key" or "limit-exceeded"; `found` says line and column) if the
/// text is not acceptable.
std::optional<nlohmann::json> parse_json(std::string_view text, const JsonLimits& limits, Diagnostics& d);

/// RFC 6901: escapes ~ and /.
std::string pointer_token(std::string_view name);

}  // namespace alder
