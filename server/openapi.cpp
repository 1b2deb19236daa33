// GET /v1/openapi.json: OpenAPI 3.1. Paths come from the routes, bodies and queries from the code that reads them, problems from
// the table of errors; what is left to say here is what an operation is for and what it answers.
#include "server/openapi.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "server/access.h"
#include "server/errors.h"
#include "server/service.h"

namespace alder {
namespace {

using nlohmann::json;
using Types = std::vector<const char*>;

constexpr const char* kJson = "application/json";
const Types kPictures{"image/png", "image/jpeg", "image/x-exr", kJson};

/// One answer: its status, types and, of JSON, its schema.
struct Answer {
    int status;
    Types types = {kJson};
    const char* schema = nullptr;
};

struct Operation {
    const char* method;
    const char* path;
    const char* summary;
    std::vector<Answer> answers;
    std::vector<const char*> errors = {};                  ///< beyond those that every operation may have
    std::vector<void (*)(Members&)> bodies = {};           ///< JSON: one of them
    void (*query)(Query&) = nullptr;
    std::vector<std::pair<const char*, const char*>> content = {};   ///< other bodies: type, schema or null
    std::vector<const char*> headers = {};                 ///< that the request may have
};

const std::vector<std::pair<const char*, const char*>> kGraphEdits{{"application/merge-patch+json", "MergePatch"}, {"application/json-patch+json", "JsonPatch"}};

const std::vector<Operation>& operations() {
    static const std::vector<Operation> list{
        {"GET", "/", "Leads to the lookdev page", {{302, {}}}},
        {"GET", "/about", "A page about this daemon, for people", {{200, {"text/html"}}}},
        {"GET", "/ui", "The lookdev page", {{200, {"text/html"}}}},
        {"GET", "/ui/examples", "Examples and stages that the page offers", {{200}}},
        {"GET", "/ui/examples/{file}", "An example: a graph document", {{200, {kJson}, "Graph"}}, {"not-found"}},
        {"GET", "/ui/{file}", "A file of the page", {{200, {"text/javascript", "text/css", "text/html", "image/svg+xml"}}}, {"not-found"}},
        {"GET", "/livez", "Whether the process answers", {{200, {"text/plain"}}}},
        {"GET", "/readyz", "Whether it takes work", {{200, {kJson}, "Ready"}, {503, {kJson}, "Ready"}}},
        {"GET", "/metrics", "Counters in OpenMetrics text", {{200, {"application/openmetrics-text"}}}},
        {"GET", "/problems/{type}", "What a problem type means", {{200, {"text/html"}}}, {"not-found"}},
        {"GET", "/v1/openapi.json", "This document", {{200}}},
        {"GET", "/v1/version", "What is running", {{200, {kJson}, "Version"}}},
        {"POST", "/v1/login", "A token in, a cookie out: for pages, whose images and event sources cannot send headers", {{200, {kJson}, "User"}}, {"token-invalid"}, {}, nullptr, {{kJson, "Login"}}},
        {"DELETE", "/v1/login", "Takes the cookie back", {{204, {}}}},
        {"GET", "/v1/nodes", "The catalogue: types, parameters, defaults, ranges, help", {{200, {kJson}, "NodeList"}}, {}, {}, describe_nodes_query},
        {"GET", "/v1/nodes/{type}", "One node type", {{200, {kJson}, "Node"}}, {"not-found"}},
        {"POST", "/v1/evaluate", "Outputs of a graph at given points", {{200, {kJson}, "Evaluation"}}, {"request-invalid", "graph-invalid", "asset-missing"}, {}, nullptr, {{kJson, "EvaluateRequest"}}},
        {"POST", "/v1/graphs/validate", "What is wrong with a graph, and what its compiled form is like", {{200, {kJson}, "GraphReport"}}, {"request-invalid", "asset-missing"}, {describe_validate}},
        {"POST", "/v1/preview", "A graph in, a picture out", {{200, kPictures, "PreviewReport"}}, {"settings-invalid", "graph-invalid", "scene-invalid", "asset-missing", "not-found"}, {describe_preview}},
        {"POST", "/v1/assets/missing", "Which of these assets are not there", {{200, {kJson}, "Missing"}}, {"request-invalid"}, {describe_missing}},
        {"GET", "/v1/assets/{digest}", "The bytes of an asset", {{200, {"application/octet-stream"}}, {206, {"application/octet-stream"}}}, {"not-found", "range"}, {}, nullptr, {}, {"Range"}},
        {"PUT", "/v1/assets/{digest}", "Keeps an asset under the digest of its bytes", {{200, {kJson}, "Asset"}, {201, {kJson}, "Asset"}}, {"not-found", "digest-mismatch", "body-too-large", "storage"}, {}, nullptr, {{"application/octet-stream", nullptr}}},
        {"DELETE", "/v1/assets/{digest}", "Removes an asset that nothing refers to", {{204, {}}}, {"not-found", "in-use"}},
        {"POST", "/v1/uploads", "Announces a large asset that comes in pieces", {{200, {kJson}, "Upload"}, {201, {kJson}, "Upload"}}, {"request-invalid", "storage"}, {describe_upload}},
        {"GET", "/v1/uploads/{id}", "How much of it is there", {{200, {kJson}, "Upload"}}, {"not-found"}},
        {"PATCH", "/v1/uploads/{id}", "The next bytes", {{200, {kJson}, "Upload"}}, {"not-found", "upload-offset", "state-conflict", "digest-mismatch", "body-too-large", "storage"}, {}, nullptr, {{"application/octet-stream", nullptr}}, {"Upload-Offset"}},
        {"DELETE", "/v1/uploads/{id}", "Gives it up", {{204, {}}}, {"not-found", "state-conflict"}},
        {"POST", "/v1/scenes", "A scene document, or the digest of a container that was uploaded", {{201, {kJson}, "Scene"}}, {"request-invalid", "scene-invalid", "graph-invalid", "asset-missing", "storage"}, {describe_container}, describe_lenient_query, {{kJson, "SceneDocument"}}},
        {"GET", "/v1/scenes/{id}", "What a scene holds", {{200, {kJson}, "Scene"}}, {"not-found"}},
        {"PATCH", "/v1/scenes/{id}", "Edits the scene document; live renders of it follow", {{200, {kJson}, "Edit"}}, {"not-found", "etag-mismatch", "if-match-required", "scene-invalid", "graph-invalid", "asset-missing", "request-invalid"}, {}, describe_lenient_query, kGraphEdits, {"If-Match"}},
        {"DELETE", "/v1/scenes/{id}", "Removes a scene", {{204, {}}}, {"not-found"}},
        {"GET", "/v1/scenes/{id}/materials/{name}", "The graph of a material", {{200, {kJson}, "Graph"}}, {"not-found"}},
        {"PUT", "/v1/scenes/{id}/materials/{name}", "Replaces it", {{200, {kJson}, "Edit"}}, {"not-found", "etag-mismatch", "if-match-required", "graph-invalid", "asset-missing"}, {}, describe_lenient_query, {{kJson, "Graph"}}, {"If-Match"}},
        {"PATCH", "/v1/scenes/{id}/materials/{name}", "Edits it", {{200, {kJson}, "Edit"}}, {"not-found", "etag-mismatch", "if-match-required", "graph-invalid", "request-invalid", "asset-missing"}, {}, describe_lenient_query, kGraphEdits, {"If-Match"}},
        {"POST", "/v1/renders", "A render of a scene, or with \"mode\": \"live\" one that follows edits",
         {{200, {"image/x-exr", "image/png", "image/jpeg", kJson}, "Job"}, {201, {kJson}, "Live"}, {202, {kJson}, "Job"}},
         {"settings-invalid", "scene-invalid", "graph-invalid", "not-found", "limit-exceeded", "idempotency-key-reused", "idempotency-in-progress", "storage"}, {describe_render, describe_live}, nullptr, {}, {"Prefer", "Idempotency-Key"}},
        {"GET", "/v1/renders", "Renders, newest first", {{200, {kJson}, "RenderList"}}, {}, {}, describe_renders_query},
        {"GET", "/v1/renders/{id}", "How a render is", {{200, {kJson}, "Render"}}, {"not-found"}, {}, nullptr, {}, {"Prefer"}},
        {"PATCH", "/v1/renders/{id}", "Priority, labels, more samples; of a live render resolution, layers, stage and light mix", {{200, {kJson}, nullptr}}, {"not-found", "settings-invalid", "graph-invalid", "state-conflict", "not-resumable", "etag-mismatch"}, {describe_render_change, describe_live_change}},
        {"DELETE", "/v1/renders/{id}", "Removes a render and its files", {{204, {}}}, {"not-found"}},
        {"POST", "/v1/renders/{id}/cancel", "Ends it", {{200, {kJson}, "Render"}}, {"not-found"}},
        {"POST", "/v1/renders/{id}/pause", "Holds it", {{200, {kJson}, "Render"}}, {"not-found", "state-conflict"}},
        {"POST", "/v1/renders/{id}/resume", "Goes on", {{200, {kJson}, "Render"}}, {"not-found", "state-conflict"}},
        {"GET", "/v1/renders/{id}/outputs", "Its files", {{200, {kJson}, "OutputList"}}, {"not-found"}},
        {"GET", "/v1/renders/{id}/outputs/{file}", "One of them", {{200, {"image/x-exr"}}, {206, {"image/x-exr"}}}, {"not-found", "expired", "range"}, {}, nullptr, {}, {"Range"}},
        {"GET", "/v1/renders/{id}/log", "What happened to it", {{200, {"text/plain"}}}, {"not-found"}},
        {"GET", "/v1/renders/{id}/stats", "Counters and times", {{200, {kJson}, "Stats"}}, {"not-found"}},
        {"GET", "/v1/renders/{id}/snapshot.exr", "The picture as it is now", {{200, {"image/x-exr"}}}, {"not-found", "expired", "settings-invalid"}, {}, describe_snapshot_query},
        {"GET", "/v1/renders/{id}/snapshot.png", "The picture as it is now, for a screen", {{200, {"image/png"}}}, {"not-found", "expired", "settings-invalid"}, {}, describe_snapshot_query},
        {"GET", "/v1/renders/{id}/snapshot.jpg", "The picture as it is now, for a screen", {{200, {"image/jpeg"}}}, {"not-found", "expired", "settings-invalid"}, {}, describe_snapshot_query},
        {"GET", "/v1/renders/{id}/graph", "The graph of a live render of a stage", {{200, {kJson}, "Graph"}}, {"not-found"}},
        {"PUT", "/v1/renders/{id}/graph", "Replaces it", {{200, {kJson}, "Edit"}}, {"not-found", "etag-mismatch", "if-match-required", "graph-invalid", "asset-missing"}, {}, nullptr, {{kJson, "Graph"}}, {"If-Match"}},
        {"PATCH", "/v1/renders/{id}/graph", "Edits it", {{200, {kJson}, "Edit"}}, {"not-found", "etag-mismatch", "if-match-required", "graph-invalid", "request-invalid", "asset-missing"}, {}, nullptr, kGraphEdits, {"If-Match"}},
        {"GET", "/v1/renders/{id}/pixel", "All values of a pixel, and with explain=1 what each node made of it", {{200, {kJson}, "Pixel"}}, {"not-found", "settings-invalid"}, {}, describe_pixel_query},
        {"GET", "/v1/renders/{id}/events", "What happens to a render, as server-sent events", {{200, {"text/event-stream"}}}, {"not-found"}, {}, nullptr, {}, {"Last-Event-ID"}},
        {"GET", "/v1/renders/{id}/preview.mjpg", "Pictures one after the other, for an <img>", {{200, {"multipart/x-mixed-replace"}}}, {"not-found"}, {}, describe_preview_stream_query},
        {"GET", "/v1/renders/{id}/stream", "Whole EXR files as samples come", {{200, {"multipart/mixed"}}}, {"not-found"}, {}, describe_exr_stream_query},
        {"GET", "/v1/renders/{id}/tiles", "Tiles with a JSON head and planar pixels", {{200, {"application/vnd.alder.tiles"}}}, {"not-found"}, {}, describe_tile_stream_query},
    };
    return list;
}

const char* scope_text(unsigned scope) {
    switch (scope) {
        case kScopeRead: return "read";
        case kScopeRender: return "render";
        case kScopeEdit: return "edit";
        case kScopeAdmin: return "admin";
        default: return "";
    }
}

std::string operation_id(const Operation& o) {
    std::string id = o.method;
    for (char& c : id) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    for (const char* c = o.path; *c; ++c) id += std::isalnum(static_cast<unsigned char>(*c)) ? *c : '_';
    return id;
}

json parameter_list(const Operation& o) {
    json list = json::array();
    const std::string path = o.path;
    for (size_t at = 0; (at = path.find('{', at)) != std::string::npos; ++at) {
        const std::string name = path.substr(at + 1, path.find('}', at) - at - 1);
        list.push_back({{"name", name}, {"in", "path"}, {"required", true}, {"schema", plain_text(1)}});
    }
    if (o.query)
        for (json& p : Query::describing(o.query)) list.push_back(std::move(p));
    for (const std::string name : o.headers) {
        json schema = {{"type", "string"}};
        if (name == "Upload-Offset") schema = {{"type", "integer"}, {"minimum", 0}};
        if (name == "Idempotency-Key") schema["pattern"] = "^[!-~]([ -~]{0,253}[!-~])?$";
        list.push_back({{"name", name}, {"in", "header"}, {"required", name == "Upload-Offset"}, {"schema", std::move(schema)}});
    }
    return list;
}

json body_of(const Operation& o) {
    json content = json::object();
    json one_of = json::array();
    for (const auto& describe : o.bodies) one_of.push_back(Members::describing(describe));
    for (const auto& [type, schema] : o.content) {
        if (std::string_view(type) == kJson) one_of.push_back(schema_ref(schema));
        else content[type] = schema ? json{{"schema", schema_ref(schema)}} : json::object();
    }
    if (one_of.size() == 1) content[kJson] = {{"schema", one_of[0]}};
    if (one_of.size() > 1) content[kJson] = {{"schema", {{"anyOf", one_of}}}};
    // Of bytes there may be none.
    return {{"required", content.contains(kJson) || content.contains("application/merge-patch+json")}, {"content", std::move(content)}};
}

json answers_of(const Operation& o, bool changes, unsigned scope) {
    json answers = json::object();
    for (const Answer& a : o.answers) {
        json content = json::object();
        for (const std::string type : a.types) content[type] = type == kJson && a.schema ? json{{"schema", schema_ref(a.schema)}} : json::object();
        json row = {{"description", o.summary}};
        if (!content.empty()) row["content"] = std::move(content);
        answers[std::to_string(a.status)] = std::move(row);
    }
    std::set<std::string> types{"malformed-request", "not-acceptable", "queue-full", "internal", "host-refused", "origin-refused"};
    for (const char* type : o.errors) types.insert(type);
    if (!o.bodies.empty() || !o.content.empty()) types.insert({"malformed-json", "duplicate-key", "media-type", "body-too-large", "request-timeout", "limit-exceeded"});
    if (changes) types.insert("draining");
    if (scope != kScopeNone) types.insert({"token-missing", "scope-missing"});
    if (std::string_view(o.method) == "GET") answers["304"] = {{"description", "what the client has is current"}};
    std::map<int, std::string> by_status;
    for (const std::string& type : types)
        if (const ErrorKind* kind = find_error(type)) by_status[kind->status] += (by_status[kind->status].empty() ? "" : ", ") + type;
    for (const auto& [status, names] : by_status)
        if (!answers.contains(std::to_string(status)))
            answers[std::to_string(status)] = {{"description", names}, {"content", {{"application/problem+json", {{"schema", schema_ref("Problem")}}}}}};
    return answers;
}

/// What can be done with what a POST has made: programs that walk the interface follow these.
void add_links(json& paths) {
    const auto link = [&](const char* from, const char* statuses, const char* prefix, const std::vector<std::string>& to, const char* pointer = "$response.body#/id") {
        for (const std::string& status : {std::string(statuses).substr(0, 3), std::string(statuses).substr(4)}) {
            if (status.empty()) continue;
            json& links = paths[from]["post"]["responses"][status]["links"];
            for (const std::string& name : to) links[name] = {{"operationId", std::string(prefix) + name}, {"parameters", {{"id", pointer}}}};
        }
    };
    link("/v1/scenes", "201,", "", {"get_v1_scenes__id_", "delete_v1_scenes__id_", "patch_v1_scenes__id_"});
    link("/v1/uploads", "201,", "", {"get_v1_uploads__id_", "delete_v1_uploads__id_", "patch_v1_uploads__id_"});
    link("/v1/renders", "201,202", "", {"get_v1_renders__id_", "patch_v1_renders__id_", "delete_v1_renders__id_", "post_v1_renders__id__cancel", "post_v1_renders__id__pause",
                                        "post_v1_renders__id__resume", "get_v1_renders__id__stats", "get_v1_renders__id__outputs", "get_v1_renders__id__log"});
    link("/v1/renders", "201,", "", {"get_v1_renders__id__graph", "patch_v1_renders__id__graph", "put_v1_renders__id__graph", "get_v1_renders__id__pixel", "get_v1_renders__id__snapshot_png"});
}

json make_document() {
    json paths = json::object();
    std::map<std::pair<std::string, std::string>, unsigned> scopes;
    for (const RouteInfo& route : route_list()) scopes[{route.method, route.path}] = route.scope;
    for (const Operation& o : operations()) {
        const unsigned scope = scopes.at({o.method, o.path});
        std::string method = o.method;
        for (char& c : method) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        const bool changes = method != "get";
        json& j = paths[o.path][method] = {{"operationId", operation_id(o)}, {"summary", o.summary}, {"parameters", parameter_list(o)}, {"responses", answers_of(o, changes, scope)}};
        if (!o.bodies.empty() || !o.content.empty()) j["requestBody"] = body_of(o);
        if (const char* name = scope_text(scope); *name) {
            j["security"] = json::array({json::object(), {{"token", json::array()}}, {{"cookie", json::array()}}});
            j["x-scope"] = name;
        }
    }
    add_links(paths);
    return {{"openapi", "3.1.0"},
            {"info", {{"title", "Alder"}, {"version", ALDER_VERSION}, {"license", {{"name", "see LICENSE"}}}}},
            {"paths", std::move(paths)},
            {"components",
             {{"schemas", answer_schemas()},
              {"securitySchemes", {{"token", {{"type", "http"}, {"scheme", "bearer"}}}, {"cookie", {{"type", "apiKey"}, {"in", "cookie"}, {"name", kSessionCookie}}}}}}}};
}

}  // namespace

bool has_query(const std::string& method, const std::string& path) {
    for (const Operation& o : operations())
        if (method == o.method && path == o.path) return o.query != nullptr;
    return false;
}

http::Response get_openapi(Service&, http::Request& request) {
    static const json document = make_document();
    return constant_json(request, document);
}

}  // namespace alder
