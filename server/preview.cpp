// POST /v1/preview: a graph in, a picture out; nothing is left behind.
#include <chrono>

#include <fmt/format.h>

#include "render/prepared_scene.h"
#include "render/stages.h"
#include "server/build_id.h"
#include "server/digest.h"
#include "server/negotiate.h"
#include "server/openapi.h"
#include "server/picture.h"
#include "server/routes.h"
#include "server/service.h"

namespace alder {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

constexpr int kDefaultSamples = 16;
constexpr int kDefaultSide = 256;
constexpr int kSideMost = 4096;

struct PreviewRequest {
    nlohmann::json graph;
    std::string stage = "shaderball";
    std::string assign_to;   ///< material of a scene, where the stage is one
    RenderRequest render;
    View view;
    bool lenient = false, strict = false;
    bool with_budget = false;
};

bool is_scene(const std::string& stage) { return stage.rfind("scn_", 0) == 0; }

void read_size(Members& m, RenderRequest& render) {
    const nlohmann::json one = {{"type", "integer"}, {"minimum", 1}, {"maximum", kSideMost}};
    const nlohmann::json* size = m.find("size", {{"anyOf", {one, {{"type", "array"}, {"items", one}, {"minItems", 2}, {"maxItems", 2}}}}});
    render.width = render.height = kDefaultSide;
    if (!size) return;
    const auto side = [](const nlohmann::json& v) {
        int64_t n = 0;
        return whole_number(v, 1, kSideMost, n) ? static_cast<int>(n) : 0;
    };
    if (size->is_array() && size->size() == 2) {
        render.width = side((*size)[0]);
        render.height = side((*size)[1]);
    } else {
        render.width = render.height = side(*size);
    }
    if (render.width == 0 || render.height == 0) m.fault("size", "out-of-range", brief(*size), fmt::format("a whole number from 1 to {}, or two of them", kSideMost));
}

void read_preview(Members& m, PreviewRequest& p) {
    if (const auto* graph = m.require("graph", "a graph document", schema_ref("Graph"))) p.graph = *graph;
    m.boolean("lenient", p.lenient);
    m.boolean("strict", p.strict);
    if (m.text("stage", p.stage) && !is_scene(p.stage)) {
        const auto views = stage_names();
        const std::vector<std::string> names(views.begin(), views.end());
        if (std::find(names.begin(), names.end(), p.stage) == names.end())
            m.fault("stage", "unknown-value", "\"" + p.stage + "\"", fmt::format("one of {}, or a scene's id", fmt::join(names, ", ")), nearest_name(p.stage, names));
    }
    m.text("assign_to", p.assign_to);
    if (!m.describes() && is_scene(p.stage) != !p.assign_to.empty())
        m.fault("assign_to", is_scene(p.stage) ? "missing-member" : "unexpected", p.assign_to.empty() ? "nothing" : "\"" + p.assign_to + "\"",
                is_scene(p.stage) ? "the scene's material that the graph replaces" : "no assign_to: the stage is not a scene");
    read_size(m, p.render);
    int64_t samples = kDefaultSamples, seed = 0;
    const bool has_samples = m.integer("samples", samples, 1, 1 << 20);
    p.with_budget = m.number("budget", p.render.seconds, 0.001, 600);
    if (has_samples && p.with_budget) m.fault("budget", "conflict", "samples and budget", "one of them");
    p.render.samples = p.with_budget ? 1 << 20 : static_cast<int>(samples);
    if (m.integer("seed", seed, 0, UINT32_MAX)) p.render.seed = static_cast<uint32_t>(seed);
    m.texts("aovs", p.render.aovs, 1024);
    m.object("view", [&](Members& v) { read_view(v, p.view); });
    m.finish(p.lenient);
}

/// A digest of everything that decides the pixels and their encoding.
std::string preview_etag(const PreviewRequest& p, const std::string& scene_state, const std::string& type) {
    const nlohmann::json key = {{"version", ALDER_VERSION}, {"build", build_id()}, {"isa", current_isa()}, {"graph", p.graph}, {"stage", p.stage},
                                {"scene", scene_state}, {"assign_to", p.assign_to}, {"lenient", p.lenient}, {"strict", p.strict}, {"width", p.render.width},
                                {"height", p.render.height}, {"samples", p.render.samples}, {"seed", p.render.seed}, {"aovs", p.render.aovs},
                                {"type", type}, {"exposure", p.view.exposure}, {"transform", static_cast<int>(p.view.transform)},
                                {"layer", p.view.layer}, {"alpha", p.view.alpha}, {"quality", p.view.quality}};
    return "\"" + sha256_hex(key.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)).substr(0, 40) + "\"";
}

}  // namespace

