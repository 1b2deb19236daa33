// Errors: the table of every kind of refusal, and problem documents made from it.
#include "server/errors.h"

#include <algorithm>

#include <fmt/format.h>

namespace alder {
namespace {

constexpr ErrorKind kErrors[] = {
    {"malformed-json", 400, "The body is not JSON", "The body could not be read as JSON (RFC 8259, UTF-8). The members line and column say where reading stopped; JSON has no comments, trailing commas, NaN or infinity."},
    {"malformed-request", 400, "The request is malformed", "The request breaks the rules of HTTP or of this API at a place where guessing would be unsafe. The detail names it."},
    {"duplicate-key", 400, "An object has the same key twice", "Readers disagree about which of two equal keys counts, so neither is taken. Remove one of them."},
    {"token-missing", 401, "A token is needed", "This daemon was started with tokens. Send 'Authorization: Bearer TOKEN'."},
    {"token-invalid", 401, "The token is not known", "The bearer token is in none of the lines of the token file. It may have been replaced."},
    {"scope-missing", 403, "The token may not do this", "The token's scopes (read, render, edit, admin) do not include what this request needs."},
    {"origin-refused", 403, "Requests from this web page are refused", "The Origin header names a page that is not this daemon's own. Start the daemon with --allow-origin ORIGIN to accept it."},
    {"not-found", 404, "There is nothing here", "No resource has this path or identifier. GET / lists the routes."},
    {"method", 405, "The method is not available here", "The Allow header lists the methods of this resource."},
    {"not-acceptable", 406, "No representation fits the Accept header", "The detail lists the types that this resource can answer with."},
    {"request-timeout", 408, "The request arrived too slowly", "Headers must arrive within 5 seconds, a body at 4 KiB/s or more after its first 10 seconds."},
    {"state-conflict", 409, "The resource is in another state", "What was asked for cannot be done in the state that the member state names. Terminal states never change."},
    {"not-resumable", 409, "The render cannot be continued", "Its checkpoint has been removed, or it has several frames. Send a new request with the settings wanted."},
    {"idempotency-in-progress", 409, "The first request with this key is being answered", "Wait a moment and send the request again: the answer will be that of the first."},
    {"upload-offset", 409, "The body does not begin where the upload ends", "The member offset, also the header Upload-Offset, says how many bytes are there. Go on from it."},
    {"in-use", 409, "The resource is in use", "Something refers to it. Remove what refers to it first."},
    {"expired", 410, "The data has been removed", "The identifier is known, but what it named has been removed."},
    {"etag-mismatch", 412, "The resource has changed", "The If-Match tag is not the current one, which is the member etag. Fetch the resource, apply the change again and retry."},
    {"body-too-large", 413, "The body is too large", "The member limit says how many bytes are accepted and limit_option which option of the daemon sets it. Large data belongs into assets."},
    {"uri-too-long", 414, "The request line is too long", "Request lines are limited to 8 KiB. Send data in the body."},
    {"media-type", 415, "The type of the body is not known here", "Send the Content-Type that the detail names; bodies with a Content-Encoding are not accepted."},
    {"range", 416, "The range lies outside of the data", "The Content-Range header has the actual size."},
    {"host-refused", 421, "The Host header names another machine", "A daemon on the loopback address answers only requests whose Host is a loopback name, so that web pages cannot reach it by a name of their own."},
    {"graph-invalid", 422, "The graph cannot be compiled", "Each entry of errors has the place as a JSON Pointer into the request, what was found, what was expected, and the nearest known name."},
    {"scene-invalid", 422, "The scene cannot be used", "Each entry of errors has the place as a JSON Pointer into the scene document, what was found and what was expected."},
    {"settings-invalid", 422, "The settings are not valid", "Each entry of errors has the place as a JSON Pointer into the request, what was found and what was expected."},
    {"request-invalid", 422, "The request is not valid", "Each entry of errors has the place as a JSON Pointer into the request, what was found and what was expected."},
    {"asset-missing", 422, "Assets are missing", "The member missing lists all digests that the request needs and the store lacks. Send them with PUT /v1/assets/sha256:HEX and repeat the request."},
    {"asset-invalid", 422, "An asset cannot be read", "The asset is there, but it is not what it is used as. The detail says why."},
    {"digest-mismatch", 422, "The body does not have the digest of its name", "The bytes received hash to the member found. Nothing was stored."},
    {"limit-exceeded", 422, "A limit is exceeded", "The member errors says which quantity is too large and what is allowed."},
    {"idempotency-key-reused", 422, "The Idempotency-Key belongs to another request", "A key stands for one request, body included. Use a new key for a new request."},
    {"nonfinite", 422, "The render has values that are not finite numbers", "In strict mode samples that are NaN or infinite fail the render. The statistics count them; the graph that makes them has to be mended."},
    {"asset-unreadable", 422, "What the render needs is not in the store any more", "The scene's revision or one of its assets has been removed while the render was waiting."},
    {"not-available", 422, "This is not available in this version", "What the request asks for is part of the interface but not of this version. Nothing was done."},
    {"if-match-required", 428, "If-Match is required", "Edits must say which state they are based on: send If-Match with the resource's ETag, or '*' to edit whatever is there."},
    {"rate", 429, "Too many requests", "Wait as long as Retry-After says."},
    {"headers-too-large", 431, "The headers are too large", "Headers are limited to 16 KiB and 100 fields."},
    {"render-crashed", 500, "The worker ended three times while rendering this", "The log of the render has how it ended and where. Other renders are not affected."},
    {"out-of-memory", 500, "The render needs more memory than it may have", "The daemon's option --worker-memory-mib limits the process that renders. Fewer pixels or layers need less."},
    {"internal", 500, "Something went wrong inside", "The fault is on this side. The log has the details under the request id."},
    {"queue-full", 503, "The service is busy", "The queue has no place left. Wait as long as Retry-After says and try again."},
    {"draining", 503, "The service is stopping", "The daemon takes no new work. Try again after it has been restarted."},
    {"cancelled", 503, "The work was cancelled", "The client hung up, or the daemon is stopping. Nothing was kept."},
    {"deadline", 504, "The render took longer than renders may take here", "The daemon's option --max-render-seconds limits each attempt. Ask for fewer samples, or stop by an error."},
    {"storage", 507, "The store is full", "There is no room for the data below the data directory, or it cannot be written."},
};

}  // namespace

std::span<const ErrorKind> error_kinds() { return kErrors; }
const ErrorKind* find_error(std::string_view type) {
    const auto it = std::find_if(std::begin(kErrors), std::end(kErrors), [&](const ErrorKind& e) { return type == e.type; });
    return it == std::end(kErrors) ? nullptr : it;
}

int Problem::status() const {
    const ErrorKind* kind = find_error(type);
    return kind ? kind->status : 500;
}
nlohmann::json Problem::document(const std::string& request_id) const {
    const ErrorKind* kind = find_error(type);
    if (!kind) kind = find_error("internal");
    nlohmann::json j = extra;
    j["type"] = std::string("/problems/") + kind->type;
    j["title"] = kind->title;
    j["status"] = kind->status;
    j["instance"] = "/requests/" + request_id;
    if (!detail.empty()) j["detail"] = detail;
    if (!faults.errors.empty()) j["errors"] = to_json(faults.errors);
    if (!faults.warnings.empty()) j["warnings"] = to_json(faults.warnings);
    return j;
}
http::Response Problem::response(const std::string& request_id) const {
    // Replacing invalid UTF-8: what was found in a request may be quoted, and an answer must not fail on it.
    auto r = http::Response::text(status(), document(request_id).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n",
                                  "application/problem+json");
    for (const auto& [name, value] : headers) r.set(name, value);
    r.set("Cache-Control", "no-store");
    return r;
}

Problem problem_from(std::string type, Diagnostics d) {
    const auto count = [](size_t n, const char* what) { return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s"); };
    std::string detail = count(d.errors.size(), "error");
    if (!d.warnings.empty()) detail += ", " + count(d.warnings.size(), "warning");
    if (!d.errors.empty()) detail += "; first: " + d.errors.front().line();
    return {std::move(type), std::move(detail), std::move(d)};
}

}  // namespace alder
