// alSurface against tables made with the original shader: widths, Fresnel, refraction, shadows, and the arithmetic of the
// layers with prescribed BRDF values. alshaders specification, section 14.
#include "nodes/surface/al_surface-inl.h"
#include "nodes/surface/al_surface_params.h"
#include "tests/nodes/surface/al_fixture.h"

namespace alder {
namespace {

using namespace testing;
using namespace al_surface;
namespace hw = alder::HWY_NAMESPACE;

/// Values compared and the worst relative error, against max(|reference|, scale).
struct Tally {
    int compared = 0;
    double worst = 0;
    std::string where;
    void add(double got, double want, const std::string& place, double scale = 1e-3) {
        ++compared;
        const double e = std::abs(got - want) / std::max(std::abs(want), scale);
        if (!(e <= worst)) {
            worst = e;
            where = place + ": " + std::to_string(got) + ", reference " + std::to_string(want);
        }
    }
};
#define LOAD_OR_SKIP(table, name)     \
    const json table = load_table(name); \
    if (table.is_null()) GTEST_SKIP() << "no table " << name << " in " << reference_folder()

std::string label(const json& table, size_t k, const char* what) {
    return table["node"].get<std::string>() + "[" + std::to_string(k) + "] " + what;
}

TEST(al_surface_reference, widths_and_rotation) {
    LOAD_OR_SKIP(table, "alSurface.widths");
    Tally t;
    for (size_t k = 0; k < table["cases"].size(); ++k) {
        const json& c = table["cases"][k];
        SurfaceNode node(c["params"], {"specular1Anisotropy", "specular2Anisotropy"});  // linked: keeps the tangent for all
        node.set(Global::RayDepth, number(c["depth"]));
        node.set(Global::PreviousAlpha, number(c["previousRoughness"]));
        const auto lobes = node.run();
        for (int which : {kSpecular1, kSpecular2}) {
            const json& want = c["output"][which == kSpecular1 ? "specular1" : "specular2"];
            const Lobe<double>& l = lobes[which];
            const double roughness = c["params"].value(which == kSpecular1 ? "specular1Roughness" : "specular2Roughness", 0.5);
            if (l.weight.x == 0 || want.is_null()) continue;                 // switched off: nothing is read
            if (which == kSpecular1 && roughness == 0) {                     // the mirror path; the table has the floor of its direct part
                EXPECT_EQ(l.p[0], 0);
                continue;
            }
            const std::string place = label(table, k, which == kSpecular1 ? "specular1" : "specular2");
            t.add(l.p[0], number(want["alphaX"]), place + " alphaX");
            t.add(l.p[1], number(want["alphaY"]), place + " alphaY");
            const double turned = c["params"].value(which == kSpecular1 ? "specular1Anisotropy" : "specular2Anisotropy", 0.5);
            if (turned == 0.5) continue;
            for (int i = 0; i < 3; ++i) t.add(l.t[i], number(want["U"][i]), place + " U", 1);
        }
    }
    EXPECT_GT(t.compared, 50);
    EXPECT_LT(t.worst, 1e-5) << t.where;
}

TEST(al_surface_reference, fresnel_of_dielectrics_and_metals) {
    LOAD_OR_SKIP(table, "alSurface.fresnel");
    Tally t;
    for (size_t k = 0; k < table["cases"].size(); ++k) {
        const json& c = table["cases"][k];
        const json& p = c["params"];
        if (c["function"] == "dielectric") {
            const double cos = number(p["cos"]), ior = number(p["ior"]);
            if (cos >= 1) continue;  // the original's defect: 0 there
            if (ior == 1 && cos * cos < 1e-6) continue;  // 1 - cos^2 rounds to 1 in the table's floats
            t.add(hw::fresnel_dielectric(cos, hw::al_ior(ior)), number(c["output"][0]), label(table, k, "dielectric"));
        } else if (c["function"] == "dielectricSides") {
            const double cos = std::abs(dot(vec3(p["N"]), vec3(p["I"]))), ior = number(p["ior"]);
            t.add(hw::fresnel_dielectric(cos, c.value("inside", false) ? 1 / ior : ior), number(c["output"][0]), label(table, k, "sides"));
        } else {
            for (int i = 0; i < 3 && i < static_cast<int>(c["output"].size()); ++i) {
                // No metal has an edge tint outside 0 ... 1; there the lobe is limited to positive n and k.
                if (number(p["edgeTint"][i]) < 0 || number(p["edgeTint"][i]) > 1) continue;
                const auto channel = [&](const char* name) { return number(p[name].is_array() ? p[name][i] : p[name]); };
                const auto m = hw::al_metal(channel("reflectivity"), channel("edgeTint"));
                t.add(hw::fresnel_conductor(number(p["cos"]), m.n, m.k), number(c["output"][i]), label(table, k, "conductor"));
            }
        }
    }
    EXPECT_GT(t.compared, 50);
    EXPECT_LT(t.worst, 2e-4) << t.where;
    EXPECT_NEAR(hw::fresnel_dielectric(1.0, 1.5), 0.04, 1e-12) << "straight on: the limit, where the original gives 0";
}

TEST(al_surface_reference, custom_metals_of_alFresnelConductor) {
    LOAD_OR_SKIP(table, "alFresnelConductor");
    Tally t;
    for (size_t k = 0; k < table["cases"].size(); ++k) {
        const json& c = table["cases"][k];
        if (c["params"]["material"] != "custom") continue;
        const Vec3d r = vec3(c["params"]["reflectivity"]), g = vec3(c["params"]["edgetint"]);
        const double cos = -dot(vec3(c["globals"]["Rd"]), vec3(c["globals"]["Nf"]));
        for (int i = 0; i < 3; ++i) {
            if (g[i] < 0 || g[i] > 1) continue;
            const auto m = hw::al_metal(r[i], g[i]);
            t.add(hw::fresnel_conductor(cos, m.n, m.k), number(c["output"][i]), label(table, k, "custom"));
        }
    }
    EXPECT_GT(t.compared, 50);
    EXPECT_LT(t.worst, 2e-4) << t.where;
}

TEST(al_surface_reference, rough_refraction) {
    LOAD_OR_SKIP(table, "alSurface.transmission");
    LobeSpec spec{LobeKind::MicrofacetGlass, LobeLabel::Refraction};
    spec.distribution = Distribution::Beckmann;
    spec.fresnel = FresnelMode::TotalReflection;
    spec.anisotropic = true;  // the tables have two widths
    const MicrofacetLayout at(spec);
    Tally t;
    for (size_t k = 0; k < table["cases"].size(); ++k) {
        const json& c = table["cases"][k];
        if (!c.value("refracted", false)) continue;
        const Vec3d wo = vec3(c["params"]["wo"]), wi = vec3(c["wi"]);
        if (wi.z >= 0) continue;  // "refracted" to the viewer's side by a steep microfacet: no light comes from there
        Lobe<double> l;
        l.spec = &spec;
        l.weight = Vec3d(1, 1, 1);
        l.t = {1, 0, 0};
        l.p[at.alpha_x] = number(c["params"]["alphaX"]);
        l.p[at.alpha_y] = number(c["params"]["alphaY"]);
        l.p[at.eta] = number(c["params"]["eta"]);
        // Widths above 1 are limited in a lobe. In narrow ones the table's directions, rounded to float, decide the value.
        if (std::max(l.p[at.alpha_x], l.p[at.alpha_y]) > 1 || std::min(l.p[at.alpha_x], l.p[at.alpha_y]) < 0.005) continue;
        // The original's sampler, which misses a rotation (6.7), also gives microfacets that face away from the viewer.
        const ShadingView<double> view{hw::normalize(wo), {0, 0, 1}, {0, 0, 1}, true};
        const BsdfEval<double> e = eval_lobe<double>(l, view, hw::normalize(wi));
        t.add(e.f_cos.x, number(c["output"][5]), label(table, k, "btdf cos"));
    }
    EXPECT_GT(t.compared, 50);
    EXPECT_LT(t.worst, 1e-3) << t.where;
}

TEST(al_surface_reference, shadow_at_the_first_surface) {
    LOAD_OR_SKIP(table, "alSurface.shadow");
    Tally t;
    for (size_t k = 0; k < table["cases"].size(); ++k) {
        const json& c = table["cases"][k];
        SurfaceNode node(c["params"], {"opacity"});  // linked: keeps the transparent lobe for all
        node.set(Global::I, -vec3(c["globals"]["Rd"]));
        node.set(Global::N, vec3(c["globals"]["Nf"]));
        const auto lobes = node.run();
        const Vec3d passed = lobes[kShadow].weight + lobes[kTransparent].weight;
        for (int i = 0; i < 3; ++i) t.add(1 - passed[i], number(c["output"]["entryOpacity"][i]), label(table, k, "entryOpacity"));
    }
    EXPECT_GT(t.compared, 50);
    EXPECT_LT(t.worst, 2e-4) << t.where;
}

/// One case of the table in which every BRDF value, light sample and traced radiance is prescribed.
class Prescribed {
  public:
    explicit Prescribed(const json& c) : c_(c), type_(*find_node("alSurface")) {
        base_.diffuse = tinted("diffuse");
        base_.backlight = tinted("backlight");
        base_.transmission = tinted("transmission");
        base_.emission = tinted("emission");
        base_.opacity = Vec3d(1, 1, 1);  // the table's colours are not composited yet
        path_.depth = number(c["globals"]["Rr"]);
        path_.diffuse_depth = path_.transmission_depth = 0;
        path_.glossy_depth = number(c["globals"]["Rr_gloss"]);
        path_.previous_alpha = path_.depth > 0 ? number(c["previousRoughness"]) : 0;
        base_.sss_mix = hw::al_sss_mix(path_, value("sssMix"), value("sssWeight1") + value("sssWeight2") + value("sssWeight3") != 0);
        hw::al_balance(base_);
        for (int which : {0, 1}) set_coat(which);
    }

