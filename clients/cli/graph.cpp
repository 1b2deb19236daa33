// alder graph: what the optimiser makes of a network: as text, or as a drawing for Graphviz.
#include <cstdio>
#include <memory>

#include "clients/cli/common.h"
#include "graph/report.h"

namespace alder::cli {
namespace {

struct Options {
    std::string file, ray = "camera";
    std::vector<std::string> outputs;
    bool dump = false, dot = false, lenient = false;
};

int run(const Options& o) {
    Diagnostics d;
    MaterialOptions options;
    options.lenient = o.lenient;
    options.resolve_image = image_resolver(o.file);
    const auto material = build_material(read_graph_file(o.file), options, d);
    report(o.file, d);
    ProgramRequest request;
    if (!o.outputs.empty()) {
        request.outputs = o.outputs;
    } else {
        request = everything(*material);
        if (o.ray == "shadow") request = {.surface = LobeFilter::Transparency | LobeFilter::Shadow};
        if (o.ray == "emission") request = {.surface = LobeFilter::Emission};
        if (request == ProgramRequest{}) fail(kWrong, o.file + ": the graph has no outputs; name one: --output NODE.OUTPUT");
    }
    d = {};
    const auto program = material->program(request, d);
    report(o.file, d);
    const std::string text = o.dot ? program_dot(*program) : program->dump();
    std::fwrite(text.data(), 1, text.size(), stdout);
    if (std::fflush(stdout) != 0 || std::ferror(stdout)) fail(kMachineFailed, "the answer could not be written");
    return kDone;
}

}  // namespace

Run add_graph(CLI::App& app) {
    auto o = std::make_shared<Options>();
    CLI::App* c = app.add_subcommand("graph", "what the optimiser makes of a graph");
    c->add_option("GRAPH", o->file, "a graph document; - is standard input")->required();
    CLI::Option* dump = c->add_flag("--dump", o->dump, "the program as text (default): what became of each node, instructions, lobes");
    c->add_flag("--dot", o->dot, "the network and the program as Graphviz text")->excludes(dump);
    CLI::Option* output = c->add_option("--output", o->outputs, "NODE.OUTPUT: the program for this alone; may be repeated");
    c->add_option("--ray", o->ray, "which program of the surface")->check(CLI::IsMember({"camera", "shadow", "emission"}))->excludes(output)->capture_default_str();
    c->add_flag("--lenient", o->lenient, "unknown parameters are warnings");
    return [o] { return run(*o); };
}

}  // namespace alder::cli
