// glTF: the .glb container, nodes, cameras and lights; the result is a scene document.
#include "render/import/gltf.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "render/import/asset_folder.h"
#include "render/import/gltf_parts.h"
#include "render/import/scene_parts.h"

namespace alder {

using nlohmann::json;

namespace {

constexpr const char* kSupportedExtensions[] = {
    "KHR_lights_punctual", "KHR_texture_transform", "KHR_mesh_quantization", "EXT_mesh_gpu_instancing", "EXT_texture_webp",
    "KHR_materials_anisotropy", "KHR_materials_clearcoat", "KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_sheen",
    "KHR_materials_specular", "KHR_materials_transmission", "KHR_materials_unlit", "KHR_materials_volume"};
constexpr double kLumensPerWatt = 683;
constexpr int kMaxDepth = 4096;

// C turns Y up into Z up: (x, y, z) -> (x, -z, y).
Transform to_z_up() { return {{1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0}}; }
Transform to_y_up() { return {{1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0}}; }

json transform_json(const Transform& t) {
    json j = json::array();
    for (float x : t.m) j.push_back(x);
    return j;
}

Transform from_parts(const std::array<float, 3>& t, std::array<float, 4> q, const std::array<float, 3>& s) {
    const float length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (length > 0 && std::isfinite(length)) for (float& x : q) x /= length;
    else q = {0, 0, 0, 1};
    const auto [x, y, z, w] = q;
    return {{(1 - 2 * (y * y + z * z)) * s[0], 2 * (x * y - w * z) * s[1], 2 * (x * z + w * y) * s[2], t[0],
             2 * (x * y + w * z) * s[0], (1 - 2 * (x * x + z * z)) * s[1], 2 * (y * z - w * x) * s[2], t[1],
             2 * (x * z - w * y) * s[0], 2 * (y * z + w * x) * s[1], (1 - 2 * (x * x + y * y)) * s[2], t[2]}};
}

/// The same place and direction without scale: what cameras and lights take from a node.
Transform rigid(const Transform& t) {
    Transform out = t;
    for (int column = 0; column < 3; ++column) {
        const Vec3f v(t.m[column], t.m[4 + column], t.m[8 + column]);
        const float l = std::sqrt(dot(v, v));
        for (int row = 0; row < 3 && l > 0; ++row) out.m[row * 4 + column] = t.m[row * 4 + column] / l;
    }
    return out;
}

class GltfScene {
  public:
    GltfScene(GltfFile& file, SceneSource& source) : file_(file), source_(source), meshes_(file, *buffer_) {}

    bool run() {
        const size_t faults = file_.d.errors.size();
        if (!file_.json.is_object()) {
            add_error(file_.d, "", "wrong-type", describe(file_.json), "a glTF document");
            return false;
        }
        check_version();
        check_extensions();
        if (file_.d.errors.size() > faults) return false;
        document_ = {{"alder_scene", kSceneVersion}, {"meshes", json::object()}, {"materials", json::object()}, {"instances", json::object()}};
        walk();
        add_camera_if_none();
        add_light_if_none();
        leave_out();
        if (file_.d.errors.size() > faults) return false;
        publish();
        return true;
    }

  private:
    void check_version() {
        JsonReader top = file_.reader(file_.json, "");
        const json* asset = top.required("asset", "an object with the version");
        if (!asset) return;
        std::string version;
        file_.reader(*asset, "/asset").text("version", version);
        if (!version.starts_with("2.")) add_error(file_.d, "/asset/version", "unsupported", version, "glTF 2.0");
    }

    void check_extensions() {
        const auto r = file_.json.find("extensionsRequired");
        if (r == file_.json.end() || !r->is_array()) return;
        for (size_t i = 0; i < r->size(); ++i) {
            const std::string name = (*r)[i].is_string() ? (*r)[i].get<std::string>() : describe((*r)[i]);
            const bool known = std::any_of(std::begin(kSupportedExtensions), std::end(kSupportedExtensions), [&](const char* k) { return name == k; });
            if (!known) add_error(file_.d, "/extensionsRequired/" + std::to_string(i), "unsupported", name, "a file that does without this extension");
        }
    }