    void check(Tally& t, const std::string& place) const {
        const Vec3d trace = prescribed("trace"), light = prescribed("lightRadiance");
        const double brdf = number(c_["prescribed"]["brdf"]), pdf = number(c_["prescribed"]["pdf"]);
        // The direct pass of these cases hands everything down: no coat dims what lies below.
        hw::AlCoat<double> bare[2];
        const auto direct = hw::al_weights<double>(path_, base_, bare[0], bare[1], false, 1);
        const auto w = hw::al_weights<double>(path_, base_, coat_[0], coat_[1], false, 1);
        expect(t, place, "direct_diffuse", direct.diffuse * light * 0.25);
        expect(t, place, "emission", w.emission);
        for (int which : {0, 1}) {
            const double strength = value(which == 0 ? "specular1IndirectStrength" : "specular2IndirectStrength");
            const double share = mirror_[which] ? 1 : brdf / pdf;
            const Vec3d weight = which == 0 ? w.specular1 : w.specular2;
            const double clamp = value(which == 0 ? "specular1IndirectClamp" : "specular2IndirectClamp");
            Vec3d l = trace * fresnel_[which] * weight * (share * strength);
            for (int i = 0; i < 3; ++i)
                if (clamp > 0) l[i] = std::min(l[i], clamp);
            expect(t, place, which == 0 ? "indirect_specular" : "indirect_specular_2", l);
        }
        if (clear_ && path_.depth == 0 && !attenuated()) {
            Vec3d l;
            const double clamp = value("transmissionClamp");
            for (int i = 0; i < 3; ++i) {
                const double k = base_.transmission[i] != 0 ? w.transmission[i] / base_.transmission[i] : 0;
                l[i] = (clamp > 0 ? std::min(trace[i], clamp) : trace[i]) * k * base_.transmission[i];
            }
            expect(t, place, "refraction", l);
        }
    }

