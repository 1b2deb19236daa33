// alder diff: how far one image is from another, in figures, with limits for CI. Exit status 1 where a limit is passed.
#include <cstdio>
#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "clients/cli/common.h"
#include "clients/cli/compare/figures.h"
#include "clients/cli/compare/junit.h"
#include "graph/json_text.h"
#include "render/image/exr.h"

namespace alder::cli {
namespace {

struct Options {
    std::string test, reference, junit, heat_map;
    std::vector<std::string> layers, limits;
    CompareOptions compare;
    float heat_range = 0.5f;
    bool json = false, no_flip = false, quiet = false;
};

Image read(const std::string& file) {
    std::string error;
    auto image = read_exr(file, error);
    if (!image) fail(kWrong, error.find(file) == std::string::npos ? file + ": " + error : error);
    return std::move(*image);
}

std::vector<Limit> parse_limits(const std::vector<std::string>& texts) {
    std::vector<Limit> limits;
    for (const std::string& text : texts) {
        const size_t equals = text.find('=');
        Diagnostics d;
        const auto value = equals == std::string::npos ? std::optional<nlohmann::json>(text == "exact" ? nlohmann::json(true) : nlohmann::json()) : parse_json(text.substr(equals + 1), JsonLimits{}, d);
        std::string error;
        const auto limit = limit_from_json(text.substr(0, equals), value ? *value : nlohmann::json(text.substr(equals + 1)), error);
        if (!limit) fail(kWrong, "--limit " + text + ": " + error);
        limits.push_back(*limit);
    }
    return limits;
}

/// Layers that both images have, under one name.
std::vector<std::string> common_layers(const Image& a, const Image& b) {
    std::vector<std::string> names;
    std::string ignored;
    if (!find_layer(a, "beauty", ignored).planes.empty() && !find_layer(b, "beauty", ignored).planes.empty()) names.push_back("beauty");
    for (const Layer& l : a.layers)
        if (!l.name.empty() && b.find(l.name)) names.push_back(l.name);
    return names;
}

void print(const Figures& f) {
    const auto line = [](const char* name, const std::string& value) { fmt::print("{:<16} {}\n", name, value); };
    if (f.layer != "beauty") line("layer", f.layer);
    for (const std::string& name : figure_names()) {
        if (name == "exact") {
            line("exact", f.exact ? "yes" : "no");
        } else if (name == "nonfinite") {
            line("nonfinite", fmt::format("{} (reference {})", f.nonfinite, f.reference_nonfinite));
        } else if (const auto value = f.value(name)) {
            line(name.c_str(), name == "max_abs" ? fmt::format("{:.6g} at ({}, {})", *value, f.worst_x, f.worst_y) : fmt::format("{:.6g}", *value));
        } else {
            line(name.c_str(), name == "sigma" ? "- (" + f.no_sigma + ")" : "-");
        }
    }
}

int run(const Options& o) {
    const std::vector<Limit> limits = parse_limits(o.limits);
    const Image test = read(o.test), reference = read(o.reference);
    std::vector<std::string> layers = o.layers;
    if (layers.empty()) layers = {"beauty"};
    if (layers == std::vector<std::string>{"all"}) layers = common_layers(test, reference);
    if (layers.empty()) fail(kWrong, o.test + " and " + o.reference + " have no layer in common");
    CompareOptions compare = o.compare;
    compare.flip = !o.no_flip;
    bool good = true;
    nlohmann::json all = nlohmann::json::array();
    std::vector<JunitCase> cases;
    for (const std::string& layer : layers) {
        std::string error;
        std::vector<float> map;
        const auto figures = compare_layer(test, reference, layer, compare, error, o.heat_map.empty() || layer != layers.front() ? nullptr : &map);
        if (!figures) fail(kWrong, fmt::format("{} and {}: {}", o.test, o.reference, error));
        std::string passed;
        for (const Limit& limit : limits)
            if (const std::string what = check_limit(*figures, limit); !what.empty()) passed += (passed.empty() ? "" : "\n") + what;
        good = good && passed.empty();
        if (!map.empty()) {
            const auto png = heat_map_png(map, test.width, test.height, o.heat_range, error);
            if (png.empty()) fail(kMachineFailed, o.heat_map + ": " + error);
            write_bytes(o.heat_map, png.data(), png.size());
        }
        nlohmann::json entry = figures->json();
        JunitCase test_case{std::filesystem::path(o.test).filename().string() + " " + layer, 0, passed, {}, {}, {}, {}};
        for (const std::string& name : figure_names()) test_case.properties.emplace_back(name, entry[name].dump());
        test_case.attachments = {o.test, o.reference};
        if (!o.heat_map.empty()) test_case.attachments.push_back(o.heat_map);
        cases.push_back(std::move(test_case));
        entry["passed"] = passed.empty();
        all.push_back(std::move(entry));
        if (!o.json && !o.quiet) print(*figures);
        if (!passed.empty() && !o.json) std::fprintf(stderr, "alder: %s\n", passed.c_str());
    }
    if (!o.junit.empty()) {
        const std::string xml = junit_xml("alder diff", cases);
        write_bytes(o.junit, xml.data(), xml.size());
    }
    if (o.json) fmt::print("{}\n", (all.size() == 1 ? all[0] : all).dump());
    return good ? kDone : kCheckFailed;
}

}  // namespace

Run add_diff(CLI::App& app) {
    auto o = std::make_shared<Options>();
    CLI::App* c = app.add_subcommand("diff", "how far one image is from another");
    c->add_option("A", o->test, "the image to judge (.exr)")->required();
    c->add_option("B", o->reference, "the reference (.exr)")->required();
    c->add_option("--layer", o->layers, "beauty (default), the name of a layer, a channel (beauty.A), or all; repeatable")->allow_extra_args(false);
    c->add_option("--limit", o->limits, "FIGURE=VALUE: rmse, relmse, relmse_trimmed, flip, max_abs, bias, nonfinite, sigma; or exact; repeatable")->allow_extra_args(false);
    c->add_option("--epsilon", o->compare.epsilon, "added to the square of the reference in relmse")->check(CLI::Range(1e-12, 1e12))->capture_default_str();
    c->add_option("--trim", o->compare.trim, "share of the pixels left out of relmse_trimmed")->check(CLI::Range(0.0, 0.99))->capture_default_str();
    c->add_flag("--no-flip", o->no_flip, "without FLIP, which takes most of the time");
    c->add_option("--heat-map", o->heat_map, "write where the first layer differs here (.png)");
    c->add_option("--heat-range", o->heat_range, "the value that is white in the heat map")->check(CLI::Range(1e-6f, 1e6f))->capture_default_str();
    c->add_option("--junit", o->junit, "write a JUnit report here (.xml)");
    c->add_flag("--json", o->json, "figures as JSON");
    c->add_flag("--quiet", o->quiet, "only what passes a limit");
    return [o] { return run(*o); };
}

}  // namespace alder::cli