    /// Nodes of the chosen scene, parents first, without recursion.
    void walk() {
        const json* nodes = nullptr;
        if (const auto n = file_.json.find("nodes"); n != file_.json.end() && n->is_array()) nodes = &*n;
        if (!nodes) return;
        struct Visit {
            int node;
            Transform parent;
            int depth;
        };
        std::vector<Visit> stack;
        for (const int root : roots(*nodes)) stack.push_back({root, Transform{}, 0});
        std::reverse(stack.begin(), stack.end());
        std::vector<bool> seen(nodes->size(), false);
        while (!stack.empty() && file_.d.errors.size() < kMaxDiagnostics) {
            const Visit v = stack.back();
            stack.pop_back();
            const std::string pointer = "/nodes/" + std::to_string(v.node);
            if (v.node < 0 || size_t(v.node) >= nodes->size()) {
                file_.element("nodes", v.node, "/nodes");
                continue;
            }
            if (seen[size_t(v.node)] || v.depth > kMaxDepth) {
                add_error(file_.d, pointer, "cycle", "a node with two parents", "a tree of nodes");
                continue;
            }
            seen[size_t(v.node)] = true;
            JsonReader r = file_.reader((*nodes)[size_t(v.node)], pointer);
            if (!r.ok()) continue;
            const Transform here = v.parent * local(r);
            visit(r, here);
            if (const json* children = r.member("children"); children && children->is_array()) {
                for (auto c = children->rbegin(); c != children->rend(); ++c) {
                    if (c->is_number_integer()) stack.push_back({int(std::clamp<int64_t>(c->get<int64_t>(), -1, INT32_MAX)), here, v.depth + 1});
                    else add_error(file_.d, r.pointer_to("children"), "wrong-type", describe(*c), "the index of a node");
                }
            }
        }
    }

    std::vector<int> roots(const json& nodes) {
        std::vector<int> out;
        const auto scenes = file_.json.find("scenes");
        if (scenes != file_.json.end() && scenes->is_array() && !scenes->empty()) {
            int index = 0;
            JsonReader top = file_.reader(file_.json, "");
            top.integer("scene", index, 0, INT32_MAX);
            const json* s = file_.element("scenes", index, "/scene");
            if (!s) return out;
            JsonReader r = file_.reader(*s, "/scenes/" + std::to_string(index));
            r.text("name", name_);
            if (const json* list = r.member("nodes"); list && list->is_array()) {
                for (const json& n : *list) out.push_back(n.is_number_integer() ? int(std::clamp<int64_t>(n.get<int64_t>(), -1, INT32_MAX)) : -1);
            }
            return out;
        }
        std::vector<bool> is_child(nodes.size(), false);
        for (const json& n : nodes) {
            if (!n.is_object() || !n.contains("children") || !n["children"].is_array()) continue;
            for (const json& c : n["children"]) {
                if (c.is_number_unsigned() && c.get<uint64_t>() < nodes.size()) is_child[c.get<size_t>()] = true;
            }
        }
        for (size_t i = 0; i < nodes.size(); ++i) {
            if (!is_child[i]) out.push_back(int(i));
        }
        return out;
    }

    Transform local(JsonReader& r) {
        std::array<float, 16> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
        std::array<float, 3> t{0, 0, 0}, s{1, 1, 1};
        std::array<float, 4> q{0, 0, 0, 1};
        if (r.member("matrix")) {
            r.numbers("matrix", m);   // column by column
            return {{m[0], m[4], m[8], m[12], m[1], m[5], m[9], m[13], m[2], m[6], m[10], m[14]}};
        }
        r.numbers("translation", t);
        r.numbers("rotation", q);
        r.numbers("scale", s);
        return from_parts(t, q, s);
    }

    void visit(JsonReader& r, const Transform& here) {
        std::string name;
        r.text("name", name);
        int mesh = -1, camera = -1, light = -1;
        r.integer("mesh", mesh, 0, INT32_MAX);
        r.integer("camera", camera, 0, INT32_MAX);
        const json* extensions = r.member("extensions");
        const json* instancing = nullptr;
        if (extensions && extensions->is_object()) {
            if (const auto l = extensions->find("KHR_lights_punctual"); l != extensions->end()) {
                file_.reader(*l, r.pointer_to("extensions") + "/KHR_lights_punctual").integer("light", light, 0, INT32_MAX);
            }
            if (const auto i = extensions->find("EXT_mesh_gpu_instancing"); i != extensions->end()) instancing = &*i;
        }
        if (mesh >= 0) add_instance(r, name, mesh, here, instancing);
        if (camera >= 0) add_camera(r, name, camera, here);
        if (light >= 0) add_light(r, name, light, here);
    }

