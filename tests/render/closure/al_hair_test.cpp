// alHair against tables of the original: colour and lobes through the graph, lobes with the original's own random numbers, and the
// functions of dual scattering.
#include <gtest/gtest.h>

#include "nodes/surface/al_hair_dual.h"
#include "render/evaluate.h"
#include "tests/nodes/surface/al_fixture.h"

namespace alder::testing {
namespace {

constexpr double kRadians = 0.017453292519943295;

/// The README's error: relative, to at least 1e-3 of the table's own scale.
double error_of(double got, double want, double scale = 1e-3) { return std::abs(got - want) / std::max(std::abs(want), scale); }

double param(const json& c, const char* name, double otherwise) { return c["params"].contains(name) ? number(c["params"][name]) : otherwise; }

/// f cos of one lobe with the frame, the absorption and the glint's azimuth that the table gives.
Vec3d lobe_value(const json& c, const std::string& lobe) {
    LobeSpec spec{.kind = lobe == "TT" ? LobeKind::HairForward : lobe == "glint" ? LobeKind::HairGlint : LobeKind::HairGlossy};
    const double alpha = -param(c, "specularShift", 4) * kRadians, beta = param(c, "specularWidth", 3) * kRadians;
    Lobe<double> l;
    l.spec = &spec;
    l.weight = Vec3d(1.0);
    l.t = vec3(c["frame"]["U"]);
    const auto tint = [&](const char* name) { return vec3(c["params"][std::string(name) + "Color"]) * param(c, (std::string(name) + "Strength").c_str(), 1); };
    Vec3d color;
    const Vec3d sigma = vec3(c["absorption"]);
    const auto faded = [&](double by, double amount) { return Vec3d(std::exp(by * sigma.x), std::exp(by * sigma.y), std::exp(by * sigma.z)) * amount; };
    if (lobe == "R") {
        l.p[0] = alpha + param(c, "specular1Shift", 0) * kRadians;
        l.p[1] = beta * param(c, "specular1WidthScale", 1);
        color = tint("specular1") * 0.05;
    } else if (lobe == "TT") {
        l.p[0] = -alpha / 2 + param(c, "transmissionShift", 0) * kRadians;
        l.p[1] = beta / 2 * param(c, "transmissionWidthScale", 1);
        l.p[2] = param(c, "transmissionRolloff", 10) * kRadians;
        color = tint("transmission") * faded(-0.5, 0.8);
    } else {
        l.p[0] = -1.5 * alpha + param(c, "specular2Shift", 0) * kRadians;
        l.p[1] = 2 * beta * param(c, "specular2WidthScale", 1);
        color = tint("specular2") * faded(-1, 0.3);
        if (lobe == "glint") {
            l.p[2] = param(c, "glintRolloff", 5) * kRadians;
            l.p[3] = number(c["phiG"]);
            color = color * param(c, "glintStrength", 2.5);
        }
    }
    const Vec3d wo = vec3(c["globals"]["Rd"]) * -1;
    const ShadingView<double> view{wo, wo, wo};
    return eval_lobe(l, view, vec3(c["wi"])).f_cos * color;
}

TEST(AlHair, lobes_are_those_of_the_table) {
    const json table = load_table("alHair");
    ASSERT_FALSE(table.is_null());
    int outside = 0, count = 0;
    double worst = 0;
    for (const json& c : table["cases"])
        for (const char* lobe : {"R", "TT", "TRT", "glint"}) {
            const Vec3d got = lobe_value(c, lobe), want = vec3(c["output"][lobe]);
            double e = 0;
            for (int k = 0; k < 3; ++k) e = std::max(e, error_of(got[k], want[k]));
            ++count;
            outside += e > 2e-4;
            worst = std::max(worst, e);
        }
    EXPECT_LE(outside, count / 100) << "of " << count << ", worst " << worst;
}

// The same through the graph, where the strand has no random number: colour of melanin and dye, widths, shifts, tints.
TEST(AlHair, graph_gives_the_lobes_of_the_table) {
    const json table = load_table("alHair");
    ASSERT_FALSE(table.is_null());
    int cases = 0, outside = 0;
    double worst = 0;
    for (const json& c : table["cases"]) {
        if (!c["basis"].empty()) continue;
        if (++cases > 60) break;
        for (const char* lobe : {"R", "TT", "TRT", "glint"}) {
            json params = c["params"];
            params["diffuseStrength"] = 0;
            const std::string name = lobe;
            if (name != "R") params["specular1Strength"] = 0;
            if (name != "TT") params["transmissionStrength"] = 0;
            if (name != "TRT" && name != "glint") params["specular2Strength"] = 0;
            if (name == "TRT") params["glintStrength"] = 0;
            const Vec3d wo = vec3(c["globals"]["Rd"]) * -1;
            const json request = {{"graph", {{"nodes", {{"hair", {{"type", "alHair"}, {"params", params}}}}}, {"outputs", {{"surface", {{"node", "hair"}}}}}}},
                                  {"points", {{"count", 1}, {"dPdv", {c["globals"]["dPdv"]}}, {"N", {c["globals"]["N"]}}}},
                                  {"closure", {{"wi", {c["wi"]}}, {"wo", {{wo.x, wo.y, wo.z}}}}}};
            EvaluateOptions options;
            options.precision = EvaluateOptions::Precision::Double;
            options.threads = 1;
            Diagnostics d;
            const json answer = evaluate_request(request, options, d);
            ASSERT_FALSE(answer.is_null()) << (d.errors.empty() ? "" : d.errors[0].line());
            Vec3d got = vec3(answer["closure"]["f_cos"][0]), want = vec3(c["output"][lobe]);
            if (name == "glint") want = want + vec3(c["output"]["TRT"]);
            double e = 0;
            // Colours below 1e-4 are raised to that, which the original does not do.
            for (int k = 0; k < 3; ++k)
                if (number(c["absorption"][k]) < 9.2) e = std::max(e, error_of(got[k], want[k]));
            outside += e > 2e-4;
            worst = std::max(worst, e);
        }
    }
    EXPECT_GT(cases, 8);
    EXPECT_LE(outside, cases * 4 / 100) << "worst " << worst;
}

// f_s in the table has the original's defect of reading column 0 for every azimuth: compared at pi/2, where that column stands.
TEST(AlHair, dual_scattering_is_that_of_the_table) {
    const json table = load_table("alHair.dual");
    ASSERT_FALSE(table.is_null());
    int outside[4] = {}, count = 0;
    double worst[4] = {};
    for (const json& c : table["cases"]) {
        const al_hair::DualTables t({-param(c, "specularShift", 4) * kRadians, param(c, "specularWidth", 3) * kRadians,
                                     param(c, "transmissionRolloff", 10) * kRadians, param(c, "glintRolloff", 5) * kRadians});
        const double theta_i = number(c["thetaI"]), theta_d = number(c["thetaD"]), theta_h = number(c["thetaH"]);
        const Vec3d color = vec3(c["fibreColor"]), variance = vec3(c["sigmaF2"]);
        const json& out = c["output"];
        const auto hundredth = [&](int k) { return std::floor(100 * color[k]); };
        for (int k = 0; k < 3; ++k) {
            // Channels in one hundredth share the first one's table.
            bool shared = color[k] < 1e-4;
            for (int j = 0; j < k; ++j) shared = shared || hundredth(j) == hundredth(k);
            if (shared) continue;
            ++count;
            const double got[4] = {t.forward_attenuation(theta_i, color[k]), t.back_scattering(theta_d, theta_h, 0.0, color[k]),
                                   t.back_scattering(theta_d, theta_h, variance[k], color[k]),
                                   t.forward_scattering(theta_d, theta_h, 0.0, variance[k], color[k])};
            const double want[4] = {number(out["aBarF"][k]), number(out["fBackDirect"][k]), number(out["fBackScatter"][k]), number(out["fScatter"][k])};
            for (int i = 0; i < 4; ++i) {
                const double e = error_of(got[i], want[i]);
                outside[i] += e > 2e-4;
                worst[i] = std::max(worst[i], e);
            }
        }
    }
    EXPECT_GT(count, 50);
    const char* names[4] = {"a_f", "f_back direct", "f_back", "f_s"};
    for (int i = 0; i < 4; ++i) EXPECT_LE(outside[i], count / 100) << names[i] << " of " << count << ", worst " << worst[i];
}

// f_s by azimuth, which the original never varies: between the table's columns it is linear, at their ends it is the sum itself.
TEST(AlHair, forward_scattering_follows_the_azimuth) {
    const al_hair::DualTables t({-0.07, 0.05, 0.17, 0.09});
    const auto f = [&](double phi) { return t.forward_scattering(0.1, 0.05, phi, 0.0, 0.5); };
    const double half = 1.57079632679490, step = half / 31;
    EXPECT_NEAR(f(half + 4.5 * step), (f(half + 4 * step) + f(half + 5 * step)) / 2, 1e-9 * f(half));
    EXPECT_GT(std::abs(f(2 * half) - f(half)), 1e-3 * f(half));
    EXPECT_EQ(f(0), f(half));
}

// Of light that came through fibres nothing is direct any more; none of it is the global part's where it came through none.
TEST(AlHair, dual_scattering_splits_by_fibres_met) {
    LobeSpec local{.kind = LobeKind::HairDual}, global{.kind = LobeKind::HairDual};
    global.order = 1;
    Lobe<double> l;
    l.weight = Vec3d(1.0);
    l.t = Vec3d(1, 0, 0);
    const double p[] = {0.6, 0.5, 0.4, 0.7, 0.7, -0.07, 0.05, 0.17, 0.09};
    std::copy(std::begin(p), std::end(p), l.p);
    const Vec3d wo(0, 0.6, 0.8), wi(0.1, -0.6, 0.79);
    double before[2] = {};
    for (const double fibres : {0.0, 1.0, 2.0, 5.0}) {
        ShadingView<double> view{wo, wo, wo};
        view.fibres = fibres;
        view.fibre_variance = 0.01 * fibres;
        l.spec = &local;
        const double direct = eval_lobe(l, view, normalize(wi)).f_cos.x;
        l.spec = &global;
        const double through = eval_lobe(l, view, normalize(wi)).f_cos.x;
        EXPECT_EQ(direct > 0, fibres < 2) << fibres;
        EXPECT_EQ(through > 0, fibres > 0) << fibres;
        if (fibres == 1) {
            EXPECT_NEAR(direct, before[0] / 2, 1e-12);
        }
        if (fibres == 5) {
            EXPECT_LT(through, before[1]) << "fades with every fibre";
        }
        before[0] = direct;
        before[1] = through;
    }
}

}  // namespace
}  // namespace alder::testing
