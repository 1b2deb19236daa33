// Times of the graph compiler and executor on this machine, as JSON on stdout: compiling a large graph, re-specialising after one
// constant changed, and points per second of the benchmark graphs for each instruction set.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "graph/material.h"
#include "graph/program.h"
#include "render/evaluate.h"

using namespace alder;
using nlohmann::json;

namespace {

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

double median(std::vector<double> v) {
    std::sort(v.begin(), v.end());
    return v.empty() ? 0 : v[v.size() / 2];
}

/// A chain of noise and arithmetic of `count` nodes in all, as wide graphs of production look: nothing folds away.
json large_graph(int count) {
    json nodes = json::object();
    std::string last;
    for (int i = 0; i + 1 < count; ++i) {
        const std::string name = fmt::format("n{}", i);
        const json link = {{"node", last}, {"output", (i - 1) % 8 == 0 ? "Fac" : "Value"}};
        if (i % 8 == 0) {
            nodes[name] = {{"type", "ShaderNodeTexNoise"}, {"params", {{"Scale", 1.0 + i * 0.37}, {"Detail", 3.0}}}};
        } else {
            static const char* const kOperations[] = {"MULTIPLY", "ADD", "SUBTRACT", "MAXIMUM", "SINE", "MULTIPLY_ADD", "POWER"};
            nodes[name] = {{"type", "ShaderNodeMath"},
                           {"params", {{"operation", kOperations[i % 7]}, {"Value", link}, {"Value_001", 0.9 + i * 1e-3}, {"Value_002", 0.1}}}};
        }
        if (i % 8 == 0 && !last.empty()) nodes[name]["params"]["Distortion"] = link;
        last = name;
    }
    nodes["surface"] = {{"type", "alSurface"}, {"params", {{"specular1Roughness", {{"node", last}}}, {"diffuseStrength", 0.7}}}};   // alShaders' links need no output
    return {{"version", 1}, {"nodes", nodes}, {"outputs", {{"surface", {{"node", "surface"}}}}}};
}

bool print_faults(const Diagnostics& d) {
    for (const auto& e : d.errors) std::fprintf(stderr, "graph_bench: %s\n", e.line().c_str());
    return !d.ok();
}

int compile_figures(json& out, int repeat) {
    const json graph = large_graph(200);
    const ProgramRequest request{.surface = LobeFilter::Surface};
    std::vector<double> cold, edit, recompile;
    int instructions = 0;
    for (int i = 0; i < repeat; ++i) {
        Diagnostics d;
        const double start = now();
        const auto material = build_material(graph, {}, d);
        const auto program = material ? material->program(request, d) : nullptr;
        cold.push_back(now() - start);
        if (!program) return print_faults(d), 2;
        instructions = program->stats().ops;
        // A slider: one constant takes a value that no assumption of the compiled form depends on.
        const double dragged = now();
        const auto edited = material->with_param("/nodes/surface/params/diffuseStrength", 0.5 + 1e-3 * i, d);
        const auto same = edited ? edited->program(request, d) : nullptr;
        edit.push_back(now() - dragged);
        // And one that changes what is live.
        const double switched = now();
        const auto pruned = material->with_param("/nodes/surface/params/diffuseStrength", 0.0, d);
        const auto other = pruned ? pruned->program(request, d) : nullptr;
        recompile.push_back(now() - switched);
        if (!same || !other) return print_faults(d), 2;
    }
    out["compile_200_nodes_ms"] = median(cold) * 1e3;
    out["compile_200_nodes_instructions"] = instructions;
    out["edit_constant_ms"] = median(edit) * 1e3;
    out["edit_recompile_ms"] = median(recompile) * 1e3;
    return 0;
}

int throughput(json& out, const std::string& folder, int points, int repeat) {
    json positions = json::array();
    uint32_t state = 1;
    const auto uniform = [&] { return static_cast<double>((state = state * 1664525u + 1013904223u) >> 8) / (1 << 24) * 2 - 1; };
    for (int i = 0; i < points; ++i) positions.push_back({uniform(), uniform(), uniform()});
    for (const char* name : {"noise", "noise_fac", "graph30"}) {
        std::ifstream file(folder + "/" + name + ".graph.json");
        const json graph = json::parse(std::string(std::istreambuf_iterator<char>(file), {}), nullptr, false);
        if (graph.is_discarded()) return std::fprintf(stderr, "graph_bench: %s/%s.graph.json cannot be read\n", folder.c_str(), name), 2;
        const json source = graph["outputs"]["aovs"]["color"];
        const json request = {{"graph", graph}, {"points", {{"count", points}, {"P", positions}}}, {"outputs", {source["node"].get<std::string>() + "." + source["output"].get<std::string>()}}};
        for (const char* isa : {"scalar", "sse4", "avx2", "avx512"}) {
            const bool scalar = std::string(isa) == "scalar";
            if (!choose_isa(scalar ? "" : isa)) continue;
            EvaluateOptions options;
            options.scalar = scalar;
            options.stats = true;
            options.threads = 1;
            options.repeat = repeat;
            Diagnostics d;
            const json answer = evaluate_request(request, options, d);
            if (answer.is_null()) return print_faults(d), 2;
            out["points_per_second"][name][isa] = points / answer["stats"]["seconds"].get<double>();
        }
        choose_isa("");
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) return std::fprintf(stderr, "usage: graph_bench FOLDER-OF-GRAPHS [--quick]\n"), 2;
    const bool quick = argc > 2 && std::string(argv[2]) == "--quick";
    json out = json::object();
    if (const int status = compile_figures(out, quick ? 5 : 31)) return status;
    if (const int status = throughput(out, argv[1], 65536, quick ? 3 : 11)) return status;
    std::printf("%s\n", out.dump().c_str());
    return 0;
}
