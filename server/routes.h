// Routes: all of them on one page, one line each.
#pragma once
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "server/http/message.h"

namespace alder {

class Service;
using RouteHandler = http::Response (*)(Service&, http::Request&);

struct RouteMatch {
    bool path_known = false;
    RouteHandler handler = nullptr;   ///< null: the path is known, the method is not there
    unsigned scope = 0;
    std::string allow;                ///< methods of this path
};
/// Fills request.route and request.parameters.
RouteMatch match_route(http::Request& request);
bool known_method(const std::string& method);

// health.cpp
http::Response get_home(Service&, http::Request&);
http::Response get_about(Service&, http::Request&);
http::Response get_livez(Service&, http::Request&);
http::Response get_readyz(Service&, http::Request&);
http::Response get_metrics(Service&, http::Request&);
http::Response get_version(Service&, http::Request&);
http::Response get_problem(Service&, http::Request&);
// login.cpp
http::Response post_login(Service&, http::Request&);
http::Response delete_login(Service&, http::Request&);
// page.cpp
http::Response get_ui(Service&, http::Request&);
http::Response get_ui_file(Service&, http::Request&);
http::Response get_ui_examples(Service&, http::Request&);
http::Response get_ui_example(Service&, http::Request&);
// graphs.cpp
http::Response get_nodes(Service&, http::Request&);
http::Response get_node(Service&, http::Request&);
http::Response post_evaluate(Service&, http::Request&);
http::Response post_validate(Service&, http::Request&);
// preview.cpp
http::Response post_preview(Service&, http::Request&);
// asset_routes.cpp
http::Response get_asset(Service&, http::Request&);
http::Response put_asset(Service&, http::Request&);
http::Response delete_asset(Service&, http::Request&);
http::Response post_assets_missing(Service&, http::Request&);
// uploads.cpp
http::Response post_uploads(Service&, http::Request&);
http::Response get_upload(Service&, http::Request&);
http::Response patch_upload(Service&, http::Request&);
http::Response delete_upload(Service&, http::Request&);
// scene_routes.cpp
http::Response post_scenes(Service&, http::Request&);
http::Response get_scene(Service&, http::Request&);
http::Response patch_scene(Service&, http::Request&);
http::Response delete_scene(Service&, http::Request&);
http::Response get_scene_material(Service&, http::Request&);
http::Response put_scene_material(Service&, http::Request&);
http::Response patch_scene_material(Service&, http::Request&);
// live/live_routes.cpp
http::Response post_live_render(Service&, http::Request&, const nlohmann::json& body);
/// The answer where the request is about a live render; nothing where its id is none.
std::optional<http::Response> live_route(Service&, http::Request&);
/// For paths that only live renders have.
http::Response only_live(Service&, http::Request&);
// renders.cpp
http::Response post_renders(Service&, http::Request&);
// jobs/routes.cpp
http::Response post_final_render(Service&, http::Request&, const nlohmann::json& body);
http::Response get_renders(Service&, http::Request&);
http::Response get_render(Service&, http::Request&);
http::Response patch_render(Service&, http::Request&);
http::Response delete_render(Service&, http::Request&);
http::Response post_render_cancel(Service&, http::Request&);
http::Response post_render_pause(Service&, http::Request&);
http::Response post_render_resume(Service&, http::Request&);
http::Response get_render_outputs(Service&, http::Request&);
http::Response get_render_output(Service&, http::Request&);
http::Response get_render_log(Service&, http::Request&);
http::Response get_render_stats(Service&, http::Request&);
http::Response get_render_events(Service&, http::Request&);
http::Response get_render_snapshot_exr(Service&, http::Request&);
http::Response get_render_snapshot_png(Service&, http::Request&);
http::Response get_render_snapshot_jpg(Service&, http::Request&);

}  // namespace alder
