// Scene documents: writing a Scene.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "render/image/image.h"
#include "render/import/container.h"
#include "render/import/scene_parts.h"

namespace alder {

using nlohmann::json;

namespace {

/// A float by its shortest decimal, so that documents stay readable and values come back exactly.
json number(float x) { return std::strtod(number_text(x).c_str(), nullptr); }
/// The float nearest to pi is a little more than pi.
json degrees(float radians) { return std::min(double(radians) * 180 / std::numbers::pi, 180.0); }
json vector(Vec3f v) { return json::array({number(v.x), number(v.y), number(v.z)}); }
json transform(const Transform& t) {
    json j = json::array();
    for (float x : t.m) j.push_back(number(x));
    for (int i = 0; i < 4; ++i) j.push_back(i == 3 ? 1 : 0);
    return j;
}

/// Names are keys in a document: the second "Cube" becomes "Cube.001".
class Names {
  public:
    std::string take(const std::string& wanted, const char* otherwise) {
        const std::string base = wanted.empty() ? otherwise : wanted;
        std::string name = base;
        for (int i = 1; !used_.insert(name).second; ++i) {
            const std::string n = std::to_string(i);
            name = base + "." + std::string(n.size() < 3 ? 3 - n.size() : 0, '0') + n;
        }
        return name;
    }

  private:
    std::set<std::string> used_;
};

class SceneWriter {
  public:
    SceneWriter(const Scene& scene, const std::string& buffer_name, std::vector<uint8_t>& buffer)
        : scene_(scene), buffer_name_(buffer_name), buffer_(buffer) {}

    json run() {
        json doc{{"alder_scene", kSceneVersion}, {"settings", settings()}};
        if (!scene_.name.empty()) doc["name"] = scene_.name;
        Names cameras;
        doc["camera"] = cameras.take(scene_.camera.name, "camera");
        doc["cameras"][doc["camera"].get<std::string>()] = camera(scene_.camera);
        for (const Camera& c : scene_.other_cameras) doc["cameras"][cameras.take(c.name, "camera")] = camera(c);
        Names names;
        for (const SceneMaterial& m : scene_.materials) {
            material_names_.push_back(names.take(m.name, "material"));
            json graph = m.graph ? m.graph->document() : json{{"version", 1}, {"nodes", json::object()}, {"outputs", json::object()}};
            if (m.pass_index != 0) graph["pass_index"] = m.pass_index;
            doc["materials"][material_names_.back()] = std::move(graph);
        }
        Names meshes;
        for (const auto& m : scene_.meshes) {
            mesh_names_.push_back(meshes.take(m->name, "mesh"));
            doc["meshes"][mesh_names_.back()] = mesh(*m);
        }
        write_instances(doc["instances"] = json::object());
        Names lights;
        for (const Light& l : scene_.lights) doc["lights"][lights.take(l.name, "light")] = light(l);
        const World& w = scene_.world;
        doc["world"] = {{"light_group", w.light_group}, {"visibility", visibility(w.visibility)}, {"importance_resolution", w.importance_resolution}};
        if (w.graph) doc["world"]["graph"] = w.graph->document();
        return doc;
    }

  private:
    json visibility(uint32_t bits) const {
        json j = json::object();
        for (const VisibilityName& n : kVisibilityNames) {
            if (!(bits & n.bit)) j[n.name] = false;
        }
        return j;
    }

    template <class T>
    json array(const T* data, size_t numbers, int channels, const char* type) {
        if (numbers <= 32) {
            json j = json::array();
            for (size_t i = 0; i < numbers; ++i) {
                if constexpr (std::is_same_v<T, float>) j.push_back(number(data[i]));
                else j.push_back(data[i]);
            }
            return j;
        }
        while (buffer_.size() % 4 != 0) buffer_.push_back(0);
        const size_t offset = buffer_.size();
        const auto* p = reinterpret_cast<const uint8_t*>(data);
        buffer_.insert(buffer_.end(), p, p + numbers * sizeof(T));
        return {{"buffer", buffer_name_}, {"type", type}, {"offset", offset}, {"count", numbers / size_t(channels)}};
    }
    template <class Element>
    json floats(const std::vector<Element>& v) {
        constexpr size_t n = sizeof(Element) / sizeof(float);
        return array(reinterpret_cast<const float*>(v.data()), v.size() * n, int(n), "f32");
    }

    json mesh(const Mesh& m) {
        json j{{"positions", floats(m.positions)},
               {"triangles", array(reinterpret_cast<const uint32_t*>(m.triangles.data()), m.triangles.size() * 3, 3, "u32")}};
        if (!m.vertex_normals.empty()) j["normals"] = floats(m.vertex_normals);
        if (!m.corner_normals.empty()) j["corner_normals"] = floats(m.corner_normals);
        if (!m.uv.empty()) j["uv"] = floats(m.uv);
        if (!m.tangents.empty()) j["tangents"] = floats(m.tangents), j["tangent_signs"] = floats(m.tangent_signs);
        if (!m.smooth.empty()) j["smooth"] = array(m.smooth.data(), m.smooth.size(), 1, "u8");
        if (!m.face_material.empty()) j["face_material"] = array(m.face_material.data(), m.face_material.size(), 1, "u32");
        j["generated_bounds"] = {vector(m.generated_bounds[0]), vector(m.generated_bounds[1])};
        for (const Attribute& a : m.attributes) {
            j["attributes"][a.name] = {{"domain", kDomainNames[int(a.domain)]}, {"channels", a.channels},
                                       {"values", array(a.values.data(), a.values.size(), a.channels, "f32")}};
        }
        return j;
    }

