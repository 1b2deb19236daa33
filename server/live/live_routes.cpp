// Live renders over HTTP: made by POST /v1/renders with "mode": "live", edited by PATCH, looked at by streams and snapshots.
#include <cmath>

#include <fmt/format.h>

#include "graph/json_text.h"
#include "render/explain.h"
#include "render/image/exr.h"
#include "render/prepared_scene.h"
#include "render/stages.h"
#include "server/digest.h"
#include "server/live/live_streams.h"
#include "server/members.h"
#include "server/negotiate.h"
#include "server/openapi.h"
#include "server/picture.h"
#include "server/routes.h"
#include "server/service.h"

namespace alder {
namespace {

using namespace live;

constexpr int64_t kSideMost = 8192;
constexpr double kFirstFrameSeconds = 30;   // a snapshot waits so long for the first picture

std::string graph_etag(const nlohmann::json& graph) {
    return "\"" + sha256_hex(graph.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)).substr(0, 32) + "\"";
}

void read_resolution(Members& m, LiveSettings& settings) {
    const auto* value = m.find("resolution", {{"type", "array"}, {"items", {{"type", "integer"}, {"minimum", 1}, {"maximum", kSideMost}}}, {"minItems", 2}, {"maxItems", 2}});
    if (!value) return;
    int64_t width = 0, height = 0;
    if (!value->is_array() || value->size() != 2 || !whole_number((*value)[0], 1, kSideMost, width) || !whole_number((*value)[1], 1, kSideMost, height)) {
        m.fault("resolution", "out-of-range", brief(*value), fmt::format("two whole numbers from 1 to {}", kSideMost));
        return;
    }
    settings.width = static_cast<int>(width);
    settings.height = static_cast<int>(height);
}

/// Members that may be given at first and changed later.
void read_settings(Members& m, LiveSettings& settings) {
    read_resolution(m, settings);
    int64_t n = 0;
    if (m.integer("max_samples", n, 1, 1 << 20)) settings.max_samples = static_cast<int>(n);
    if (m.integer("seed", n, 0, UINT32_MAX)) settings.seed = static_cast<uint32_t>(n);
    m.texts("aovs", settings.aovs, 1024);
}

void read_weight(Members& e, Vec3f& weight) {
    double intensity = 1;
    e.number("intensity", intensity, 0, 1e6);
    Vec3f color(1, 1, 1);
    if (const auto* c = e.find("color", {{"type", "array"}, {"items", {{"type", "number"}, {"minimum", 0}, {"maximum", 1e6}}}, {"minItems", 3}, {"maxItems", 3}})) {
        bool fits = c->is_array() && c->size() == 3;
        for (int i = 0; fits && i < 3; ++i) {
            fits = (*c)[i].is_number() && (*c)[i].get<double>() >= 0 && (*c)[i].get<double>() <= 1e6;
            if (fits) color[i] = (*c)[i].get<float>();
        }
        if (!fits) e.fault("color", "wrong-type", brief(*c), "three numbers from 0 to 1000000");
    }
    e.finish(false);
    weight = color * static_cast<float>(intensity);
}

/// {"key or 1": {"intensity": 2, "color": [1, 0.5, 0.2]}}: light groups by number, "default", or the name of a light that is alone
/// in its group.
nlohmann::json mix_schema() {
    const nlohmann::json entry = Members::describing([](Members& e) {
        Vec3f weight;
        read_weight(e, weight);
    });
    return {{"type", "object"}, {"additionalProperties", {{"anyOf", {entry, {{"type", "null"}}}}}}};
}

bool read_mix(const nlohmann::json& value, const Scene& scene, Mix& mix, Diagnostics& d) {
    Members m(value, "/mix", d);
    if (!value.is_object()) return false;
    const auto groups = used_groups(scene);
    std::vector<std::pair<std::string, int>> names;
    for (const int g : groups) {
        names.emplace_back(group_name(g).substr(12), g);
        const Light* alone = nullptr;
        int members = scene.world.light_group == g && scene.world.graph ? 2 : 0;
        for (const Light& l : scene.lights)
            if (l.light_group == g) {
                alone = &l;
                ++members;
            }
        for (const Instance& i : scene.instances)
            if (i.light_group == g && g != 0) ++members;
        if (alone && members == 1) names.emplace_back(alone->name, g);
    }
    for (const auto& [name, g] : names) {
        const auto* entry = m.find(name);
        if (!entry) continue;
        Members e(*entry, "/mix/" + pointer_token(name), d);
        read_weight(e, mix.weight[g]);
    }
    m.finish(false);
    return true;
}

struct Compiled {
    std::shared_ptr<const PreparedScene> scene;
    std::shared_ptr<const Material> material;
};
Compiled compile(Service& s, const nlohmann::json& graph, const std::string& prefix, const std::string& stage, bool lenient, Diagnostics& d) {
    const auto material = s.engine.material(graph, prefix, lenient, d);
    return {s.engine.stage(stage, material, d), material};
}

bool read_stage(Members& m, std::string& stage) {
    const auto views = stage_names();
    return m.choice("stage", stage, {views.begin(), views.end()});
}

struct LiveRequest {
    std::string scene, stage = "shaderball";
    const nlohmann::json* graph = nullptr;
    bool lenient = false, has_stage = false;
    LiveSettings settings;
};

void read_live(Members& m, LiveRequest& r) {
    m.require("mode", "\"live\"", {{"type", "string"}, {"enum", {"live"}}});
    m.boolean("lenient", r.lenient);
    m.text("scene", r.scene);
    r.has_stage = read_stage(m, r.stage);
    r.graph = m.find("graph", schema_ref("Graph"));
    if (!m.describes() && r.scene.empty() == (r.graph == nullptr)) m.fault("graph", r.graph ? "conflict" : "missing-member", r.graph ? "scene and graph" : "nothing", "either scene, or graph and stage");
    if (r.has_stage && !r.scene.empty()) m.fault("stage", "conflict", "scene and stage", "either scene, or graph and stage");
    r.settings.width = r.settings.height = 0;
    read_settings(m, r.settings);
    std::string groups;
    m.choice("light_groups", groups, {"all"});   // they are recorded anyway
    m.finish(r.lenient);
}

struct LiveChange {
    LiveSettings settings;
    std::string stage;
    bool has_stage = false;
    const nlohmann::json* mix = nullptr;
};

void read_live_change(Members& m, LiveChange& c) {
    read_settings(m, c.settings);
    c.has_stage = read_stage(m, c.stage);
    c.mix = m.find("mix", m.describes() ? mix_schema() : nullptr);
    m.finish(false);
}

nlohmann::json document(const LiveEntry& entry) {
    nlohmann::json j = entry.render->document();
    if (!entry.scene.empty()) j["scene"] = {{"id", entry.scene}, {"revision", j["revision"]}};
    else j["stage"] = entry.stage;
    return j;
}

http::Response get_live(Service&, http::Request& request, LiveEntry& entry) {
    best_type(request, {"application/json"});
    const std::lock_guard lock(entry.edit_mutex);
    http::Response r = json_response(200, document(entry));
    r.set("Cache-Control", "no-store");
    return r;
}

/// Replaces the graph or the stage; answers what that cost and what was kept.
nlohmann::json set_graph(Service& s, LiveEntry& entry, nlohmann::json graph, const std::string& stage, const std::string& prefix, const std::string& token, Diagnostics& d) {
    const auto before = entry.render->scene();
    const Compiled now = compile(s, graph, prefix, stage, entry.lenient, d);
    const bool same = now.scene == before;
    const bool geometry = now.scene->surfaces != before->surfaces, lights = now.scene->lights != before->lights;
    nlohmann::json answer = {{"changed", same ? nlohmann::json::array() : nlohmann::json::array({stage != entry.stage ? "stage" : "graph"})},
                             {"rebuild", same ? "none" : geometry ? "geometry" : lights ? "lights" : "shading"},
                             {"reused", reused(*before, *now.scene)}};
    entry.graph = std::move(graph);
    entry.stage = stage;
    // The same scene again still answers the edit: its client waits for a picture with this token.
    entry.render->edit({now.scene, graph_etag(entry.graph)}, token);
    return answer;
}

http::Response patch_live(Service& s, http::Request& request, LiveEntry& entry) {
    best_type(request, {"application/json"});
    const nlohmann::json body = s.read_json(request);
    const std::string token = edit_token(request);
    Diagnostics d;
    nlohmann::json answer = {{"changed", nlohmann::json::array()}, {"rebuild", "none"}};
    const std::lock_guard lock(entry.edit_mutex);
    Members m(body, "", d);
    LiveChange change{entry.render->settings(), entry.stage};
    read_live_change(m, change);
    const auto& [settings, stage, has_stage, weights] = change;
    if (has_stage && !entry.scene.empty()) m.fault("stage", "unexpected", "\"" + stage + "\"", "nothing: the render follows a scene");
    Mix mix = entry.render->current_mix();
    if (weights) read_mix(*weights, *entry.render->scene()->scene, mix, d);
    if (!d.ok()) throw problem_from("settings-invalid", d);
    if (stage != entry.stage)
        s.run(s.compile_lane, request, 0, [&](const std::atomic<bool>&) { answer = set_graph(s, entry, entry.graph, change.stage, "", token, d); });
    for (const char* name : {"resolution", "max_samples", "seed", "aovs"})
        if (body.contains(name)) answer["changed"].push_back(name);
    if (body.contains("resolution") || body.contains("max_samples") || body.contains("seed") || body.contains("aovs")) entry.render->change(settings, weights ? "" : token);
    if (weights) {
        answer["remixed"] = entry.render->mix(mix, token);
        answer["changed"].push_back("mix");
    }
    answer["render"] = document(entry);
    answer["warnings"] = to_json(d.warnings);
    http::Response r = json_response(200, answer);
    if (!token.empty()) r.set("Alder-Edit-Id", token);
    return r;
}

http::Response get_graph(Service&, http::Request& request, LiveEntry& entry) {
    best_type(request, {"application/json"});
    const std::lock_guard lock(entry.edit_mutex);
    if (!entry.scene.empty()) throw Problem{"not-found", "this render follows a scene: its graphs are at /v1/scenes/{id}/materials/{name}"};
    http::Response r = json_response(200, entry.graph);
    r.set("ETag", graph_etag(entry.graph));
    r.set("Cache-Control", "no-cache");
    return r;
}

http::Response edit_graph(Service& s, http::Request& request, LiveEntry& entry) {
    best_type(request, {"application/json"});
    const nlohmann::json body = s.read_json(request);
    const std::string token = edit_token(request);
    Diagnostics d;
    const std::lock_guard lock(entry.edit_mutex);
    if (!entry.scene.empty()) throw Problem{"not-found", "this render follows a scene: its graphs are at /v1/scenes/{id}/materials/{name}"};
    require_match(request, graph_etag(entry.graph));
    nlohmann::json graph = request.method == "PUT" ? body : patched(request, entry.graph, body), answer;
    s.run(s.compile_lane, request, 0, [&](const std::atomic<bool>&) { answer = set_graph(s, entry, std::move(graph), entry.stage, "", token, d); });
    answer["warnings"] = to_json(d.warnings);
    http::Response r = json_response(200, answer);
    r.set("ETag", graph_etag(entry.graph));
    if (!token.empty()) r.set("Alder-Edit-Id", token);
    return r;
}

std::shared_ptr<const Frame> some_frame(LiveEntry& entry) {
    const LiveRender::Reader reader(entry.render);
    const auto frame = entry.render->next_frame(0, kFirstFrameSeconds);
    if (!frame) throw Problem{"not-found", "there is no picture yet"};
    return frame;
}

http::Response snapshot(Service&, http::Request& request, LiveEntry& entry, const std::string& type) {
    Query q(request);
    const auto aovs = q.list("aovs");
    const View view = query_view(q);
    q.finish();
    const auto frame = some_frame(entry);
    const std::string etag = fmt::format("\"{}.{}\"", entry.render->id().substr(4), frame->number);
    http::Response r;
    if (none_match_names(request, etag)) {
        r.status = 304;
    } else if (type == "image/x-exr") {
        std::string error;
        const auto bytes = encode_exr(frame->image(aovs), {}, error);
        if (bytes.empty()) throw Problem{"settings-invalid", error};
        r = http::Response::text(200, std::string(bytes.begin(), bytes.end()), type);
        r.set("Content-Disposition", "inline; filename=\"" + entry.render->id() + ".exr\"");
    } else {
        r = http::Response::text(200, encode_frame(*frame, type, view, 0), type);
    }
    r.set("ETag", etag);
    r.set("Cache-Control", "no-cache");
    r.set("Alder-Samples", std::to_string(frame->samples()));
    r.set("Alder-Divisor", std::to_string(frame->divisor));
    return r;
}

struct PixelRequest {
    int x, y;
    bool explain;
};
PixelRequest read_pixel(Query& q) {
    const auto x = q.integer("x", 0, 0, 65535, true), y = q.integer("y", 0, 0, 65535, true);
    return {static_cast<int>(x), static_cast<int>(y), q.choice("explain", "0", {"0", "1"}) == "1"};
}

http::Response get_pixel(Service& s, http::Request& request, LiveEntry& entry) {
    best_type(request, {"application/json"});
    Query q(request);
    const auto [x, y, explain] = read_pixel(q);
    q.finish();
    const auto frame = some_frame(entry);
    if (x >= frame->width || y >= frame->height) throw Problem{"settings-invalid", fmt::format("the picture has {} x {} pixels", frame->width, frame->height)};
    const int px = std::min(x / frame->divisor, frame->film->width() - 1), py = std::min(y / frame->divisor, frame->film->height() - 1);
    const size_t i = size_t(py) * frame->film->width() + px;
    const Scene& scene = *entry.render->scene()->scene;
    nlohmann::json values = nlohmann::json::object(), object, material;
    for (const Layer& layer : frame->image({}).layers) {
        nlohmann::json v = nlohmann::json::array();
        for (const auto& plane : layer.planes) {
            if (std::isfinite(plane[i])) v.push_back(plane[i]);
            else v.push_back(std::isnan(plane[i]) ? "nan" : plane[i] > 0 ? "inf" : "-inf");
        }
        if (layer.name == "id_object" && layer.planes[0][i] >= 0 && layer.planes[0][i] < static_cast<float>(scene.instances.size())) object = scene.instances[size_t(layer.planes[0][i])].name;
        if (layer.name == "id_material" && layer.planes[0][i] >= 0 && layer.planes[0][i] < static_cast<float>(scene.materials.size())) material = scene.materials[size_t(layer.planes[0][i])].name;
        values[layer.name.empty() ? "rgba" : layer.name] = v.size() == 1 ? v[0] : v;
    }
    nlohmann::json answer = {{"x", x}, {"y", y}, {"samples", frame->samples()}, {"divisor", frame->divisor}, {"layers", std::move(values)}};
    if (explain) {
        const auto prepared = entry.render->scene();
        const int width = frame->width, height = frame->height, column = x, row = y;
        s.run(s.compile_lane, request, 0, [&](const std::atomic<bool>&) { answer["explain"] = explain_pixel(*prepared, width, height, column, row); });
        if (object.is_null() && answer["explain"].value("hit", false)) {
            object = answer["explain"]["object"];
            material = answer["explain"]["material"];
        }
    }
    answer["object"] = std::move(object);
    answer["material"] = std::move(material);
    http::Response r = json_response(200, answer);
    r.set("Cache-Control", "no-store");
    return r;
}

http::Response get_stats(LiveEntry& entry) {
    http::Response r = json_response(200, stats_json(entry.render->stats()));
    r.set("Cache-Control", "no-store");
    return r;
}

}  // namespace

