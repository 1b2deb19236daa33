// alder ci: renders the cases of a suite and holds them against their references; reports for people and for CI systems.
//
// Exit status: 0 all within limits; 1 a picture differs; 2 the suite is wrong; 3 a render did not finish; 130 interrupted.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>

#include <fmt/format.h>

#include "clients/cli/ci/child.h"
#include "clients/cli/ci/report.h"
#include "clients/cli/ci/suite.h"
#include "clients/cli/common.h"
#include "clients/cli/compare/junit.h"
#include "graph/digest.h"
#include "render/image/exr.h"

namespace alder::cli {
namespace {

namespace fs = std::filesystem;

struct Options {
    std::string suite, junit, report, only, shard, reason;
    int threads = 0;
    float heat_range = 0.5f;
    bool update = false, json = false, quiet = false, no_flip = false;
};

/// The report's folder, or one that is removed in the end.
class Folder {
  public:
    explicit Folder(const std::string& wanted) : path_(wanted), keep_(!wanted.empty()) {
        std::error_code code;
        if (keep_) {
            fs::create_directories(path_, code);
            if (code) fail(kMachineFailed, path_ + ": " + code.message());
            return;
        }
        std::string name = (fs::temp_directory_path() / "alder-ci-XXXXXX").string();
        if (!mkdtemp(name.data())) fail(kMachineFailed, "no temporary folder can be made");
        path_ = name;
    }
    ~Folder() {
        std::error_code code;
        if (!keep_) fs::remove_all(path_, code);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    std::string file(const std::string& name) const { return (fs::path(path_) / name).string(); }

  private:
    std::string path_;
    bool keep_;
};

/// A case's name as that of a file.
std::string file_name(const std::string& name) {
    std::string out;
    for (const char c : name) out += std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' || c == '.' ? c : '_';
    return out == name && out[0] != '.' ? out : out + "-" + sha256_hex(name).substr(0, 8);
}

std::string last_line(std::string text) {
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
    const size_t line = text.rfind('\n');
    return line == std::string::npos ? text : text.substr(line + 1);
}

std::string bytes_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

class CiRun {
  public:
    CiRun(const Options& o, const Suite& suite) : o_(o), suite_(suite), folder_(o.report) {}

    int run() {
        for (const SuiteCase* c : chosen()) {
            results_.push_back(one(*c));
            const CaseResult& r = results_.back();
            if (!o_.json && !o_.quiet) print(r);
            if (interrupted_) break;
        }
        write_reports();
        if (o_.json) print_json();
        if (interrupted_) return kInterrupted;
        const bool errors = std::any_of(results_.begin(), results_.end(), [](const CaseResult& r) { return !r.error.empty(); });
        const bool good = std::all_of(results_.begin(), results_.end(), [](const CaseResult& r) { return r.good(); });
        return good ? kDone : errors ? (wrong_ ? kWrong : kMachineFailed) : kCheckFailed;
    }

  private:
    std::vector<const SuiteCase*> chosen() const {
        std::vector<const SuiteCase*> cases;
        for (const SuiteCase& c : suite_.cases)
            if (o_.only.empty() || matches(o_.only, c.name)) cases.push_back(&c);
        if (cases.empty()) fail(kWrong, fmt::format("--only {}: no case of {} is called so", o_.only, o_.suite));
        if (o_.shard.empty()) return cases;
        int i = 0, n = 0;
        char end = 0;
        if (std::sscanf(o_.shard.c_str(), "%d/%d%c", &i, &n, &end) != 2 || i < 1 || n < 1 || i > n) fail(kWrong, "--shard " + o_.shard + ": expected i/n with i from 1 to n");
        std::vector<const SuiteCase*> part;
        for (size_t k = size_t(i) - 1; k < cases.size(); k += size_t(n)) part.push_back(cases[k]);
        return part;   // may be empty: there are more shards than cases
    }

