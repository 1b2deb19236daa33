// Errors: every kind of refusal is one row of one table; problem documents (RFC 9457), help pages and exit codes come from it.
#pragma once
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>

#include "graph/report.h"
#include "server/http/message.h"

namespace alder {

struct ErrorKind {
    const char* type;    ///< last part of the problem type: "graph-invalid"
    int status;
    const char* title;   ///< one line, the same for each occurrence
    const char* help;    ///< what it means and what to do, for the page at /problems/{type}
};
std::span<const ErrorKind> error_kinds();
const ErrorKind* find_error(std::string_view type);

/// One refusal. Thrown by routes, caught at the request boundary.
struct Problem {
    std::string type;
    std::string detail;
    Diagnostics faults = {};
    nlohmann::json extra = nlohmann::json::object();   ///< further members: line, column, etag, missing ...
    std::vector<std::pair<std::string, std::string>> headers = {};

    int status() const;
    nlohmann::json document(const std::string& request_id) const;
    http::Response response(const std::string& request_id) const;
};

/// A problem from collected faults; `detail` counts them.
Problem problem_from(std::string type, Diagnostics d);

}  // namespace alder
