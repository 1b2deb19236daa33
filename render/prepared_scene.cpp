// PreparedScene: builds what a render needs, and swaps one material.
#include "render/prepared_scene.h"

#include <chrono>
#include <cmath>

#include "render/geometry/displace.h"
#include "render/worker.h"

namespace alder {
namespace {

double seconds_since(std::chrono::steady_clock::time_point t) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - t).count();
}

void fault(Diagnostics& d, std::string pointer, std::string found, std::string expected) {
    if (d.errors.size() < kMaxDiagnostics) d.errors.push_back({std::move(pointer), "scene-invalid", std::move(found), std::move(expected), {}});
}

/// Curves and spheres have radii and no triangles, triangles neither; curves cover the points one after the other.
void check_threads(const Mesh& m, const std::string& at, Diagnostics& d) {
    if (m.shape == Shape::Triangles) return;
    if (!m.triangles.empty()) fault(d, at + "/triangles", "triangles among curves or points", "none");
    if (m.radii.size() != m.positions.size()) fault(d, at + "/radii", std::to_string(m.radii.size()) + " elements", std::to_string(m.positions.size()));
    if (m.shape != Shape::Curves) return;
    bool ascending = !m.curve_first.empty() && m.curve_first.front() == 0 && m.curve_first.back() == m.positions.size();
    for (size_t i = 0; i + 1 < m.curve_first.size(); ++i) ascending = ascending && m.curve_first[i] < m.curve_first[i + 1];
    if (!ascending) fault(d, at + "/curve_first", "curves that do not follow each other", "0, ascending, up to the number of points");
    if (!m.curve_normals.empty() && m.curve_normals.size() != m.positions.size())
        fault(d, at + "/curve_normals", std::to_string(m.curve_normals.size()) + " elements", std::to_string(m.positions.size()) + " or none");
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
        check_threads(m, at, d);
        const size_t moved = m.moves() ? static_cast<size_t>(m.motion_steps) * m.positions.size() : 0;
        if (m.moves() && m.motion_positions.size() != moved)
            fault(d, at + "/motion_positions", std::to_string(m.motion_positions.size()) + " points", std::to_string(moved));
        length("motion_normals", m.motion_normals.size(), moved);
        length("motion_radii", m.motion_radii.size(), moved);
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
    if (m.graph && m.graph->has_displacement() && m.displacement != Displacement::Move)
        d.warnings.push_back({"/materials/" + m.name + "/outputs/displacement", "unsupported", "displacement as bump",
                              m.displacement == Displacement::Both ? "vertices moved, but normals not turned by what is finer than them"
                                                                   : "normals turned: they are rendered as they were",
                              {}});
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

namespace {

bool reads_camera(const Program& program) {
    return std::any_of(program.inputs().begin(), program.inputs().end(), [](const ProgramInput& in) {
        return !in.is_attribute && (in.global == Global::Window || (in.global >= Global::WorldToCameraX && in.global <= Global::WorldToCameraT));
    });
}
bool reads_camera(const std::shared_ptr<const SceneProgram>& p) { return p && reads_camera(*p->program); }

bool same_material(const SceneMaterial& a, const SceneMaterial& b) {
    return a.name == b.name && a.graph == b.graph && a.pass_index == b.pass_index && a.displacement == b.displacement;
}

/// Whether lights come out the same for another camera.
bool lights_follow_camera(const PreparedScene& p) {
    return reads_camera(p.world->program) || std::any_of(p.light_programs.begin(), p.light_programs.end(), [](const auto& l) { return reads_camera(l); }) ||
           std::any_of(p.materials.begin(), p.materials.end(), [](const auto& m) { return reads_camera(m->emission); });
}

/// Lights are the same where materials that emit are.
bool same_emission(const PreparedScene& a, const PreparedScene& b) {
    return std::equal(a.materials.begin(), a.materials.end(), b.materials.begin(), b.materials.end(),
                      [](const auto& x, const auto& y) { return x == y || (!x->emission && !y->emission); });
}

/// `base`: null, or the scene before an edit that left the parts in `same` alone.
std::shared_ptr<const PreparedScene> prepare(std::shared_ptr<const Scene> scene, const EvalContext& context, const PreparedScene* base, const SameParts& same, Diagnostics& d) {
    check(*scene, d);
    if (!d.ok()) return nullptr;
    auto p = std::make_shared<PreparedScene>();
    p->scene = scene;
    p->workers = base ? base->workers : std::make_shared<WorkerPool>(context);
    const auto build_start = std::chrono::steady_clock::now();
    auto meshes = scene->meshes;
    auto instances = scene->instances;
    displace(*scene, context, meshes, instances, d);
    if (!d.ok()) return nullptr;
    p->surfaces = base && same.instances && base->surfaces->are_made_of(meshes) ? base->surfaces
                                                                                : std::make_shared<Surfaces>(std::move(meshes), std::move(instances), base ? base->surfaces.get() : nullptr);
    p->build_seconds = seconds_since(build_start);
    // Programs have the meshes' attributes by place: with the same meshes at the same places they go on.
    const bool same_meshes = base && base->surfaces->meshes() == p->surfaces->meshes();

    const auto compile_start = std::chrono::steady_clock::now();
    for (const SceneMaterial& m : scene->materials) {
        warn_about_displacement(m, d);
        const size_t i = p->materials.size();
        if (same_meshes && same.settings && i < base->materials.size() && same_material(base->materials[i]->material, m)) p->materials.push_back(base->materials[i]);
        else p->materials.push_back(compile_material(m, *p->surfaces, scene->settings, d));
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
    const bool same_world = same_meshes && same.world && (same.camera || !reads_camera(base->world->program));
    p->world = same_world ? base->world : build_world(scene->world, *p->surfaces, camera, context, d);
    if (!d.ok()) return nullptr;
    finish(*p);
    if (same_world && same.lights && p->surfaces == base->surfaces && same_emission(*base, *p) && (same.camera || !lights_follow_camera(*base))) {
        p->light_programs = base->light_programs;   // the table points at them
        p->lights = base->lights;
    } else {
        build_lights(*p);
    }
    p->build_seconds += seconds_since(light_start);
    return p;
}

}  // namespace

std::shared_ptr<const PreparedScene> prepare_scene(std::shared_ptr<const Scene> scene, const EvalContext& context, Diagnostics& d) {
    return prepare(std::move(scene), context, nullptr, {}, d);
}
std::shared_ptr<const PreparedScene> prepare_edited(const PreparedScene& base, const SameParts& same, std::shared_ptr<const Scene> scene, Diagnostics& d) {
    return prepare(std::move(scene), base.workers->context(), &base, same, d);
}

std::shared_ptr<const PreparedScene> with_material(const std::shared_ptr<const PreparedScene>& base, size_t material,
                                                   std::shared_ptr<const Material> graph, Diagnostics& d) {
    if (material >= base->materials.size()) {
        fault(d, "/materials/" + std::to_string(material), std::to_string(material), "below " + std::to_string(base->materials.size()));
        return nullptr;
    }
    SceneMaterial changed = base->materials[material]->material;
    const bool displaced = displaces(changed);
    changed.graph = std::move(graph);
    if (displaced || displaces(changed)) {  // other vertices: everything follows from them
        auto scene = std::make_shared<Scene>(*base->scene);
        for (size_t i = 0; i < scene->materials.size(); ++i) scene->materials[i] = base->materials[i]->material;
        scene->materials[material] = std::move(changed);
        return prepare_scene(std::move(scene), base->workers->context(), d);
    }
    auto p = std::make_shared<PreparedScene>(*base);
    const auto start = std::chrono::steady_clock::now();
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