    struct KnownMesh {
        std::string name;   ///< empty: nothing to render
        json materials;
        std::array<Vec3f, 2> bounds{Vec3f(0), Vec3f(0)};
    };

    const KnownMesh* mesh(int index, const std::string& referrer) {
        const auto known = known_meshes_.find(index);
        if (known != known_meshes_.end()) return &known->second;
        GltfMeshes::Result result;
        if (!meshes_.convert(index, referrer, result)) return nullptr;
        KnownMesh& k = known_meshes_[index];
        if (result.mesh.is_null()) return &k;
        std::string name;
        file_.reader(*file_.element("meshes", index, referrer), "/meshes/" + std::to_string(index)).text("name", name);
        k.name = mesh_names_.take(name, "mesh");
        k.bounds = result.bounds;
        k.materials = json::array();
        for (const auto& key : result.materials) k.materials.push_back(material(key, referrer));
        document_["meshes"][k.name] = std::move(result.mesh);
        return &k;
    }

    std::string material(const GltfMeshes::MaterialKey& key, const std::string& referrer) {
        const auto known = known_materials_.find(key);
        if (known != known_materials_.end()) return known->second;
        std::string name;
        json graph;
        if (key.first < 0) {
            name = "default";   // Blender's grey; tinted if there are vertex colours
            const json color = key.second ? json{{"node", "color"}, {"output", "Color"}} : json{0.8, 0.8, 0.8};
            graph = {{"version", 1}, {"nodes", {{"bsdf", {{"type", "ShaderNodeBsdfDiffuse"}, {"params", {{"Color", color}}}}}}},
                     {"outputs", {{"surface", {{"node", "bsdf"}}}}}};
            if (key.second) graph["nodes"]["color"] = {{"type", "ShaderNodeVertexColor"}, {"params", {{"layer_name", kGltfColorAttribute}}}};
        } else if (const json* j = file_.element("materials", key.first, referrer)) {
            file_.reader(*j, "/materials/" + std::to_string(key.first)).text("name", name);
            graph = gltf_material(file_, key.first, key.second, images_, image_names_);
        }
        const std::string unique = material_names_.take(name, "material");
        document_["materials"][unique] = std::move(graph);
        return known_materials_[key] = unique;
    }

    void add_instance(JsonReader& r, const std::string& name, int mesh_index, const Transform& here, const json* instancing) {
        const KnownMesh* m = mesh(mesh_index, r.pointer_to("mesh"));
        if (!m || m->name.empty()) return;
        if (r.member("skin")) add_warning(file_.d, r.pointer_to("skin"), "unsupported", "a skin", "a mesh without: it is shown in its rest pose");
        json instance{{"mesh", m->name}, {"materials", m->materials}};
        std::vector<Transform> places{Transform{}};
        const bool many = instancing != nullptr;
        if (many && !instance_places(*instancing, r.pointer_to("extensions") + "/EXT_mesh_gpu_instancing", places)) return;
        std::vector<float> transforms;
        for (const Transform& p : places) {
            const Transform world = to_z_up() * (here * p) * to_y_up();
            transforms.insert(transforms.end(), world.m.begin(), world.m.end());
            for (int corner = 0; corner < 8; ++corner) {
                grow(world.point({m->bounds[corner & 1].x, m->bounds[corner >> 1 & 1].y, m->bounds[corner >> 2 & 1].z}));
            }
        }
        if (many) {
            if (places.empty()) return;
            instance["transforms"] = meshes_.store(transforms.data(), transforms.size(), 12, "f32");
        } else {
            instance["transform"] = json(transforms);
        }
        document_["instances"][instance_names_.take(name, m->name)] = std::move(instance);
    }

