// PreparedScene: builds what a render needs, and swaps one material.
#include "render/prepared_scene.h"

#include <chrono>
#include <cmath>

#include "render/worker.h"

namespace alder {
namespace {

double seconds_since(std::chrono::steady_clock::time_point t) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - t).count();
}

void fault(Diagnostics& d, std::string pointer, std::string found, std::string expected) {
    if (d.errors.size() < kMaxDiagnostics) d.errors.push_back({std::move(pointer), "scene-invalid", std::move(found), std::move(expected), {}});
}

/// Everything that would read outside an array. Values (NaN positions, zero areas) are dealt with where they are used.
void check(const Scene& s, Diagnostics& d) {
    for (size_t i = 0; i < s.meshes.size(); ++i) {
        const std::string at = "/meshes/" + std::to_string(i);
        if (!s.meshes[i]) {
            fault(d, at, "nothing", "a mesh");
            continue;
        }
        const Mesh& m = *s.meshes[i];
        const size_t triangles = m.triangles.size(), corners = 3 * triangles;
        for (const auto& t : m.triangles)
            if (std::max({t[0], t[1], t[2]}) >= m.positions.size()) {
                fault(d, at + "/triangles", "index " + std::to_string(std::max({t[0], t[1], t[2]})),
                      "below " + std::to_string(m.positions.size()));
                break;
            }
        const auto length = [&](const char* name, size_t have, size_t want) {
            if (have != 0 && have != want)
                fault(d, at + "/" + name, std::to_string(have) + " elements", std::to_string(want) + " or none");
        };
        length("vertex_normals", m.vertex_normals.size(), m.positions.size());
        length("corner_normals", m.corner_normals.size(), corners);
        length("smooth", m.smooth.size(), triangles);
        length("face_material", m.face_material.size(), triangles);
        length("uv", m.uv.size(), corners);
        length("tangents", m.tangents.size(), corners);
    }
    for (size_t i = 0; i < s.instances.size(); ++i) {
        const Instance& in = s.instances[i];
        const std::string at = "/instances/" + std::to_string(i);
        if (in.mesh >= s.meshes.size()) fault(d, at + "/mesh", std::to_string(in.mesh), "below " + std::to_string(s.meshes.size()));
        if (in.materials.empty()) fault(d, at + "/materials", "none", "at least one material");
        for (uint32_t m : in.materials)
            if (m >= s.materials.size()) fault(d, at + "/materials", std::to_string(m), "below " + std::to_string(s.materials.size()));
    }
}

void warn_about_displacement(const SceneMaterial& m, Diagnostics& d) {
    if (m.graph && m.graph->has_displacement())
        d.warnings.push_back({"/materials/" + m.name + "/outputs/displacement", "unsupported", "displacement",
                              "no displacement: the surface is rendered undisplaced", {}});
}

void finish(PreparedScene& p) {
    p.material_pass_index.clear();
    p.has_transparent_shadows = false;
    for (const auto& m : p.materials) {
        p.material_pass_index.push_back(m->material.pass_index);
        p.has_transparent_shadows |= m->shadow != nullptr || m->boundary_only;
    }
}

void build_lights(PreparedScene& p) {
    const CameraModel camera(p.scene->camera, p.scene->settings.width, p.scene->settings.height);
    p.lights = std::make_shared<LightTable>(*p.surfaces, p.materials, p.lamps, p.light_programs, p.world, camera,
                                            p.workers->context());
}

}  // namespace

WorkerPool::WorkerPool(const EvalContext& context) : context_(context) {}
WorkerPool::~WorkerPool() = default;

std::unique_ptr<Worker> WorkerPool::take() {
    {
        const std::scoped_lock lock(mutex_);
        if (!idle_.empty()) {
            auto w = std::move(idle_.back());
            idle_.pop_back();
            return w;
        }
    }
    return std::make_unique<Worker>(context_);
}

void WorkerPool::give_back(std::unique_ptr<Worker> worker) {
    const std::scoped_lock lock(mutex_);
    idle_.push_back(std::move(worker));
}

std::shared_ptr<const PreparedScene> prepare_scene(std::shared_ptr<const Scene> scene, const EvalContext& context, Diagnostics& d) {
    check(*scene, d);
    if (!d.ok()) return nullptr;
    auto p = std::make_shared<PreparedScene>();
    p->scene = scene;
    p->workers = std::make_shared<WorkerPool>(context);
    const auto build_start = std::chrono::steady_clock::now();
    p->surfaces = std::make_shared<Surfaces>(scene->meshes, scene->instances);
    p->build_seconds = seconds_since(build_start);

    const auto compile_start = std::chrono::steady_clock::now();
    for (const SceneMaterial& m : scene->materials) {
        warn_about_displacement(m, d);
        p->materials.push_back(compile_material(m, *p->surfaces, scene->settings, d));
    }
    p->lamps = scene->lights;
    for (size_t i = 0; i < scene->lights.size(); ++i) {
        const Light& light = scene->lights[i];
        if (!light.graph) {
            p->light_programs.push_back(nullptr);
            continue;
        }
        const auto m = compile_material({light.name, light.graph, 0}, *p->surfaces, scene->settings, d);
        const bool constant = m && (!m->emission || m->emission_constant);
        if (constant) p->lamps[i].color *= m->emission_value;  // the graph is a factor; black where it does not emit
        p->light_programs.push_back(constant || !m ? nullptr : m->emission);
    }
    p->compile_seconds = seconds_since(compile_start);
    if (!d.ok()) return nullptr;

    const auto light_start = std::chrono::steady_clock::now();
    const CameraModel camera(scene->camera, scene->settings.width, scene->settings.height);
    p->world = build_world(scene->world, *p->surfaces, camera, context, d);
    if (!d.ok()) return nullptr;
    finish(*p);
    build_lights(*p);
    p->build_seconds += seconds_since(light_start);
    return p;
}

std::shared_ptr<const PreparedScene> with_material(const std::shared_ptr<const PreparedScene>& base, size_t material,
                                                   std::shared_ptr<const Material> graph, Diagnostics& d) {
    if (material >= base->materials.size()) {
        fault(d, "/materials/" + std::to_string(material), std::to_string(material), "below " + std::to_string(base->materials.size()));
        return nullptr;
    }
    auto p = std::make_shared<PreparedScene>(*base);
    const auto start = std::chrono::steady_clock::now();
    SceneMaterial changed = base->materials[material]->material;
    changed.graph = std::move(graph);
    warn_about_displacement(changed, d);
    p->materials[material] = compile_material(changed, *p->surfaces, p->scene->settings, d);
    if (!p->materials[material]) return nullptr;
    p->compile_seconds = seconds_since(start);
    finish(*p);
    // Emission decides which triangles are lights; the table also points into the material's programs.
    const auto light_start = std::chrono::steady_clock::now();
    if (base->materials[material]->emission || p->materials[material]->emission) build_lights(*p);
    p->build_seconds = seconds_since(light_start);
    return p;
}

}  // namespace alder