  private:
    double value(const char* name, int i = 0) const {
        if (!c_["params"].contains(name)) return type_.params[type_.param_index(name)].number[i];
        const json& j = c_["params"][name];
        return j.is_array() ? number(j[i]) : j.is_boolean() ? double(j.get<bool>()) : number(j);
    }
    Vec3d color(const char* name) const { return {value(name, 0), value(name, 1), value(name, 2)}; }
    Vec3d tinted(const std::string& lobe) const { return color((lobe + "Color").c_str()) * value((lobe + "Strength").c_str()); }
    Vec3d prescribed(const char* name) const { return vec3(c_["prescribed"][name]); }
    bool attenuated() const {
        return largest(Vec3d(1, 1, 1) - color("ssAttenuationColor")) > 0 || value("ssInScatteringStrength") > 0 || value("ssSpecifyCoefficients") != 0;
    }

    void set_coat(int which) {
        const std::string name = which == 0 ? "specular1" : "specular2";
        const double alpha = std::pow(value((name + "Roughness").c_str()), 2), ior = value((name + "Ior").c_str());
        hw::AlCoat<double>& coat = coat_[which];
        coat.color = tinted(name);
        coat.runs = hw::al_specular_runs<double>(path_, coat.color, alpha, false, true);
        const Vec3d wo = -vec3(c_["globals"]["Rd"]), n = vec3(c_["globals"]["Nf"]);
        mirror_[which] = which == 0 && alpha == 0;
        if (mirror_[which]) {
            coat.runs = coat.runs && hw::al_mirror_runs<double>(path_, dot(wo, n), ior, dot(wo, vec3(c_["globals"]["N"])) < 0);
            clear_ = value("transmissionLinkToSpecular1") != 0;
        } else if (which == 0) {
            clear_ = value("transmissionLinkToSpecular1") == 0 && value("transmissionRoughness") == 0;
        }
        const Vec3d wi = prescribed("sampleDirection");
        const double cos = mirror_[which] ? dot(wo, n) : std::max(0.0, dot(hw::normalize(wi + wo), wi));
        for (int i = 0; i < 3; ++i) {
            const auto m = hw::al_metal(value((name + "Reflectivity").c_str(), i), value((name + "EdgeTint").c_str(), i));
            const bool metallic = c_["params"].value(name + "FresnelMode", "dielectric") == "metallic";
            fresnel_[which][i] = metallic ? hw::fresnel_conductor(cos, m.n, m.k) : hw::fresnel_dielectric(cos, ior);
        }
        // The original counts the indirect strength of a mirror against the layers below, but not that of a rough specular,
        // and a strength of 0 leaves them undimmed.
        const double strength = value((name + "IndirectStrength").c_str());
        coat.albedo = strength == 0 ? 0 : largest(fresnel_[which]) * (mirror_[which] ? strength : 1);
    }

    void expect(Tally& t, const std::string& place, const char* aov, Vec3d got) const {
        if (!c_["aovs"].contains(aov)) return;
        for (int i = 0; i < 3; ++i) t.add(got[i], number(c_["aovs"][aov][i]), place + " " + aov);
    }

    const json& c_;
    const NodeType& type_;
    hw::AlBase<double> base_;
    hw::AlPath<double> path_;
    hw::AlCoat<double> coat_[2];
    Vec3d fresnel_[2];
    bool mirror_[2] = {false, false}, clear_ = false;
};

TEST(al_surface_reference, layers_with_prescribed_values) {
    LOAD_OR_SKIP(table, "alSurface");
    Tally t;
    for (size_t k = 0; k < table["cases"].size(); ++k) Prescribed(table["cases"][k]).check(t, label(table, k, ""));
    EXPECT_GT(t.compared, 50);
    EXPECT_LT(t.worst, 1e-4) << t.where;
}

}  // namespace
}  // namespace alder
