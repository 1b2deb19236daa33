// The description of the interface at /v1/openapi.json: made from the routes, from what reads their bodies and queries, and from
// the table of errors.
#pragma once
#include <vector>

#include "server/http/message.h"
#include "server/members.h"
#include "server/query.h"

namespace alder {

class Service;

/// A route that is served: method, path with {names}, and the scope a token needs.
struct RouteInfo {
    const char* method;
    const char* path;
    unsigned scope;
};
std::vector<RouteInfo> route_list();
/// Whether a route takes members in its query.
bool has_query(const std::string& method, const std::string& path);

/// {"$ref": ...} to a schema of answer_schemas().
inline nlohmann::json schema_ref(const std::string& name) { return {{"$ref", "#/components/schemas/" + name}}; }
/// Schemas of documents and answers by name.
const nlohmann::json& answer_schemas();

http::Response get_openapi(Service&, http::Request&);

// What routes read. Each is the code that reads it, on Members or a Query that write it down.
void describe_preview(Members&);
void describe_validate(Members&);
void describe_missing(Members&);
void describe_upload(Members&);
void describe_container(Members&);
void describe_render(Members&);
void describe_render_change(Members&);
void describe_live(Members&);
void describe_live_change(Members&);
void describe_nodes_query(Query&);
void describe_lenient_query(Query&);
void describe_renders_query(Query&);
void describe_pixel_query(Query&);
void describe_snapshot_query(Query&);
void describe_preview_stream_query(Query&);
void describe_exr_stream_query(Query&);
void describe_tile_stream_query(Query&);

}  // namespace alder
