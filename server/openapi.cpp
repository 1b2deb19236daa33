// GET /v1/openapi.json: OpenAPI 3.1, made from the tables that serve: the routes, their scopes, and the kinds of errors.
#include "server/openapi.h"

#include "server/access.h"
#include "server/errors.h"
#include "server/service.h"

namespace alder {
namespace {

using nlohmann::json;

const char* scope_text(unsigned scope) {
    switch (scope) {
        case kScopeRead: return "read";
        case kScopeRender: return "render";
        case kScopeEdit: return "edit";
        case kScopeAdmin: return "admin";
        default: return "";
    }
}

std::vector<std::string> names_in(const std::string& path) {
    std::vector<std::string> names;
    for (size_t at = 0; (at = path.find('{', at)) != std::string::npos; ++at) names.push_back(path.substr(at + 1, path.find('}', at) - at - 1));
    return names;
}

json problem_schema() {
    json types = json::array();
    for (const ErrorKind& kind : error_kinds()) types.push_back(std::string("/problems/") + kind.type);
    const json text = {{"type", "string"}};
    return {{"type", "object"},
            {"required", {"type", "title", "status"}},
            {"properties",
             {{"type", {{"type", "string"}, {"enum", std::move(types)}}},
              {"title", text},
              {"status", {{"type", "integer"}}},
              {"detail", text},
              {"instance", text},
              {"errors",
               {{"type", "array"},
                {"items",
                 {{"type", "object"}, {"properties", {{"pointer", text}, {"code", text}, {"found", text}, {"expected", text}, {"suggest", text}}}}}}}}}};
}

json operation(const RouteInfo& route) {
    const std::string path = route.path;
    std::string id = route.method;
    for (char& c : id) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    for (const char c : path) id += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
    json parameters = json::array();
    for (const std::string& name : names_in(path)) parameters.push_back({{"name", name}, {"in", "path"}, {"required", true}, {"schema", {{"type", "string"}}}});
    json o = {{"operationId", id},
              {"parameters", std::move(parameters)},
              {"responses",
               {{"2XX", {{"description", "done"}}},
                {"default", {{"description", "refused"}, {"content", {{"application/problem+json", {{"schema", {{"$ref", "#/components/schemas/Problem"}}}}}}}}}}}};
    if (const char* scope = scope_text(route.scope); *scope) o["security"] = json::array({json::object(), {{"token", json::array({scope})}}});
    const std::string_view method = route.method;
    const bool raw = path == "/v1/assets/{digest}";
    if (method == "PUT" || method == "PATCH" || (method == "POST" && !path.ends_with("/cancel") && !path.ends_with("/pause") && !path.ends_with("/resume"))) {
        json content = json::object();
        if (raw) content["application/octet-stream"] = json::object();
        else content["application/json"] = {{"schema", json::object()}};
        if (method == "PATCH") content["application/merge-patch+json"] = {{"schema", json::object()}};
        if (method == "PATCH" && (path.ends_with("/graph") || path.ends_with("/materials/{name}"))) content["application/json-patch+json"] = {{"schema", {{"type", "array"}}}};
        o["requestBody"] = {{"required", true}, {"content", std::move(content)}};
    }
    return o;
}

}  // namespace

http::Response get_openapi(Service&, http::Request& request) {
    static const json document = [] {
        json paths = json::object();
        for (const RouteInfo& route : route_list()) {
            std::string method = route.method;
            for (char& c : method) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
            paths[route.path][method] = operation(route);
        }
        return json{{"openapi", "3.1.0"},
                    {"info", {{"title", "Alder"}, {"version", ALDER_VERSION}, {"license", {{"name", "see LICENSE"}}}}},
                    {"paths", std::move(paths)},
                    {"components",
                     {{"schemas", {{"Problem", problem_schema()}}}, {"securitySchemes", {{"token", {{"type", "http"}, {"scheme", "bearer"}}}}}}}};
    }();
    return constant_json(request, document);
}

}  // namespace alder
