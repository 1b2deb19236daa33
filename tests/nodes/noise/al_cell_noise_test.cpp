// cellular noise against brute force, alCellNoise's arithmetic against the reference table with that table's features.
#include "nodes/math/remap-inl.h"
#include "nodes/noise/cell_chips-inl.h"
#include "nodes/noise/cell_hash-inl.h"
#include "nodes/noise/cellular-inl.h"
#include "tests/nodes/al_table.h"
#include "tests/nodes/node_call.h"

#include <algorithm>
#include <random>

namespace alder {
using test::NodeCall;
using test::Path;
namespace kn = HWY_NAMESPACE;

/// All features within `reach` cells, by asking each cell's neighbourhood at its centre with the search as it stands for one cell.
static std::vector<float> distances_by_brute_force(Vec3f p, float randomness, int reach) {
    std::vector<float> d;
    for (int x = -reach; x <= reach; ++x)
        for (int y = -reach; y <= reach; ++y)
            for (int z = -reach; z <= reach; ++z) {
                int32_t h[3] = {static_cast<int32_t>(std::floor(p.x)) + x, static_cast<int32_t>(std::floor(p.y)) + y, static_cast<int32_t>(std::floor(p.z)) + z};
                const float cell[3] = {static_cast<float>(h[0]), static_cast<float>(h[1]), static_cast<float>(h[2])};
                kn::pcg3d(h[0], h[1], h[2]);
                double sum = 0;
                for (int i = 0; i < 3; ++i) {
                    const double at = cell[i] + 0.5 + randomness * (static_cast<double>(static_cast<uint32_t>(h[i]) >> 8) / (1 << 24) - 0.5);
                    sum += (at - p[i]) * (at - p[i]);
                }
                d.push_back(static_cast<float>(std::sqrt(sum)));
            }
    std::sort(d.begin(), d.end());
    return d;
}
TEST(Cellular, finds_the_nearest_features) {
    std::mt19937 rng(11);
    std::uniform_real_distribution<float> at(-40, 40);
    for (float randomness : {0.0f, 0.4f, 1.0f})
        for (int i = 0; i < 300; ++i) {
            const Vec3f p(at(rng), at(rng), at(rng));
            const auto c = kn::cellular<4>(p, randomness);
            const auto want = distances_by_brute_force(p, randomness, 3);
            for (int n = 0; n < 4; ++n) {
                EXPECT_NEAR(c.distance[n], want[n], 2e-5) << "rank " << n << " at randomness " << randomness;
                EXPECT_NEAR(kn::length(c.delta[n]), c.distance[n], 1e-6);
            }
        }
}
TEST(Cellular, a_regular_grid_at_randomness_zero) {
    const auto c = kn::cellular<2>(Vec3f(3.5f, -1.5f, 0.75f), 0.0f);
    EXPECT_FLOAT_EQ(c.distance[0], 0.25f);
    EXPECT_FLOAT_EQ(c.delta[0].z, -0.25f);
    EXPECT_FLOAT_EQ(c.distance[1], 0.75f);
}
TEST(Cellular, distances_are_continuous_and_ids_uniform) {
    float before = 0;
    std::vector<int> count(8);
    int32_t last = 0;
    int features = 0;
    for (int i = 0; i < 200000; ++i) {
        const Vec3f p(0.003f * i, 0.17f, -2.9f);
        const auto c = kn::cellular<2>(p, 1.0f);
        if (i > 0) {
            EXPECT_LE(std::fabs(c.distance[1] - before), 0.0032f) << "jump at " << p.x;
        }
        before = c.distance[1];
        if (c.id[0] != last) ++count[static_cast<uint32_t>(c.id[0]) >> 29], ++features, last = c.id[0];
    }
    for (int n : count) EXPECT_NEAR(n, features / 8.0, 5 * std::sqrt(features / 8.0));
}
TEST(Cellular, huge_and_undefined_points_are_safe) {
    for (float x : {1e9f, -3e38f, INFINITY, NAN})
        for (float randomness : {1.0f, 1e30f, INFINITY, NAN}) {
            const auto c = kn::cellular<2>(Vec3f(x, 0.5f, 0.5f), randomness);
            EXPECT_FALSE(std::isnan(c.distance[0]) || std::isnan(c.distance[1])) << x << ", randomness " << randomness;
        }
}

TEST(UnsignedDivision, is_exact) {
    std::mt19937 rng(5);
    for (int i = 0; i < 200000; ++i) {
        const uint32_t x = i < 1000 ? i : i < 2000 ? ~static_cast<uint32_t>(i) : i < 100000 ? (rng() / 100) * 100 + (i & 1 ? 99 : 0) : rng();
        ASSERT_EQ(static_cast<uint32_t>(kn::unsigned_divide_by_100<float>(static_cast<int32_t>(x))), x / 100) << x;
    }
}

static float remapped(const nlohmann::json& p, float x) {
    const char* names[12] = {"RMPinputMin", "RMPinputMax", "RMPcontrast", "RMPcontrastPivot", "RMPbias", "RMPgain",
                             "RMPoutputMin", "RMPoutputMax", "RMPclampEnable", "RMPthreshold", "RMPclampMin", "RMPclampMax"};
    float value[12];
    Channel<float> in[12];
    for (int i = 0; i < 12; ++i) value[i] = test::al_float(p[names[i]]), in[i] = {&value[i], 0};
    const OpCall<float> call{in, nullptr, nullptr, nullptr, 1};
    return kn::al_remap(kn::Lanes<float>{call, 0}, 0, x);
}
TEST(AlCellNoise, arithmetic_matches_the_reference_with_its_features) {
    double worst = 0;
    for (const auto& c : test::al_cases("alCellNoise")) {
        const auto& p = c["params"];
        const test::BasisReplay calls(c["basis"]);
        const auto& found = calls.next("cellular", {});
        Vec3f got;
        if (p["mode"] == "features") {
            const float n = (test::al_float(found["F"][1]) - test::al_float(found["F"][0])) / p["octaves"].get<float>();
            got = kn::lerp(test::al_vec(p["color1"]), test::al_vec(p["color2"]), remapped(p, n));
        } else {
            const uint32_t id = found["id"][0].get<uint32_t>();
            if (p["randomChips"].get<bool>()) {
                const auto group = kn::to_float<float>(kn::unsigned_divide_by_100<float>(static_cast<int32_t>(id)));
                got = test::al_vec(calls.next("vcellnoise3", {group, 0, 0}));
            } else {
                Vec3f color[5];
                float probability[5];
                for (int i = 0; i < 5; ++i) {
                    color[i] = test::al_vec(p["chipColor" + std::to_string(i + 1)]);
                    probability[i] = test::al_float(p["chipProb" + std::to_string(i + 1)]);
                }
                const float x = kn::uint_to_unit<float>(static_cast<int32_t>(id));
                got = p["smoothChips"].get<bool>() ? kn::chip_color<true>(x, color, probability) : kn::chip_color<false>(x, color, probability);
            }
        }
        EXPECT_TRUE(calls.finished());
        for (int i = 0; i < 3; ++i) worst = std::max(worst, test::al_error(got[i], test::al_number(c["output"][i])));
        ASSERT_LE(worst, 2e-4) << c << " got " << got.x << " " << got.y << " " << got.z;
    }
    RecordProperty("worst_relative", std::to_string(worst));
}
TEST(AlCellNoise, chips_appear_in_proportion_to_their_probabilities) {
    const size_t n = 20000;
    std::vector<double> x;
    for (size_t i = 0; i < n; ++i) x.push_back(3.7 * static_cast<double>(i));
    NodeCall call("alCellNoise", n);
    call.set("mode", "chips").vary("P", x);
    for (int i = 1; i <= 5; ++i) {
        const std::string number = std::to_string(i);
        call.set("chipColor" + number, {1.0 * i, 0, 0}).set("chipProb" + number, i == 2 ? 0 : i);
    }
    int count[6] = {};
    const auto out = call.run();
    for (double v : out[0]) ++count[static_cast<int>(v)];
    const double total = 1 + 3 + 4 + 5;
    for (int i = 1; i <= 5; ++i) {
        const double share = i == 2 ? 0 : i / total;
        EXPECT_NEAR(count[i], n * share, 5 * std::sqrt(n * share) + 1e-9) << "chip " << i;
    }
}
TEST(AlCellNoise, lanes_equal_scalar_in_every_mode) {
    const size_t n = 512;
    std::vector<double> x, y;
    for (size_t i = 0; i < n; ++i) x.push_back(0.37 * static_cast<double>(i) - 90), y.push_back(0.11 * static_cast<double>(i));
    const auto compare = [&](NodeCall& call, const char* what) {
        call.vary("P", x, 0).vary("P", y, 1);
        const auto lanes = call.run(), scalar = call.run(Path::Scalar), exact = call.run(Path::Double);
        for (size_t i = 0; i < n; ++i) {
            EXPECT_NEAR(lanes[0][i], scalar[0][i], 1e-5) << what << " " << i;
            EXPECT_NEAR(lanes[0][i], exact[0][i], 2e-4) << what << " " << i;
        }
    };
    NodeCall features("alCellNoise", n), chips("alCellNoise", n), random("alCellNoise", n);
    compare(features.set("octaves", 3), "features");
    compare(chips.set("mode", "chips"), "chips");
    compare(random.set("mode", "chips").set("randomChips", 1), "random chips");
}
}  // namespace alder
