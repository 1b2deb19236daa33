// alTriplanar: the original's projections with its table's cells and texture values; its spaces through a graph.
#include "nodes/texture/triplanar-inl.h"
#include "tests/nodes/al_table.h"

#include "graph/material.h"

namespace alder {
namespace kn = HWY_NAMESPACE;

/// Texture values of the table. (Its steps from pixel to pixel, without frequency, rotation and cells, are the original's defect.)
struct ReplayedTexture {
    const test::BasisReplay& calls;
    kn::Rgba<float> operator()(const kn::Projected<float>& at) const {
        const auto& v = calls.next("texture", {at.u, at.v}, std::hypot(at.u, at.v) + 1);   // sums of a rotation
        return {{test::al_float(v[0]), test::al_float(v[1]), test::al_float(v[2])}, test::al_float(v[3])};
    }
};
template <int kCells>
struct ReplayedCells {
    const test::BasisReplay& calls;
    kn::Cellular<kCells, float> operator()(float u, float v) const {
        const auto& found = calls.next("cellular", {u, v, 0, kCells, 1});
        kn::Cellular<kCells, float> c;
        for (int i = 0; i < kCells; ++i) {
            c.distance[i] = test::al_float(found["F"][i]);
            c.delta[i] = test::al_vec(found["delta"][i]);
            c.id[i] = static_cast<int32_t>(found["id"][i].get<uint32_t>());
        }
        return c;
    }
};

TEST(AlTriplanar, arithmetic_matches_the_reference_with_its_texture) {
    double worst = 0;
    int cases = 0, outside = 0;
    for (const auto& c : test::al_cases("alTriplanar")) {
        const auto& p = c["params"];
        const auto& g = c["globals"];
        const auto f = [&](const char* name) { return test::al_float(p[name]); };
        Vec3f at = test::al_vec(g["P"]), n = test::al_vec(g[p["normal"] == "Geometric" ? "Ng" : p["normal"] == "Smooth" ? "N" : "Ns"]);
        Vec3f dx = test::al_vec(g["dPdx"]), dy = test::al_vec(g["dPdy"]);
        if (p["space"] == "Pref") {
            if (!c.contains("userData")) continue;   // object space: the table has no matrix
            at = test::al_vec(c["userData"]["Pref"]), dx = test::al_vec(c["userData"]["Pref:dx"]), dy = test::al_vec(c["userData"]["Pref:dy"]);
            n = kn::normalize(kn::cross(dx, dy));
        }
        kn::Triplanar<float> t;
        t.p = at * f("frequency"), t.dpdx = dx * f("frequency"), t.dpdy = dy * f("frequency");
        t.scale = {1 / f("scalex"), 1 / f("scaley"), 1 / f("scalez")};
        t.offset = {f("offsetx"), f("offsety"), f("offsetz")}, t.degrees = {f("rotx"), f("roty"), f("rotz")};
        t.jitter = {f("rotjitterx"), f("rotjittery"), f("rotjitterz")}, t.cell_softness = kn::saturate(f("cellSoftness"));
        const Vec3f weight = kn::triplanar_weights(n, f("blendSoftness"));
        const test::BasisReplay calls(c["basis"]);
        kn::Rgba<float> r;
        if (p["tiling"] == "regular") r = kn::triplanar_regular(t, weight, ReplayedTexture{calls});
        else if (t.cell_softness == 0) r = kn::triplanar_cells<1>(t, weight, ReplayedCells<1>{calls}, ReplayedTexture{calls});
        else r = kn::triplanar_cells<3>(t, weight, ReplayedCells<3>{calls}, ReplayedTexture{calls});
        EXPECT_TRUE(calls.finished()) << "look-ups are missing in " << c;
        const Vec3f got = kn::lerp(test::al_vec(p["input"]), r.rgb, r.a);
        double error = 0;
        for (int i = 0; i < 3; ++i) error = std::max(error, test::al_error(got[i], test::al_number(c["output"][i])));
        worst = std::max(worst, error);
        outside += error > 2e-4;
        ++cases;
    }
    EXPECT_LE(outside, cases / 100) << "of " << cases << ", worst " << worst;
}

/// The place a projection reads, found by hand, and the one a pixel on: the steps are their difference.
struct Recorded {
    mutable std::vector<kn::Projected<double>> at;
    kn::Rgba<double> operator()(const kn::Projected<double>& p) const {
        at.push_back(p);
        return {Vec3d(0.0), 0.0};
    }
};
struct OneCell {
    kn::Cellular<1, double> operator()(double u, double v) const { return kn::cellular<1>(Vec3d(u, v, 0.0), 1.0); }
};
struct RecordedBy {
    const Recorded& record;
    kn::Rgba<double> operator()(const kn::Projected<double>& p) const { return record(p); }
};
TEST(AlTriplanar, steps_are_differences_between_pixels) {
    for (const bool cells : {false, true}) {
        const Vec3d p(0.31, -0.62, 1.17), dx(1e-5, 2e-5, -1e-5), dy(-2e-5, 1e-5, 3e-5);
        std::vector<kn::Projected<double>> at[3];
        for (int k = 0; k < 3; ++k) {
            kn::Triplanar<double> t;
            t.p = p + (k == 1 ? dx : k == 2 ? dy : Vec3d(0.0));
            t.dpdx = dx, t.dpdy = dy, t.scale = {0.5, 2.0, 1.25}, t.offset = {0.1, 0.2, 0.3}, t.degrees = {10, 77, 200}, t.jitter = {1, 0.5, 0};
            t.cell_softness = 0;
            const Recorded record;
            if (cells) kn::triplanar_cells<1>(t, Vec3d(1.0 / 3), OneCell(), RecordedBy{record});
            else kn::triplanar_regular(t, Vec3d(1.0 / 3), RecordedBy{record});
            at[k] = record.at;
        }
        ASSERT_EQ(at[0].size(), 3u);
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(at[0][i].dudx, at[1][i].u - at[0][i].u, 1e-10) << "projection " << i << ", cells " << cells;
            EXPECT_NEAR(at[0][i].dvdx, at[1][i].v - at[0][i].v, 1e-10);
            EXPECT_NEAR(at[0][i].dudy, at[2][i].u - at[0][i].u, 1e-10);
            EXPECT_NEAR(at[0][i].dvdy, at[2][i].v - at[0][i].v, 1e-10);
        }
    }
}
TEST(AlTriplanar, weights_fade_with_softness) {
    const Vec3f n(0.8f, 0.6f, 0);
    const Vec3f hard = kn::triplanar_weights(n, 0.f), soft = kn::triplanar_weights(n, 1.f);
    EXPECT_NEAR(hard.x, 0.75, 1e-6);   // (0.8 - 0.5) to (0.6 - 0.5)
    EXPECT_NEAR(soft.x, 0.8 / 1.4, 1e-6);
    const Vec3f none = kn::triplanar_weights(Vec3f(0, 0, 0), 0.5f);
    EXPECT_EQ(none.x + none.y + none.z, 0);
    EXPECT_EQ(kn::triplanar_weights(Vec3f(NAN, 1, 0), 0.5f).y, 1);
}
TEST(AlImage, frame_replaces_the_first_four_hashes_padded) {
    const auto name_for = [](const char* params) {
        std::string asked;
        MaterialOptions options;
        options.resolve_image = [&](const nlohmann::json& image, std::string&) { return asked = image.value("file", ""), std::string("/nonexistent"); };
        Diagnostics d;
        build_material({{"nodes", {{"t", {{"type", "alImage"}, {"params", nlohmann::json::parse(params)}}}}}}, options, d);
        EXPECT_TRUE(d.ok());
        return asked;
    };
    EXPECT_EQ(name_for(R"({"filename": "a.####.exr", "frame": 7})"), "a.0007.exr");
    EXPECT_EQ(name_for(R"({"filename": {"file": "a.####.####"}, "frame": 12345})"), "a.12345.####");
    EXPECT_EQ(name_for(R"({"filename": "a.####.exr"})"), "a.0000.exr");
    EXPECT_EQ(name_for(R"({"filename": "a.###.exr", "frame": 7})"), "a.###.exr");
}
}  // namespace alder
