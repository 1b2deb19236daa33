// /v1/scenes: documents and containers, and their materials one by one.
#include <fmt/format.h>

#include "server/digest.h"
#include "server/members.h"
#include "server/negotiate.h"
#include "server/openapi.h"
#include "server/query.h"
#include "server/routes.h"
#include "server/service.h"

namespace alder {
namespace {

std::string graph_etag(const nlohmann::json& graph) {
    return "\"" + sha256_hex(graph.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)).substr(0, 32) + "\"";
}

nlohmann::json scene_json(const SceneRevision& scene, const LoadedScene& loaded) {
    const Scene& s = *loaded.scene;
    nlohmann::json materials = nlohmann::json::array();
    for (const auto& m : s.materials) materials.push_back(m.name);
    uint64_t triangles = 0;
    for (const auto& mesh : s.meshes) triangles += mesh->triangles.size();
    nlohmann::json cameras = nlohmann::json::array({s.camera.name});
    for (const auto& c : s.other_cameras) cameras.push_back(c.name);
    nlohmann::json j = {{"id", scene.id},
                        {"revision", scene.revision},
                        {"etag", scene.etag},
                        {"materials", std::move(materials)},
                        {"cameras", std::move(cameras)},
                        {"resolution", {s.settings.width, s.settings.height}},
                        {"samples", s.settings.samples},
                        {"statistics", {{"meshes", s.meshes.size()}, {"instances", s.instances.size()}, {"triangles", triangles}, {"lights", s.lights.size()}}},
                        {"assets", scene.assets},
                        {"warnings", s.warnings}};
    if (scene.source.contains("container")) j["container"] = scene.source["container"];
    return j;
}

bool read_lenient(Query& q) { return q.choice("lenient", "false", {"true", "false"}) == "true"; }
bool query_lenient(const http::Request& request) {
    Query q(request);
    const bool lenient = read_lenient(q);
    q.finish();
    return lenient;
}

struct Container {
    std::string digest;
    bool lenient = false;
};
void read_container(Members& m, Container& c) {
    constexpr const char* kDigest = "sha256: and 64 lower-case hexadecimal digits";
    const auto* value = m.require("container", kDigest, {{"type", "string"}, {"pattern", "^sha256:[0-9a-f]{64}$"}});
    if (value && value->is_string() && !digest_hex(value->get<std::string>()).empty()) c.digest = *value;
    else if (value) m.fault("container", "wrong-type", brief(*value), kDigest);
    m.boolean("lenient", c.lenient);
    m.finish(c.lenient);
}

}  // namespace

void describe_container(Members& m) {
    Container c;
    read_container(m, c);
}
void describe_lenient_query(Query& q) { read_lenient(q); }

http::Response post_scenes(Service& s, http::Request& request) {
    best_type(request, {"application/json"});
    bool lenient = query_lenient(request);
    nlohmann::json body = s.read_json(request, true);
    Diagnostics d;
    nlohmann::json source;
    if (body.is_object() && body.contains("container")) {
        Members m(body, "", d);
        Container c{{}, lenient};
        read_container(m, c);
        lenient = c.lenient;
        source = {{"container", c.digest}};
    } else {
        Members m(body, "", d);   // faults of what is not an object
        source = {{"document", std::move(body)}};
    }
    if (!d.ok()) throw problem_from("request-invalid", d);
    http::Response response;
    s.run(s.compile_lane, request, 0, [&](const std::atomic<bool>&) {
        const auto scene = s.scenes.create(s.engine, s.assets, std::move(source), lenient, d);
        nlohmann::json j = scene_json(*scene, *s.scenes.load(s.engine, s.assets, *scene, d));
        for (const auto& w : d.warnings) j["warnings"].push_back(w.line());
        response = json_response(201, j);
        response.set("Location", "/v1/scenes/" + scene->id);
        response.set("ETag", scene->etag);
        response.set("Alder-Warnings", std::to_string(j["warnings"].size()));
    });
    return response;
}

http::Response get_scene(Service& s, http::Request& request) {
    best_type(request, {"application/json"});
    const auto scene = s.scenes.get(request.parameters["id"]);
    http::Response response;
    if (none_match_names(request, scene->etag)) {
        response.status = 304;
    } else {
        s.run(s.compile_lane, request, 0, [&](const std::atomic<bool>&) {
            Diagnostics d;
            response = json_response(200, scene_json(*scene, *s.scenes.load(s.engine, s.assets, *scene, d)));
        });
    }
    response.set("ETag", scene->etag);
    response.set("Cache-Control", "no-cache");
    return response;
}

