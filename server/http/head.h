// The head of an HTTP/1.1 request: request line and headers, parsed strictly. What two readers could understand differently
// (two lengths, bare line feeds, folded lines, chunking and a length) is refused: RFC 9112, sections 3, 5, 6 and 11.2.
#pragma once
#include <optional>
#include <string_view>

#include "server/http/message.h"

namespace alder::http {

/// How far a head has come.
struct HeadProgress {
    size_t end = 0;               ///< length of the head with its empty line; 0 = not there yet
    std::optional<Fault> fault;   ///< a limit is passed already
};
/// Looks at the bytes received so far, before any of them is parsed.
HeadProgress head_progress(std::string_view bytes, const Limits& limits);

/// Parses a complete head. Returns the fault, if any.
std::optional<Fault> parse_head(std::string_view bytes, const Limits& limits, Head& head);

/// Percent-decoding of a path segment or query member; false where an escape is broken or a control character results.
bool percent_decode(std::string_view text, bool plus_is_space, std::string& out);

/// Whether `text` is well-formed UTF-8 (RFC 3629).
bool is_utf8(std::string_view text);

}  // namespace alder::http
