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
double angle(float radians) { return double(radians) * 180 / std::numbers::pi; }
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
            if (m.displacement != Displacement::Bump) graph["displacement"] = kDisplacementNames[int(m.displacement)];
            doc["materials"][material_names_.back()] = std::move(graph);
        }
        Names shapes[3];
        for (const auto& m : scene_.meshes) {
            mesh_names_.push_back(shapes[int(m->shape)].take(m->name, kInstanceMembers[int(m->shape)]));
            doc[kShapeMembers[int(m->shape)]][mesh_names_.back()] = m->shape == Shape::Triangles ? mesh(*m) : threads(*m);
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
        extras(m, j);
        return j;
    }

    /// Curves or points.
    json threads(const Mesh& m) {
        json j{{"positions", floats(m.positions)}, {"radii", floats(m.radii)}};
        if (m.shape == Shape::Curves) {
            std::vector<uint32_t> counts;
            for (size_t c = 0; c + 1 < m.curve_first.size(); ++c) counts.push_back(m.curve_first[c + 1] - m.curve_first[c]);
            j["counts"] = array(counts.data(), counts.size(), 1, "u32");
            j["form"] = kCurveFormNames[int(m.curve_form)];
            j["subdivisions"] = m.curve_subdivisions;
            if (!m.curve_normals.empty()) j["normals"] = floats(m.curve_normals);
        }
        extras(m, j);
        return j;
    }

    void extras(const Mesh& m, json& j) {
        if (m.moves()) {
            json& motion = j["motion"];
            motion = {{"steps", m.motion_steps}, {"positions", floats(m.motion_positions)}};
            if (!m.motion_normals.empty()) motion["normals"] = floats(m.motion_normals);
            if (!m.motion_radii.empty()) motion["radii"] = floats(m.motion_radii);
        }
        j["generated_bounds"] = {vector(m.generated_bounds[0]), vector(m.generated_bounds[1])};
        for (const Attribute& a : m.attributes) {
            j["attributes"][a.name] = {{"domain", kDomainNames[int(a.domain)]}, {"channels", a.channels},
                                       {"values", array(a.values.data(), a.values.size(), a.channels, "f32")}};
        }
    }
    json motion(const std::vector<Transform>& keys) {
        std::vector<float> numbers;
        for (const Transform& t : keys) numbers.insert(numbers.end(), t.m.begin(), t.m.end());
        return array(numbers.data(), numbers.size(), 12, "f32");
    }

    json instance(const Instance& i) const {
        json materials = json::array();
        for (uint32_t m : i.materials) materials.push_back(material_names_.at(m));
        return {{kInstanceMembers[int(scene_.meshes.at(i.mesh)->shape)], mesh_names_.at(i.mesh)}, {"materials", materials}, {"visibility", visibility(i.visibility)}, {"pass_index", i.pass_index},
                {"color", vector(i.color)}, {"holdout", i.holdout}, {"light_group", i.light_group}};
    }

    /// Runs of instances that differ in place and random number only are written as one member.
    void write_instances(json& out) {
        Names names;
        const std::vector<Instance>& all = scene_.instances;
        for (size_t first = 0, last; first < all.size(); first = last) {
            json j = instance(all[first]);
            const size_t steps = all[first].motion.size();
            for (last = first + 1; last < all.size() && all[last].name == all[first].name && all[last].motion.size() == steps && instance(all[last]) == j;) ++last;
            std::vector<Transform> moves;
            for (size_t i = first; i < last; ++i) moves.insert(moves.end(), all[i].motion.begin(), all[i].motion.end());
            if (!moves.empty()) j["motion"] = motion(moves);
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

    json camera(const Camera& c) {
        json j{{"type", kCameraNames[int(c.kind)]}, {"transform", transform(c.to_world)}, {"fov_degrees", degrees(c.fov_x)},
                {"ortho_scale", number(c.ortho_scale)}, {"near_clip", number(c.near_clip)}, {"far_clip", number(c.far_clip)},
                {"shift", {number(c.shift_x), number(c.shift_y)}}, {"aperture_radius", number(c.aperture_radius)},
                {"focus_distance", number(c.focus_distance)}, {"aperture_blades", c.aperture_blades},
                {"aperture_rotation_degrees", angle(c.aperture_rotation)}, {"aperture_ratio", number(c.aperture_ratio)}};
        if (c.kind == Camera::Kind::Panoramic) {
            j["panorama"] = kPanoramaNames[int(c.panorama)];
            j["longitude_min_degrees"] = angle(c.longitude_min);
            j["longitude_max_degrees"] = angle(c.longitude_max);
            j["latitude_min_degrees"] = std::max(angle(c.latitude_min), -90.0);
            j["latitude_max_degrees"] = std::min(angle(c.latitude_max), 90.0);
            j["fisheye_fov_degrees"] = angle(c.fisheye_fov);
            j["fisheye_lens_mm"] = number(c.fisheye_lens);
            j["sensor_mm"] = {number(c.sensor_width), number(c.sensor_height)};
        }
        if (!c.motion.empty()) j["motion"] = motion(c.motion);
        return j;
    }

    json settings() {
        const RenderSettings& s = scene_.settings;
        json j{{"resolution", {s.width, s.height}}, {"samples", s.samples}, {"seed", s.seed}, {"max_bounces", s.max_bounces},
                {"diffuse_bounces", s.diffuse_bounces}, {"glossy_bounces", s.glossy_bounces}, {"transmission_bounces", s.transmission_bounces},
                {"volume_bounces", s.volume_bounces}, {"transparent_bounces", s.transparent_bounces}, {"clamp_direct", number(s.clamp_direct)}, {"clamp_indirect", number(s.clamp_indirect)},
                {"film_transparent", s.film_transparent}, {"exposure", number(s.exposure)}, {"filter_glossy", number(s.filter_glossy)}, {"filter", kFilterNames[int(s.filter)]}, {"filter_width", number(s.filter_width)},
                {"caustics_reflective", s.caustics_reflective}, {"caustics_refractive", s.caustics_refractive},
                {"texture_filter", s.texture_filter}, {"noise_filter", s.noise_filter}};
        if (!s.shutter_curve.empty()) j["shutter_curve"] = floats(s.shutter_curve);
        return j;
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