    json instance(const Instance& i) const {
        json materials = json::array();
        for (uint32_t m : i.materials) materials.push_back(material_names_.at(m));
        return {{"mesh", mesh_names_.at(i.mesh)}, {"materials", materials}, {"visibility", visibility(i.visibility)}, {"pass_index", i.pass_index},
                {"color", vector(i.color)}, {"light_group", i.light_group}};
    }

    /// Runs of instances that differ in place and random number only are written as one member.
    void write_instances(json& out) {
        Names names;
        const std::vector<Instance>& all = scene_.instances;
        for (size_t first = 0, last; first < all.size(); first = last) {
            json j = instance(all[first]);
            for (last = first + 1; last < all.size() && all[last].name == all[first].name && instance(all[last]) == j;) ++last;
            if (last == first + 1) {
                j["transform"] = transform(all[first].object_to_world);
                j["random"] = number(all[first].random);
            } else {
                std::vector<float> transforms, randoms;
                for (size_t i = first; i < last; ++i) {
                    transforms.insert(transforms.end(), all[i].object_to_world.m.begin(), all[i].object_to_world.m.end());
                    randoms.push_back(all[i].random);
                }
                j["transforms"] = array(transforms.data(), transforms.size(), 12, "f32");
                j["randoms"] = floats(randoms);
            }
            out[names.take(all[first].name, "object")] = std::move(j);
        }
    }

    json light(const Light& l) const {
        json j{{"type", kLightNames[int(l.kind)]}, {"transform", transform(l.to_world)}, {"color", vector(l.color)}, {"strength", number(l.strength)},
               {"visibility", visibility(l.visibility)}, {"cast_shadow", l.cast_shadow}, {"light_group", l.light_group}, {"normalize", l.normalize},
               {"radius", number(l.radius)}, {"soft_falloff", l.soft_falloff}, {"spot_angle_degrees", degrees(l.spot_angle)}, {"spot_blend", number(l.spot_blend)},
               {"angle_degrees", degrees(l.angle)}, {"shape", kShapeNames[int(l.shape)]}, {"size", {number(l.size_x), number(l.size_y)}},
               {"spread_degrees", degrees(l.spread)}};
        if (l.graph) j["graph"] = l.graph->document();
        return j;
    }

    json camera(const Camera& c) const {
        return {{"type", kCameraNames[int(c.kind)]}, {"transform", transform(c.to_world)}, {"fov_degrees", degrees(c.fov_x)},
                {"ortho_scale", number(c.ortho_scale)}, {"near_clip", number(c.near_clip)}, {"far_clip", number(c.far_clip)},
                {"shift", {number(c.shift_x), number(c.shift_y)}}, {"aperture_radius", number(c.aperture_radius)},
                {"focus_distance", number(c.focus_distance)}};
    }

    json settings() const {
        const RenderSettings& s = scene_.settings;
        return {{"resolution", {s.width, s.height}}, {"samples", s.samples}, {"seed", s.seed}, {"max_bounces", s.max_bounces},
                {"diffuse_bounces", s.diffuse_bounces}, {"glossy_bounces", s.glossy_bounces}, {"transmission_bounces", s.transmission_bounces},
                {"volume_bounces", s.volume_bounces}, {"transparent_bounces", s.transparent_bounces}, {"clamp_direct", number(s.clamp_direct)}, {"clamp_indirect", number(s.clamp_indirect)},
                {"film_transparent", s.film_transparent}, {"filter", kFilterNames[int(s.filter)]}, {"filter_width", number(s.filter_width)},
                {"caustics_reflective", s.caustics_reflective}, {"caustics_refractive", s.caustics_refractive},
                {"texture_filter", s.texture_filter}, {"noise_filter", s.noise_filter}};
    }

    const Scene& scene_;
    const std::string& buffer_name_;
    std::vector<uint8_t>& buffer_;
    std::vector<std::string> material_names_, mesh_names_;
};

}  // namespace

json scene_to_json(const Scene& scene, const std::string& buffer_name, std::vector<uint8_t>& buffer) {
    return SceneWriter(scene, buffer_name, buffer).run();
}

bool write_scene(const std::string& path, const Scene& scene, std::string& error) {
    std::vector<uint8_t> buffer;
    const std::string text = scene_to_json(scene, "buffers.bin", buffer).dump(1);
    ContainerWriter w(path);
    const bool ok = w.add("scene.json", {reinterpret_cast<const uint8_t*>(text.data()), text.size()}) &&
                    (buffer.empty() || w.add("buffers.bin", buffer)) && w.commit();
    if (!ok) error = w.error();
    return ok;
}

}  // namespace alder