void describe_live(Members& m) {
    LiveRequest r;
    read_live(m, r);
}
void describe_live_change(Members& m) {
    LiveChange c;
    read_live_change(m, c);
}
void describe_pixel_query(Query& q) { read_pixel(q); }
void describe_snapshot_query(Query& q) {
    q.list("aovs");
    query_view(q);
}

http::Response post_live_render(Service& s, http::Request& request, const nlohmann::json& body) {
    best_type(request, {"application/json"});
    Diagnostics d;
    Members m(body, "", d);
    LiveRequest wanted;
    wanted.settings.threads = s.engine.threads();
    read_live(m, wanted);
    if (!d.ok()) throw problem_from("settings-invalid", d);
    LiveSettings& settings = wanted.settings;
    auto entry = std::make_shared<LiveEntry>();
    entry->user = request.user;
    entry->scene = wanted.scene;
    entry->stage = wanted.stage;
    entry->lenient = wanted.lenient;
    if (wanted.graph) entry->graph = *wanted.graph;
    const auto revision = entry->scene.empty() ? nullptr : s.scenes.get(entry->scene);
    LiveSource source;
    s.run(s.compile_lane, request, 0, [&](const std::atomic<bool>&) {
        if (revision) source = {s.scenes.load(s.engine, s.assets, *revision, d)->prepared, revision->etag};
        else source = {compile(s, entry->graph, "/graph", entry->stage, entry->lenient, d).scene, graph_etag(entry->graph)};
    });
    if (settings.width == 0) {
        settings.width = entry->scene.empty() ? 512 : source.scene->scene->settings.width;
        settings.height = entry->scene.empty() ? 512 : source.scene->scene->settings.height;
    }
    s.live.add(entry, source, settings);
    // An edit between the load and now has not reached it.
    if (revision)
        if (const auto newer = s.scenes.get(entry->scene); newer->etag != revision->etag)
            s.run(s.compile_lane, request, 0, [&](const std::atomic<bool>&) { entry->render->edit({s.scenes.load(s.engine, s.assets, *newer, d)->prepared, newer->etag}, ""); });
    nlohmann::json j = document(*entry);
    j["warnings"] = to_json(d.warnings);
    http::Response r = json_response(201, j);
    r.set("Location", "/v1/renders/" + entry->render->id());
    return r;
}

