// Sample numbers: uniform, stratified, independent between pixels and sets, and a function of their key alone.
#include "render/sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace alder {
namespace {

/// Owen-scrambled Sobol pairs (0,1) and (2,3): every elementary interval of 2^k points holds exactly one.
TEST(Sampler, first_pairs_are_nets_in_base_2) {
    for (const uint32_t pixel : {0u, 17u})
        for (const auto& [a, b] : {std::pair{0, 1}})
            for (int k = 0; k <= 8; ++k) {
                const int n = 1 << k;
                for (int split = 0; split <= k; ++split) {
                    std::set<std::pair<int, int>> cells;
                    for (int i = 0; i < n; ++i) {
                        const Sample4 s = sample_set(sample_key(1, pixel, 5, i), 3);
                        cells.insert({int(s.u[a] * (1 << split)), int(s.u[b] * (1 << (k - split)))});
                    }
                    EXPECT_EQ(cells.size(), size_t(n)) << "2^" << k << " points, split " << split << ", pixel " << pixel;
                }
            }
}

TEST(Sampler, every_dimension_is_stratified_and_every_aligned_block) {
    for (int block = 0; block < 4; ++block)
        for (int d = 0; d < 4; ++d) {
            std::set<int> cells;
            for (int i = 0; i < 64; ++i) {
                const float u = sample_set(sample_key(9, 3, 4, 64 * block + i), 12).u[d];
                ASSERT_GE(u, 0);
                ASSERT_LT(u, 1);
                cells.insert(int(u * 64));
            }
            EXPECT_EQ(cells.size(), 64u) << "dimension " << d << " block " << block;
        }
}

TEST(Sampler, pixels_sets_and_seeds_are_uncorrelated) {
    const int n = 4096;
    const auto correlation = [&](auto first, auto second) {
        double sxy = 0, sx = 0, sy = 0, sxx = 0, syy = 0;
        for (int i = 0; i < n; ++i) {
            const double x = first(i), y = second(i);
            sx += x, sy += y, sxy += x * y, sxx += x * x, syy += y * y;
        }
        return (sxy / n - sx / n * sy / n) / std::sqrt((sxx / n - sx / n * sx / n) * (syy / n - sy / n * sy / n));
    };
    const auto at = [](uint32_t seed, uint32_t x, uint32_t y, int i, uint32_t set) { return sample_set(sample_key(seed, x, y, i), set).u[0]; };
    const double limit = 5 / std::sqrt(double(n));
    EXPECT_LT(std::abs(correlation([&](int i) { return at(0, 1, 1, i, 2); }, [&](int i) { return at(0, 1, 1, i, 3); })), limit) << "sets";
    EXPECT_LT(std::abs(correlation([&](int i) { return at(0, 1, 1, i, 2); }, [&](int i) { return at(0, 2, 1, i, 2); })), limit) << "pixels";
    EXPECT_LT(std::abs(correlation([&](int i) { return at(0, 1, 1, i, 2); }, [&](int i) { return at(1, 1, 1, i, 2); })), limit) << "seeds";
    // The first sample of neighbouring pixels: no pattern over an image at one sample a pixel.
    EXPECT_LT(std::abs(correlation([&](int i) { return at(0, i % 64, i / 64, 0, 2); }, [&](int i) { return at(0, i % 64 + 1, i / 64, 0, 2); })), limit) << "image";
}

TEST(Sampler, mean_of_a_smooth_function_converges_faster_than_random) {
    // Integral of exp(x + y) over the unit square is (e - 1)^2. Random points would be off by some 1e-2 with 4096 samples.
    double sum = 0;
    for (int i = 0; i < 4096; ++i) {
        const Sample4 s = sample_set(sample_key(3, 8, 8, i), 6);
        sum += std::exp(s.u[0] + s.u[1]);
    }
    EXPECT_NEAR(sum / 4096, std::pow(std::exp(1.0) - 1, 2), 2e-4);
}

}  // namespace
}  // namespace alder
