// alSurface: its schema against the catalogue, its switches, its refusals, and what each setting does to the lobes.
#include <fstream>
#include <random>

#include "nodes/surface/al_surface_params.h"
#include "tests/nodes/surface/al_fixture.h"

namespace alder {
namespace {

using namespace testing;
using namespace al_surface;

json catalogue(const std::string& node) {
    std::ifstream f(std::string(ALDER_SOURCE_DIR) + "/tests/data/alshaders/surface_catalogue.json");
    const json all = json::parse(f);
    for (const json& n : all["nodes"])
        if (n["name"] == node) return n["parameters"];
    return nullptr;
}

TEST(al_surface, schema_is_the_catalogues) {
    const NodeType& type = *find_node("alSurface");
    const json rows = catalogue("alSurface");
    ASSERT_EQ(rows.size(), type.params.size());
    const std::map<std::string, Type> types = {{"float", Type::Float}, {"int", Type::Int},       {"bool", Type::Bool}, {"rgb", Type::Color},
                                               {"vector", Type::Vector}, {"string", Type::String}, {"enum", Type::Enum}};
    for (size_t k = 0; k < rows.size(); ++k) {
        const json& row = rows[k];
        const Param& p = type.params[k];
        SCOPED_TRACE(row["name"].get<std::string>());
        EXPECT_EQ(p.name, row["name"]);
        EXPECT_EQ(p.type, types.at(row["type"]));
        const json& d = row["default"];
        if (d.is_string()) {
            EXPECT_EQ(p.text, d);
        } else {
            for (size_t c = 0; c < (d.is_array() ? d.size() : 1); ++c)
                EXPECT_EQ(p.number[c], d.is_array() ? d[c].get<double>() : d.is_boolean() ? double(d.get<bool>()) : d.get<double>());
        }
        if (row.contains("enum")) {
            ASSERT_EQ(p.items.size(), row["enum"].size());
            for (size_t i = 0; i < p.items.size(); ++i) EXPECT_EQ(p.items[i].name, row["enum"][i]);
        }
        EXPECT_EQ(p.takes_links, row["takesLinks"].get<bool>());
        EXPECT_EQ(p.link_only, row.value("onlyUsedWhenLinked", false));
        const json ui = row.value("ui", json::object());
        EXPECT_EQ(p.group, ui.value("group", ""));
        EXPECT_EQ(p.label, ui.value("label", ""));
        if (ui.contains("min")) {
            EXPECT_EQ(p.soft_min, ui["min"].get<double>());
            EXPECT_EQ(p.soft_max, ui["max"].get<double>());
        }
        EXPECT_FALSE(p.help.empty());
    }
}

TEST(al_surface, defaults_are_accepted_and_grey_with_a_coat) {
    const SurfaceNode node(json::object());
    EXPECT_TRUE(node.faults().empty());
    const auto lobes = node.run();
    ASSERT_EQ(lobes.size(), size_t(kLobeCount - 1)) << "an opaque surface has no transparent lobe";
    const double f0 = std::pow(0.4 / 2.4, 2);
    EXPECT_NEAR(lobes[kDiffuse].weight.x, 0.5 * (1 - f0), 2e-3);
    EXPECT_EQ(lobes[kSpecular1].weight.x, 1);
    EXPECT_EQ(lobes[kSpecular1].p[0], 0.3 * 0.3) << "roughness is squared";
    for (int k : {kSpecular2, kBacklight, kTransmission, kEmission, kShadow}) EXPECT_EQ(largest(lobes[k].weight), 0) << k;
}

TEST(al_surface, parameters_of_black_lobes_are_not_needed) {
    const SurfaceNode plain(json::object());
    EXPECT_FALSE(plain.uses("specular2Roughness"));
    EXPECT_FALSE(plain.uses("transmissionIor"));
    EXPECT_FALSE(plain.uses("specular1Rotation")) << "no anisotropy";
    EXPECT_FALSE(plain.uses("specular1EdgeTint")) << "dielectric";
    EXPECT_TRUE(plain.uses("specular1Roughness"));
    const SurfaceNode matt = surface({{"specular1Strength", 0}});
    EXPECT_FALSE(matt.uses("specular1Roughness"));
    EXPECT_FALSE(matt.uses("specular1Color"));
    const SurfaceNode clear = surface({{"specular1Strength", 0}, {"transmissionStrength", 1}});
    EXPECT_TRUE(clear.uses("specular1Roughness")) << "transmission is linked to it";
    EXPECT_TRUE(clear.uses("specular1Ior"));
    EXPECT_FALSE(surface({{"debug", "diffuse-color"}}).uses("diffuseStrength"));
    EXPECT_TRUE(surface({{"debug", "sss-color-2"}}).uses("sssRadiusColor2"));
}

TEST(al_surface, colours_beyond_the_budget_are_scaled_together) {
    const auto lobes = surface({{"diffuseColor", {1.0, 0.5, 0.25}}, {"backlightStrength", 1}, {"backlightColor", {0.5, 0, 0}},
                                    {"transmissionStrength", 0.5}, {"specular1Strength", 0}}).run();
    EXPECT_NEAR(lobes[kDiffuse].weight.x, 0.5, 1e-12);
    EXPECT_NEAR(lobes[kDiffuse].weight.z, 0.125, 1e-12);
    EXPECT_NEAR(lobes[kBacklight].weight.x, 0.25, 1e-12);
    EXPECT_NEAR(lobes[kTransmission].weight.y, 0.25, 1e-12);
}

TEST(al_surface, opacity_scales_every_lobe_and_the_rest_is_transparent) {
    const json params = {{"backlightStrength", 1}, {"transmissionStrength", 0.3}, {"emissionStrength", 2}, {"specular2Strength", 0.5}};
    json covered = params;
    covered["opacity"] = {0.25, 1.5, -1};
    const auto full = SurfaceNode(params).run(), part = SurfaceNode(covered).run();
    ASSERT_EQ(part.size(), size_t(kLobeCount));
    for (int k = 0; k < kTransparent; ++k) {
        EXPECT_NEAR(part[k].weight.x, 0.25 * full[k].weight.x, 1e-12) << k;
        EXPECT_NEAR(part[k].weight.y, full[k].weight.y, 1e-12) << k;
        EXPECT_EQ(part[k].weight.z, 0) << k;
    }
    EXPECT_EQ(part[kTransparent].weight.x, 0.75);
    EXPECT_EQ(part[kTransparent].weight.y, 0);
    EXPECT_EQ(part[kTransparent].weight.z, 1);
}

TEST(al_surface, caustic_switches_follow_the_path) {
    const json params = {{"specular2Strength", 1}, {"transmissionStrength", 0.5}, {"specular1Roughness", 0.2}};
    const auto lobes = [&](json extra, Global g, double depth) {
        json p = params;
        p.update(extra);
        SurfaceNode node(p);
        node.set(g, depth);
        node.set(Global::RayDepth, depth);
        return node.run();
    };
    auto l = lobes(json::object(), Global::DiffuseDepth, 1);
    EXPECT_EQ(largest(l[kSpecular1].weight), 0);
    EXPECT_EQ(largest(l[kSpecular2].weight), 0);
    EXPECT_EQ(largest(l[kTransmission].weight), 0);
    EXPECT_GT(largest(l[kShadow].weight), 0) << "light still falls through";
    EXPECT_NEAR(l[kDiffuse].weight.x, 0.5, 1e-12) << "no specular, so nothing is taken from diffuse";
    l = lobes({{"specular1CausticPaths", true}, {"transmissionCausticPaths", true}}, Global::DiffuseDepth, 1);
    EXPECT_EQ(l[kSpecular1].weight.x, 1);
    EXPECT_EQ(largest(l[kSpecular2].weight), 0);
    EXPECT_GT(largest(l[kTransmission].weight), 0);
    l = lobes(json::object(), Global::TransmissionDepth, 1);
    EXPECT_EQ(l[kSpecular1].weight.x, 1);
    l = lobes({{"transmissionEnableCaustics", false}}, Global::TransmissionDepth, 1);
    EXPECT_EQ(largest(l[kSpecular1].weight), 0);
    EXPECT_EQ(largest(l[kSpecular2].weight), 0);
    EXPECT_GT(largest(l[kTransmission].weight), 0);
}

TEST(al_surface, rough_paths_widen_what_they_see_and_hide_mirrors) {
    const auto lobes = [](json params, double previous, double depth) {
        SurfaceNode node(params);
        node.set(Global::PreviousAlpha, previous);
        node.set(Global::RayDepth, depth);
        return node.run();
    };
    const json rough = {{"specular1Roughness", 0.1}, {"transmissionStrength", 1}};
    EXPECT_NEAR(lobes(rough, 0.4, 1)[kSpecular1].p[0], 0.4, 1e-12);
    EXPECT_NEAR(lobes(rough, 0.4, 1)[kTransmission].p[0], 0.4, 1e-12);
    EXPECT_NEAR(lobes(rough, 0.4, 0)[kSpecular1].p[0], 0.01, 1e-12) << "camera rays have no past";
    json scaled = rough;
    scaled["specular1RoughnessDepthScale"] = 0.5;
    EXPECT_NEAR(lobes(scaled, 0.4, 1)[kSpecular1].p[0], 0.2, 1e-12);
    scaled["rr"] = false;
    EXPECT_NEAR(lobes(scaled, 0.4, 1)[kSpecular1].p[0], 0.01, 1e-12);
    const json mirror = {{"specular1Roughness", 0}, {"transmissionStrength", 1}};
    EXPECT_EQ(lobes(mirror, 0, 1)[kSpecular1].p[0], 0) << "a mirror";
    EXPECT_EQ(lobes(mirror, 0, 1)[kTransmission].p[0], 0) << "clear";
    EXPECT_EQ(lobes(mirror, 0, 1)[kSpecular1].weight.x, 1);
    EXPECT_EQ(lobes(mirror, 0.2, 1)[kSpecular1].weight.x, 0);
    EXPECT_EQ(surface({{"specular2Strength", 1}, {"specular2Roughness", 0}}).run()[kSpecular2].p[0], 1e-3) << "no mirror path";
    EXPECT_EQ(largest(surface({{"specular1Roughness", 1.01}}).run()[kSpecular1].weight), 0);
}

TEST(al_surface, inside_the_index_is_inverted_and_total_reflection_leaves_transmission_whole) {
    SurfaceNode node = surface({{"transmissionStrength", 1}, {"diffuseStrength", 0}, {"specular1Roughness", 0}, {"specular1Ior", 1.5}});
    EXPECT_EQ(node.run()[kTransmission].p[1], 1.5);
    node.set(Global::Backfacing, 1);
    EXPECT_NEAR(node.run()[kTransmission].p[1], 1 / 1.5, 1e-12);
    EXPECT_EQ(node.run()[kSpecular1].weight.x, 1);
    const double s = 0.7;  // beyond asin(1/1.5)
    node.set(Global::I, {s, 0, std::sqrt(1 - s * s)});
    const auto lobes = node.run();
    EXPECT_EQ(lobes[kSpecular1].weight.x, 0);
    EXPECT_EQ(lobes[kTransmission].weight.x, 1);
    const BsdfSample<double> sample = sample_lobe<double>(lobes[kTransmission], {{s, 0, std::sqrt(1 - s * s)}, {0, 0, 1}, {0, 0, 1}}, 0.3, 0.3, 0.3);
    ASSERT_TRUE(sample.valid);
    EXPECT_FALSE(sample.is_transmission);
    EXPECT_NEAR(sample.wi.x, -s, 1e-12);
    EXPECT_NEAR(sample.weight.x, 1, 1e-12);
}

TEST(al_surface, linked_normals_replace_the_shading_normal_of_their_lobe) {
    const json params = {{"specular1Normal", {0, 3, 4}}, {"diffuseNormal", {0, 0, 0}}, {"transmissionNormal", {0, -3, -4}},
                         {"transmissionStrength", 0.5}};
    const auto constant = SurfaceNode(params).run();
    EXPECT_EQ(constant[kSpecular1].n.z, 1) << "the constant is never used";
    const auto linked = SurfaceNode(params, {"specular1Normal", "diffuseNormal", "transmissionNormal"}).run();
    EXPECT_NEAR(linked[kSpecular1].n.y, 0.6, 1e-12);
    EXPECT_EQ(linked[kDiffuse].n.z, 1) << "no length, no direction";
    EXPECT_NEAR(linked[kTransmission].n.z, 0.8, 1e-12) << "turned to the viewer";
}

TEST(al_surface, debug_shows_the_raw_value_as_emission) {
    const auto shown = [](const char* item, json params = json::object()) {
        params["debug"] = item;
        params["opacity"] = {0.1, 0.1, 0.1};
        const SurfaceNode node(params);
        const auto lobes = node.run();
        EXPECT_EQ(lobes.size(), 1u);
        EXPECT_EQ(node.statics().lobes[0].kind, LobeKind::Emission);
        return lobes[0].weight;
    };
    const Vec3d c = shown("diffuse-color", {{"diffuseColor", {0.1, 2, -3}}});
    EXPECT_EQ(c.x, 0.1);
    EXPECT_EQ(c.y, 2);
    EXPECT_EQ(c.z, -3);
    EXPECT_EQ(shown("specular-1-roughness", {{"specular1Roughness", 0.5}}).y, 0.5) << "before squaring";
    EXPECT_EQ(shown("transmission-roughness", {{"transmissionRoughness", 0.7}}).z, 0.7);
    EXPECT_EQ(shown("sss-color-3").x, 0.523);
    EXPECT_EQ(shown("sss-weight-1", {{"sssWeight1", 0.4}}).x, 0.4);
    EXPECT_TRUE(surface({{"debug", "sss-mix"}, {"sssMix", 1}}).faults().empty());
}

TEST(al_surface, what_would_change_the_picture_and_is_not_there_is_refused) {
    const auto fault = [](const json& params, const std::set<std::string>& links = {}) {
        const auto errors = SurfaceNode(params, links).faults();
        return errors.empty() ? std::string() : errors.size() > 1 ? "several" : errors[0].substr(0, errors[0].find(':'));
    };
    EXPECT_EQ(fault({{"sssMix", 0.5}}), "");
    EXPECT_EQ(fault({{"sssMix", 0.5}, {"sssMode", "diffusion"}}), "sssMode");
    EXPECT_EQ(fault({{"sssMode", "directional"}}, {"sssMix"}), "sssMode");
    EXPECT_EQ(fault({{"sssMode", "directional"}, {"sssMix", 0.009}}), "") << "below 0.01 is off";
    EXPECT_EQ(fault({{"sssMode", "directional"}, {"sssMix", 1}, {"diffuseStrength", 0}}), "");
    EXPECT_EQ(fault({{"sssMode", "directional"}, {"sssMix", 1}, {"sssWeight1", 0}}), "") << "no weights, no scattering";
    EXPECT_EQ(fault({{"ssAttenuationColor", {1, 0.9, 1}}, {"transmissionStrength", 1}}), "");
    EXPECT_EQ(fault({{"diffuseIndirectStrength", 0.5}}), "diffuseIndirectStrength");
    EXPECT_EQ(fault({{"specular1IndirectClamp", 2}}), "specular1IndirectClamp");
    EXPECT_EQ(fault({{"specular2IndirectClamp", 2}}), "") << "specular 2 is off";
    EXPECT_EQ(fault({{"specular1InternalDirect", false}}), "specular1InternalDirect");
    EXPECT_EQ(fault({{"aov_emission_clamp", 1}}), "aov_emission_clamp");
    EXPECT_EQ(fault({{"traceSetAll", "-lamps"}}), "traceSetAll");
    EXPECT_EQ(fault({{"transmitAovs", true}}), "transmitAovs");
    EXPECT_EQ(fault({{"aov_emission", "glow"}, {"diffuseExtraSamples", 3}, {"rrTransmissionDepth", 4}}), "");
}

TEST(al_surface, metallic_specular_reflects_the_colour_of_the_metal_and_casts_a_full_shadow) {
    const json gold = {{"specular1FresnelMode", "metallic"}, {"specular1Reflectivity", {0.9, 0.7, 0.3}}, {"specular1Roughness", 0},
                       {"transmissionStrength", 0.5}};
    SurfaceNode node(gold);  // the lobes refer to its specs
    const auto lobes = node.run();
    const MicrofacetLayout at(*lobes[kSpecular1].spec);
    for (int c = 0; c < 3; ++c) {
        const double n = lobes[kSpecular1].p[at.f0 + c], k = lobes[kSpecular1].p[at.edge + c];
        EXPECT_NEAR(((n - 1) * (n - 1) + k * k) / ((n + 1) * (n + 1) + k * k), gold["specular1Reflectivity"][c].get<double>(), 1e-12);
    }
    EXPECT_NEAR(lobes[kDiffuse].weight.x, 0.5 * (1 - 0.9), 1e-9) << "the largest channel is what is passed on";
    EXPECT_EQ(largest(lobes[kShadow].weight), 0);
}

TEST(al_surface, lanes_agree_with_double) {
    std::mt19937 engine(5);
    std::uniform_real_distribution<double> u(0, 1);
    const NodeType& type = *find_node("alSurface");
    double worst = 0;
    for (int k = 0; k < 300; ++k) {
        json params = {{"specular1Distribution", k % 2 ? "ggx" : "beckmann"}, {"specular2FresnelMode", k % 3 ? "dielectric" : "metallic"},
                       {"specular1FresnelMode", k % 5 ? "dielectric" : "metallic"}};
        for (const Param& p : type.params) {
            if (channels(p.type) == 3 && p.takes_links) params[p.name] = {u(engine), u(engine), u(engine)};
            if (p.type == Type::Float && p.takes_links) params[p.name] = u(engine);
        }
        params["specular1Ior"] = 1 + 2 * u(engine);
        params["specular2Ior"] = 1 + 2 * u(engine);
        SurfaceNode node(params, k % 2 ? std::set<std::string>{"specular1Normal", "diffuseNormal"} : std::set<std::string>{});
        const double z = 0.05 + 0.95 * u(engine), phi = 6.28 * u(engine), s = std::sqrt(1 - z * z);
        node.set(Global::I, {s * std::cos(phi), s * std::sin(phi), z});
        node.set(Global::Backfacing, k % 7 == 0);
        node.set(Global::RayDepth, k % 4);
        node.set(Global::PreviousAlpha, u(engine) * (k % 4 > 0));
        const auto exact = node.run();
        const auto lanes = node.run_lanes();
        for (size_t l = 0; l < exact.size(); ++l) {
            const Vec3d w = exact[l].weight;
            for (int c = 0; c < 3; ++c) {
                worst = std::max(worst, std::abs(w[c] - lanes[l].weight[c]));
                worst = std::max(worst, std::abs(exact[l].n[c] - lanes[l].n[c]));
                worst = std::max(worst, std::abs(exact[l].t[c] - lanes[l].t[c]));
            }
            for (int p = 0; p < exact[l].spec->params(); ++p)
                worst = std::max(worst, std::abs(exact[l].p[p] - lanes[l].p[p]) / std::max(1.0, std::abs(exact[l].p[p])));
        }
    }
    EXPECT_LT(worst, 2e-5);
}

TEST(al_surface, no_input_breaks_it) {
    const double values[] = {0, -0.0, 1e-30, -1, 1, 0.5, 1e30, -1e30, INFINITY, -INFINITY, NAN};
    const NodeType& type = *find_node("alSurface");
    for (const Param& p : type.params) {
        if (channels(p.type) == 0 || !p.takes_links) continue;
        for (double v : values) {
            json params = {{"specular2Strength", 0.5}, {"transmissionStrength", 0.2}, {"backlightStrength", 0.5}, {"specular1Anisotropy", 0.8},
                           {"specular2FresnelMode", "metallic"}};
            const bool special = !std::isfinite(v);
            const json x = special ? json(std::isnan(v) ? "nan" : v > 0 ? "inf" : "-inf") : json(v);
            params[p.name] = channels(p.type) == 3 ? json::array({x, x, x}) : x;
            SurfaceNode node(params, {p.name});
            for (const Lobe<float>& l : node.run_lanes())
                EXPECT_TRUE(special || std::abs(v) > 1e10 || std::isfinite(l.weight.x + l.weight.y + l.weight.z)) << p.name << " = " << v;
        }
    }
}

}  // namespace
}  // namespace alder
