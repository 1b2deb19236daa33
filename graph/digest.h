// Content digests: SHA-256 as lower-case hex.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace alder {
std::string sha256_hex(std::string_view bytes);
/// Of the canonical text (sorted keys, no white space): equal documents have equal digests.
std::string content_digest(const nlohmann::json& document);
}  // namespace alder
