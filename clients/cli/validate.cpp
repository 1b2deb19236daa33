// alder validate: what is wrong with graphs and scenes, without rendering. Exit status 1 where a file has errors.
#include <cstdio>
#include <memory>

#include <fmt/format.h>

#include "clients/cli/common.h"
#include "graph/json_text.h"
#include "graph/report.h"
#include "render/import/scene_document.h"

namespace alder::cli {
namespace {

struct Options {
    std::vector<std::string> files;
    bool lenient = false, json = false;
};

bool is_scene(const std::string& file, const std::optional<nlohmann::json>& document) {
    const size_t dot = file.rfind('.');
    const std::string extension = dot == std::string::npos ? "" : file.substr(dot);
    return extension == ".alder" || extension == ".glb" || extension == ".gltf" || extension == ".ass" || extension == ".xml" || (document && document->is_object() && document->contains("alder_scene"));
}

/// A scene is loaded with all its graphs and arrays; nothing is built or rendered.
nlohmann::json check_scene(const std::string& file, bool lenient) {
    Diagnostics d;
    SceneLoadOptions options;
    options.lenient = lenient;
    const SceneFile source(file);
    const auto scene = load_scene(source.path(), options, d);
    nlohmann::json report{{"ok", scene && d.ok()}, {"errors", to_json(d.errors)}, {"warnings", to_json(d.warnings)}};
    if (scene) report["scene"] = {{"materials", scene->materials.size()}, {"meshes", scene->meshes.size()}, {"instances", scene->instances.size()}, {"lights", scene->lights.size()}};
    return report;
}

nlohmann::json check(const std::string& file, bool lenient) {
    if (is_scene(file, std::nullopt)) return check_scene(file, lenient);
    Diagnostics d;
    std::shared_ptr<const Material> material;
    JsonLimits limits;
    limits.string_bytes = size_t{1} << 30;
    if (auto document = parse_json(read_text(file), limits, d)) {
        if (file != "-" && is_scene(file, document)) return check_scene(file, lenient);
        MaterialOptions options;
        options.lenient = lenient;
        options.resolve_image = image_resolver(file);
        const bool wrapped = document->is_object() && document->contains("graph") && !document->contains("nodes");
        if (wrapped) options.pointer_prefix = "/graph";
        material = build_material(wrapped ? (*document)["graph"] : *document, options, d);
    }
    return graph_report(material.get(), std::move(d));
}

int run(const Options& o) {
    bool good = true;
    nlohmann::json all = nlohmann::json::object();
    for (const std::string& file : o.files) {
        const nlohmann::json report = check(file, o.lenient);
        good = good && report["ok"].get<bool>();
        if (o.json) {
            all[file] = report;
            continue;
        }
        for (const char* kind : {"warnings", "errors"})
            for (const auto& e : report[kind]) {
                const Diagnostic d{e.value("pointer", ""), e.value("code", ""), e.value("found", ""), e.value("expected", ""), e.value("suggest", ""),
                                   e.value("path", std::vector<std::string>{})};
                fmt::print(stderr, "alder: {}{}: {}\n", kind[0] == 'w' ? "warning: " : "", file, d.line());
            }
        if (report["ok"].get<bool>() && report.contains("scene")) {
            const auto& c = report["scene"];
            fmt::print("{}: good; {} meshes, {} instances, {} lights, {} materials\n", file, c["meshes"].get<size_t>(), c["instances"].get<size_t>(), c["lights"].get<size_t>(),
                       c["materials"].get<size_t>());
        }
        if (report["ok"].get<bool>() && report.contains("compiled")) {
            const auto& c = report["compiled"];
            fmt::print("{}: good; {} of {} nodes live, {} instructions, {} values folded\n", file, c["live_nodes"].get<int>(), c["nodes"].get<int>(),
                       c["instructions"].get<int>(), c["constant_folded"].get<int>());
        }
    }
    if (o.json) fmt::print("{}\n", all.dump(1));
    return good ? kDone : kCheckFailed;
}

}  // namespace

Run add_validate(CLI::App& app) {
    auto o = std::make_shared<Options>();
    CLI::App* c = app.add_subcommand("validate", "what is wrong with graphs and scenes, without rendering");
    c->add_option("FILE", o->files, "graph documents and scenes (.json, .alder, .glb, .gltf, .ass, .xml); - is standard input")->required();
    c->add_flag("--lenient", o->lenient, "unknown parameters are warnings");
    c->add_flag("--json", o->json, "reports by file; of graphs as POST /v1/graphs/validate answers");
    return [o] { return run(*o); };
}

}  // namespace alder::cli
