// Programs of a scene's materials.
#include "render/programs.h"

#include <algorithm>
#include <set>

namespace alder {
namespace {

std::shared_ptr<const SceneProgram> resolved(std::shared_ptr<const Program> p, const Surfaces& surfaces, bool in_volume = false) {
    if (!p) return nullptr;
    InputPlan plan(*p, surfaces, in_volume);
    return std::make_shared<SceneProgram>(SceneProgram{std::move(p), std::move(plan)});
}

void append(Diagnostics& to, Diagnostics from, const std::string& prefix) {
    for (auto* list : {&from.errors, &from.warnings})
        for (Diagnostic& e : *list) e.pointer = prefix + e.pointer;
    to.errors.insert(to.errors.end(), from.errors.begin(), from.errors.end());
    to.warnings.insert(to.warnings.end(), from.warnings.begin(), from.warnings.end());
}

/// AOVs that closure nodes carry ("id_1"); black where a material's closures do not.
const std::set<std::string>& closure_aov_names() {
    static const std::set<std::string> names = [] {
        std::set<std::string> all;
        for (const NodeType* n : all_nodes())
            for (const auto& [name, param] : n->closure_aovs) all.insert(name);
        return all;
    }();
    return names;
}

}  // namespace

std::shared_ptr<const MaterialPrograms> compile_material(const SceneMaterial& material, const Surfaces& surfaces, const RenderSettings& settings,
                                                         Diagnostics& d) {
    auto m = std::make_shared<MaterialPrograms>();
    m->material = material;
    if (!material.graph || (!material.graph->has_surface() && !material.graph->has_volume())) return m;
    Diagnostics own;
    const auto compile = [&](LobeFilter lobes) {
        ProgramRequest request;
        request.surface = lobes;
        request.filter_textures = settings.texture_filter;
        request.fade_noise = settings.noise_filter;
        return material.graph->program(request, own);
    };
    std::shared_ptr<const Program> surface, shadow, emission, volume;
    if (material.graph->has_volume()) volume = material.graph->program({.volume = true}, own);
    if (own.ok() && material.graph->has_surface()) surface = compile(LobeFilter::Surface);
    if (own.ok() && surface) shadow = compile(LobeFilter::Transparency | LobeFilter::Shadow);
    if (own.ok() && surface && surface->facts().has_emission) emission = compile(LobeFilter::Emission);
    const bool ok = own.ok();
    append(d, std::move(own), "/materials/" + material.name);
    if (!ok) return nullptr;

    m->surface = resolved(surface, surfaces);
    if (volume && !volume->lobes().empty()) m->volume = resolved(volume, surfaces, true);
    m->boundary_only = !surface && volume;
    if (shadow && shadow->facts().may_be_transparent) m->shadow = resolved(shadow, surfaces);
    if (emission && emission->facts().has_emission) {
        const ProgramFacts& facts = emission->facts();
        m->emission_constant = facts.emission_constant;
        m->emission_value = {facts.emission[0], facts.emission[1], facts.emission[2]};
        m->emission = resolved(emission, surfaces);
    }
    return m;
}

std::shared_ptr<const SceneProgram> compile_with_aovs(const SceneMaterial& material, const Surfaces& surfaces, const RenderSettings& settings,
                                                      const std::vector<std::string>& names, std::vector<std::string>& present) {
    present.clear();
    if (!material.graph || !material.graph->has_surface()) return nullptr;
    const std::vector<std::string> own = material.graph->aov_names();
    const std::set<std::string>& carried = closure_aov_names();
    for (const std::string& name : names)
        if (std::find(own.begin(), own.end(), name) != own.end() || carried.contains(name)) present.push_back(name);
    if (present.empty()) return nullptr;
    ProgramRequest request;
    request.surface = LobeFilter::Surface;
    request.aovs = present;
    request.filter_textures = settings.texture_filter;
    request.fade_noise = settings.noise_filter;
    Diagnostics d;
    return resolved(material.graph->program(request, d), surfaces);
}

void require_files(const Scene& scene, Diagnostics& d) {
    const auto add = [&](const std::shared_ptr<const Material>& graph) {
        if (!graph) return;
        for (Diagnostic& fault : graph->file_faults())
            if (d.errors.size() < kMaxDiagnostics) d.errors.push_back(std::move(fault));
    };
    for (const SceneMaterial& m : scene.materials) add(m.graph);
    for (const Light& l : scene.lights) add(l.graph);
    add(scene.world.graph);
}

}  // namespace alder