void describe_preview(Members& m) {
    PreviewRequest p;
    read_preview(m, p);
}

http::Response post_preview(Service& s, http::Request& request) {
    const auto start = Clock::now();
    const std::string type = best_type(request, kPictureTypes);
    const nlohmann::json body = s.read_json(request);
    Diagnostics d;
    PreviewRequest p;
    Members m(body, "", d);
    read_preview(m, p);
    if (!d.ok()) throw problem_from("settings-invalid", d);
    p.render.threads = s.engine.threads();
    Timings timings;
    timings.parse = since(start);

    std::shared_ptr<const SceneRevision> scene;
    if (is_scene(p.stage)) scene = s.scenes.get(p.stage);
    // Files below an asset root may change under their name: such an answer has no tag and is not kept.
    const bool tagged = !p.with_budget && !s.engine.serves_files() && type != "application/json";
    const std::string etag = tagged ? preview_etag(p, scene ? scene->etag : "", type) : "";
    if (tagged && none_match_names(request, etag)) {
        http::Response r;
        r.status = 304;
        r.set("ETag", etag);
        r.set("Vary", "Accept");
        return r;
    }
    if (tagged)
        if (auto kept = s.results.find(etag)) {
            s.metrics.count("alder_previews", "outcome=\"cached\"");
            kept->set("Server-Timing", "cache;desc=hit, " + timings.header());
            return *kept;
        }

    http::Response response;
    const auto queued = Clock::now();
    s.run(s.preview_lane, request, 0, [&](const std::atomic<bool>& cancel) {
        timings.queue = since(queued);
        const jobs::Gate::Hold hold(&s.renders.gate());   // somebody waits: renders of the queue stand aside
        const auto compiling = Clock::now();
        const auto material = s.engine.material(p.graph, "/graph", p.lenient, d, p.strict);
        timings.compile = since(compiling);
        const auto building = Clock::now();
        const auto prepared = scene ? s.scenes.with_graph(s.engine, s.assets, *scene, p.assign_to, material, d) : s.engine.stage(p.stage, material, d);
        timings.build = since(building);
        if (scene && p.strict) require_files(*prepared->scene, d);
        if (!d.ok()) throw problem_from("scene-invalid", d);
        RenderStats stats;
        p.render.cancel = &cancel;
        const auto rendering = Clock::now();
        const Image image = render(*prepared, p.render, stats);
        timings.render = since(rendering);
        if (cancel) throw Problem{"cancelled", "the client hung up, or the daemon is stopping"};
        if (p.strict) {   // a file may break off in the middle
            if (scene) require_files(*prepared->scene, d);
            for (const Diagnostic& fault : material->file_faults()) d.errors.push_back(fault);
        }
        if (!d.ok()) throw problem_from("scene-invalid", d);
        response = picture(image, type, p.view, stats, d, timings);
        s.count_render(stats);
    });
    s.metrics.count("alder_previews", "outcome=\"rendered\"");
    if (tagged) {
        response.set("ETag", etag);
        response.set("Cache-Control", "no-cache");
        s.results.keep(etag, response);
    }
    return response;
}

}  // namespace alder
