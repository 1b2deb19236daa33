// alder validate: what is wrong with graphs and scenes, without rendering. Exit status 1 where a file has errors.
#include <cstdio>
#include <memory>

#include <fmt/format.h>

#include "clients/cli/common.h"
#include "graph/json_text.h"
#include "graph/report.h"

namespace alder::cli {
namespace {

struct Options {
    std::vector<std::string> files;
    bool lenient = false, json = false;
};

nlohmann::json check(const std::string& file, bool lenient) {
    Diagnostics d;
    std::shared_ptr<const Material> material;
    JsonLimits limits;
    limits.string_bytes = size_t{1} << 30;
    if (auto document = parse_json(read_text(file), limits, d)) {
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
    CLI::App* c = app.add_subcommand("validate", "what is wrong with graphs, without rendering");
    c->add_option("FILE", o->files, "graph documents; - is standard input")->required();
    c->add_flag("--lenient", o->lenient, "unknown parameters are warnings");
    c->add_flag("--json", o->json, "reports as POST /v1/graphs/validate answers, by file");
    return [o] { return run(*o); };
}

}  // namespace alder::cli
