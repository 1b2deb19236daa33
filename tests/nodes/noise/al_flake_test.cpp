// alFlake: the flake of a given cell as the original makes it; its share and size.
#include "nodes/noise/flake-inl.h"
#include "tests/nodes/al_table.h"
#include "tests/nodes/node_call.h"

namespace alder {
using test::NodeCall;
namespace kn = HWY_NAMESPACE;

TEST(TeaFloat, matches_the_reference) {
    for (const auto& c : test::al_cases("helpers")) {
        if (c["function"] != "teafloat") continue;
        const uint32_t v0 = c["params"]["v0"].get<uint32_t>(), v1 = c["params"]["v1"].get<uint32_t>();
        EXPECT_EQ(kn::tea_float<float>(static_cast<int32_t>(v0), static_cast<int32_t>(v1)), test::al_float(c["output"][0])) << v0 << ", " << v1;
    }
}
TEST(AlFlake, matches_the_reference_with_its_cells) {
    double worst = 0;
    for (const auto& c : test::al_cases("alFlake")) {
        const auto& p = c["params"];
        const Vec3f at = test::al_vec(c.contains("links") ? p["P"] : c["globals"]["P"]);
        const float size = test::al_float(p["size"]);
        const test::BasisReplay calls(c["basis"]);
        const auto& cell = calls.next("cellular", {at.x / size, at.y / size, at.z / size, 1, 1, 2, 1});
        const Vec3f r = kn::flake_normal<float>(static_cast<int32_t>(cell["id"][0].get<uint32_t>()), test::al_float(p["amount"]), test::al_float(p["divergence"]));
        const Vec3f got = p["space"] == "world" ? kn::to_shading_frame(r, test::al_vec(c["globals"]["Nf"]), test::al_vec(c["globals"]["dPdu"]))
                                                : r * 0.5f + Vec3f(0.5f);
        for (int i = 0; i < 3; ++i) worst = std::max(worst, std::fabs(got[i] - test::al_number(c["output"][i])));
        ASSERT_LE(worst, 2e-6) << c;
    }
}
TEST(AlFlake, amount_is_the_share_of_cells) {
    const size_t n = 20000;
    std::vector<double> x;
    for (size_t i = 0; i < n; ++i) x.push_back(3.7 * static_cast<double>(i));
    for (double amount : {0.0, 0.3, 1.0}) {
        NodeCall call("alFlake", n);
        const auto out = call.set("size", 1).set("divergence", 1).set("amount", amount).vary("P", x).run();
        size_t flakes = 0;
        for (size_t i = 0; i < n; ++i) flakes += out[0][i] != 0.5 || out[1][i] != 0.5;
        EXPECT_NEAR(static_cast<double>(flakes) / n, amount, 5 * std::sqrt(amount * (1 - amount) / n)) << amount;
    }
}
TEST(AlFlake, size_zero_gives_no_flakes) {
    const auto out = NodeCall("alFlake").set("size", 0).set("amount", 1).set("divergence", 1).set("P", {0.3, 0.4, 0.5}).run();
    EXPECT_EQ(out[0][0], 0.5);
    EXPECT_EQ(out[1][0], 0.5);
    EXPECT_EQ(out[2][0], 1);
}
TEST(AlFlake, world_space_does_without_a_parametrisation) {
    for (const Vec3f n : {Vec3f(0, 0, 1), Vec3f(1, 0, 0), Vec3f(0.6f, -0.8f, 0)})
        for (const Vec3f dpdu : {Vec3f(0, 0, 0), n}) {
            const Vec3f r(0.48f, 0.6f, 0.64f), w = kn::to_shading_frame(r, n, dpdu);
            EXPECT_NEAR(kn::dot(w, n), r.z, 1e-6);
            EXPECT_NEAR(kn::length(w), 1, 1e-6);
        }
}
}  // namespace alder
