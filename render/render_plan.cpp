// RenderPlan: settles sizes and compiles what the requested AOVs need.
#include "render/render_plan.h"

#include <algorithm>

namespace alder {
namespace {

RenderSettings settled(RenderSettings s, const RenderRequest& r) {
    if (r.width > 0) s.width = r.width;
    if (r.height > 0) s.height = r.height;
    if (r.samples > 0) s.samples = r.samples;
    s.width = std::clamp(s.width, 1, 1 << 16);
    s.height = std::clamp(s.height, 1, 1 << 16);
    s.samples = std::max(s.samples, 1);
    // Depths are counted in 16 bits.
    for (int* b : {&s.max_bounces, &s.diffuse_bounces, &s.glossy_bounces, &s.transmission_bounces, &s.volume_bounces, &s.transparent_bounces})
        *b = std::clamp(*b, 0, 30000);
    return s;
}

}  // namespace

RenderPlan::RenderPlan(const PreparedScene& s, const RenderRequest& r)
    : scene(s),
      settings(settled(s.scene->settings, r)),
      seed(r.seed != 0 ? r.seed : s.scene->settings.seed),
      camera(s.scene->camera, settings.width, settings.height),
      filter(settings.filter, settings.filter_width),
      shutter(settings.shutter_curve),
      moves(s.surfaces->anything_moves() || camera.moves()),
      query(*s.surfaces),
      cancel(r.cancel) {
    width = settings.width;
    height = settings.height;
    if (r.crop[2] > r.crop[0] && r.crop[3] > r.crop[1]) {
        crop_x = std::clamp(r.crop[0], 0, settings.width - 1);
        crop_y = std::clamp(r.crop[1], 0, settings.height - 1);
        width = std::clamp(r.crop[2], crop_x + 1, settings.width) - crop_x;
        height = std::clamp(r.crop[3], crop_y + 1, settings.height) - crop_y;
    }
    inputs = {s.surfaces.get(), &camera, s.material_pass_index};
    media = MediaPlan::make(s.materials, s.world->volume.get(), inputs, s.scene->camera.to_world.point(Vec3f(0.f)), s.workers->context());

    for (const auto& m : s.materials)
        if (m->material.graph)
            for (const std::string& name : m->material.graph->aov_names()) graph_aovs.push_back(name);
    const std::vector<std::string> names = expand_aovs(r.aovs, graph_aovs);

    std::vector<std::pair<std::string, Type>> scene_aovs;
    std::vector<std::vector<std::string>> present(s.materials.size());
    surface.resize(s.materials.size());
    for (size_t i = 0; i < s.materials.size(); ++i) {
        surface[i].plain = surface[i].with_aovs = s.materials[i]->surface.get();
        if (names.empty()) continue;
        auto program = compile_with_aovs(s.materials[i]->material, *s.surfaces, settings, names, present[i]);
        if (!program) continue;
        surface[i].with_aovs = program.get();
        for (size_t k = 0; k < present[i].size(); ++k) {
            const bool known = std::any_of(scene_aovs.begin(), scene_aovs.end(), [&](const auto& a) { return a.first == present[i][k]; });
            if (!known) scene_aovs.emplace_back(present[i][k], program->program->outputs()[k].type);
        }
        owned_.push_back(std::move(program));
    }
    aovs = std::make_shared<AovPlan>(names, scene_aovs);
    for (size_t i = 0; i < s.materials.size(); ++i)
        for (const std::string& name : present[i])
            for (size_t u = 0; u < aovs->user.size(); ++u)
                if (aovs->user[u].name == name) surface[i].aov_user.push_back(static_cast<int>(u));
}

}  // namespace alder
