// Scene documents: the whole.
#include "render/import/scene_document.h"

#include <algorithm>

#include "render/import/scene_parts.h"

namespace alder {

using nlohmann::json;

namespace {

/// Meshes, curves or points.
void read_shapes(SceneReading& s, const json& j, Shape shape, const std::string& pointer) {
    JsonReader all = s.object(j, pointer);
    if (!all.ok()) return;
    const char* const member = kShapeMembers[int(shape)];
    if (s.scene.meshes.size() + j.size() > s.options.limits.meshes) {
        add_error(s.d, pointer, "limit-exceeded", std::to_string(s.scene.meshes.size() + j.size()) + " meshes", "at most " + std::to_string(s.options.limits.meshes));
        return;
    }
    // Shapes about which the earlier revision's document says the same are that revision's.
    const json* before = nullptr;
    std::map<std::string_view, std::shared_ptr<const Mesh>> kept;
    if (s.options.previous && s.options.previous_document && s.options.previous_document->contains(member)) {
        before = &(*s.options.previous_document)[member];
        for (const auto& m : s.options.previous->meshes)
            if (m->shape == shape) kept.emplace(m->name, m);
    }
    for (const auto& [name, value] : j.items()) {
        const std::string here = pointer + "/" + pointer_token(name);
        uint32_t slots = 1;
        std::shared_ptr<const Mesh> mesh;
        if (const auto k = kept.find(name); before && k != kept.end() && before->contains(name) && (*before)[name] == value) {
            mesh = k->second;
            for (uint32_t m : mesh->face_material) slots = std::max(slots, m + 1);
        } else if (shape == Shape::Triangles) {
            mesh = read_mesh(s, name, value, here, slots);
        } else {
            mesh = (shape == Shape::Curves ? read_curves : read_points)(s, name, value, here);
        }
        // A faulty mesh keeps its place, so that instances of it are not reported as well.
        s.shape_index[int(shape)].emplace(name, uint32_t(s.scene.meshes.size()));
        s.scene.meshes.push_back(std::move(mesh));
        s.mesh_slots.push_back(slots);
    }
}

void read_materials(SceneReading& s, const json& j, const std::string& pointer) {
    JsonReader all = s.object(j, pointer);
    if (!all.ok()) return;
    if (j.size() > s.options.limits.materials) {
        add_error(s.d, pointer, "limit-exceeded", std::to_string(j.size()) + " materials", "at most " + std::to_string(s.options.limits.materials));
        return;
    }
    for (const auto& [name, value] : j.items()) {
        const std::string here = pointer + "/" + pointer_token(name);
        if (name.empty()) {
            add_error(s.d, here, "wrong-value", "an empty name", "a name");
            continue;
        }
        SceneMaterial m;
        m.name = name;
        const auto other = s.options.material_overrides.find(name);
        json graph = other == s.options.material_overrides.end() ? value : other->second;
        if (value.is_object() && (value.contains("pass_index") || value.contains("displacement"))) {   // the scene's, not the graph's
            JsonReader r(value, here, s.d, true);
            int displacement = 0;
            r.integer("pass_index", m.pass_index, 0, 1 << 24);
            r.choice("displacement", kDisplacementNames, displacement);
            m.displacement = Displacement(displacement);
            if (graph.is_object()) graph.erase("pass_index"), graph.erase("displacement");
        }
        m.graph = read_graph(s, graph, here);
        s.material_index.emplace(name, uint32_t(s.scene.materials.size()));
        s.scene.materials.push_back(std::move(m));
    }
    for (const auto& [name, graph] : s.options.material_overrides) {
        if (s.material_index.count(name)) continue;
        std::vector<std::string> known;
        for (const auto& [n, index] : s.material_index) known.push_back(n);
        add_error(s.d, pointer + "/" + pointer_token(name), "unknown-material", name, "a material of the scene", nearest_name(name, known));
    }
}

/// What the program that wrote the document could not say in it: each line becomes a warning of the scene.
void read_report(SceneReading& s, const json& j, const std::string& pointer) {
    if (j.is_null()) return;
    JsonReader r = s.object(j, pointer);
    if (!r.ok()) return;
    r.member("notes");
    const json* list = r.member("unsupported");
    r.finish();
    if (!list || !list->is_array()) return;
    for (size_t i = 0; i < list->size(); ++i) {
        const json& entry = (*list)[i];
        std::string what, where;
        if (entry.is_object() && entry.contains("what") && entry["what"].is_string()) what = entry["what"];
        if (entry.is_object() && entry.contains("where") && entry["where"].is_array()) {
            for (const json& place : entry["where"]) {
                if (place.is_string() && where.size() < 200) where += (where.empty() ? "" : ", ") + place.get<std::string>();
            }
        }
        if (!what.empty()) add_warning(s.d, r.pointer_to("unsupported") + "/" + std::to_string(i), "not-exported", where.empty() ? "the scene" : where, what);
    }
}

}  // namespace

std::shared_ptr<const Material> read_graph(SceneReading& s, const json& j, const std::string& pointer) {
    MaterialOptions options;
    options.lenient = s.options.lenient;
    options.pointer_prefix = pointer;
    options.resolve_image = s.options.resolve_image;
    return s.options.cache ? s.options.cache->get(j, options, s.d) : build_material(j, options, s.d);
}

bool SceneReading::unsupported(JsonReader& r, const char* key, const char* what) {
    const json* j = r.member(key);
    if (!j || j->is_null() || ((j->is_object() || j->is_array()) && j->empty())) return false;
    if (options.lenient) add_warning(d, r.pointer_to(key), "unsupported", describe(*j), what);
    else add_error(d, r.pointer_to(key), "unsupported", describe(*j), what);
    return true;
}

std::shared_ptr<const Scene> scene_from_json(const json& document, const SceneLoadOptions& options, Diagnostics& d) {
    const size_t faults = d.errors.size(), earlier_warnings = d.warnings.size();
    SceneReading s(options, d);
    JsonReader top = s.object(document, options.pointer_prefix);
    if (!top.ok()) return nullptr;
    int version = 0;
    if (top.required("alder_scene", "the version of the layout, 1")) top.integer("alder_scene", version, 1, kSceneVersion);
    if (d.errors.size() > faults) return nullptr;
    top.text("name", s.scene.name);
    if (const json* j = top.member("settings")) read_settings(s, *j, top.pointer_to("settings"));
    read_cameras(s, top);
    if (const json* j = top.member("materials")) read_materials(s, *j, top.pointer_to("materials"));
    for (const Shape shape : {Shape::Triangles, Shape::Curves, Shape::Spheres}) {
        const char* const member = kShapeMembers[int(shape)];
        if (const json* j = top.member(member); j && !j->is_null()) read_shapes(s, *j, shape, top.pointer_to(member));
    }
    if (const json* j = top.member("instances")) read_instances(s, *j, top.pointer_to("instances"));
    if (const json* j = top.member("lights")) read_lights(s, *j, top.pointer_to("lights"));
    if (const json* j = top.member("world")) read_world(s, *j, top.pointer_to("world"));
    s.unsupported(top, "volumes", "volumes are not rendered yet");
    if (const json* j = top.member("report")) read_report(s, *j, top.pointer_to("report"));
    top.finish();
    if (d.errors.size() > faults) return nullptr;
    for (size_t i = earlier_warnings; i < d.warnings.size(); ++i) s.scene.warnings.push_back(d.warnings[i].line());
    return std::make_shared<const Scene>(std::move(s.scene));
}

}  // namespace alder