    bool instance_places(const json& j, const std::string& pointer, std::vector<Transform>& places) {
        const size_t faults = file_.d.errors.size();
        JsonReader e = file_.reader(j, pointer);
        const json* attributes = e.required("attributes", "an object");
        if (!attributes) return false;
        JsonReader a = file_.reader(*attributes, e.pointer_to("attributes"));
        std::vector<float> t, q, s;
        size_t count = SIZE_MAX;
        for (const auto& [key, channels, out] : {std::tuple{"TRANSLATION", 3, &t}, std::tuple{"ROTATION", 4, &q}, std::tuple{"SCALE", 3, &s}}) {
            int accessor = -1;
            a.integer(key, accessor, 0, INT32_MAX);
            if (accessor < 0) continue;
            if (!file_.floats(accessor, a.pointer_to(key), channels, count, *out)) return false;
            count = out->size() / size_t(channels);
        }
        if (count == SIZE_MAX) count = 0;
        if (count > file_.options.limits.instances) add_error(file_.d, pointer, "limit-exceeded", std::to_string(count) + " instances", "fewer");
        if (file_.d.errors.size() > faults) return false;
        places.clear();
        for (size_t i = 0; i < count; ++i) {
            std::array<float, 3> translation{0, 0, 0}, scale{1, 1, 1};
            std::array<float, 4> rotation{0, 0, 0, 1};
            if (!t.empty()) std::copy_n(t.begin() + std::ptrdiff_t(i * 3), 3, translation.begin());
            if (!q.empty()) std::copy_n(q.begin() + std::ptrdiff_t(i * 4), 4, rotation.begin());
            if (!s.empty()) std::copy_n(s.begin() + std::ptrdiff_t(i * 3), 3, scale.begin());
            places.push_back(from_parts(translation, rotation, scale));
        }
        return true;
    }

    void add_camera(JsonReader& r, const std::string& node_name, int index, const Transform& here) {
        const json* j = file_.element("cameras", index, r.pointer_to("camera"));
        if (!j) return;
        const std::string pointer = "/cameras/" + std::to_string(index);
        JsonReader c = file_.reader(*j, pointer);
        std::string type, name = node_name;
        if (name.empty()) c.text("name", name);
        c.text("type", type);
        json out{{"transform", transform_json(rigid(to_z_up() * here))}};
        const char* key = type == "orthographic" ? "orthographic" : "perspective";
        const json* lens = c.required(key, "the lens");
        if (!lens) return;
        JsonReader l = file_.reader(*lens, c.pointer_to(key));
        float near_clip = 0.01f, far_clip = 1e10f, aspect = 0;
        l.number("znear", near_clip, 0, 1e30);
        l.number("zfar", far_clip, 0, 1e30);
        if (type == "orthographic") {
            float x = 1, y = 1;
            l.number("xmag", x);
            l.number("ymag", y);
            x = std::abs(x), y = std::abs(y);
            out["type"] = "orthographic";
            out["ortho_scale"] = std::max({2 * x, 2 * y, 1e-6f});
            aspect = x > 0 && y > 0 ? x / y : 0;
        } else {
            float yfov = 0.66f;
            if (l.required("yfov", "the vertical field of view in radians")) l.number("yfov", yfov, 1e-4, 3.1);
            l.number("aspectRatio", aspect, 1e-3, 1e3);
            const double wide = aspect > 0 ? aspect : 16.0 / 9;
            const double fov = wide >= 1 ? 2 * std::atan(wide * std::tan(yfov / 2)) : yfov;   // ours is that of the larger side
            out["fov_degrees"] = std::clamp(fov * 180 / std::numbers::pi, 0.01, 179.0);
        }
        out["near_clip"] = near_clip;
        out["far_clip"] = std::max(far_clip, near_clip * 1.001f + 1e-6f);
        const std::string unique = camera_names_.take(name, "camera");
        document_["cameras"][unique] = std::move(out);
        if (!document_.contains("camera")) {
            document_["camera"] = unique;
            set_resolution(aspect > 0 ? aspect : 16.0 / 9);
        }
    }

    /// glTF has no resolution: 960 on the larger side, in the camera's proportions.
    void set_resolution(double aspect) {
        const double a = std::clamp(aspect, 0.01, 100.0);
        document_["settings"]["resolution"] = {std::lround(a >= 1 ? 960 : 960 * a), std::lround(a >= 1 ? 960 / a : 960)};
    }

