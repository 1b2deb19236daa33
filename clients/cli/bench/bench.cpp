// alder bench: error against time over a row of sample counts: settings side by side, and Cycles and Mitsuba where they are.
//
// All of it in one run, with the same number of threads, sample count by sample count, so that what else the machine does meets
// all sides alike. Times are of preparing and rendering (Alder: build, compile, render; Cycles: its render call; Mitsuba: its
// render call), without loading and writing files. Efficiency is 1 / (trimmed relMSE x seconds).
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>

#include <fmt/format.h>

#include "clients/cli/bench/plot.h"
#include "clients/cli/ci/child.h"
#include "clients/cli/common.h"
#include "clients/cli/compare/figures.h"
#include "render/image/exr.h"

namespace alder::cli {
namespace {

namespace fs = std::filesystem;

struct Options {
    std::string scene, reference, svg, cycles, mitsuba, resolution;
    std::vector<int> samples{4, 16, 64};
    std::vector<std::string> variants;
    int threads = 2, reference_factor = 16, repeat = 1;
    bool json = false;
};

struct Measure {
    int samples = 0;
    double seconds = 0;
    Figures figures;
};
struct Series {
    std::string name, kind;   ///< kind: alder, cycles, mitsuba
    std::vector<std::string> arguments;
    std::vector<Measure> measures;
};

/// "NAME: --option value ...": words are split at spaces; quotes keep them together.
Series parse_variant(const std::string& text) {
    const size_t colon = text.find(':');
    if (colon == std::string::npos || colon == 0) fail(kWrong, "--variant " + text + ": expected NAME: OPTIONS of alder render");
    Series s{text.substr(0, colon), "alder", {}, {}};
    std::string word;
    bool quoted = false, any = false;
    for (size_t i = colon + 1; i <= text.size(); ++i) {
        const char c = i < text.size() ? text[i] : ' ';
        if (c == '"') {
            quoted = !quoted;
            any = true;
        } else if (c == ' ' && !quoted) {
            if (any || !word.empty()) s.arguments.push_back(word);
            word.clear();
            any = false;
        } else {
            word += c;
        }
    }
    if (quoted) fail(kWrong, "--variant " + text + ": a quotation mark without its end");
    return s;
}

std::string driver(const std::string& name) {
    std::error_code code;
    const fs::path program = fs::read_symlink("/proc/self/exe", code);
    for (const fs::path& place : {program.parent_path() / "../share/alder/bench" / name, fs::path(ALDER_SOURCE_DIR) / "clients/bench" / name})
        if (fs::is_regular_file(place, code)) return place.string();
    fail(kWrong, name + " is not beside the program");
}

class Bench {
  public:
    explicit Bench(const Options& o) : o_(o) {
        std::string name = (fs::temp_directory_path() / "alder-bench-XXXXXX").string();
        if (!mkdtemp(name.data())) fail(kMachineFailed, "no temporary folder can be made");
        folder_ = name;
    }
    ~Bench() {
        std::error_code code;
        fs::remove_all(folder_, code);
    }
    Bench(const Bench&) = delete;
    Bench& operator=(const Bench&) = delete;

    int run() {
        series_.push_back({"alder", "alder", {}, {}});
        for (const std::string& v : o_.variants) series_.push_back(parse_variant(v));
        if (!o_.cycles.empty()) series_.push_back({"Cycles", "cycles", {}, {}});
        if (!o_.mitsuba.empty()) series_.push_back({"Mitsuba", "mitsuba", {}, {}});
        const Image reference = read(o_.reference.empty() ? make_reference() : o_.reference);
        if (!o_.json) fmt::print("{:<16} {:>8} {:>9} {:>11} {:>11} {:>11}\n", "", "samples", "seconds", "relMSE", "trimmed", "efficiency");
        for (const int samples : o_.samples)
            for (Series& s : series_) measure(s, samples, reference);
        if (!o_.svg.empty()) write_plot();
        if (o_.json) print_json();
        else print_ratios();
        return kDone;
    }

