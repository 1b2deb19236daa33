// alder preview: a graph on a preview stage, without a scene.
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "clients/cli/common.h"
#include "clients/cli/picture.h"
#include "render/stages.h"

namespace alder::cli {
namespace {

struct Options {
    std::string graph, output, stage = "shaderball", stats, layer;
    std::vector<std::string> aovs, settings;
    int size = 256, samples = 16, threads = 0;
    double seconds = 0;
    uint32_t seed = 0;
    float exposure = 0;
    bool quiet = false, lenient = false, strict = false;
};

int run(const Options& o) {
    const std::string output = o.output.empty() ? (o.graph == "-" ? "preview" : std::filesystem::path(o.graph).stem().string()) + ".png" : o.output;
    check_image_name(output);
    const auto loading = std::chrono::steady_clock::now();
    Diagnostics d;
    MaterialOptions options;
    options.lenient = o.lenient;
    options.strict = o.strict;
    options.resolve_image = image_resolver(o.graph);
    auto material = build_material(read_graph_file(o.graph), options, d);
    report(o.graph, d, o.quiet);
    if (!material) fail(kWrong, o.graph + ": cannot be compiled");
    for (const std::string& text : o.settings) {
        const Setting s = parse_setting(text);
        material = apply_setting(*material, s.target, s.value, text);
    }
    d = {};
    const auto scene = make_stage(o.stage, material, o.size, d);
    report("--stage " + o.stage, d, o.quiet);
    if (!scene) fail(kWrong, "--stage " + o.stage + ": there is no such stage");
    const auto prepared = prepare_scene(scene, EvalContext{}, d);
    report(o.graph, d, o.quiet);
    if (!prepared) fail(kWrong, o.graph + ": cannot be rendered");
    const double load_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - loading).count();

    RenderRequest request;
    request.width = request.height = o.size;
    request.samples = o.samples;
    request.seconds = o.seconds;
    request.seed = o.seed;
    request.threads = o.threads;
    request.aovs = o.aovs;
    const std::atomic<bool>& interrupted = interruptible();
    request.cancel = &interrupted;
    RenderStats stats;
    const Image image = render(*prepared, request, stats, progress_printer(o.quiet));
    end_progress();
    if (o.strict) report(o.graph, {material->file_faults(), {}});   // a file may break off in the middle
    View view;
    view.exposure = o.exposure;
    view.layer = o.layer;
    const auto writing = std::chrono::steady_clock::now();
    write_image(output, image, {}, view);
    if (!o.stats.empty()) {
        const double write_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - writing).count();
        const std::string text = statistics(stats, load_seconds, write_seconds).dump(1) + "\n";
        write_bytes(o.stats, text.data(), text.size());
    }
    if (!o.quiet) fmt::print("{}: {} x {}, {} samples, {:.2f} s\n", output, image.width, image.height, stats.samples, stats.render_seconds);
    return interrupted ? kInterrupted : kDone;
}

}  // namespace

Run add_preview(CLI::App& app) {
    auto o = std::make_shared<Options>();
    CLI::App* c = app.add_subcommand("preview", "a graph on a preview stage");
    c->add_option("GRAPH", o->graph, "a graph document; - is standard input")->required();
    c->add_option("-o,--output", o->output, "OUT.png, .jpg or .exr; default: the graph's name with .png");
    c->add_option("--stage", o->stage, "shaderball, sphere, plane, cloth, hair or volume")->capture_default_str();
    c->add_option("--size", o->size, "pixels a side")->check(CLI::Range(1, 16384))->capture_default_str();
    c->add_option("--samples", o->samples, "samples a pixel")->check(CLI::Range(1, 1 << 20))->capture_default_str();
    c->add_option("--seconds", o->seconds, "stop with the best image after so long")->check(CLI::Range(0.001, 1e7));
    c->add_option("--seed", o->seed, "")->capture_default_str();
    c->add_option("--threads", o->threads, "0 = all processors")->check(CLI::Range(0, 1024));
    c->add_option("--aov", o->aovs, "a layer or group, for .exr; repeatable")->allow_extra_args(false);
    c->add_option("--layer", o->layer, "the layer that .png and .jpg show; default: the picture");
    c->add_option("--exposure", o->exposure, "stops, for .png and .jpg");
    c->add_option("--set", o->settings, "NODE.PARAM=VALUE; repeatable")->allow_extra_args(false);
    c->add_option("--stats", o->stats, "write times, rays and memory here as JSON");
    add_texture_options(*c);
    c->add_flag("--strict", o->strict, "files that are missing or broken are errors");
    c->add_flag("--lenient", o->lenient, "unknown parameters are warnings");
    c->add_flag("--quiet", o->quiet, "errors only");
    return [o] { return run(*o); };
}

}  // namespace alder::cli
