// What evaluation costs, by counting: only what is needed runs. ./dev bench prints the same figures as times.
#include <gtest/gtest.h>

#include <ctime>

#include "tests/graph/test_nodes.h"

namespace alder::test {
namespace {

using nlohmann::json;

json x() { return {{"attribute", "x"}}; }
json link(const std::string& n) { return {{"node", n}}; }
json probe(json input) { return {{"type", "TestProbe"}, {"params", {{"input", std::move(input)}}}}; }

/// Probes in a row: NAME0 ... NAME(count-1).
json chain(const std::string& name, int count, json nodes = json::object()) {
    for (int i = 0; i < count; ++i) nodes[name + std::to_string(i)] = probe(i == 0 ? x() : link(name + std::to_string(i - 1)));
    return nodes;
}

ExecStats cost(const json& nodes, const std::string& output, const std::vector<float>& xs) {
    Diagnostics d;
    const auto m = material({{"nodes", nodes}}, d);
    const auto p = m ? m->program({.outputs = {output}}, d) : nullptr;
    EXPECT_TRUE(p) << (d.errors.empty() ? "" : d.errors[0].line());
    if (!p) return {};
    const EvalContext context;
    Executor<float> executor(context);
    std::vector<float> padded = xs;
    padded.resize(xs.size() + 2 * kPadding, 0.5f);
    for (uint32_t i = 0; i < xs.size(); i += p->batch()) {
        std::vector<Channel<float>> in(p->inputs().empty() ? 0 : 1, Channel<float>{padded.data() + i, 1});
        executor.run(*p, std::min<uint32_t>(p->batch(), static_cast<uint32_t>(xs.size()) - i), in);
    }
    return executor.stats();
}

TEST(Figures, ten_nodes_of_a_thousand_cost_what_ten_cost) {
    const std::vector<float> xs(1024, 0.5f);
    const auto of_many = cost(chain("n", 1000), "n9", xs), alone = cost(chain("n", 10), "n9", xs);
    EXPECT_EQ(of_many.evaluations, alone.evaluations);
    EXPECT_EQ(of_many.evaluations, 10u * 1024);
}

TEST(Figures, the_selected_branch_of_a_switch_costs_what_it_costs_alone) {
    json nodes = chain("a", 10, chain("b", 50));
    nodes["s"] = {{"type", "alSwitchFloat"}, {"params", {{"inputA", link("a9")}, {"inputB", link("b49")}, {"mix", 0}, {"threshold", 0.5}}}};
    const std::vector<float> xs(1024, 0.25f);
    const auto alone = cost(nodes, "a9", xs);
    EXPECT_LE(cost(nodes, "s", xs).evaluations, alone.evaluations + 1024) << "a constant index leaves the branch and at most the switch itself";
    nodes["s"]["params"]["mix"] = x();
    const auto varying = cost(nodes, "s", xs);  // 0.25 at every point: the first branch
    EXPECT_LE(varying.evaluations, alone.evaluations + 1024 * 12) << "the switch itself and its questions, whatever the other branch costs";
    EXPECT_GE(varying.skipped, 40u * 1024) << "ten of its nodes are equal to nodes of the first";
}

TEST(Figures, a_mix_that_is_zero_on_half_of_the_points_costs_half) {
    json nodes = chain("a", 20);
    nodes["m"] = {{"type", "TestMix"}, {"params", {{"mix", x()}, {"a", 1}, {"b", link("a19")}}}};
    for (int run : {1, 5, 64, 1024}) {
        std::vector<float> xs(4096);
        for (size_t i = 0; i < xs.size(); ++i) xs[i] = i / run % 2 ? 0.0f : 0.5f;
        const uint64_t before = probe_points();
        cost(nodes, "m", xs);
        EXPECT_NEAR(static_cast<double>(probe_points() - before), 20 * 2048.0, 20 * 2048 * 0.02) << "runs of " << run;
    }
}

TEST(Figures, branches_in_branches_are_bounded) {
    // Each level of 3,000 needs the next one on some points only: as deep as the executor may recurse, no deeper.
    json nodes = {{"m0", probe(x())}};
    for (int i = 1; i < 3000; ++i) nodes["m" + std::to_string(i)] = {{"type", "TestMix"}, {"params", {{"mix", x()}, {"a", 0.5}, {"b", link("m" + std::to_string(i - 1))}}}};
    Diagnostics d;
    const auto m = material({{"nodes", nodes}}, d);
    ASSERT_TRUE(m);
    EXPECT_EQ(run(*m, "m2999", {0.0f, 1.0f}), (std::vector<float>{0.5f, 2.0f}));
    EXPECT_LE(m->program({.outputs = {"m2999"}}, d)->stats().regions, 16);
}

/// Processor seconds for reading and compiling `graph`, the least of three.
double compile_seconds(const json& graph, const ProgramRequest& request) {
    double least = 1e9;
    for (int k = 0; k < 3; ++k) {
        const std::clock_t start = std::clock();
        Diagnostics d;
        const auto m = material(graph, d);
        EXPECT_TRUE(m && m->program(request, d)) << (d.errors.empty() ? "" : d.errors[0].line());
        least = std::min(least, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    }
    return least;
}

TEST(Figures, compiling_is_linear) {
    // Ten times the nodes may take thirty times as long here (other programs disturb); what is quadratic takes a hundred times.
    const auto expect_linear = [](const char* what, json (*graph)(int)) {
        const auto last = [](int n) { return "n" + std::to_string(n - 1); };
        const double hundreds = compile_seconds(graph(900), {.outputs = {last(900)}}), all = compile_seconds(graph(9000), {.outputs = {last(9000)}});
        EXPECT_LE(all, 30 * hundreds) << what << ": 900 nodes " << hundreds << " s, 9,000 nodes " << all << " s";
    };
    expect_linear("a chain", [](int n) { return json{{"nodes", chain("n", n)}}; });
    expect_linear("equal constants that fold", [](int n) {
        json nodes;
        for (int i = 0; i < n; ++i)
            nodes["n" + std::to_string(i)] = {{"type", "TestMix"}, {"params", {{"mix", x()}, {"a", i == 0 ? x() : link("n" + std::to_string(i - 1))}, {"b", link("c" + std::to_string(i % 8))}}}};
        for (int i = 0; i < 8; ++i) nodes["c" + std::to_string(i)] = probe(1.0);
        return json{{"nodes", nodes}};
    });
    expect_linear("branches in branches", [](int n) {
        json nodes = {{"n0", probe(x())}};
        for (int i = 1; i < n; ++i) nodes["n" + std::to_string(i)] = {{"type", "TestMix"}, {"params", {{"mix", x()}, {"a", 0.5}, {"b", link("n" + std::to_string(i - 1))}}}};
        return json{{"nodes", nodes}};
    });
    expect_linear("many that nothing asks for", [](int n) {
        json nodes = chain("unused", n - 10);
        for (int i = 0; i < 10; ++i) nodes["n" + std::to_string(n - 10 + i)] = probe(i == 0 ? x() : link("n" + std::to_string(n - 11 + i)));
        return json{{"nodes", nodes}};
    });
}

}  // namespace
}  // namespace alder::test
