// Routes: all of them on one page, one line each.
#include "server/routes.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "server/access.h"
#include "server/openapi.h"

namespace alder {
namespace {

struct Route {
    const char* method;
    const char* path;   ///< {name} matches one segment
    RouteHandler handler;
    unsigned scope;
};

constexpr Route kRoutes[] = {
    {"GET", "/", get_home, kScopeNone},
    {"GET", "/about", get_about, kScopeNone},
    {"GET", "/ui", get_ui, kScopeNone},
    {"GET", "/ui/examples", get_ui_examples, kScopeNone},
    {"GET", "/ui/examples/{file}", get_ui_example, kScopeNone},
    {"GET", "/ui/{file}", get_ui_file, kScopeNone},
    {"GET", "/livez", get_livez, kScopeNone},
    {"GET", "/readyz", get_readyz, kScopeNone},
    {"GET", "/metrics", get_metrics, kScopeRead},
    {"GET", "/problems/{type}", get_problem, kScopeNone},
    {"GET", "/v1/openapi.json", get_openapi, kScopeRead},
    {"GET", "/v1/version", get_version, kScopeRead},
    {"POST", "/v1/login", post_login, kScopeNone},
    {"DELETE", "/v1/login", delete_login, kScopeNone},
    {"GET", "/v1/nodes", get_nodes, kScopeRead},
    {"GET", "/v1/nodes/{type}", get_node, kScopeRead},
    {"POST", "/v1/evaluate", post_evaluate, kScopeRender},
    {"POST", "/v1/graphs/validate", post_validate, kScopeRead},
    {"POST", "/v1/preview", post_preview, kScopeRender},
    {"POST", "/v1/assets/missing", post_assets_missing, kScopeRead},
    {"GET", "/v1/assets/{digest}", get_asset, kScopeRead},
    {"PUT", "/v1/assets/{digest}", put_asset, kScopeEdit},
    {"DELETE", "/v1/assets/{digest}", delete_asset, kScopeEdit},
    {"POST", "/v1/uploads", post_uploads, kScopeEdit},
    {"GET", "/v1/uploads/{id}", get_upload, kScopeRead},
    {"PATCH", "/v1/uploads/{id}", patch_upload, kScopeEdit},
    {"DELETE", "/v1/uploads/{id}", delete_upload, kScopeEdit},
    {"POST", "/v1/scenes", post_scenes, kScopeEdit},
    {"GET", "/v1/scenes/{id}", get_scene, kScopeRead},
    {"PATCH", "/v1/scenes/{id}", patch_scene, kScopeEdit},
    {"DELETE", "/v1/scenes/{id}", delete_scene, kScopeEdit},
    {"GET", "/v1/scenes/{id}/materials/{name}", get_scene_material, kScopeRead},
    {"PUT", "/v1/scenes/{id}/materials/{name}", put_scene_material, kScopeEdit},
    {"PATCH", "/v1/scenes/{id}/materials/{name}", patch_scene_material, kScopeEdit},
    {"POST", "/v1/renders", post_renders, kScopeRender},
    {"GET", "/v1/renders", get_renders, kScopeRead},
    {"GET", "/v1/renders/{id}", get_render, kScopeRead},
    {"PATCH", "/v1/renders/{id}", patch_render, kScopeRender},
    {"DELETE", "/v1/renders/{id}", delete_render, kScopeRender},
    {"POST", "/v1/renders/{id}/cancel", post_render_cancel, kScopeRender},
    {"POST", "/v1/renders/{id}/pause", post_render_pause, kScopeRender},
    {"POST", "/v1/renders/{id}/resume", post_render_resume, kScopeRender},
    {"GET", "/v1/renders/{id}/outputs", get_render_outputs, kScopeRead},
    {"GET", "/v1/renders/{id}/outputs/{file}", get_render_output, kScopeRead},
    {"GET", "/v1/renders/{id}/log", get_render_log, kScopeRead},
    {"GET", "/v1/renders/{id}/stats", get_render_stats, kScopeRead},
    {"GET", "/v1/renders/{id}/snapshot.exr", get_render_snapshot_exr, kScopeRead},
    {"GET", "/v1/renders/{id}/snapshot.png", get_render_snapshot_png, kScopeRead},
    {"GET", "/v1/renders/{id}/snapshot.jpg", get_render_snapshot_jpg, kScopeRead},
    {"GET", "/v1/renders/{id}/graph", only_live, kScopeRead},
    {"PUT", "/v1/renders/{id}/graph", only_live, kScopeRender},
    {"PATCH", "/v1/renders/{id}/graph", only_live, kScopeRender},
    {"GET", "/v1/renders/{id}/pixel", only_live, kScopeRead},
    {"GET", "/v1/renders/{id}/events", get_render_events, kScopeRead},
    {"GET", "/v1/renders/{id}/preview.mjpg", only_live, kScopeRead},
    {"GET", "/v1/renders/{id}/stream", only_live, kScopeRead},
    {"GET", "/v1/renders/{id}/tiles", only_live, kScopeRead},
};

/// Whether the path fits; fills the parameters. A literal segment beats a {name} because its route comes first in the table.
bool fits(std::string_view pattern, const std::vector<std::string>& segments, std::map<std::string, std::string>& parameters) {
    parameters.clear();
    size_t index = 0;
    for (size_t at = 1; at < pattern.size();) {
        const size_t slash = std::min(pattern.find('/', at), pattern.size());
        const std::string_view part = pattern.substr(at, slash - at);
        if (index == segments.size()) return false;
        const std::string& segment = segments[index++];
        if (part.front() == '{') {
            if (segment.empty()) return false;
            parameters[std::string(part.substr(1, part.size() - 2))] = segment;
        } else if (part != segment) {
            return false;
        }
        at = slash + 1;
    }
    return index == segments.size();
}

}  // namespace

std::vector<RouteInfo> route_list() {
    std::vector<RouteInfo> list;
    for (const Route& r : kRoutes) list.push_back({r.method, r.path, r.scope});
    return list;
}

bool known_method(const std::string& method) {
    static constexpr std::array<std::string_view, 7> kMethods{"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"};
    return std::find(kMethods.begin(), kMethods.end(), method) != kMethods.end();
}

RouteMatch match_route(http::Request& request) {
    RouteMatch match;
    request.route = "unknown";
    const std::string method = request.method == "HEAD" ? "GET" : request.method;
    std::string_view path;
    std::map<std::string, std::string> parameters;
    for (const Route& route : kRoutes) {
        if (match.path_known ? path != route.path : !fits(route.path, request.segments, parameters)) continue;
        if (!match.path_known) {
            path = route.path;
            match.path_known = true;
            match.scope = route.scope;
            request.route = route.path;
            request.parameters = parameters;
        }
        match.allow += match.allow.empty() ? "" : ", ";
        match.allow += route.method;
        if (std::string_view(route.method) == "GET") match.allow += ", HEAD";
        if (method == route.method) {
            match.handler = route.handler;
            match.scope = route.scope;
        }
    }
    if (match.path_known) match.allow += ", OPTIONS";
    if (!match.path_known) match.scope = kScopeRead;
    if (request.method == "OPTIONS") match.scope = kScopeNone;   // a preflight has no token
    return match;
}

}  // namespace alder
