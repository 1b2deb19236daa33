// Laws of phase functions: they integrate to 1, samples follow them, their mean cosine is the anisotropy, and their values and those
// of the nodes that emit them are Cycles' (tables volume_phase and volume_slab).
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "graph/material.h"
#include "render/closure/phase.h"
#include "render/volume/media.h"
#include "tests/render/closure/chi2.h"
#include "tests/render/closure/lobe_fixture.h"

namespace alder::testing {
namespace {

using nlohmann::json;

struct PhaseCase {
    LobeSpec spec;
    double a, b;  ///< parameters
    std::string text() const { return "kind " + std::to_string(int(spec.kind)) + " with " + std::to_string(a) + ", " + std::to_string(b); }
    template <class T = double>
    Lobe<T> lobe() const {
        Lobe<T> l;
        l.spec = &spec;
        l.weight = Vec3<T>(T(1));
        l.p[0] = static_cast<T>(a);
        l.p[1] = static_cast<T>(b);
        return l;
    }
};

std::vector<PhaseCase> phase_cases() {
    std::vector<PhaseCase> cases;
    const auto add = [&](LobeKind kind, double a, double b) { cases.push_back({LobeSpec{.kind = kind}, a, b}); };
    for (const double g : {-0.95, -0.4, -1e-3, 0.0, 9e-4, 2e-3, 0.3, 0.8, 0.97}) add(LobeKind::PhaseHenyeyGreenstein, g, 0);
    add(LobeKind::PhaseRayleigh, 0, 0);
    for (const double g : {-0.8, -0.02, 5e-4, 0.02, 0.4, 0.9})
        for (const double alpha : {0.0, 5e-4, 0.5, 1.0, 30.0, 250.0}) add(LobeKind::PhaseDraine, g, alpha);
    // A high index with little backscatter is all but a delta, and its formula negative behind, where it is cut: not normalised.
    for (const double back : {0.05, 0.1, 0.4})
        for (const double ior : {1.05, 1.33}) add(LobeKind::PhaseFournierForand, back, ior);
    add(LobeKind::PhaseFournierForand, 0.4, 1.8);
    return cases;
}

/// Over u = (1 - c)/2 in equal steps of its logarithm, and of that of 1 - u in the other half: peaks are narrow.
template <class F>
double over_the_sphere(const F& f) {
    const int n = 20000;
    const double low = std::log(1e-16), high = std::log(0.5);
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        const double u = std::exp(low + (high - low) * (i + 0.5) / n);
        sum += (f(u) + f(1 - u)) * u * (high - low) / n;
    }
    return 4 * kPi<double> * sum;
}

Vec3d deflected(double u) {  // light along +z
    const double s = 2 * std::sqrt(std::max(u * (1 - u), 0.0));
    return {s, 0, 1 - 2 * u};
}

TEST(Phase, integrates_to_one) {
    for (const PhaseCase& c : phase_cases()) {
        const Lobe<double> l = c.lobe();
        const double sum = over_the_sphere([&](double u) { return closure::phase_value(l, {0, 0, -1}, deflected(u)); });
        // Fournier and Forand's term in 3c²-1 may be negative behind and is cut there; g within 1e-3 of 0 is Cycles' isotropic branch.
        EXPECT_NEAR(sum, 1, c.spec.kind == LobeKind::PhaseFournierForand ? 5e-3 : 2e-3) << c.text();
    }
}

TEST(Phase, samples_follow_the_function) {
    Random random(7);
    const auto cases = phase_cases();
    for (const PhaseCase& c : cases) {
        if (c.spec.kind == LobeKind::PhaseFournierForand && c.a < 0.1) continue;  // its peak is within one cell: see the next test
        const Lobe<double> l = c.lobe();
        const ShadingView<double> view{random.direction(), {0, 0, 1}, {0, 0, 1}};
        expect_samples_follow_density([&](Vec3d wi) { return eval_lobe(l, view, wi).pdf; },
                                      [&] { return sample_lobe(l, view, random(), random(), random()); }, 60000, 0.01 / double(cases.size()), c.text());
    }
}

/// The share of samples within an angle is the integral of the function: from the peak outwards.
TEST(Phase, forward_peaks_are_sampled_by_their_weight) {
    for (const PhaseCase& c : phase_cases()) {
        if (c.spec.kind != LobeKind::PhaseFournierForand) continue;
        const Lobe<double> l = c.lobe();
        const closure::FournierForand<double> f(c.a, c.b);
        for (const double u : {0.1, 0.5, 0.9}) {
            const double at = closure::sample_fournier_forand(f, u);
            EXPECT_NEAR(f.within(at), u, 1e-6) << c.text();
            const double inside = over_the_sphere([&](double x) { return x <= at ? closure::phase_value(l, {0, 0, -1}, deflected(x)) : 0.0; });
            EXPECT_NEAR(inside, u, 6e-3) << c.text();
        }
    }
}

TEST(Phase, anisotropy_is_the_mean_cosine) {
    for (const double g : {-0.7, 0.2, 0.9}) {
        const LobeSpec spec{.kind = LobeKind::PhaseHenyeyGreenstein};
        const PhaseCase c{spec, g, 0};
        const Lobe<double> l = c.lobe();
        EXPECT_NEAR(over_the_sphere([&](double u) { return (1 - 2 * u) * closure::phase_value(l, {0, 0, -1}, deflected(u)); }), g, 1e-3);
    }
}

TEST(Phase, extremes_stay_finite) {
    Random random(3);
    const double kBad[] = {0, 1, -1, 1e-30, 1e30, -1e30, INFINITY, -INFINITY, NAN};
    for (const LobeKind kind : {LobeKind::PhaseHenyeyGreenstein, LobeKind::PhaseRayleigh, LobeKind::PhaseDraine, LobeKind::PhaseFournierForand})
        for (const double a : kBad)
            for (const double b : kBad) {
                const PhaseCase c{LobeSpec{.kind = kind}, a, b};
                const Lobe<float> l = c.lobe<float>();
                for (const float u : {0.f, 1e-7f, 0.5f, 0.99999994f}) {
                    const ShadingView<float> view{cast<float>(random.direction()), {0, 0, 1}, {0, 0, 1}};
                    const BsdfSample<float> s = sample_lobe(l, view, u, u, u);
                    if (s.valid) {
                        EXPECT_TRUE(std::isfinite(s.wi.x) && s.pdf > 0 && std::isfinite(s.pdf)) << c.text() << " u " << u << " pdf " << s.pdf;
                    }
                    for (const Vec3f wi : {view.wo, -view.wo}) {
                        const BsdfEval<float> e = eval_lobe(l, view, wi);
                        EXPECT_TRUE(std::isfinite(e.pdf) && e.pdf >= 0) << c.text() << " pdf " << e.pdf;
                    }
                }
            }
}

// ---- Cycles' tables -------------------------------------------------------------------------------------------------

json read_table(const std::string& name) {
    const char* folder = std::getenv("ALDER_REFERENCE");
    const std::string path = (folder ? std::string(folder) : std::string(ALDER_SOURCE_DIR) + "/tests/reference") + "/cycles_bsdf/" + name;
    gzFile f = gzopen(path.c_str(), "rb");
    if (!f) return nullptr;
    std::string text;
    char buffer[1 << 16];
    for (int n; (n = gzread(f, buffer, sizeof buffer)) > 0;) text.append(buffer, n);
    gzclose(f);
    return json::parse(text);
}

/// The lobes of a volume node at each point of a table's case.
std::vector<std::vector<Lobe<double>>> volume_lobes(const std::string& node, json params, const json& inputs, size_t count, std::shared_ptr<const Program>& program) {
    for (const auto& [name, value] : inputs.items()) params[name] = {{"attribute", name}};
    Diagnostics d;
    const auto material = build_material({{"version", 1}, {"nodes", {{"v", {{"type", node}, {"params", params}}}}}, {"outputs", {{"volume", {{"node", "v"}}}}}}, {}, d);
    for (const Diagnostic& e : d.errors) ADD_FAILURE() << e.line();
    if (!material) return {};
    program = material->program({.volume = true}, d);
    Executor<double> executor{EvalContext{}};
    std::vector<std::vector<Lobe<double>>> result;
    for (size_t i = 0; i < count; ++i) {
        std::vector<std::vector<double>> memory;
        for (const ProgramInput& in : program->inputs()) {
            const json& v = inputs[in.attribute][i];
            for (int c = 0; c < in.channels; ++c) memory.push_back(std::vector<double>(kPadding, v.is_array() ? v[c].get<double>() : v.get<double>()));
        }
        std::vector<Channel<double>> channels;
        for (const auto& m : memory) channels.push_back({m.data(), 0});
        executor.run(*program, 1, channels);
        auto& lobes = result.emplace_back();
        for (const ProgramLobe& l : program->lobes()) {
            std::vector<Channel<double>> c;
            for (int k = 0; k < l.spec.channels(); ++k) c.push_back(executor.channel(l.register_first + k));
            lobes.push_back(load_lobe(l.spec, c.data(), 0));
        }
    }
    return result;
}

TEST(Phase, values_are_those_of_cycles) {
    const json table = read_table("volume_phase.json.gz");
    ASSERT_FALSE(table.is_null()) << "no volume_phase.json.gz";
    for (const json& c : table["cases"]) {
        json params = c["properties"];
        params["Color"] = {1, 1, 1};
        params["Density"] = 1;
        const size_t count = c["f"].size();
        std::shared_ptr<const Program> program;
        const auto lobes = volume_lobes(table["node"], params, c["inputs"], count, program);
        ASSERT_EQ(lobes.size(), count);
        const bool forand = params["phase"] == "FOURNIER_FORAND";
        double worst = 0;
        for (size_t i = 0; i < count; ++i) {
            const auto vec = [&](const char* key) { return Vec3d(c[key][i][0], c[key][i][1], c[key][i][2]); };
            double f = 0;
            for (const Lobe<double>& l : lobes[i]) f += l.weight.x * closure::phase_value(l, normalize(vec("wo")), normalize(vec("wi")));
            const double want = c["f"][i], limit = (forand ? 1e-3 : 5e-5) * want;
            worst = std::max(worst, std::abs(f - want) / want);
            EXPECT_NEAR(f, want, limit) << c["name"] << " point " << i << " cos " << c["cos_scatter"][i];
        }
        RecordProperty("worst_" + c["name"].get<std::string>(), std::to_string(worst));
    }
}

TEST(Phase, slabs_are_those_of_cycles) {
    const json table = read_table("volume_slab.json.gz");
    ASSERT_FALSE(table.is_null()) << "no volume_slab.json.gz";
    for (const json& c : table["cases"]) {
        const size_t count = c["thickness"].size();
        std::shared_ptr<const Program> program;
        const auto lobes = volume_lobes(c["node"], c["properties"], c["inputs"], count, program);
        ASSERT_EQ(lobes.size(), count);
        for (size_t i = 0; i < count; ++i) {
            MediumValues v;
            for (const Lobe<double>& l : lobes[i]) {
                Lobe<float> f;
                f.spec = l.spec;
                f.weight = cast<float>(l.weight);
                add_lobe(v, f);
            }
            const float thickness = c["thickness"][i];
            const Vec3f through = transmittance(v.extinction(), thickness), light = emitted_along(v, thickness);
            for (int k = 0; k < 3; ++k) {
                const double white = c["radiance_white_background"][i][k], black = c["radiance_black_background"][i][k];
                EXPECT_NEAR(through[k], white - black, 5e-6) << c["name"] << " point " << i;
                EXPECT_NEAR(light[k], black, 2e-4) << c["name"] << " point " << i;
            }
        }
    }
}

}  // namespace
}  // namespace alder::testing
