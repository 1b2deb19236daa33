// What watches and people ask first: /livez, /readyz, /metrics, /v1/version, the home page and the pages about errors.
#include <fmt/format.h>

#include "graph/program.h"
#include "nodes/schema.h"
#include "server/build_id.h"
#include "server/routes.h"
#include "server/service.h"

namespace alder {
namespace {

std::string escape_html(std::string_view text) {
    std::string out;
    for (const char c : text) switch (c) {
            case '&': out += "&amp;"; break;
            case '<': out += "&lt;"; break;
            case '>': out += "&gt;"; break;
            case '"': out += "&quot;"; break;
            default: out.push_back(c);
        }
    return out;
}

http::Response page(const std::string& title, const std::string& body) {
    auto r = http::Response::text(
        200,
        fmt::format("<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>{0}</title>"
                    "<style>body{{font:16px/1.5 sans-serif;max-width:46em;margin:2em auto;padding:0 1em;color:#222}}"
                    "pre{{background:#f4f4f2;padding:1em;overflow:auto}}td{{padding:.1em 1em .1em 0;vertical-align:top}}</style>"
                    "<h1>{0}</h1>{1}</html>\n",
                    escape_html(title), body),
        "text/html; charset=utf-8");
    r.set("Content-Security-Policy", "default-src 'none'; style-src 'unsafe-inline'");
    return r;
}

}  // namespace

http::Response get_livez(Service&, http::Request&) { return http::Response::text(200, "ok\n", "text/plain; charset=utf-8"); }

http::Response get_readyz(Service& s, http::Request&) {
    const bool store = s.assets.error().empty(), room = s.assets.has_room(0);
    const bool worker = !s.renders.worker_fails();
    const bool ready = store && room && worker && !s.draining;
    auto r = json_response(ready ? 200 : 503, {{"ready", ready}, {"checks", {{"store", store}, {"disk", room}, {"worker", worker}, {"accepting", !s.draining}}}});
    r.set("Cache-Control", "no-store");
    return r;
}

http::Response get_metrics(Service& s, http::Request&) {
    return http::Response::text(200, s.metrics.text(), "application/openmetrics-text; version=1.0.0; charset=utf-8");
}

http::Response get_version(Service&, http::Request&) {
    return json_response(200, {{"name", "alderd"}, {"version", ALDER_VERSION}, {"build", build_id()}, {"api", "v1"}, {"isa", current_isa()}, {"nodes", all_nodes().size()}});
}

http::Response get_home(Service&, http::Request&) {
    http::Response r;
    r.status = 302;
    r.set("Location", "/ui");
    return r;
}

http::Response get_about(Service&, http::Request& request) {
    const std::string host = request.host.empty() ? "localhost:7420" : request.host;
    return page("Alder",
                fmt::format("<p>A render service. It takes shader graphs and scenes over HTTP and answers with pictures. "
                            "Version " ALDER_VERSION ", {} node types.</p>"
                            "<p><a href=\"/ui\">The lookdev page</a>: networks, parameters, and the picture as they change.</p>"
                            "<p>A first picture:</p><pre>curl -sS http://{}/v1/preview -H 'Accept: image/png' -o ball.png --json '{}'</pre>"
                            "<table><tr><td><a href=\"/v1/openapi.json\">/v1/openapi.json</a><td>this interface, for programs"
                            "<tr><td><a href=\"/v1/nodes\">/v1/nodes</a><td>every node, its parameters, defaults and ranges"
                            "<tr><td>POST /v1/preview<td>a graph in, a picture out"
                            "<tr><td>POST /v1/evaluate<td>a graph's outputs at given points, without a scene"
                            "<tr><td>POST /v1/graphs/validate<td>what is wrong with a graph, and what its compiled form is like"
                            "<tr><td>/v1/assets, /v1/scenes, POST /v1/renders<td>whole scenes"
                            "<tr><td><a href=\"/livez\">/livez</a> <a href=\"/readyz\">/readyz</a> <a href=\"/metrics\">/metrics</a> "
                            "<a href=\"/v1/version\">/v1/version</a><td>the state of this daemon</table>",
                            all_nodes().size(), escape_html(host),
                            escape_html(R"({"graph": {"nodes": {"s": {"type": "alSurface", "params": {"diffuseColor": [0.8, 0.3, 0.1]}}}, )"
                                        R"("outputs": {"surface": {"node": "s"}}}})")));
}

http::Response get_problem(Service&, http::Request& request) {
    const ErrorKind* kind = find_error(request.parameters["type"]);
    if (!kind) throw Problem{"not-found", "there is no problem of that name"};
    return page(kind->title, fmt::format("<p><code>{}</code>, status {}</p><p>{}</p>", kind->type, kind->status, escape_html(kind->help)));
}

}  // namespace alder
