// Times of the graph compiler and executor on this machine, as JSON on stdout: compiling a large graph, re-specialising after one
// constant changed, and points per second of the benchmark graphs for each instruction set.
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <time.h>
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
    nodes["surface"] = {{"type", "alSurface"}, {"params", {{"specular1Roughness", {{"node", last}, {"output", (count - 2) % 8 == 0 ? "Fac" : "Value"}}}, {"diffuseStrength", 0.7}}}};
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

double processor_now(clockid_t clock) {
    timespec t;
    clock_gettime(clock, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

json attribute(const char* name) { return {{"attribute", name}}; }
json value_of(const std::string& node) { return {{"node", node}, {"output", "Value"}}; }

/// `count` nodes in a row that end in NAME(count-1).Value: one noise, then arithmetic, again and again.
json row(const std::string& name, int count, json nodes = json::object()) {
    for (int i = 0; i < count; ++i) {
        const json last = i == 0 ? attribute("x") : value_of(name + std::to_string(i - 1));
        json& n = nodes[name + std::to_string(i)];
        if (i % 10 == 0) n = {{"type", "ShaderNodeTexWhiteNoise"}, {"params", {{"noise_dimensions", "1D"}, {"W", last}}}};
        else n = {{"type", "ShaderNodeMath"}, {"params", {{"operation", i % 2 ? "MULTIPLY" : "SINE"}, {"Value", last}, {"Value_001", 1.5 + i * 0.01}}}};
    }
    return nodes;
}

/// Processor seconds of one evaluation of `output` at the points `x`, the least of many.
double evaluation_seconds(const json& nodes, const std::string& output, const std::vector<float>& x, int repeat) {
    Diagnostics d;
    const auto material = build_material({{"nodes", nodes}}, {}, d);
    const auto program = material ? material->program({.outputs = {output}}, d) : nullptr;
    if (print_faults(d) || !program) std::exit(2);
    const EvalContext context;
    Executor<float> executor(context);
    std::vector<float> padded = x;
    padded.resize(x.size() + 2 * kPadding, 0.5f);
    double least = 1e9;
    for (int k = 0; k < repeat; ++k) {
        const double start = processor_now(CLOCK_THREAD_CPUTIME_ID);
        for (uint32_t i = 0; i < x.size(); i += program->batch()) {
            std::vector<Channel<float>> in;
            for (const auto& input : program->inputs()) in.insert(in.end(), input.channels, {padded.data() + i, 1});
            executor.run(*program, std::min<uint32_t>(program->batch(), static_cast<uint32_t>(x.size()) - i), in);
        }
        least = std::min(least, processor_now(CLOCK_THREAD_CPUTIME_ID) - start);
    }
    return least;
}

/// What is not needed costs nothing: ratios, 1 (or 0.5) being the aim. And compile times by size.
int evaluator_figures(json& out, int repeat) {
    for (int count : {10, 100, 1000, 10000}) {
        const json graph = large_graph(count);
        double least = 1e9;
        for (int k = 0; k < std::max(3, repeat / 3); ++k) {
            Diagnostics d;
            const double start = processor_now(CLOCK_PROCESS_CPUTIME_ID);
            const auto material = build_material(graph, {}, d);
            if (!material || !material->program({.surface = LobeFilter::Surface}, d)) return print_faults(d), 2;
            least = std::min(least, processor_now(CLOCK_PROCESS_CPUTIME_ID) - start);
        }
        out["compile_us_per_node"][std::to_string(count)] = least / count * 1e6;
    }
    std::vector<float> x(16384);
    for (size_t i = 0; i < x.size(); ++i) x[i] = 0.1f + 0.8f * static_cast<float>(i) / static_cast<float>(x.size());
    const int times = 20 * repeat;
    const double ten = evaluation_seconds(row("n", 10), "n9.Value", x, times);
    out["ten_of_1000_nodes"] = evaluation_seconds(row("n", 1000), "n9.Value", x, times) / ten;

    json branches = row("a", 40, row("b", 40));
    branches["switch"] = {{"type", "alSwitchFloat"}, {"params", {{"inputA", value_of("a39")}, {"inputB", value_of("b39")}, {"mix", 0}}}};
    const double alone = evaluation_seconds(branches, "a39.Value", x, times);
    out["constant_switch"] = evaluation_seconds(branches, "switch", x, times) / alone;
    branches["switch"]["params"]["mix"] = attribute("x");
    branches["switch"]["params"]["threshold"] = 1.0;   // 0 ... 1 rounds down: the first branch at every point
    out["varying_switch"] = evaluation_seconds(branches, "switch", x, times) / alone;

    json mix = row("a", 40);
    mix["mix"] = {{"type", "ShaderNodeMix"}, {"params", {{"data_type", "FLOAT"}, {"Factor_Float", attribute("x")}, {"A_Float", 0.5}, {"B_Float", value_of("a39")}}}};
    const double full = evaluation_seconds(mix, "mix.Result_Float", x, times);
    for (size_t run : {1, 16, 256, 8192}) {
        std::vector<float> half = x;
        for (size_t i = 0; i < half.size(); ++i)
            if (i / run % 2) half[i] = 0;
        out["mix_half_zero"][std::to_string(run)] = evaluation_seconds(mix, "mix.Result_Float", half, times) / full;
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) return std::fprintf(stderr, "usage: graph_bench FOLDER-OF-GRAPHS [--quick]\n"), 2;
    const bool quick = argc > 2 && std::string(argv[2]) == "--quick";
    json out = json::object();
    if (const int status = compile_figures(out, quick ? 5 : 31)) return status;
    if (const int status = evaluator_figures(out["evaluator"], quick ? 3 : 15)) return status;
    if (const int status = throughput(out, argv[1], 65536, quick ? 3 : 11)) return status;
    std::printf("%s\n", out.dump().c_str());
    return 0;
}