  private:
    Image read(const std::string& path) const {
        std::string error;
        auto image = read_exr(path, error);
        if (!image) fail(kWrong, error);
        return std::move(*image);
    }

    std::string make_reference() const {
        const int samples = o_.reference_factor * *std::max_element(o_.samples.begin(), o_.samples.end());
        const std::string path = (folder_ / "reference.exr").string();
        std::vector<std::string> arguments{"render", o_.scene, "-o", path, "--samples", std::to_string(samples), "--seed", "12345", "--quiet"};
        if (!o_.resolution.empty()) arguments.insert(arguments.end(), {"--resolution", o_.resolution});
        if (!o_.json) fmt::print(stderr, "alder: the reference: {} samples\n", samples);
        check(run_self(arguments), "the reference");
        return path;
    }

    void check(const ChildResult& child, const std::string& what) const {
        if (child.status == 0) return;
        std::string why = child.errors;
        while (!why.empty() && why.back() == '\n') why.pop_back();
        if (const size_t line = why.rfind('\n'); line != std::string::npos) why = why.substr(line + 1);
        fail(child.status == kWrong ? kWrong : child.status == kInterrupted ? kInterrupted : kMachineFailed, fmt::format("{} ended with status {}: {}", what, child.status, why));
    }

    double render(const Series& s, int samples, const std::string& out) const {
        const std::string stats = (folder_ / "stats.json").string();
        const std::string n = std::to_string(samples), threads = std::to_string(o_.threads);
        if (s.kind == "alder") {
            std::vector<std::string> arguments{"render", o_.scene, "-o", out, "--samples", n, "--threads", threads, "--stats", stats, "--quiet"};
            if (!o_.resolution.empty()) arguments.insert(arguments.end(), {"--resolution", o_.resolution});
            arguments.insert(arguments.end(), s.arguments.begin(), s.arguments.end());
            check(run_self(arguments), s.name);
        } else {
            const char* variable = s.kind == "cycles" ? "ALDER_BPY_PYTHON" : "ALDER_MITSUBA_PYTHON";
            const char* python = std::getenv(variable);
            std::vector<std::string> arguments{driver(s.kind + "_bench.py"), s.kind == "cycles" ? o_.cycles : o_.mitsuba, "-o", out, "--samples", n, "--threads", threads, "--stats", stats};
            if (!o_.resolution.empty()) arguments.insert(arguments.end(), {"--resolution", o_.resolution});
            check(run_program(python && *python ? python : "python3", arguments), fmt::format("{} (its Python: {})", s.name, variable));
        }
        std::ifstream file(stats);
        const nlohmann::json j = nlohmann::json::parse(file, nullptr, false);
        const nlohmann::json seconds = j.is_object() ? j.value("seconds", nlohmann::json::object()) : nlohmann::json::object();
        return seconds.value("build", 0.0) + seconds.value("compile", 0.0) + seconds.value("render", 0.0);
    }

    void measure(Series& s, int samples, const Image& reference) {
        const std::string out = (folder_ / "out.exr").string();
        std::vector<double> times;
        for (int i = 0; i < o_.repeat; ++i) times.push_back(render(s, samples, out));
        std::sort(times.begin(), times.end());
        CompareOptions options;
        options.flip = false;
        std::string error;
        auto figures = compare_layer(read(out), reference, "beauty", options, error);
        if (!figures) fail(kWrong, s.name + ": " + error);
        s.measures.push_back({samples, times[times.size() / 2], std::move(*figures)});
        const Measure& m = s.measures.back();
        if (!o_.json) fmt::print("{:<16} {:>8} {:>9.3f} {:>11.4g} {:>11.4g} {:>11.4g}\n", s.name, samples, m.seconds, *m.figures.relmse, *m.figures.relmse_trimmed, efficiency(m));
        std::fflush(stdout);
    }

    static double efficiency(const Measure& m) {
        const double product = m.figures.relmse_trimmed.value_or(0) * m.seconds;
        return product > 0 ? 1 / product : 0;
    }