http::Response only_live(Service&, http::Request& request) {
    throw Problem{"not-found", fmt::format("there is no live render '{}'", request.parameters["id"].substr(0, 64))};
}

std::optional<http::Response> live_route(Service& s, http::Request& request) {
    constexpr std::string_view kBase = "/v1/renders/{id}";
    if (request.route.rfind(kBase, 0) != 0) return std::nullopt;
    const auto entry = s.live.find(request.parameters["id"]);
    if (!entry || (!request.sees_all && request.user != entry->user)) return std::nullopt;
    const std::string what = request.route.substr(kBase.size());
    const std::string method = request.method == "HEAD" ? "GET" : request.method;
    if (method == "GET") {
        if (what.empty()) return get_live(s, request, *entry);
        if (what == "/graph") return get_graph(s, request, *entry);
        if (what == "/snapshot.exr") return snapshot(s, request, *entry, "image/x-exr");
        if (what == "/snapshot.png") return snapshot(s, request, *entry, "image/png");
        if (what == "/snapshot.jpg") return snapshot(s, request, *entry, "image/jpeg");
        if (what == "/pixel") return get_pixel(s, request, *entry);
        if (what == "/stats") return get_stats(*entry);
        if (what == "/events") return events_stream(s, request, entry);
        if (what == "/preview.mjpg") return preview_stream(s, request, entry);
        if (what == "/stream") return exr_stream(s, request, entry);
        if (what == "/tiles") return tile_stream(s, request, entry);
        throw Problem{"not-found", "a live render has nothing of this name"};
    }
    if (method == "PATCH" && what.empty()) return patch_live(s, request, *entry);
    if ((method == "PUT" || method == "PATCH") && what == "/graph") return edit_graph(s, request, *entry);
    if (method == "DELETE" && what.empty()) {
        s.live.remove(entry->render->id());
        http::Response r;
        r.status = 204;
        return r;
    }
    if (method == "POST") {
        if (what == "/cancel") entry->render->close("cancelled");
        else if (what == "/pause" || what == "/resume") entry->render->pause(what == "/pause");
        else return std::nullopt;
        return get_live(s, request, *entry);
    }
    return std::nullopt;
}

}  // namespace alder
