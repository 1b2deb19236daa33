// The film's tree of sums: any cut into passes gives the same bits, and rows combine by their rules.
#include "render/film.h"

#include <gtest/gtest.h>

#include <bit>
#include <random>

namespace alder {
namespace {

float sample_value(uint64_t i) { return 0.001f + static_cast<float>((i * 2654435761u) % 100003) * 1e-3f; }

/// Renders samples [first, last) of one "pixel" into leaves and commits them as the given runs of leaves.
Film film_of(const AovPlan& plan, std::initializer_list<std::pair<uint64_t, uint64_t>> runs) {
    Film film(plan, 1);
    for (const auto& [first, leaves] : runs) {
        std::vector<std::vector<float>> levels;
        std::vector<float> sum(plan.film_row());
        for (uint64_t k = 0; k < leaves; ++k) {
            LeafSum leaf(plan);
            leaf.clear();
            for (uint64_t i = 0; i < kLeafSamples; ++i) {
                std::vector<float> row(plan.row());
                plan.clear(row.data());
                row[0] = sample_value((first + k) * kLeafSamples + i);
                leaf.add(row.data());
            }
            leaf.finish((first + k) & 1, kLeafSamples, sum.data());
            const size_t height = std::countr_one(k);
            levels.resize(std::max(levels.size(), height + 1));
            for (size_t l = 0; l < height; ++l) combine_rows(plan, levels[l].data(), sum.data(), sum.data());
            levels[height] = sum;
        }
        film.pass_rows() = sum;
        film.commit(first, leaves, leaves * kLeafSamples);
    }
    return film;
}

TEST(Film, any_cut_into_aligned_passes_gives_the_same_bits) {
    const AovPlan plan({"quality", "half_b"}, {});
    const std::vector<float> whole = film_of(plan, {{0, 64}}).total();
    EXPECT_EQ(whole, film_of(plan, {{0, 1}, {1, 1}, {2, 2}, {4, 4}, {8, 8}, {16, 16}, {32, 32}}).total());
    EXPECT_EQ(whole, film_of(plan, {{0, 32}, {32, 16}, {48, 8}, {56, 4}, {60, 2}, {62, 1}, {63, 1}}).total());
    EXPECT_EQ(film_of(plan, {{0, 4}, {4, 2}, {6, 1}}).total(), film_of(plan, {{0, 1}, {1, 1}, {2, 2}, {4, 1}, {5, 1}, {6, 1}}).total());
}

TEST(Film, total_is_close_to_a_double_sum) {
    const AovPlan plan({}, {});
    double sum = 0;
    for (uint64_t i = 0; i < 256 * kLeafSamples; ++i) sum += sample_value(i);
    EXPECT_NEAR(film_of(plan, {{0, 256}}).total()[0], sum, 3e-7 * sum);
}

TEST(Film, minima_and_firsts) {
    const AovPlan plan({"Z", "id_object"}, {});
    LeafSum leaf(plan);
    leaf.clear();
    std::vector<float> row(plan.row());
    const auto add = [&](float z, float id) {
        plan.clear(row.data());
        if (id >= 0) {
            row[plan.z] = z;
            row[plan.id_object] = id;
        }
        leaf.add(row.data());
    };
    add(0, -1);  // hits nothing
    add(5, 3);
    add(2, 8);
    std::vector<float> out(plan.film_row());
    leaf.finish(false, 3, out.data());
    const auto layers = plan.layers({out, 3, 0}, 1);
    EXPECT_EQ(layers[1].name, "Z");
    EXPECT_EQ(layers[1].planes[0][0], 2);
    EXPECT_EQ(layers[2].planes[0][0], 3) << "the earliest sample that hit something names the object";
}

TEST(Film, half_b_holds_the_odd_leaves) {
    const AovPlan plan({"half_b"}, {});
    const std::vector<float> rows = film_of(plan, {{0, 4}}).total();
    double odd = 0;
    for (uint64_t leaf : {1, 3})
        for (uint64_t i = 0; i < kLeafSamples; ++i) odd += sample_value(leaf * kLeafSamples + i);
    EXPECT_NEAR(plan.layers({rows, 64, 4}, 1)[1].planes[0][0], odd / 32, 1e-6 * odd / 32);
}

TEST(Film, variance_of_the_mean_of_independent_samples) {
    // Pseudo-random, not stratified: both estimates must give sigma^2 / n.
    const AovPlan plan({"variance"}, {});
    std::mt19937 rng(1);
    std::uniform_real_distribution<float> u(0, 1);
    for (const int leaves : {4, 4096}) {
        std::vector<float> total(plan.film_row(), 0.f), one(plan.film_row());
        for (int k = 0; k < leaves; ++k) {
            LeafSum leaf(plan);
            leaf.clear();
            for (uint32_t i = 0; i < kLeafSamples; ++i) {
                std::vector<float> row(plan.row());
                plan.clear(row.data());
                row[0] = u(rng);
                leaf.add(row.data());
            }
            leaf.finish(k & 1, kLeafSamples, one.data());
            combine_rows(plan, total.data(), one.data(), total.data());
        }
        const double expected = 1.0 / 12 / (leaves * 16);
        const float variance = plan.layers({total, uint64_t(leaves) * 16, uint64_t(leaves)}, 1)[1].planes[0][0];
        EXPECT_NEAR(variance, expected, 0.3 * expected) << leaves << " leaves";
    }
}

}  // namespace
}  // namespace alder