    CaseResult one(const SuiteCase& c) {
        CaseResult r{c.name, c.scene, c.reference, folder_.file(file_name(c.name) + ".exr"), 0, 0, 0, {}, false, {}};
        const std::string stats = folder_.file(file_name(c.name) + ".stats.json");
        std::vector<std::string> arguments{c.is_graph ? "preview" : "render", c.scene, "-o", r.image, "--stats", stats, "--quiet"};
        arguments.insert(arguments.end(), c.arguments.begin(), c.arguments.end());
        if (o_.threads > 0) arguments.insert(arguments.end(), {"--threads", std::to_string(o_.threads)});
        const ChildResult child = run_self(arguments);
        r.seconds = child.seconds;
        if (child.status == kInterrupted) interrupted_ = true;
        if (child.status != 0) {
            wrong_ = wrong_ || child.status == kWrong;
            r.error = fmt::format("the render ended with status {}{}", child.status, child.errors.empty() ? "" : ": " + last_line(child.errors));
            return r;
        }
        const nlohmann::json read = nlohmann::json::parse(bytes_of(stats), nullptr, false);
        if (read.is_object()) {
            r.samples = read.value("samples", 0);
            r.render_seconds = read.value("/seconds/render"_json_pointer, 0.0);
        }
        compare(c, r);
        if (o_.update && !r.good() && child.status == 0) update(c, r);
        return r;
    }

    void compare(const SuiteCase& c, CaseResult& r) {
        std::string error;
        const auto test = read_exr(r.image, error);
        if (!test) {
            r.error = error;
            return;
        }
        if (!fs::exists(c.reference)) {
            r.error = c.reference + ": there is no such reference; make it with --update --reason TEXT";
            wrong_ = true;
            return;
        }
        const auto reference = read_exr(c.reference, error);
        if (!reference) {
            r.error = error;
            wrong_ = true;
            return;
        }
        for (const auto& [layer, limits] : c.layers) {
            LayerResult l;
            l.layer = layer;
            l.limits = limits;
            std::vector<float> map;
            CompareOptions options;
            options.flip = !o_.no_flip || std::any_of(limits.begin(), limits.end(), [](const Limit& x) { return x.figure == "flip"; });
            l.figures = compare_layer(*test, *reference, layer, options, error, &map);
            if (!l.figures) l.failure = layer + ": " + error;
            else
                for (const Limit& limit : limits)
                    if (const std::string what = check_limit(*l.figures, limit); !what.empty()) l.failure += (l.failure.empty() ? "" : "\n") + what;
            if (!o_.report.empty()) {
                const std::string base = file_name(c.name) + "." + file_name(layer);
                l.test = write_png(layer_png(*test, layer, error), base + ".result.png");
                l.reference = write_png(layer_png(*reference, layer, error), base + ".reference.png");
                if (!map.empty()) l.map = write_png(heat_map_png(map, test->width, test->height, o_.heat_range, error), base + ".difference.png");
            }
            r.layers.push_back(std::move(l));
        }
    }

    std::string write_png(const std::vector<uint8_t>& png, const std::string& name) {
        if (png.empty()) return {};
        write_bytes(folder_.file(name), png.data(), png.size());
        return name;
    }

    /// The result becomes the reference; who changed it and why stays beside the suite.
    void update(const SuiteCase& c, CaseResult& r) {
        const std::string result = bytes_of(r.image);
        const bool replaces = fs::exists(c.reference);
        const nlohmann::json entry{{"case", c.name}, {"reference", fs::path(c.reference).filename().string()}, {"sha256", sha256_hex(result)},
                                   {"previous_sha256", replaces ? nlohmann::json(sha256_hex(bytes_of(c.reference))) : nlohmann::json()}, {"reason", o_.reason}, {"alder", ALDER_VERSION}};
        std::error_code code;
        if (const fs::path folder = fs::path(c.reference).parent_path(); !folder.empty()) fs::create_directories(folder, code);
        write_bytes(c.reference, result.data(), result.size());
        const std::string history = o_.suite + ".history.jsonl";
        const std::string lines = bytes_of(history) + entry.dump() + "\n";
        write_bytes(history, lines.data(), lines.size());
        r.error.clear();
        for (LayerResult& l : r.layers) l.failure.clear();
        r.updated = true;
    }

    static void print(const CaseResult& r) {
        fmt::print("{:<6} {} ({:.1f} s)\n", r.updated ? "update" : r.good() ? "good" : r.error.empty() ? "FAIL" : "ERROR", r.name, r.seconds);
        if (!r.error.empty()) fmt::print("       {}\n", r.error);
        for (const LayerResult& l : r.layers)
            if (!l.failure.empty()) fmt::print("       {}\n", l.failure);
        std::fflush(stdout);
    }

