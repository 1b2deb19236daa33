// Hashes and Perlin noise: known values, lattice zeros, period, continuity, coordinates of any size.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "nodes/noise/fractal-inl.h"

namespace alder::HWY_NAMESPACE {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity(), kNan = std::numeric_limits<float>::quiet_NaN();

template <int D, class F>
Coord<D, F> point(F x, F y = 0, F z = 0, F w = 0) {
    const F all[4] = {x, y, z, w};
    Coord<D, F> p;
    for (int i = 0; i < D; ++i) p.c[i] = all[i];
    return p;
}
template <int D>
float noise(float x, float y = 0, float z = 0, float w = 0) { return signed_noise(point<D>(x, y, z, w)); }

TEST(Hash, of_words_is_lookup3) {
    // The last rounds as lookup3.c writes them.
    auto final_round = [](uint32_t a, uint32_t b, uint32_t c) {
        auto rot = [](uint32_t x, int k) { return (x << k) | (x >> (32 - k)); };
        c ^= b; c -= rot(b, 14); a ^= c; a -= rot(c, 11); b ^= a; b -= rot(a, 25); c ^= b; c -= rot(b, 16);
        a ^= c; a -= rot(c, 4); b ^= a; b -= rot(a, 14); c ^= b; c -= rot(b, 24);
        return c;
    };
    for (uint32_t k : {0u, 1u, 77u, 0x80000000u, 0xffffffffu}) {
        const uint32_t s1 = 0xdeadbeefu + 4 + 13, s2 = s1 + 4, s3 = s1 + 8;
        EXPECT_EQ(final_round(s1 + k, s1, s1), hash_uint(k));
        EXPECT_EQ(final_round(s2 + k, s2 + 5, s2), hash_uint2(k, 5u));
        EXPECT_EQ(final_round(s3 + k, s3 + 5, s3 + 9), hash_uint3(k, 5u, 9u));
        EXPECT_EQ(static_cast<int32_t>(hash_uint4(k, 5u, 9u, 3u)), hash_uint4(static_cast<int32_t>(k), 5, 9, 3));
        EXPECT_EQ(hash_uint3(k, 5u, 9u) & 0x3f, hash_low6(k, 5u, 9u) & 0x3f);
    }
}
TEST(Hash, of_coordinates_tells_zero_from_minus_zero) {
    EXPECT_NE(hash_to_float(0.0f, 1.0f), hash_to_float(-0.0f, 1.0f));
    EXPECT_EQ(static_cast<float>(hash_to_float(0.25)), hash_to_float(0.25f)) << "double hashes the bits of the float";
}
TEST(Perlin, is_zero_at_lattice_points) {
    for (float x : {-70000.0f, -3.0f, 0.0f, 1.0f, 99999.0f}) {
        EXPECT_EQ(noise<1>(x), 0.0f);
        EXPECT_EQ(noise<2>(x, 2), 0.0f);
        EXPECT_EQ(noise<3>(x, -2, 5), 0.0f);
        EXPECT_EQ(noise<4>(x, -2, 5, 8), 0.0f);
    }
}
TEST(Perlin, is_bounded_and_continuous_across_cells) {
    float least = 0, most = 0;
    for (int i = 0; i < 20000; ++i) {
        const float x = -9.37f + 0.0173f * i, y = 3.1f + 0.0071f * i, z = 0.013f * i, w = 1.3f - 0.0031f * i;
        for (float v : {noise<1>(x), noise<2>(x, y), noise<3>(x, y, z), noise<4>(x, y, z, w)}) {
            least = std::min(least, v), most = std::max(most, v);
        }
        const float edge = std::floor(y) + 0.0f, h = 1e-4f;
        EXPECT_NEAR(noise<3>(x, edge - h, z), noise<3>(x, edge + h, z), 20 * h) << x << " " << edge << " " << z;
    }
    EXPECT_GT(least, -1.01f);
    EXPECT_LT(most, 1.01f);
    EXPECT_LT(least, -0.8f);
    EXPECT_GT(most, 0.8f);
}
TEST(Perlin, repeats_every_100000) {
    for (float x : {0.25f, 0.5f, 7.75f, 1024.5f}) {
        EXPECT_EQ(noise<3>(x, x, x), noise<3>(x + 100000.0f, x + 200000.0f, x + 300000.0f)) << x;
        EXPECT_EQ(noise<1>(x), noise<1>(x + 500000.0f)) << x;
        EXPECT_EQ(noise<2>(x, 0.5f), noise<2>(x, 100000.5f)) << x;
    }
    // From a million on half a unit is added, so that whole numbers do not all give 0.
    EXPECT_NE(noise<3>(4e6f, 3e6f, 2e6f), 0.0f);
    EXPECT_EQ(noise<2>(4e6f, 3e6f), noise<2>(0.5f, 0.5f));
}
TEST(Perlin, takes_coordinates_of_any_size) {
    for (float x : {1e7f, -1e9f, 3e15f, 1e30f, std::numeric_limits<float>::max(), std::numeric_limits<float>::denorm_min()}) {
        EXPECT_TRUE(std::isfinite(noise<3>(x, 1.5f, 2.5f)) || std::fabs(x) > 1e20f) << x;
        noise<1>(x), noise<2>(x, x), noise<4>(x, x, x, x);  // must return
    }
    for (float x : {kInf, -kInf, kNan}) {
        EXPECT_TRUE(std::isnan(noise<1>(x))) << x;
        EXPECT_TRUE(std::isnan(noise<3>(0.5f, x, 0.5f))) << x;
    }
}
TEST(Perlin, gradients_are_the_edges_of_the_cube) {
    for (int h = 0; h < 16; ++h) {
        // Written as it is defined: u = h<8 ? x : y, v = h<4 ? y : (12, 14: x; else z), signs from bits 0 and 1.
        const float x = 0.3f, y = -0.7f, z = 0.11f;
        const float u = h < 8 ? x : y, v = h < 4 ? y : h == 12 || h == 14 ? x : z;
        EXPECT_EQ(gradient3<float>(h, x, y, z), 2 * ((h & 1 ? -u : u) + (h & 2 ? -v : v))) << h;
    }
    for (int h = 0; h < 32; ++h) {
        const float x = 0.3f, y = -0.7f, z = 0.11f, w = 0.9f;
        const float u = h < 24 ? x : y, v = h < 16 ? y : z, s = h < 8 ? z : w;
        EXPECT_EQ(gradient4<float>(h, x, y, z, w), 2 * ((h & 1 ? -u : u) + (h & 2 ? -v : v) + (h & 4 ? -s : s))) << h;
    }
}

FractalParams<double> params(double detail, double roughness = 0.5, bool normalize = false) {
    FractalParams<double> q;
    q.detail = detail, q.roughness = roughness, q.lacunarity = 2, q.offset = 0.4, q.gain = 1.3, q.normalize = normalize;
    return q;
}
TEST(Fractal, without_detail_is_one_octave) {
    const Coord<3, double> p = point<3>(0.37, 1.9, -4.2);
    const double n = signed_noise(p);
    EXPECT_DOUBLE_EQ(fbm(p, params(0)), n);
    EXPECT_DOUBLE_EQ(fbm(p, params(0, 0.5, true)), 0.5 * n + 0.5);
    EXPECT_DOUBLE_EQ(multifractal(p, params(0)), n + 1);
    EXPECT_DOUBLE_EQ(hetero_terrain(p, params(0)), n + 0.4);
    EXPECT_DOUBLE_EQ(hybrid_multifractal(p, params(0)), n + 0.4);
    EXPECT_DOUBLE_EQ(ridged_multifractal(p, params(0)), (0.4 - std::fabs(n)) * (0.4 - std::fabs(n)));
}
TEST(Fractal, detail_fades_octaves_in) {
    const Coord<2, double> p = point<2>(0.37, 1.9);
    for (int octave = 0; octave < 6; ++octave) {
        for (auto f : {fbm<2, double>, +[](const Coord<2, double>& c, const FractalParams<double>& q) { return multifractal(c, q); },
                       +[](const Coord<2, double>& c, const FractalParams<double>& q) { return hetero_terrain(c, q); },
                       +[](const Coord<2, double>& c, const FractalParams<double>& q) { return hybrid_multifractal(c, q); }}) {
            const double whole = f(p, params(octave)), next = f(p, params(octave + 1));
            EXPECT_NEAR(f(p, params(octave + 1e-9)), whole, 1e-7) << octave;
            EXPECT_NEAR(f(p, params(octave + 1 - 1e-9)), next, 1e-7) << octave;
            EXPECT_NEAR(f(p, params(octave + 0.5)), 0.5 * (whole + next), 1e-9) << octave;
        }
    }
}
TEST(Fractal, ends_for_any_detail) {
    const Coord<1, double> p = point<1>(0.37);
    for (double detail : {-1e9, -2.5, 1e3, 1e30, std::numeric_limits<double>::infinity()}) fbm(p, params(detail));
    EXPECT_TRUE(std::isnan(fbm(p, params(kNan))));
}

}  // namespace
}  // namespace alder::HWY_NAMESPACE
