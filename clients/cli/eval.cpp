// alder eval: outputs of a graph at given points, with no scene.
#include <cstdio>
#include <memory>

#include "clients/cli/common.h"
#include "graph/program.h"
#include "graph/report.h"
#include "render/evaluate.h"

namespace alder::cli {
namespace {

struct Options {
    std::string file = "-", isa, precision = "float";
    bool stats = false;
    int repeat = 1, threads = 0;
};

std::string join(const std::string& folder_of, const std::string& name) {
    const size_t slash = folder_of.rfind('/');
    return name.empty() || name[0] == '/' || slash == std::string::npos ? name : folder_of.substr(0, slash + 1) + name;
}

nlohmann::json evaluate(const nlohmann::json& request, const Options& o, const std::string& pointer, MaterialCache& cache, Diagnostics& d) {
    EvaluateOptions options;
    options.precision = o.precision == "double" ? EvaluateOptions::Precision::Double : EvaluateOptions::Precision::Float;
    options.scalar = o.isa == "scalar";
    options.stats = o.stats;
    options.repeat = o.repeat;
    options.threads = o.threads;
    options.pointer_prefix = pointer;
    options.material.resolve_image = image_resolver(o.file);
    options.points.resolve_file = [&](const std::string& name, std::string&) { return join(o.file, name); };
    options.cache = &cache;
    if (request.is_object())
        if (const auto it = request.find("lenient"); it != request.end() && it->is_boolean()) options.material.lenient = it->get<bool>();
    return evaluate_request(request, options, d);
}

int run(const Options& o) {
    if (!o.isa.empty() && o.isa != "scalar" && !choose_isa(o.isa)) fail(kWrong, "this processor has no " + o.isa);
    if (o.isa == "scalar" && o.precision == "double") fail(kWrong, "--isa scalar means single precision: double is scalar anyway");
    const nlohmann::json request = read_json_file(o.file);
    MaterialCache cache;
    const auto print = [](const nlohmann::json& j, const char* end) {
        const std::string text = j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
        std::fwrite(text.data(), 1, text.size(), stdout);
        std::fputs(end, stdout);
    };
    if (request.is_array()) {
        // One answer a request, in order; a wrong one gets its own error and the others are answered all the same.
        std::fputs("[", stdout);
        for (size_t i = 0; i < request.size(); ++i) {
            Diagnostics d;
            nlohmann::json answer = evaluate(request[i], o, "", cache, d);
            if (!d.ok() || answer.is_null()) {
                answer = {{"error", {{"detail", d.errors.empty() ? "" : d.errors.front().line()}, {"errors", to_json(d.errors)}}}};
                if (!d.warnings.empty()) answer["error"]["warnings"] = to_json(d.warnings);
            }
            print(answer, i + 1 < request.size() ? ",\n" : "");
        }
        std::fputs("]\n", stdout);
    } else {
        Diagnostics d;
        const nlohmann::json answer = evaluate(request, o, "", cache, d);
        report(o.file, d);
        print(answer, "\n");
    }
    if (std::fflush(stdout) != 0 || std::ferror(stdout)) fail(kMachineFailed, "the answer could not be written");
    return kDone;
}

}  // namespace

Run add_eval(CLI::App& app) {
    auto o = std::make_shared<Options>();
    CLI::App* c = app.add_subcommand("eval", "outputs of a graph at given points, with no scene");
    c->add_option("REQUEST", o->file, "a request or an array of them; - is standard input")->capture_default_str();
    c->add_option("--isa", o->isa, "instructions to use; default: the best of this processor")->check(CLI::IsMember({"scalar", "sse4", "avx2", "avx512"}));
    c->add_option("--precision", o->precision, "double is the accuracy reference")->check(CLI::IsMember({"float", "double"}))->capture_default_str();
    c->add_flag("--stats", o->stats, "add what was evaluated and what was skipped");
    c->add_option("--repeat", o->repeat, "evaluate N times, for timing")->check(CLI::Range(1, 1000000))->capture_default_str();
    c->add_option("--threads", o->threads, "0 = all processors")->check(CLI::Range(0, 1024))->capture_default_str();
    add_texture_options(*c);
    return [o] { return run(*o); };
}

}  // namespace alder::cli