    /// Geometric mean of the ratios of efficiency at equal places of the row.
    static double ratio(const Series& a, const Series& b) {
        double sum = 0;
        int n = 0;
        for (size_t i = 0; i < std::min(a.measures.size(), b.measures.size()); ++i)
            if (efficiency(a.measures[i]) > 0 && efficiency(b.measures[i]) > 0) {
                sum += std::log(efficiency(a.measures[i]) / efficiency(b.measures[i]));
                ++n;
            }
        return n ? std::exp(sum / n) : 0;
    }

    void print_ratios() const {
        for (size_t i = 1; i < series_.size(); ++i)
            fmt::print("time to equal error: alder is {:.2f} x as fast as {}\n", ratio(series_[0], series_[i]), series_[i].name);
    }

    void write_plot() const {
        std::vector<PlotSeries> lines;
        for (const Series& s : series_) {
            PlotSeries line{s.name, {}};
            for (const Measure& m : s.measures) line.points.push_back({m.seconds, m.figures.relmse_trimmed.value_or(0), fmt::format("{} samples", m.samples)});
            lines.push_back(std::move(line));
        }
        const std::string svg = log_log_svg(fmt::format("{}: error against time, {} threads", fs::path(o_.scene).filename().string(), o_.threads), "seconds", "relMSE without the worst 0.1 %", lines);
        write_bytes(o_.svg, svg.data(), svg.size());
    }

    void print_json() const {
        nlohmann::json all = nlohmann::json::array();
        for (const Series& s : series_) {
            nlohmann::json measures = nlohmann::json::array();
            for (const Measure& m : s.measures) {
                nlohmann::json j = m.figures.json();
                j["samples"] = m.samples;
                j["seconds"] = m.seconds;
                j["efficiency"] = efficiency(m);
                measures.push_back(std::move(j));
            }
            all.push_back({{"name", s.name}, {"kind", s.kind}, {"arguments", s.arguments}, {"measures", measures}, {"alder_is_faster_by", ratio(series_[0], s)}});
        }
        fmt::print("{}\n", nlohmann::json{{"scene", o_.scene}, {"threads", o_.threads}, {"series", all}}.dump());
    }

    const Options& o_;
    fs::path folder_;
    std::vector<Series> series_;
};

}  // namespace

Run add_bench(CLI::App& app) {
    auto o = std::make_shared<Options>();
    CLI::App* c = app.add_subcommand("bench", "error against time over a row of sample counts");
    c->add_option("SCENE", o->scene, "a scene as alder render takes it")->required();
    c->add_option("--samples", o->samples, "the row, by commas")->delimiter(',')->check(CLI::Range(1, 1 << 20))->capture_default_str();
    c->add_option("--reference", o->reference, "an .exr of high quality; default: rendered first");
    c->add_option("--reference-factor", o->reference_factor, "samples of that reference over the most of the row")->check(CLI::Range(1, 4096))->capture_default_str();
    c->add_option("--variant", o->variants, "\"NAME: OPTIONS\": a line of its own with further options of alder render; repeatable")->allow_extra_args(false);
    c->add_option("--cycles", o->cycles, "FILE.blend: the same scene for Cycles, in the Python of $ALDER_BPY_PYTHON");
    c->add_option("--mitsuba", o->mitsuba, "FILE.xml: the same scene for Mitsuba 3, in the Python of $ALDER_MITSUBA_PYTHON");
    c->add_option("--resolution", o->resolution, "WIDTHxHEIGHT");
    c->add_option("--threads", o->threads, "of all sides")->check(CLI::Range(1, 1024))->capture_default_str();
    c->add_option("--repeat", o->repeat, "renders of each; the median time counts")->check(CLI::Range(1, 100))->capture_default_str();
    c->add_option("--svg", o->svg, "write the plot here");
    c->add_flag("--json", o->json, "figures as JSON");
    return [o] { return Bench(*o).run(); };
}

}  // namespace alder::cli
