// Graphs without a scene: the node catalogue, evaluation at points, validation.
#include <fmt/format.h>

#include "render/evaluate.h"
#include "nodes/registry_json.h"
#include "server/members.h"
#include "server/negotiate.h"
#include "server/openapi.h"
#include "server/query.h"
#include "server/routes.h"
#include "server/service.h"

namespace alder {
namespace {

std::vector<std::string> node_names() {
    std::vector<std::string> names;
    for (const NodeType* n : all_nodes()) names.push_back(n->name);
    return names;
}

bool is_lenient(const nlohmann::json& body) {
    const auto it = body.is_object() ? body.find("lenient") : body.end();
    return body.is_object() && it != body.end() && it->is_boolean() && it->get<bool>();
}

}  // namespace

namespace {
bool read_view_query(Query& q) { return q.choice("view", "full", {"summary", "full"}) == "summary"; }
}  // namespace
void describe_nodes_query(Query& q) { read_view_query(q); }

http::Response get_nodes(Service&, http::Request& request) {
    Query q(request);
    const bool summary = read_view_query(q);
    q.finish();
    static const nlohmann::json full = nodes_json();
    static const nlohmann::json brief = nodes_summary_json();
    return constant_json(request, summary ? brief : full);
}

http::Response get_node(Service&, http::Request& request) {
    const std::string& name = request.parameters["type"];
    const NodeType* type = find_node(name);
    if (!type) {
        Problem p{"not-found", fmt::format("there is no node type '{}'", name)};
        const auto names = node_names();
        if (const std::string near = nearest_name(name, names); !near.empty()) {
            p.detail += fmt::format("; did you mean '{}'?", near);
            p.extra["suggest"] = near;
        }
        throw p;
    }
    return constant_json(request, node_json(*type));
}

http::Response post_evaluate(Service& s, http::Request& request) {
    best_type(request, {"application/json"});
    const nlohmann::json body = s.read_json(request);
    http::Response response;
    s.run(s.compile_lane, request, 0, [&](const std::atomic<bool>&) {
        std::vector<std::string> missing;
        EvaluateOptions options;
        options.stats = true;
        options.threads = s.engine.threads();
        options.material.lenient = is_lenient(body);
        options.material.resolve_image = [&](const nlohmann::json& image, std::string& error) { return s.engine.resolve(image, error, &missing); };
        options.cache = &s.engine.materials();
        Diagnostics d;
        nlohmann::json answer = evaluate_request(body, options, d);
        if (!missing.empty()) throw_missing(missing);
        if (!d.ok() || answer.is_null()) throw problem_from("request-invalid", d);
        if (!d.warnings.empty()) answer["warnings"] = to_json(d.warnings);
        response = json_response(200, answer);
        response.set("Alder-Warnings", std::to_string(d.warnings.size()));
    });
    return response;
}

namespace {
struct ValidateRequest {
    const nlohmann::json* graph = nullptr;
    bool lenient = false, strict = false;
};
void read_validate(Members& m, ValidateRequest& v) {
    v.graph = m.require("graph", "a graph document");   // whatever it is, the answer says what is wrong with it
    m.boolean("lenient", v.lenient);
    m.boolean("strict", v.strict);
    m.finish(v.lenient);
}
}  // namespace
void describe_validate(Members& m) {
    ValidateRequest v;
    read_validate(m, v);
}

http::Response post_validate(Service& s, http::Request& request) {
    best_type(request, {"application/json"});
    const nlohmann::json body = s.read_json(request);
    Diagnostics faults;
    Members m(body, "", faults);
    ValidateRequest v;
    read_validate(m, v);
    if (!faults.ok()) throw problem_from("request-invalid", faults);
    http::Response response;
    s.run(s.compile_lane, request, 0, [&](const std::atomic<bool>&) {
        Diagnostics d = faults;   // of the request itself: warnings only, here
        std::shared_ptr<const Material> material;
        try {
            material = s.engine.material(*v.graph, "/graph", v.lenient, d, v.strict);
        } catch (const Problem& p) {
            if (p.type != "graph-invalid") throw;   // what is wrong with the graph is the answer, not a refusal
            d = p.faults;
        }
        response = json_response(200, graph_report(material.get(), std::move(d)));
    });
    return response;
}

}  // namespace alder
