// Reports: diagnostics and the compiled form of a graph as JSON.
#include "graph/report.h"

#include <algorithm>
#include <set>

#include "nodes/schema.h"

namespace alder {

const char* closure_name(const LobeSpec& spec) {
    switch (spec.kind) {
        case LobeKind::Emission: return "emission";
        case LobeKind::Transparent: return "transparent";
        case LobeKind::Holdout: return "holdout";
        case LobeKind::Diffuse: return "diffuse";
        case LobeKind::OrenNayar: return "oren_nayar";
        case LobeKind::Translucent: return "translucent";
        case LobeKind::SheenMicrofiber: return "sheen_microfiber";
        case LobeKind::SheenAshikhmin: return "sheen_ashikhmin";
        case LobeKind::ToonDiffuse: return "toon_diffuse";
        case LobeKind::ToonGlossy: return "toon_glossy";
        case LobeKind::MicrofacetReflection: return spec.distribution == Distribution::GGX ? "ggx" : "beckmann";
        case LobeKind::MicrofacetTransmission: return spec.distribution == Distribution::GGX ? "ggx_refraction" : "beckmann_refraction";
        case LobeKind::MicrofacetGlass: return spec.distribution == Distribution::GGX ? "ggx_glass" : "beckmann_glass";
        case LobeKind::AshikhminShirley: return "ashikhmin_shirley";
        case LobeKind::HairReflection: return "hair_reflection";
        case LobeKind::HairTransmission: return "hair_transmission";
        case LobeKind::HairChiang: return "hair_chiang";
        case LobeKind::HairOrder: return "hair_order";
        case LobeKind::HairHuang: return "hair_huang";
        case LobeKind::HairKajiya: return "hair_diffuse";
        case LobeKind::HairGlossy: return "hair_glossy";
        case LobeKind::HairForward: return "hair_forward";
        case LobeKind::HairGlint: return "hair_glint";
        case LobeKind::HairDual: return "hair_dual";
        case LobeKind::Measured: return "measured";
        case LobeKind::RandomWalk: return "random_walk";
        case LobeKind::Profile: return "subsurface_profile";
        case LobeKind::Absorption: return "absorption";
        case LobeKind::PhaseHenyeyGreenstein: return "henyey_greenstein";
        case LobeKind::PhaseRayleigh: return "rayleigh";
        case LobeKind::PhaseDraine: return "draine";
        case LobeKind::PhaseFournierForand: return "fournier_forand";
        case LobeKind::Interior: return "interior";
        case LobeKind::RayPortal: return "ray_portal";
        case LobeKind::kCount: break;
    }
    return "?";
}

ProgramRequest everything(const Material& material) {
    ProgramRequest request;
    if (material.has_surface()) request.surface = LobeFilter::Surface;
    else request.volume = material.has_volume();
    request.displacement = material.has_displacement();
    request.aovs = material.aov_names();
    return request;
}

nlohmann::json to_json(const Diagnostic& d) {
    nlohmann::json j = {{"pointer", d.pointer}, {"code", d.code}};
    if (!d.found.empty()) j["found"] = d.found;
    if (!d.expected.empty()) j["expected"] = d.expected;
    if (!d.suggest.empty()) j["suggest"] = d.suggest;
    if (!d.path.empty()) j["path"] = d.path;
    return j;
}

nlohmann::json to_json(const std::vector<Diagnostic>& list) {
    nlohmann::json j = nlohmann::json::array();
    for (const auto& d : list) {
        if (j.size() == kMaxDiagnostics) break;
        j.push_back(to_json(d));
    }
    return j;
}

nlohmann::json graph_report(const Material* material, Diagnostics d) {
    nlohmann::json compiled = nullptr;
    if (material) {
        const ProgramRequest request = everything(*material);  // as a camera ray would need it
        if (const auto program = material->program(request, d)) {
            const ProgramStats& s = program->stats();
            std::set<std::string> closures, needs;
            for (const ProgramLobe& lobe : program->lobes()) closures.insert(closure_name(lobe.spec));
            for (const ProgramInput& in : program->inputs()) {
                if (in.is_attribute)
                    needs.insert("attribute:" + in.attribute);
                else if (const char* name = global_name(in.global))
                    needs.insert(name);
            }
            compiled = {{"nodes", s.nodes}, {"live_nodes", s.live_nodes}, {"pruned", s.skipped}, {"constant_folded", s.folded},
                        {"merged", s.merged}, {"regions", s.regions}, {"instructions", s.ops}, {"closures", closures}, {"needs", needs},
                        {"compile_seconds", s.compile_seconds}};
        }
    }
    nlohmann::json unsupported = nlohmann::json::array();
    for (const Diagnostic& e : d.errors)
        if (e.code == "unsupported") unsupported.push_back(e.pointer);
    if (!compiled.is_null()) compiled["unsupported"] = unsupported;
    nlohmann::json report = {{"ok", d.ok() && material != nullptr}, {"errors", to_json(d.errors)}, {"warnings", to_json(d.warnings)}};
    if (!compiled.is_null()) report["compiled"] = std::move(compiled);
    return report;
}

}  // namespace alder
