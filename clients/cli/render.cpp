// alder render: a scene file to an image with all its layers.
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "clients/cli/common.h"
#include "clients/cli/picture.h"
#include "graph/program.h"
#include "render/import/scene_document.h"
#include "render/programs.h"

namespace alder::cli {
namespace {

struct Options {
    std::string scene, output, resolution, crop, stats, isa, pixel_type = "float";
    std::string texture_filter, noise_filter;
    std::vector<std::string> aovs, settings;
    int samples = 0, threads = 0;
    double seconds = 0, target_error = 0;
    uint64_t sample_offset = 0;
    uint32_t seed = 0;
    bool seed_given = false, quiet = false, lenient = false, strict = false, progress = false;
    View view;
};

double since(std::chrono::steady_clock::time_point t) { return std::chrono::duration<double>(std::chrono::steady_clock::now() - t).count(); }

/// MATERIAL/NODE.PARAM: the material is the longest name of the scene that leads the target, so names may have slashes.
std::shared_ptr<const Scene> apply_settings(std::shared_ptr<const Scene> scene, const std::vector<std::string>& settings) {
    if (settings.empty()) return scene;
    auto edited = std::make_shared<Scene>(*scene);
    for (const std::string& text : settings) {
        const Setting s = parse_setting(text);
        SceneMaterial* best = nullptr;
        for (SceneMaterial& m : edited->materials)
            if (s.target.rfind(m.name + "/", 0) == 0 && (!best || m.name.size() > best->name.size())) best = &m;
        if (!best) {
            std::vector<std::string> names;
            for (const auto& m : edited->materials) names.push_back(m.name);
            const std::string near = nearest_name(s.target.substr(0, s.target.find('/')), names);
            fail(kWrong, fmt::format("--set {}: the scene has no such material{}", text, near.empty() ? "" : fmt::format("; did you mean '{}'?", near)));
        }
        best->graph = apply_setting(*best->graph, s.target.substr(best->name.size() + 1), s.value, text);
    }
    return edited;
}

int run(const Options& o) {
    const std::string output = o.output.empty() ? std::filesystem::path(o.scene).stem().string() + ".exr" : o.output;
    check_image_name(output);
    if (!o.isa.empty() && !choose_isa(o.isa)) fail(kWrong, "this processor has no " + o.isa);
    RenderRequest request;
    if (!o.resolution.empty()) parse_resolution(o.resolution, request);
    if (!o.crop.empty()) parse_crop(o.crop, request);
    if (!std::filesystem::exists(o.scene)) fail(kWrong, o.scene + ": there is no such file");

    const auto loading = std::chrono::steady_clock::now();
    Diagnostics d;
    SceneLoadOptions load;
    load.lenient = o.lenient;
    const SceneFile file(o.scene);
    auto scene = load_scene(file.path(), load, d);
    report(o.scene, d, o.quiet);
    if (!scene) fail(kWrong, o.scene + ": cannot be used");
    scene = apply_settings(scene, o.settings);
    if (!o.texture_filter.empty() || !o.noise_filter.empty()) {
        auto filtered = std::make_shared<Scene>(*scene);
        if (!o.texture_filter.empty()) filtered->settings.texture_filter = o.texture_filter == "on";
        if (!o.noise_filter.empty()) filtered->settings.noise_filter = o.noise_filter == "on";
        scene = filtered;
    }
    const double load_seconds = since(loading);

    d = {};
    const auto prepared = prepare_scene(scene, EvalContext{}, d);
    if (prepared && o.strict) require_files(*scene, d);
    report(o.scene, d, o.quiet);
    if (!prepared) fail(kWrong, o.scene + ": cannot be rendered");
    const int width = request.width ? request.width : scene->settings.width, height = request.height ? request.height : scene->settings.height;
    if (request.crop[2] > width || request.crop[3] > height) fail(kWrong, fmt::format("--crop {}: reaches beyond the {} x {} image", o.crop, width, height));
    request.samples = o.samples;
    request.seconds = o.seconds;
    request.target_error = o.target_error;
    request.sample_offset = o.sample_offset;
    request.seed = o.seed_given ? o.seed : scene->settings.seed;
    request.threads = o.threads;
    request.aovs = o.aovs;
    const std::atomic<bool>& interrupted = interruptible();
    request.cancel = &interrupted;

    RenderStats stats;
    const Image image = render(*prepared, request, stats, progress_printer(o.quiet, o.progress));
    end_progress();
    if (o.strict) {   // a file may break off in the middle
        Diagnostics late;
        require_files(*scene, late);
        report(o.scene, late);
    }
    const auto writing = std::chrono::steady_clock::now();
    ExrOptions exr;
    exr.all_float = o.pixel_type == "float";
    write_image(output, image, exr, o.view);
    const double write_seconds = since(writing);
    if (!o.stats.empty()) {
        const std::string text = statistics(stats, load_seconds, write_seconds).dump(1) + "\n";
        write_bytes(o.stats, text.data(), text.size());
    }
    if (!o.quiet) fmt::print("{}: {} x {}, {} samples, {} layers, {:.2f} s\n", output, image.width, image.height, stats.samples, image.layers.size(), stats.render_seconds);
    if (interrupted) {
        std::fprintf(stderr, "alder: interrupted after %d samples; %s is marked incomplete\n", stats.samples, output.c_str());
        return kInterrupted;
    }
    // A time limit alone is a goal; together with --samples it is a deadline that was missed.
    return !stats.complete && o.seconds > 0 && o.samples > 0 ? kDeadline : kDone;
}

}  // namespace

Run add_render(CLI::App& app) {
    auto o = std::make_shared<Options>();
    CLI::App* c = app.add_subcommand("render", "a scene to an image with all its layers");
    c->add_option("SCENE", o->scene, "a scene document (.json, .alder), .glb, .gltf, .ass or .xml (Cycles)")->required();
    c->add_option("-o,--output", o->output, "OUT.exr, .png or .jpg; default: the scene's name with .exr");
    c->add_option("--samples", o->samples, "samples a pixel; default: the scene's")->check(CLI::Range(1, 1 << 20));
    c->add_option("--seconds", o->seconds, "stop with the best image after so long")->check(CLI::Range(0.001, 1e7));
    c->add_option("--target-error", o->target_error, "stop when the estimated relative error is below")->check(CLI::Range(1e-6, 10.0));
    c->add_option("--seed", o->seed, "default: the scene's")->each([o](const std::string&) { o->seed_given = true; });
    c->add_option("--threads", o->threads, "0 = all processors")->check(CLI::Range(0, 1024));
    c->add_option("--sample-offset", o->sample_offset, "number of the first sample: disjoint ranges merge with `alder merge`")->check(CLI::Range(uint64_t{0}, uint64_t{1} << 40));
    c->add_option("--crop", o->crop, "x0,y0,x1,y1 in pixels from the top left");
    c->add_option("--resolution", o->resolution, "WIDTHxHEIGHT");
    c->add_option("--aov", o->aovs, "a layer or group (shading, data, quality, light_groups, ids ...); repeatable")->allow_extra_args(false);
    c->add_option("--set", o->settings, "MATERIAL/NODE.PARAM=VALUE; repeatable")->allow_extra_args(false);
    c->add_option("--stats", o->stats, "write times, rays and memory here as JSON");
    c->add_option("--pixel-type", o->pixel_type, "of colour layers in an .exr")->check(CLI::IsMember({"float", "half"}))->capture_default_str();
    c->add_option("--exposure", o->view.exposure, "stops, for .png and .jpg");
    c->add_option("--isa", o->isa, "instructions to use")->check(CLI::IsMember({"sse4", "avx2", "avx512"}));
    add_texture_options(*c);
    c->add_option("--texture-filter", o->texture_filter, "image textures by the ray's footprint; default: the scene's")->check(CLI::IsMember({"on", "off"}));
    c->add_option("--noise-filter", o->noise_filter, "noise finer than the ray's footprint fades; default: the scene's")->check(CLI::IsMember({"on", "off"}));
    c->add_flag("--strict", o->strict, "textures that are missing or broken are errors");
    c->add_flag("--lenient", o->lenient, "unknown members and parameters are warnings");
    c->add_flag("--progress", o->progress, "lines \"progress 0.43\" on stderr, for programs");
    c->add_flag("--quiet", o->quiet, "errors only");
    return [o] { return run(*o); };
}

}  // namespace alder::cli