    void write_reports() const {
        if (!o_.report.empty()) {
            const std::string html = report_html(suite_.name, results_);
            write_bytes(folder_.file("index.html"), html.data(), html.size());
        }
        if (o_.junit.empty()) return;
        std::vector<JunitCase> cases;
        for (const CaseResult& r : results_) {
            const JunitCase base{r.name, r.seconds, {}, r.error, {}, {{"samples", std::to_string(r.samples)}, {"render_seconds", fmt::format("{:.3f}", r.render_seconds)}, {"alder", ALDER_VERSION}}, {}};
            if (r.layers.empty()) cases.push_back(base);
            for (const LayerResult& l : r.layers) {
                JunitCase one = base;
                one.name = r.name + " " + l.layer;
                one.failure = l.failure;
                if (l.figures) {
                    const nlohmann::json figures = l.figures->json();
                    for (const std::string& name : figure_names()) one.properties.emplace_back(name, figures[name].dump());
                }
                for (const std::string& file : {l.test, l.reference, l.map})
                    if (!file.empty()) one.attachments.push_back(fs::absolute(folder_.file(file)).string());
                cases.push_back(std::move(one));
            }
        }
        const std::string xml = junit_xml(suite_.name, cases);
        write_bytes(o_.junit, xml.data(), xml.size());
    }

    void print_json() const {
        nlohmann::json items = nlohmann::json::array();
        for (const CaseResult& r : results_) {
            nlohmann::json layers = nlohmann::json::array();
            for (const LayerResult& l : r.layers) {
                nlohmann::json layer = l.figures ? l.figures->json() : nlohmann::json{{"layer", l.layer}};
                layer["failure"] = l.failure.empty() ? nlohmann::json() : nlohmann::json(l.failure);
                layers.push_back(std::move(layer));
            }
            items.push_back({{"name", r.name}, {"passed", r.good()}, {"updated", r.updated}, {"error", r.error.empty() ? nlohmann::json() : nlohmann::json(r.error)},
                             {"seconds", r.seconds}, {"samples", r.samples}, {"layers", layers}});
        }
        fmt::print("{}\n", nlohmann::json{{"suite", suite_.name}, {"cases", items}}.dump());
    }

    const Options& o_;
    const Suite& suite_;
    Folder folder_;
    std::vector<CaseResult> results_;
    bool interrupted_ = false, wrong_ = false;
};

int run(const Options& o) {
    if (o.update && o.reason.empty()) fail(kWrong, "--update needs --reason TEXT: why the pictures may change");
    Diagnostics d;
    const Suite suite = read_suite(read_json_file(o.suite), o.suite, d);
    report(o.suite, d);
    return CiRun(o, suite).run();
}

}  // namespace

Run add_ci(CLI::App& app) {
    auto o = std::make_shared<Options>();
    CLI::App* c = app.add_subcommand("ci", "render a suite and hold it against its references");
    c->add_option("SUITE", o->suite, "a suite of cases (.json)")->required();
    c->add_option("--junit", o->junit, "write a JUnit report here (.xml)");
    c->add_option("--report", o->report, "write index.html with pictures into this folder");
    c->add_option("--only", o->only, "pattern (* ? [..]) of the cases to run");
    c->add_option("--shard", o->shard, "i/n: every n-th case, beginning with the i-th");
    c->add_option("--threads", o->threads, "0 = all processors")->check(CLI::Range(0, 1024));
    c->add_option("--heat-range", o->heat_range, "the value that is white in the maps of differences")->check(CLI::Range(1e-6f, 1e6f))->capture_default_str();
    CLI::Option* update = c->add_flag("--update", o->update, "results that differ become the references");
    c->add_option("--reason", o->reason, "with --update: why; kept beside the suite in SUITE.history.jsonl")->needs(update);
    c->add_flag("--no-flip", o->no_flip, "without FLIP where no limit asks for it");
    c->add_flag("--json", o->json, "results as JSON");
    c->add_flag("--quiet", o->quiet, "errors only");
    return [o] { return run(*o); };
}

}  // namespace alder::cli
