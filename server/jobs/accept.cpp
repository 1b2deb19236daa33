// Accepting a render.
#include "server/jobs/accept.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "graph/json_text.h"
#include "graph/program.h"
#include "render/prepared_scene.h"
#include "render/programs.h"
#include "server/build_id.h"
#include "server/digest.h"
#include "server/http/door.h"
#include "server/json_patch.h"
#include "server/jobs/files.h"
#include "server/scene_source.h"

namespace alder::jobs {
namespace {

bool is_below(const std::string& path, const std::string& folder) { return path == folder || path.rfind(folder + "/", 0) == 0; }

/// Applies the operations one by one, so that a fault has its place.
void apply_operations(nlohmann::json& document, const std::vector<std::pair<size_t, nlohmann::json>>& operations, Diagnostics& d) {
    for (const auto& [index, operation] : operations) {
        if (apply_operation(document, operation)) continue;
        d.errors.push_back({fmt::format("/overrides/{}/path", index), "unknown-value", operation.value("path", ""), "a place that is there", {}});
        return;
    }
}

/// The revision with the overrides in it. Graphs are compiled, other members are read: what is wrong is known now.
SceneRevision overridden(Service& s, const SceneRevision& scene, const LoadedScene& loaded, const nlohmann::json& overrides, bool lenient, Diagnostics& d) {
    SceneRevision next = scene;
    std::vector<std::pair<size_t, nlohmann::json>> on_materials, on_document;
    for (size_t i = 0; i < overrides.size(); ++i) {
        const std::string path = overrides[i].at("path").get<std::string>();
        (is_below(path, "/materials") ? on_materials : on_document).emplace_back(i, overrides[i]);
        if (path == "/materials" || std::count(path.begin(), path.end(), '/') < 3)
            if (is_below(path, "/materials") && (path == "/materials" || overrides[i].at("op") != "replace"))
                d.errors.push_back({fmt::format("/overrides/{}/path", i), "wrong-value", path, "a place inside a material, or replace of one", {}});
    }
    if (!d.ok()) throw problem_from("settings-invalid", d);
    if (!on_document.empty()) {
        if (!next.source.contains("document")) {
            d.errors.push_back({fmt::format("/overrides/{}/path", on_document[0].first), "wrong-value", on_document[0].second.value("path", ""), "/materials/...: of a container nothing else can be overridden", {}});
            throw problem_from("settings-invalid", d);
        }
        apply_operations(next.source["document"], on_document, d);
        if (!d.ok()) throw problem_from("settings-invalid", d);
        if (!load_scene_source(s.engine, s.assets, next.source, lenient, d) || !d.ok()) throw problem_from("scene-invalid", d);
    }
    if (!on_materials.empty()) {
        nlohmann::json graphs = nlohmann::json::object();
        for (const SceneMaterial& m : loaded.scene->materials) graphs["materials"][m.name] = m.graph->document();
        const nlohmann::json before = graphs;
        apply_operations(graphs, on_materials, d);
        if (!d.ok()) throw problem_from("settings-invalid", d);
        for (const auto& [name, graph] : graphs["materials"].items()) {
            if (graph == before["materials"].value(name, nlohmann::json())) continue;
            s.engine.material(graph, "/overrides/materials/" + pointer_token(name), lenient, d);
            next.materials[name] = graph;
        }
    }
    return next;
}

void check_against_scene(const LoadedScene& loaded, const JobSettings& f, uint64_t memory_cap, Diagnostics& d) {
    const Scene& scene = *loaded.scene;
    if (f.strict) require_files(scene, d);
    if (!d.ok()) throw problem_from("scene-invalid", d);
    const int width = f.render.width ? f.render.width : scene.settings.width, height = f.render.height ? f.render.height : scene.settings.height;
    if (f.render.crop[2] > width || f.render.crop[3] > height)
        d.errors.push_back({"/crop", "out-of-range", fmt::format("{} x {}", f.render.crop[2], f.render.crop[3]), fmt::format("a rectangle inside {} x {}", width, height), {}});
    if (!f.camera.empty()) {
        std::vector<std::string> names{scene.camera.name};
        for (const Camera& c : scene.other_cameras) names.push_back(c.name);
        if (std::find(names.begin(), names.end(), f.camera) == names.end())
            d.errors.push_back({"/camera", "unknown-value", "\"" + f.camera + "\"", "the name of a camera of the scene", nearest_name(f.camera, names)});
    }
    if (!d.ok()) throw problem_from("settings-invalid", d);
    std::vector<std::string> graph_aovs;
    for (const SceneMaterial& m : scene.materials)
        if (m.graph)
            for (const std::string& name : m.graph->aov_names()) graph_aovs.push_back(name);
    std::sort(graph_aovs.begin(), graph_aovs.end());
    graph_aovs.erase(std::unique(graph_aovs.begin(), graph_aovs.end()), graph_aovs.end());
    const uint64_t needed = film_bytes(f, width, height, graph_aovs);
    if (needed > memory_cap) {
        Problem p{"limit-exceeded", fmt::format("{} x {} pixels with these layers need {} MiB of memory; {} MiB may be used", width, height, needed >> 20, memory_cap >> 20)};
        p.extra["needed_bytes"] = needed;
        p.extra["limit"] = memory_cap;
        p.extra["limit_option"] = "--worker-memory-mib";
        throw p;
    }
}

/// Kept under the digest of its text, as assets are.
std::string keep_snapshot(AssetStore& assets, const SceneRevision& scene) {
    nlohmann::json j = to_json(scene);
    j.erase("revision");   // equal content is equal, whatever it was called
    const std::string text = j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    const std::string hex = sha256_hex(text);
    if (!assets.has(hex)) {
        const auto upload = assets.has_room(text.size()) ? assets.begin() : nullptr;
        if (!upload || !upload->write(text) || upload->hex() != hex || !upload->commit(hex)) throw Problem{"storage", "the render could not be written"};
    }
    return "sha256:" + hex;
}

/// The files of an equal render, under the new one's name too: links, so nothing is copied and each may go on its own.
bool share_result(Service& s, Job& job) {
    if (job.cache_key.empty()) return false;
    const auto found = s.renders.store().find_result(job.cache_key);
    const auto other = found ? s.renders.store().get(*found) : std::nullopt;
    if (!other || other->outputs.empty()) return false;
    const RenderFolder from(s.options.data, other->id), to(s.options.data, job.id);
    bool linked = to.prepare() == 0;
    for (const Output& o : other->outputs) linked = linked && ::link(from.output(o.file).c_str(), to.output(o.file).c_str()) == 0;
    if (!linked || sync_folder(to.outputs()) != 0) {
        to.remove();
        return false;
    }
    append_log(to.log(), "info", "the result of " + other->id + ", which was asked for the same");
    job.state = State::Succeeded;
    job.started = job.ended = job.created;
    job.outputs = other->outputs;
    job.progress = other->progress;
    job.stats = other->stats;
    job.warnings = other->warnings;
    job.timings = {{"queued", 0}};
    s.metrics.count("alder_render_cache_hits");
    return true;
}

}  // namespace

std::string result_key(const std::string& snapshot, const nlohmann::json& body, const JobSettings& settings) {
    if (!settings.is_deterministic()) return {};
    nlohmann::json what = body;
    for (const char* name : {"scene", "overrides", "priority", "labels", "retain", "cancel_on_disconnect", "mode", "lenient"}) what.erase(name);
    return content_digest({{"build", build_id()}, {"isa", current_isa()}, {"scene", snapshot}, {"settings", what}});
}

Accepted accept(Service& s, http::Request& request, const nlohmann::json& body, const JobSettings& settings, Diagnostics& d) {
    const auto scene = s.scenes.get(settings.scene);
    Accepted a;
    SceneRevision snapshot = *scene;
    s.run(s.compile_lane, request, 0, [&](const std::atomic<bool>&) {
        const auto loaded = s.scenes.load(s.engine, s.assets, *scene, d);
        check_against_scene(*loaded, settings, s.renders.memory_cap(), d);
        if (!settings.overrides.is_null()) snapshot = overridden(s, *scene, *loaded, settings.overrides, settings.lenient, d);
        for (const auto& w : loaded->scene->warnings) a.job.warnings.push_back(w);
        for (const auto& w : d.warnings) a.job.warnings.push_back(w.line());
    });
    Job& job = a.job;
    job.id = "rnd_" + http::time_sorted_id();
    job.user = request.user;
    job.priority = settings.priority;
    job.created = wall_seconds();
    job.retain = settings.retain >= 0 ? settings.retain : s.options.retain_seconds;
    job.scene = scene->id;
    job.scene_etag = scene->etag;
    job.request = body;
    job.labels = settings.labels;
    job.progress = {{"fraction", 0}, {"samples", 0}, {"estimated_error", nullptr}, {"eta", nullptr}, {"frames_done", 0}, {"frames", settings.frames.size()}};
    job.snapshot = keep_snapshot(s.assets, snapshot);
    job.cache_key = result_key(job.snapshot, body, settings);
    a.assets = revision_from_json(job.snapshot, to_json(snapshot))->assets;
    a.assets.push_back(job.snapshot);
    const std::string* control = request.header("cache-control");
    if (!control || control->find("no-cache") == std::string::npos) a.from_cache = share_result(s, job);
    return a;
}

}  // namespace alder::jobs
