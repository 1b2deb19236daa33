// The optimiser: what a constant switches off is not built, what no lane needs is not run, and values stay the same.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/graph/test_nodes.h"

namespace alder::test {
namespace {

using nlohmann::json;

json x() { return {{"attribute", "x"}}; }
json link(const char* n) { return {{"node", n}}; }

std::vector<float> ramp(int n, float lo, float hi) {
    std::vector<float> v(n);
    for (int i = 0; i < n; ++i) v[i] = lo + (hi - lo) * i / (n - 1);
    return v;
}

json mix_graph(json factor) {
    return {{"nodes",
             {{"p", {{"type", "TestProbe"}, {"params", {{"input", x()}}}}},
              {"r", {{"type", "TestReciprocal"}, {"params", {{"input", x()}}}}},
              {"m", {{"type", "TestMix"}, {"params", {{"mix", factor}, {"a", link("r")}, {"b", link("p")}}}}}}}};
}

TEST(Compiler, constant_mix_keeps_one_side) {
    for (double f : {0.0, 1.0}) {
        Diagnostics d;
        const auto m = material(mix_graph(f), d);
        ASSERT_TRUE(m) << (d.errors.empty() ? "" : d.errors[0].line());
        const auto p = m->program({.outputs = {"m"}}, d);
        ASSERT_TRUE(p);
        EXPECT_EQ(p->stats().live_nodes, 2) << p->dump();
        EXPECT_EQ(p->stats().skipped.size(), 1u) << p->dump();
        EXPECT_EQ(p->stats().regions, 0);
        const auto v = run(*m, "m", {0.25f, 4.0f});
        EXPECT_FLOAT_EQ(v[0], f == 0 ? 4.0f : 0.5f);
        EXPECT_FLOAT_EQ(v[1], f == 0 ? 0.25f : 8.0f);
    }
}

TEST(Compiler, lanes_that_do_not_need_a_branch_do_not_run_it) {
    // Factor = x, clamped by the test itself: 10 % of the lanes have x > 0.
    Diagnostics d;
    const auto m = material(mix_graph(x()), d);
    ASSERT_TRUE(m);
    std::vector<float> xs(1000);
    for (int i = 0; i < 1000; ++i) xs[i] = i % 10 == 3 ? 0.5f : 0.0f;
    probe_points() = 0;
    const auto v = run(*m, "m", xs);
    // x = 0 makes 1/x infinite: the side with weight 0 must not leak it.
    for (int i = 0; i < 1000; ++i) {
        const float want = xs[i] == 0 ? INFINITY : 0.5f * 2.0f + 0.5f * 1.0f;
        EXPECT_EQ(v[i], want) << i;
    }
    EXPECT_LE(probe_points(), 100u + 16 * 8) << "only the active lanes, and padding";
    EXPECT_GE(probe_points(), 100u);
}

TEST(Compiler, no_active_lane_skips_the_region) {
    Diagnostics d;
    const auto m = material(mix_graph(x()), d);
    ASSERT_TRUE(m);
    probe_points() = 0;
    const auto v = run(*m, "m", std::vector<float>(512, -1.0f));
    EXPECT_EQ(probe_points(), 0u);
    for (float f : v) EXPECT_FLOAT_EQ(f, 2.0f * -1.0f);  // (1+1) * (1/-1) - 0
}

TEST(Compiler, lazy_values_do_not_depend_on_batch_size_or_position) {
    Diagnostics d;
    const auto m = material(mix_graph(x()), d);
    ASSERT_TRUE(m);
    const auto xs = ramp(777, -0.5f, 1.5f);
    const auto whole = run(*m, "m", xs);
    for (uint32_t batch : {1u, 3u, 16u, 17u, 64u}) {
        const auto part = run(*m, "m", xs, batch);
        for (size_t i = 0; i < xs.size(); ++i) ASSERT_EQ(part[i], whole[i]) << "batch " << batch << " point " << i;
    }
}

TEST(Compiler, equal_nodes_are_evaluated_once) {
    Diagnostics d;
    const json p = {{"type", "TestProbe"}, {"params", {{"input", x()}}}};
    const auto m = material({{"nodes", {{"p1", p}, {"p2", p}, {"m", {{"type", "TestMix"}, {"params", {{"mix", 0.5}, {"a", link("p1")}, {"b", link("p2")}}}}}}}}, d);
    ASSERT_TRUE(m);
    const auto program = m->program({.outputs = {"m"}}, d);
    EXPECT_EQ(program->stats().merged, 1) << program->dump();
    EXPECT_EQ(program->stats().ops, 2) << program->dump();
}

TEST(Compiler, constants_fold) {
    Diagnostics d;
    const auto m = material({{"nodes", {{"p", {{"type", "TestProbe"}, {"params", {{"input", 3}}}}}, {"q", {{"type", "TestProbe"}, {"params", {{"input", link("p")}}}}}}}}, d);
    ASSERT_TRUE(m);
    const auto program = m->program({.outputs = {"q"}}, d);
    EXPECT_EQ(program->stats().ops, 0) << program->dump();
    EXPECT_TRUE(program->facts().spatially_constant);
    EXPECT_FLOAT_EQ(run(*m, "q", {0})[0], 12.0f);
}

json layers(json factor, double black = 0.8) {
    return {{"nodes",
             {{"p", {{"type", "TestProbe"}, {"params", {{"input", x()}}}}},
              {"a", {{"type", "TestDiffuse"}, {"params", {{"sigma", link("p")}}}}},
              {"b", {{"type", "TestDiffuse"}, {"params", {{"color", {black, black, black}}, {"sigma", 0.25}}}}},
              {"m", {{"type", "TestMixClosure"}, {"params", {{"mix", factor}, {"a", link("a")}, {"b", link("b")}}}}}}},
            {"outputs", {{"surface", link("m")}}}};
}

TEST(Compiler, closures_with_weight_zero_are_not_there) {
    Diagnostics d;
    auto p = material(layers(1.0), d)->program({.surface = LobeFilter::Surface}, d);
    EXPECT_EQ(p->lobes().size(), 1u) << p->dump();
    EXPECT_EQ(p->stats().ops, 0) << p->dump();
    p = material(layers(0.5, 0.0), d)->program({.surface = LobeFilter::Surface}, d);
    EXPECT_EQ(p->lobes().size(), 1u) << "the black lobe is gated\n" << p->dump();
    p = material(layers(0.5), d)->program({.surface = LobeFilter::Surface}, d);
    EXPECT_EQ(p->lobes().size(), 2u) << p->dump();
    p = material(layers(0.5), d)->program({.surface = LobeFilter::Emission}, d);
    EXPECT_EQ(p->lobes().size(), 0u) << p->dump();
    EXPECT_EQ(p->stats().ops, 0) << p->dump();
}

TEST(Compiler, closures_are_evaluated_where_their_weight_is_not_zero) {
    Diagnostics d;
    const auto m = material(layers(x()), d);
    const auto p = m->program({.surface = LobeFilter::Surface}, d);
    ASSERT_EQ(p->lobes().size(), 2u);
    std::vector<float> xs(300);
    for (int i = 0; i < 300; ++i) xs[i] = i % 10 == 7 ? 0.75f : 1.0f;  // weight of "a" is 1 - x
    probe_points() = 0;
    std::vector<std::vector<float>> weight, sigma;
    for (const auto& l : p->lobes()) {
        weight.push_back(run(*p, l.register_first, xs));
        sigma.push_back(run(*p, l.register_first + 6, xs));
    }
    EXPECT_LE(probe_points(), 4 * (30u + 16 * 4));
    const int a = p->lobes()[0].node == "a" ? 0 : 1;
    for (int i = 0; i < 300; ++i) {
        EXPECT_NEAR(weight[a][i], (1 - xs[i]) * 0.8f, 1e-6f);
        EXPECT_NEAR(weight[1 - a][i], xs[i] * 0.8f, 1e-6f);
        EXPECT_FLOAT_EQ(sigma[a][i], xs[i] == 1 ? 0.0f : 1.5f);
    }
}

TEST(Compiler, a_closure_reached_twice_is_emitted_once) {
    Diagnostics d;
    json nodes = {{"l0", {{"type", "TestDiffuse"}, {"params", {{"sigma", x()}}}}}};
    for (int i = 1; i <= 60; ++i) {
        const auto below = "l" + std::to_string(i - 1);
        nodes["l" + std::to_string(i)] = {{"type", "TestMixClosure"}, {"params", {{"mix", 0.25}, {"a", {{"node", below}}}, {"b", {{"node", below}}}}}};
    }
    const auto m = material({{"nodes", nodes}, {"outputs", {{"surface", link("l60")}}}}, d);
    ASSERT_TRUE(m);
    const auto p = m->program({.surface = LobeFilter::Surface}, d);
    ASSERT_EQ(p->lobes().size(), 1u);
    EXPECT_NEAR(run(*p, p->lobes()[0].register_first, {0.5f})[0], 0.8f, 1e-5f);
}

TEST(Compiler, closure_aovs_blend_like_the_closures) {
    Diagnostics d;
    const auto m = material(layers(0.25), d);
    const auto p = m->program({.aovs = {"sigma_aov"}}, d);
    const auto v = run(*p, p->outputs()[0].register_first, {2.0f});
    EXPECT_NEAR(v[0], 0.75f * 4.0f + 0.25f * 0.25f, 1e-6f);
}

TEST(Material, an_edit_gives_what_a_rebuild_gives) {
    Diagnostics d;
    const auto base = material(layers(0.5), d);
    base->program({.surface = LobeFilter::Surface}, d);
    for (double f : {0.25, 0.75, 0.0, 1.0, 0.5}) {
        const auto edited = base->with_param("/nodes/m/params/mix", f, d);
        const auto rebuilt = material(layers(f), d);
        ASSERT_TRUE(edited && rebuilt);
        EXPECT_EQ(edited->document(), rebuilt->document());
        EXPECT_EQ(edited->digest(), rebuilt->digest());
        const auto p = edited->program({.surface = LobeFilter::Surface}, d), q = rebuilt->program({.surface = LobeFilter::Surface}, d);
        ASSERT_EQ(p->lobes().size(), q->lobes().size()) << f;
        for (size_t l = 0; l < p->lobes().size(); ++l)
            for (int c = 0; c < 7; ++c)
                EXPECT_EQ(run(*p, p->lobes()[l].register_first + c, {0.3f, 0.6f}), run(*q, q->lobes()[l].register_first + c, {0.3f, 0.6f})) << f;
        EXPECT_EQ(p->stats().compile_seconds == base->program({.surface = LobeFilter::Surface}, d)->stats().compile_seconds, f != 0 && f != 1)
            << "a value that keeps the structure compiles nothing; " << f;
    }
}

TEST(Material, shared_constants_split_when_one_is_edited) {
    Diagnostics d;
    const json g = {{"nodes",
                     {{"a", {{"type", "TestMix"}, {"params", {{"mix", 0.5}, {"a", x()}}}}},
                      {"b", {{"type", "TestMix"}, {"params", {{"mix", 0.5}, {"a", x()}}}}},
                      {"m", {{"type", "TestMix"}, {"params", {{"mix", 0.5}, {"a", link("a")}, {"b", link("b")}}}}}}}};
    const auto base = material(g, d);
    EXPECT_EQ(run(*base, "m", {2.0f})[0], 1.5f);
    const auto edited = base->with_param("/nodes/b/params/mix", 0.25, d);
    EXPECT_EQ(run(*edited, "m", {2.0f})[0], 0.5f * 1.5f + 0.5f * 1.75f);
    EXPECT_EQ(run(*base, "m", {2.0f})[0], 1.5f) << "the base is untouched";
}

TEST(Material, faults_of_an_edit_have_their_pointer) {
    Diagnostics d;
    const auto base = material(layers(0.5), d);
    EXPECT_FALSE(base->with_param("/nodes/m/params/mix", "half", d));
    ASSERT_EQ(d.errors.size(), 1u);
    EXPECT_EQ(d.errors[0].pointer, "/nodes/m/params/mix");
    d = {};
    EXPECT_FALSE(base->with_param("/nodes/m/params/nix", 1, d));
    EXPECT_EQ(d.errors.size(), 1u);
}

TEST(MaterialCache, same_content_is_compiled_once) {
    MaterialCache cache(2);
    Diagnostics d;
    const auto a = cache.get(layers(0.5), {}, d);
    EXPECT_EQ(cache.get(layers(0.5), {}, d), a);
    EXPECT_EQ(cache.counters().hits, 1u);
    cache.get(layers(0.1), {}, d);
    cache.get(layers(0.2), {}, d);
    EXPECT_EQ(cache.counters().entries, 2u);
    EXPECT_NE(cache.get(layers(0.5), {}, d), a) << "the oldest has left";
}

TEST(Compiler, a_chain_of_ten_thousand_nodes_compiles) {
    json nodes;
    for (int i = 0; i < 10000; ++i)
        nodes["n" + std::to_string(i)] = {{"type", "TestMix"}, {"params", {{"mix", 0.5}, {"a", i == 0 ? x() : json{{"node", "n" + std::to_string(i - 1)}}}}}};
    Diagnostics d;
    const auto m = material({{"nodes", nodes}}, d);
    ASSERT_TRUE(m) << d.errors[0].line();
    EXPECT_NEAR(run(*m, "n9999", {5.0f})[0], 1.0f, 1e-5f);
}

}  // namespace
}  // namespace alder::test