http::Response delete_scene(Service& s, http::Request& request) {
    s.scenes.remove(request.parameters["id"]);
    http::Response r;
    r.status = 204;
    return r;
}

http::Response get_scene_material(Service& s, http::Request& request) {
    best_type(request, {"application/json"});
    const auto scene = s.scenes.get(request.parameters["id"]);
    const std::string name = request.parameters["name"];
    http::Response response;
    s.run(s.compile_lane, request, 0, [&](const std::atomic<bool>&) {
        Diagnostics d;
        const auto loaded = s.scenes.load(s.engine, s.assets, *scene, d);
        const size_t index = loaded->material_index(name);
        if (index == loaded->scene->materials.size()) throw Problem{"not-found", fmt::format("the scene has no material '{}'", name)};
        const auto& graph = loaded->scene->materials[index].graph->document();
        const std::string etag = graph_etag(graph);
        if (none_match_names(request, etag))
            response.status = 304;
        else
            response = json_response(200, graph);
        response.set("ETag", etag);
        response.set("Cache-Control", "no-cache");
    });
    return response;
}

namespace {

http::Response edit_response(const SceneStore::Edit& edit, const Diagnostics& d, const std::string& token) {
    http::Response r = json_response(200, {{"changed", edit.changed}, {"rebuild", edit.rebuild}, {"reused", live::reused(*edit.before->prepared, *edit.after->prepared)},
                                           {"scene", {{"revision", edit.scene->revision}, {"etag", edit.scene->etag}}}, {"warnings", to_json(d.warnings)}});
    if (!token.empty()) r.set("Alder-Edit-Id", token);
    return r;
}

http::Response edit_scene_material(Service& s, http::Request& request, bool is_patch) {
    best_type(request, {"application/json"});
    const bool lenient = query_lenient(request);
    const std::string id = request.parameters["id"], name = request.parameters["name"];
    s.scenes.get(id);   // 404 before 428
    if (!request.header("if-match")) require_match(request, "GET it first");
    const nlohmann::json body = s.read_json(request);
    const std::string token = live::edit_token(request);
    http::Response response;
    s.run(s.compile_lane, request, 0, [&](const std::atomic<bool>&) {
        Diagnostics d;
        const auto edit = s.scenes.edit_material(s.engine, s.assets, id, name, lenient,
                                                 [&](const nlohmann::json& current) {
                                                     require_match(request, graph_etag(current));
                                                     return is_patch ? live::patched(request, current, body) : body;
                                                 }, d);
        s.live.scene_changed(id, {edit.after->prepared, edit.scene->etag}, token);
        response = edit_response(edit, d, token);
        response.set("ETag", graph_etag(edit.graph));
    });
    return response;
}

}  // namespace

http::Response patch_scene(Service& s, http::Request& request) {
    best_type(request, {"application/json"});
    const bool lenient = query_lenient(request);
    const std::string id = request.parameters["id"];
    const auto known = s.scenes.get(id);   // 404 before 428
    if (!request.header("if-match")) require_match(request, known->etag);
    const nlohmann::json body = s.read_json(request, true);
    const std::string token = live::edit_token(request);
    http::Response response;
    s.run(s.compile_lane, request, 0, [&](const std::atomic<bool>&) {
        Diagnostics d;
        const auto edit = s.scenes.edit_document(s.engine, s.assets, id, lenient,
                                                 [&](const nlohmann::json& current, const SceneRevision& scene) {
                                                     require_match(request, scene.etag);
                                                     return live::patched(request, current, body);
                                                 }, d);
        s.live.scene_changed(id, {edit.after->prepared, edit.scene->etag}, token);
        response = edit_response(edit, d, token);
        response.set("ETag", edit.scene->etag);
    });
    return response;
}

http::Response put_scene_material(Service& s, http::Request& request) { return edit_scene_material(s, request, false); }
http::Response patch_scene_material(Service& s, http::Request& request) { return edit_scene_material(s, request, true); }

}  // namespace alder
