// The directional albedo that alSurface's layers rely on, against integration of the lobes; and the energy of the whole surface.
#include <random>

#include "nodes/surface/al_surface-inl.h"
#include "nodes/surface/al_surface_params.h"
#include "tests/nodes/surface/al_fixture.h"

namespace alder {
namespace {

using namespace testing;
using namespace al_surface;
namespace hw = alder::HWY_NAMESPACE;

/// Directional albedo of one lobe: mean sample weight over a stratified set.
Vec3d integrated_albedo(const Lobe<double>& lobe, Vec3d wo, int side = 56) {
    Vec3d sum(0, 0, 0);
    if (largest(lobe.weight) <= 0) return sum;
    const ShadingView<double> view{wo, {0, 0, 1}, {0, 0, 1}};
    const bool delta = is_delta(lobe);
    const int n = delta ? 1 : side;
    std::mt19937 engine(7);
    std::uniform_real_distribution<double> u(0, 1);
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const BsdfSample<double> s = sample_lobe<double>(lobe, view, (i + u(engine)) / n, (j + u(engine)) / n, u(engine));
            if (s.valid) sum += s.weight;
        }
    return sum * (1.0 / (n * n));
}

Vec3d tilted(double mu, double phi) {
    const double s = std::sqrt(1 - mu * mu);
    return {s * std::cos(phi), s * std::sin(phi), mu};
}

struct Worst {
    double value = 0, sum2 = 0;
    int count = 0;
    std::string where;
    void add(double e, const std::string& place) {
        sum2 += e * e;
        ++count;
        if (std::abs(e) > std::abs(value)) {
            value = e;
            where = place;
        }
    }
    double rms() const { return std::sqrt(sum2 / count); }
};

TEST(al_albedo, rules_match_integration_of_isotropic_lobes) {
    std::mt19937 engine(1);
    std::uniform_real_distribution<double> u(0, 1);
    Worst plastic, strong;
    for (int k = 0; k < 240; ++k) {
        const bool ggx = k % 2;
        const double mu = std::max(0.01, std::pow(u(engine), 1.5)), alpha = std::max(1e-3, std::pow(u(engine), 2.0));
        const double ior = k % 4 < 2 ? 1.1 + 1.4 * u(engine) : std::pow(10.0, 1 + 2 * u(engine));
        LobeSpec spec{LobeKind::MicrofacetReflection};
        spec.distribution = ggx ? Distribution::GGX : Distribution::Beckmann;
        spec.fresnel = FresnelMode::Dielectric;
        Lobe<double> lobe;
        lobe.spec = &spec;
        lobe.weight = Vec3d(1, 1, 1);
        lobe.p[0] = alpha;
        lobe.p[1] = ior;
        const double got = hw::al_albedo(ggx ? kAlbedoRulesGgx : kAlbedoRulesBeckmann, hw::AlAlbedoPlace<double>(mu, alpha), hw::AlDielectricCurve<double>{ior});
        const double e = got - integrated_albedo(lobe, tilted(mu, 0)).x;
        (ior < 5 ? plastic : strong).add(e, (ggx ? "ggx" : "beckmann") + std::string(" mu ") + std::to_string(mu) + " alpha " + std::to_string(alpha) + " ior " + std::to_string(ior));
    }
    EXPECT_LT(std::abs(plastic.value), 0.004) << plastic.where;
    EXPECT_LT(plastic.rms(), 0.001);
    EXPECT_LT(std::abs(strong.value), 0.03) << strong.where;
}

TEST(al_albedo, rules_match_integration_of_anisotropic_lobes) {
    std::mt19937 engine(2);
    std::uniform_real_distribution<double> u(0, 1);
    Worst dielectric, metal;
    for (int k = 0; k < 160; ++k) {
        const bool ggx = k % 2, metallic = k % 4 >= 2;
        const double mu = std::max(0.05, u(engine)), phi = 6.2831853 * u(engine);
        const auto w = hw::al_widths<double>(std::pow(u(engine), 2.0), u(engine), 0);
        LobeSpec spec{LobeKind::MicrofacetReflection};
        spec.distribution = ggx ? Distribution::GGX : Distribution::Beckmann;
        spec.fresnel = metallic ? FresnelMode::Conductor : FresnelMode::Dielectric;
        spec.anisotropic = true;
        const MicrofacetLayout at(spec);
        Lobe<double> lobe;
        lobe.spec = &spec;
        lobe.weight = Vec3d(1, 1, 1);
        lobe.p[at.alpha_x] = w.x;
        lobe.p[at.alpha_y] = w.y;
        const auto m = hw::al_metal(0.9, 0.5);
        if (metallic) {
            for (int c = 0; c < 3; ++c) {
                lobe.p[at.f0 + c] = m.n;
                lobe.p[at.edge + c] = m.k;
            }
        } else {
            lobe.p[at.eta] = 1.5;
        }
        const Vec3d wo = tilted(mu, phi);
        const float* table = ggx ? kAlbedoRulesGgx : kAlbedoRulesBeckmann;
        const hw::AlMetalCurve<double> metal_curve{Vec3d(m.n), Vec3d(m.k)};
        const double got = metallic ? hw::al_albedo_anisotropic<double>(table, mu, w.x, w.y, wo.x, wo.y, metal_curve).x
                                    : hw::al_albedo_anisotropic<double>(table, mu, w.x, w.y, wo.x, wo.y, hw::AlDielectricCurve<double>{1.5});
        (metallic ? metal : dielectric).add(got - integrated_albedo(lobe, wo).x, "alpha " + std::to_string(w.x) + " " + std::to_string(w.y) + " mu " + std::to_string(mu));
    }
    EXPECT_LT(dielectric.rms(), 0.006) << dielectric.value << " at " << dielectric.where;
    EXPECT_LT(metal.rms(), 0.025) << metal.value << " at " << metal.where;
}

TEST(al_albedo, rules_are_safe_for_any_lane) {
    for (float mu : {-1.f, 0.f, 1e-30f, 2.f, INFINITY, -INFINITY, NAN})
        for (float alpha : {-1.f, 0.f, 5.f, INFINITY, NAN}) {
            const float e = hw::al_albedo(kAlbedoRulesGgx, hw::AlAlbedoPlace<float>(mu, alpha), hw::AlDielectricCurve<float>{1.5f});
            EXPECT_TRUE(mu != mu || mu < 0 || std::isfinite(e)) << mu << " " << alpha;
        }
}

/// Light that leaves a surface lit evenly from everywhere, towards wo.
double white_furnace(const std::vector<Lobe<double>>& lobes, Vec3d wo) {
    Vec3d sum(0, 0, 0);
    for (const Lobe<double>& l : lobes)
        if (!l.spec->shadow_only) sum += integrated_albedo(l, wo, 40);
    return largest(sum);
}

TEST(al_surface, never_gives_back_more_light_than_it_gets) {
    std::mt19937 engine(3);
    std::uniform_real_distribution<double> u(0, 1);
    Worst worst;
    for (int k = 0; k < 160; ++k) {
        const auto maybe = [&](double p, double v) { return u(engine) < p ? v : u(engine); };
        json params = {{"diffuseStrength", maybe(0.6, 1)}, {"diffuseColor", {1, 1, 1}}, {"diffuseRoughness", maybe(0.5, 0)},
                       {"backlightStrength", maybe(0.5, 0)}, {"backlightColor", {1, 1, 1}}, {"transmissionStrength", maybe(0.4, 0)},
                       {"specular1Strength", maybe(0.7, 1)}, {"specular1Roughness", maybe(0.2, 0)}, {"specular1Ior", 1 + 3 * u(engine) * u(engine)},
                       {"specular2Strength", maybe(0.5, 0)}, {"specular2Roughness", u(engine)}, {"specular2Ior", 1 + 2 * u(engine)},
                       {"specular1Distribution", k % 2 ? "ggx" : "beckmann"}, {"specular2Distribution", k % 4 > 1 ? "ggx" : "beckmann"},
                       {"specular1FresnelMode", k % 5 == 0 ? "metallic" : "dielectric"}, {"specular1Reflectivity", {0.95, 0.8, 0.5}},
                       {"specular1EdgeTint", {0.3, 0.5, 0.9}}, {"transmissionLinkToSpecular1", u(engine) < 0.5},
                       {"transmissionRoughness", maybe(0.3, 0)}, {"opacity", {maybe(0.7, 1), 1, 1}}};
        SurfaceNode node(params);
        const Vec3d wo = tilted(std::max(0.02, u(engine)), 6.28 * u(engine));
        node.set(Global::I, wo);
        node.set(Global::Backfacing, k % 3 == 0);
        worst.add(std::max(0.0, white_furnace(node.run(), wo) - 1), params.dump() + " cos " + std::to_string(wo.z));
    }
    EXPECT_LT(worst.value, 0.01) << worst.where;
}

TEST(al_surface, white_surface_under_a_clear_coat_loses_only_what_masking_loses) {
    for (double mu : {0.1, 0.3, 0.6, 1.0})
        for (double roughness : {0.0, 0.3, 0.6}) {
            SurfaceNode node({{"diffuseColor", {1, 1, 1}}, {"specular1Roughness", roughness}, {"specular1Ior", 1.5}});
            const Vec3d wo = tilted(mu, 0.4);
            node.set(Global::I, wo);
            const double light = white_furnace(node.run(), wo);
            EXPECT_NEAR(light, 1, 0.008) << "cos " << mu << ", roughness " << roughness;
        }
}

TEST(al_surface, glass_keeps_all_light_on_both_sides) {
    for (bool inside : {false, true})
        for (double mu : {0.1, 0.4, 0.7, 1.0}) {
            SurfaceNode node({{"diffuseStrength", 0}, {"transmissionStrength", 1}, {"specular1Roughness", 0}, {"specular1Ior", 1.5}});
            const Vec3d wo = tilted(mu, 1);
            node.set(Global::I, wo);
            node.set(Global::Backfacing, inside);
            EXPECT_NEAR(white_furnace(node.run(), wo), 1, 1e-9) << "inside " << inside << ", cos " << mu;
        }
}

}  // namespace
}  // namespace alder