    void add_light(JsonReader& r, const std::string& node_name, int index, const Transform& here) {
        const json* list = nullptr;
        if (const auto e = file_.json.find("extensions"); e != file_.json.end() && e->is_object()) {
            if (const auto p = e->find("KHR_lights_punctual"); p != e->end() && p->is_object() && p->contains("lights")) list = &(*p)["lights"];
        }
        if (!list || !list->is_array() || size_t(index) >= list->size()) {
            add_error(file_.d, r.pointer_to("extensions") + "/KHR_lights_punctual/light", "out-of-range", std::to_string(index), "the index of a light of the file");
            return;
        }
        JsonReader l = file_.reader((*list)[size_t(index)], "/extensions/KHR_lights_punctual/lights/" + std::to_string(index));
        std::string type, name = node_name;
        if (name.empty()) l.text("name", name);
        l.text("type", type);
        Vec3f color(1);
        float intensity = 1;
        l.vector("color", color);
        l.number("intensity", intensity, 0);
        json out{{"transform", transform_json(rigid(to_z_up() * here))}, {"color", {color.x, color.y, color.z}}};
        // Photometric to radiometric as Blender's importer does: lux to W/m^2, candela over the whole sphere to W.
        if (type == "directional") {
            out["type"] = "sun";
            out["strength"] = intensity / kLumensPerWatt;
        } else if (type == "point" || type == "spot") {
            out["type"] = type;
            out["strength"] = intensity / kLumensPerWatt * 4 * std::numbers::pi;
        } else {
            add_error(file_.d, l.pointer_to("type"), "unknown-value", type, "directional, point or spot");
            return;
        }
        if (type == "spot") {
            float outer = float(std::numbers::pi / 4), inner = 0;
            if (const json* s = l.member("spot")) {
                JsonReader cone = file_.reader(*s, l.pointer_to("spot"));
                cone.number("outerConeAngle", outer, 0, 1.5708);
                cone.number("innerConeAngle", inner, 0, 1.5708);
            }
            out["spot_angle_degrees"] = std::min(outer * 360 / std::numbers::pi, 180.0);
            out["spot_blend"] = std::clamp(outer > 0 ? 1 - inner / outer : 0, 0.0f, 1.0f);
        }
        document_["lights"][light_names_.take(name, type)] = std::move(out);
    }

    void grow(Vec3f p) {
        if (!has_bounds_) bounds_ = {p, p};
        has_bounds_ = true;
        bounds_[0] = {std::min(bounds_[0].x, p.x), std::min(bounds_[0].y, p.y), std::min(bounds_[0].z, p.z)};
        bounds_[1] = {std::max(bounds_[1].x, p.x), std::max(bounds_[1].y, p.y), std::max(bounds_[1].z, p.z)};
    }

    /// A file without a camera is seen from the front left, slightly from above, as a whole.
    void add_camera_if_none() {
        if (document_.contains("cameras")) return;
        const Vec3f center = (bounds_[0] + bounds_[1]) * 0.5f, extent = bounds_[1] - bounds_[0];
        const float radius = std::max(0.5f * std::sqrt(dot(extent, extent)), 1e-3f);
        constexpr float kFovDegrees = 30;
        const float distance = radius / std::sin(kFovDegrees / 2 * 3.14159265f / 180);
        const Vec3f eye = center + Vec3f(-0.5f, -0.8f, 0.33f) * distance;   // of length 1
        document_["cameras"]["camera"] = {{"look_at", {{"from", {eye.x, eye.y, eye.z}}, {"to", {center.x, center.y, center.z}}}},
                                          {"fov_degrees", kFovDegrees}, {"near_clip", distance * 1e-4f}, {"far_clip", distance * 1e4f}};
        document_["camera"] = "camera";
        set_resolution(16.0 / 9);
        add_warning(file_.d, "/cameras", "missing-member", "no camera", "one: the whole scene is shown from the front left");
    }

    /// A file without lamps is lit evenly, so that something is to be seen.
    void add_light_if_none() {
        if (document_.contains("lights")) return;
        document_["world"] = {{"graph", {{"version", 1}, {"nodes", {{"background", {{"type", "ShaderNodeBackground"}, {"params", {{"Color", {1, 1, 1}}, {"Strength", 1}}}}}}},
                                         {"outputs", {{"surface", {{"node", "background"}}}}}}},
                              {"importance_resolution", 16}};
        add_warning(file_.d, "/extensions/KHR_lights_punctual", "missing-member", "no lights", "lights: a white world is used");
    }

