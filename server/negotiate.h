// Content negotiation and conditional requests: RFC 9110, sections 12.5.1, 13.1 and 14.2.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/http/message.h"

namespace alder {

/// The best of `offers` (in the server's order of preference) for the request's Accept; throws not-acceptable.
std::string best_type(const http::Request& request, const std::vector<std::string>& offers);

/// Whether If-None-Match names the tag (weak comparison) or is "*".
bool none_match_names(const http::Request& request, const std::string& etag);

/// Throws if-match-required where If-Match is missing, etag-mismatch where it names another state.
void require_match(const http::Request& request, const std::string& etag);

struct ByteRange {
    uint64_t first = 0, length = 0;
};
/// The single range asked for. Nothing where the whole is to be sent (no Range, several ranges, other units, If-Range of
/// another state); throws `range` where it lies outside.
std::optional<ByteRange> byte_range(const http::Request& request, uint64_t size, const std::string& etag);

/// N of "Prefer: wait=N", if given.
std::optional<double> preferred_wait(const http::Request& request);

}  // namespace alder