    void leave_out() {
        if (const auto a = file_.json.find("animations"); a != file_.json.end() && !a->empty()) {
            add_warning(file_.d, "/animations", "unsupported", "animations", "a still: nodes are shown where they stand");
        }
        if (!name_.empty()) document_["name"] = name_;
    }

    void publish() {
        source_.document = std::move(document_);
        source_.read_buffer = [buffer = buffer_, next = source_.read_buffer](const std::string& name, std::vector<uint8_t>& bytes, std::string& error) {
            if (name != "gltf") return next && next(name, bytes, error);
            bytes = *buffer;
            return true;
        };
        auto images = std::make_shared<const std::map<std::string, GltfImage>>(std::move(images_));
        source_.resolve_image = [images, next = source_.resolve_image](const json& image, std::string& error) -> std::string {
            const auto file = image.find("file");
            const auto i = file != image.end() && file->is_string() ? images->find(file->get<std::string>()) : images->end();
            if (i == images->end() || i->second.bytes.empty()) return next ? next(image, error) : (error = "there is no such image", std::string());
            return store_temporary_asset(i->second.bytes, i->second.extension, error);
        };
    }

    GltfFile& file_;
    SceneSource& source_;
    std::shared_ptr<std::vector<uint8_t>> buffer_ = std::make_shared<std::vector<uint8_t>>();
    GltfMeshes meshes_;
    json document_;
    std::string name_;
    std::map<int, KnownMesh> known_meshes_;
    std::map<GltfMeshes::MaterialKey, std::string> known_materials_;
    std::map<std::string, GltfImage> images_;
    std::map<int, std::string> image_names_;
    GltfNames mesh_names_, material_names_, instance_names_, camera_names_, light_names_;
    std::array<Vec3f, 2> bounds_{Vec3f(0), Vec3f(0)};
    bool has_bounds_ = false;
};

bool import(const json& gltf, std::span<const uint8_t> bin, const SceneLoadOptions& options, SceneSource& source, Diagnostics& d) {
    GltfFile file(gltf, bin, source, options, d);
    return GltfScene(file, source).run();
}

}  // namespace

bool import_gltf(const json& gltf, const SceneLoadOptions& options, SceneSource& source, Diagnostics& d) { return import(gltf, {}, options, source, d); }

bool import_glb(std::span<const uint8_t> bytes, const std::string& folder, const SceneLoadOptions& options, SceneSource& source, Diagnostics& d) {
    use_folder(folder, options, source);
    const auto word = [&](size_t at) {
        uint32_t x = 0;
        if (at + 4 <= bytes.size()) std::memcpy(&x, bytes.data() + at, 4);
        return x;
    };
    constexpr uint32_t kMagic = 0x46546c67, kJson = 0x4e4f534a, kBin = 0x004e4942;
    if (bytes.size() < 20 || word(0) != kMagic || word(4) != 2 || word(8) > bytes.size()) {
        add_error(d, "", "unreadable", "not a whole .glb file of version 2", "one");
        return false;
    }
    std::span<const uint8_t> text, bin;
    for (size_t at = 12; at + 8 <= word(8);) {
        const uint32_t length = word(at), type = word(at + 4);
        at += 8;
        if (length > word(8) - at) {
            add_error(d, "", "unreadable", "a chunk of " + std::to_string(length) + " bytes", "chunks inside the file");
            return false;
        }
        if (type == kJson && text.empty()) text = bytes.subspan(at, length);
        if (type == kBin && bin.empty()) bin = bytes.subspan(at, length);
        at += (size_t(length) + 3) / 4 * 4;
    }
    if (text.size() > options.limits.document_bytes) {
        add_error(d, "", "limit-exceeded", std::to_string(text.size()) + " bytes of JSON", "at most " + std::to_string(options.limits.document_bytes));
        return false;
    }
    JsonLimits limits;
    limits.string_bytes = size_t(std::min<uint64_t>(options.limits.document_bytes, size_t(1) << 30));   // data: URIs
    const std::optional<json> j = parse_json({reinterpret_cast<const char*>(text.data()), text.size()}, limits, d);
    return j && import(*j, bin, options, source, d);
}

}  // namespace alder
