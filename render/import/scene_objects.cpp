// Scene documents: instances, lights, cameras, world, settings.
#include <algorithm>
#include <cmath>

#include "render/import/scene_parts.h"

namespace alder {

using nlohmann::json;

namespace {

constexpr const char* kGreyGraph = R"({"version": 1, "nodes": {"bsdf": {"type": "ShaderNodeBsdfDiffuse",
    "params": {"Color": [0.8, 0.8, 0.8]}}}, "outputs": {"surface": {"node": "bsdf"}}})";

void read_visibility(JsonReader& r, uint32_t& visibility) {
    const json* j = r.member("visibility");
    if (!j) return;
    JsonReader v(*j, r.pointer_to("visibility"), r.diagnostics(), r.lenient());
    for (const VisibilityName& n : kVisibilityNames) {
        bool on = (visibility & n.bit) != 0;
        v.boolean(n.name, on);
        visibility = on ? visibility | n.bit : visibility & ~uint32_t(n.bit);
    }
    v.finish();
}

/// "transform", or for people "look_at": {"from", "to", "up"}: along -Z from `from` to `to`, +Y towards `up`.
void read_placement(SceneReading& s, JsonReader& r, Transform& t) {
    const size_t faults = s.d.errors.size();
    r.transform("transform", t);
    const json* j = r.member("look_at");
    if (!j) return;
    JsonReader l(*j, r.pointer_to("look_at"), s.d, s.options.lenient);
    Vec3f from(0), to(0), up(0, 0, 1);
    if (l.required("from", "a point")) l.vector("from", from);
    if (l.required("to", "a point")) l.vector("to", to);
    l.vector("up", up);
    l.finish();
    const Vec3f back = from - to, side = cross(up, back);
    const float back_length = std::sqrt(dot(back, back)), side_length = std::sqrt(dot(side, side));
    if (s.d.errors.size() > faults) return;
    if (!(back_length > 0 && side_length > 1e-6f * back_length) || !std::isfinite(side_length)) {
        add_error(s.d, l.pointer(), "wrong-value", "no direction, or one along \"up\"", "\"from\" apart from \"to\" and not above or below it along \"up\"");
        return;
    }
    const Vec3f z = back / back_length, x = side / side_length, y = cross(z, x);
    t.m = {x.x, y.x, z.x, from.x, x.y, y.y, z.y, from.y, x.z, y.z, z.z, from.z};
}

/// Names in "materials" (or one in "material") as indices; none = Blender's grey.
std::vector<uint32_t> read_material_names(SceneReading& s, JsonReader& r) {
    const json *one = r.member("material"), *many = r.member("materials");
    std::vector<uint32_t> out;
    const auto resolve = [&](const json& j, const std::string& pointer) {
        if (!j.is_string()) {
            add_error(s.d, pointer, "wrong-type", describe(j), "the name of a material");
            return;
        }
        const auto i = s.material_index.find(j.get_ref<const std::string&>());
        if (i != s.material_index.end()) {
            out.push_back(i->second);
            return;
        }
        std::vector<std::string> known;
        for (const auto& [name, index] : s.material_index) known.push_back(name);
        add_error(s.d, pointer, "unknown-material", j.get<std::string>(), "a name in \"materials\"", nearest_name(j.get<std::string>(), known));
    };
    if (one && many) {
        add_error(s.d, r.pointer(), "wrong-value", "both \"material\" and \"materials\"", "one of them");
    } else if (one) {
        resolve(*one, r.pointer_to("material"));
    } else if (many && !many->is_array()) {
        add_error(s.d, r.pointer_to("materials"), "wrong-type", describe(*many), "an array of names of materials");
    } else if (many && !many->empty()) {
        for (size_t i = 0; i < many->size(); ++i) resolve((*many)[i], r.pointer_to("materials") + "/" + std::to_string(i));
    } else {
        // Without a material Blender shows grey. Its empty name cannot be one of the document's.
        const auto [i, is_new] = s.material_index.try_emplace("", uint32_t(s.scene.materials.size()));
        if (is_new) s.scene.materials.push_back({"", read_graph(s, json::parse(kGreyGraph), r.pointer())});
        out.push_back(i->second);
    }
    return out;
}

/// "mesh", "curves" or "points".
void read_shape_name(SceneReading& s, JsonReader& r, uint32_t& mesh, uint32_t& slots) {
    const char* key = nullptr;
    int shape = 0;
    for (int k = 0; k < 3; ++k) {
        if (!r.member(kInstanceMembers[k])) continue;
        if (key) add_error(s.d, r.pointer(), "wrong-value", std::string("both \"") + key + "\" and \"" + kInstanceMembers[k] + "\"", "one of them");
        else key = kInstanceMembers[k], shape = k;
    }
    if (!key) {
        r.required("mesh", "the name of a mesh (or \"curves\", \"points\")");
        return;
    }
    std::string name;
    const size_t faults = s.d.errors.size();
    r.text(key, name);
    const auto& index = s.shape_index[shape];
    if (const auto i = index.find(name); i != index.end()) {
        mesh = i->second;
        slots = s.mesh_slots[i->second];
    } else if (s.d.errors.size() == faults) {
        std::vector<std::string> known;
        for (const auto& [n, at] : index) known.push_back(n);
        add_error(s.d, r.pointer_to(key), "unknown-mesh", name, std::string("a name in \"") + kShapeMembers[shape] + "\"", nearest_name(name, known));
    }
}

/// Places at equally spaced times from the shutter's opening to its closing, for each of `count` things.
std::vector<float> read_motion(SceneReading& s, JsonReader& r, size_t count, size_t& steps) {
    std::vector<float> numbers;
    steps = 0;
    const json* j = r.member("motion");
    if (!j || j->is_null() || (j->is_array() && j->empty())) return numbers;
    if (!s.arrays.floats(*j, r.pointer_to("motion"), 12, SIZE_MAX, numbers)) return {};
    const size_t places = numbers.size() / 12;
    steps = count ? places / count : 0;
    if (count == 0 || places % count != 0 || steps < 2 || steps > size_t(kMostMotionSteps)) {
        add_error(s.d, r.pointer_to("motion"), "wrong-length", std::to_string(places) + " transforms",
                  "from 2 to " + std::to_string(kMostMotionSteps) + " for each of " + std::to_string(count));
        return {};
    }
    return numbers;
}
std::vector<Transform> motion_of(const std::vector<float>& numbers, size_t first, size_t steps) {
    std::vector<Transform> out(numbers.empty() ? 0 : steps);
    for (size_t k = 0; k < out.size(); ++k) std::copy_n(numbers.begin() + std::ptrdiff_t((first * steps + k) * 12), 12, out[k].m.begin());
    return out;
}

void read_instance(SceneReading& s, const std::string& name, const json& j, const std::string& pointer) {
    const size_t faults = s.d.errors.size();
    JsonReader r = s.object(j, pointer);
    if (!r.ok()) return;
    Instance base;
    base.name = name;
    uint32_t slots = 1;
    read_shape_name(s, r, base.mesh, slots);
    base.materials = read_material_names(s, r);
    if (s.d.errors.size() == faults && base.materials.size() < slots) {
        add_error(s.d, r.pointer_to("materials"), "wrong-length", std::to_string(base.materials.size()) + " materials",
                  std::to_string(slots) + ": the mesh's face_material goes up to " + std::to_string(slots - 1));
    }
    r.transform("transform", base.object_to_world);
    read_visibility(r, base.visibility);
    r.number("random", base.random, 0, 1);
    r.integer("pass_index", base.pass_index, 0, 1 << 24);
    r.vector("color", base.color);
    r.boolean("holdout", base.holdout);
    s.unsupported(r, "shadow_catcher", "shadow catchers are not rendered yet");
    r.integer("light_group", base.light_group, 0, kMaxLightGroup);
    std::vector<float> transforms, randoms;
    const json *many = r.member("transforms"), *random_values = r.member("randoms");
    size_t count = 1;
    if (many) {
        s.arrays.floats(*many, r.pointer_to("transforms"), 12, SIZE_MAX, transforms);
        count = transforms.size() / 12;
    }
    if (random_values) s.arrays.floats(*random_values, r.pointer_to("randoms"), 1, count, randoms);
    size_t steps = 0;
    const std::vector<float> motion = read_motion(s, r, count, steps);
    r.finish();
    if (s.scene.instances.size() + count > s.options.limits.instances) {
        add_error(s.d, pointer, "limit-exceeded", std::to_string(s.scene.instances.size() + count) + " instances", "at most " + std::to_string(s.options.limits.instances));
    }
    if (s.d.errors.size() != faults) return;
    for (size_t i = 0; i < count; ++i) {
        Instance& out = s.scene.instances.emplace_back(base);
        if (many) std::copy_n(transforms.begin() + std::ptrdiff_t(i * 12), 12, out.object_to_world.m.begin());
        if (random_values) out.random = randoms[i];
        out.motion = motion_of(motion, i, steps);
    }
}

void read_light(SceneReading& s, const std::string& name, const json& j, const std::string& pointer) {
    JsonReader r = s.object(j, pointer);
    if (!r.ok()) return;
    Light l;
    l.name = name;
    int kind = 0, shape = 0;
    r.required("type", "point, spot, sun or area");
    r.choice("type", kLightNames, kind);
    l.kind = LightKind(kind);
    read_placement(s, r, l.to_world);
    r.vector("color", l.color);
    r.number("strength", l.strength);
    r.number("radius", l.radius, 0);
    r.boolean("soft_falloff", l.soft_falloff);
    r.degrees("spot_angle_degrees", l.spot_angle, 0, 180);
    r.number("spot_blend", l.spot_blend, 0, 1);
    r.degrees("angle_degrees", l.angle, 0, 180);
    r.choice("shape", kShapeNames, shape);
    l.shape = Light::Shape(shape);
    float size[2] = {l.size_x, l.size_y};
    r.numbers("size", size);
    for (float x : size) {
        if (!(x >= 0)) add_error(s.d, r.pointer_to("size"), "out-of-range", json(x).dump(), "0 or more");
    }
    l.size_x = size[0];
    l.size_y = size[1];
    r.degrees("spread_degrees", l.spread, 0, 180);
    if (const json* g = r.member("graph"); g && !g->is_null()) l.graph = read_graph(s, *g, r.pointer_to("graph"));
    read_visibility(r, l.visibility);
    r.boolean("cast_shadow", l.cast_shadow);
    r.integer("light_group", l.light_group, 0, kMaxLightGroup);
    r.boolean("normalize", l.normalize);
    s.unsupported(r, "motion", "moving lights are not rendered yet");
    r.finish();
    s.scene.lights.push_back(std::move(l));
}

Camera read_camera(SceneReading& s, const std::string& name, const json& j, const std::string& pointer) {
    Camera c;
    c.name = name;
    JsonReader r = s.object(j, pointer);
    if (!r.ok()) return c;
    int kind = 0;
    r.choice("type", kCameraNames, kind);
    c.kind = Camera::Kind(kind);
    read_placement(s, r, c.to_world);
    r.degrees("fov_degrees", c.fov_x, 1e-3, 179.9);
    r.number("ortho_scale", c.ortho_scale, 1e-20);
    r.number("near_clip", c.near_clip, 0);
    r.number("far_clip", c.far_clip, 0);
    float shift[2] = {c.shift_x, c.shift_y};
    r.numbers("shift", shift);
    c.shift_x = shift[0];
    c.shift_y = shift[1];
    r.number("aperture_radius", c.aperture_radius, 0);
    r.number("focus_distance", c.focus_distance, 1e-6);
    r.integer("aperture_blades", c.aperture_blades, 0, 1000);
    r.degrees("aperture_rotation_degrees", c.aperture_rotation, -3600, 3600);
    r.number("aperture_ratio", c.aperture_ratio, 1e-3, 1e3);
    int panorama = 0;
    r.choice("panorama", kPanoramaNames, panorama);
    c.panorama = Camera::Panorama(panorama);
    r.degrees("longitude_min_degrees", c.longitude_min, -360, 360);
    r.degrees("longitude_max_degrees", c.longitude_max, -360, 360);
    r.degrees("latitude_min_degrees", c.latitude_min, -90, 90);
    r.degrees("latitude_max_degrees", c.latitude_max, -90, 90);
    if (!(c.longitude_max > c.longitude_min) || !(c.latitude_max > c.latitude_min))
        add_error(s.d, r.pointer(), "wrong-value", "an empty range of longitudes or latitudes", "maxima above minima");
    r.degrees("fisheye_fov_degrees", c.fisheye_fov, 0.1, 1800);
    r.number("fisheye_lens_mm", c.fisheye_lens, 1e-3, 1e5);
    float sensor[2] = {c.sensor_width, c.sensor_height};
    r.numbers("sensor_mm", sensor);
    for (const float x : sensor)
        if (!(x > 0)) add_error(s.d, r.pointer_to("sensor_mm"), "out-of-range", json(x).dump(), "more than 0");
    c.sensor_width = sensor[0];
    c.sensor_height = sensor[1];
    if (!(c.far_clip > c.near_clip)) add_error(s.d, r.pointer_to("far_clip"), "out-of-range", json(c.far_clip).dump(), "more than near_clip");
    size_t steps = 0;
    const std::vector<float> motion = read_motion(s, r, 1, steps);
    c.motion = motion_of(motion, 0, steps);
    r.finish();
    return c;
}

/// Calls `read` for every member of an object of named things.
template <class Read>
void for_each_member(SceneReading& s, const json& j, const std::string& pointer, size_t limit, const Read& read) {
    JsonReader all = s.object(j, pointer);
    if (!all.ok()) return;
    if (j.size() > limit) {
        add_error(s.d, pointer, "limit-exceeded", std::to_string(j.size()) + " members", "at most " + std::to_string(limit));
        return;
    }
    for (const auto& [name, value] : j.items()) {
        if (name.empty()) add_error(s.d, pointer + "/", "wrong-value", "an empty name", "a name");
        else read(name, value, pointer + "/" + pointer_token(name));
    }
}

}  // namespace

void read_instances(SceneReading& s, const json& j, const std::string& pointer) {
    for_each_member(s, j, pointer, s.options.limits.instances,
                    [&](const std::string& name, const json& value, const std::string& p) { read_instance(s, name, value, p); });
}

void read_lights(SceneReading& s, const json& j, const std::string& pointer) {
    for_each_member(s, j, pointer, s.options.limits.lights,
                    [&](const std::string& name, const json& value, const std::string& p) { read_light(s, name, value, p); });
}

void read_cameras(SceneReading& s, JsonReader& top) {
    std::string wanted;
    top.text("camera", wanted);
    const json* j = top.required("cameras", "at least one camera");
    if (!j) return;
    std::vector<Camera> cameras;
    for_each_member(s, *j, top.pointer_to("cameras"), 10000, [&](const std::string& name, const json& value, const std::string& p) {
        cameras.push_back(read_camera(s, name, value, p));
    });
    if (!j->is_object()) return;
    if (cameras.empty()) {
        add_error(s.d, top.pointer_to("cameras"), "missing-member", "no camera", "at least one camera");
        return;
    }
    std::vector<std::string> known;
    for (const Camera& c : cameras) known.push_back(c.name);
    if (wanted.empty()) {
        if (cameras.size() > 1) add_error(s.d, top.pointer_to("camera"), "missing-member", "nothing", "which of the cameras to render");
        wanted = cameras[0].name;
    }
    const auto chosen = std::find_if(cameras.begin(), cameras.end(), [&](const Camera& c) { return c.name == wanted; });
    if (chosen == cameras.end()) {
        add_error(s.d, top.pointer_to("camera"), "unknown-camera", wanted, "a name in \"cameras\"", nearest_name(wanted, known));
        return;
    }
    s.scene.camera = *chosen;
    cameras.erase(chosen);
    s.scene.other_cameras = std::move(cameras);
}

void read_settings(SceneReading& s, const json& j, const std::string& pointer) {
    JsonReader r = s.object(j, pointer);
    if (!r.ok()) return;
    RenderSettings& x = s.scene.settings;
    float resolution[2] = {float(x.width), float(x.height)};
    r.numbers("resolution", resolution);
    for (float v : resolution) {
        if (!(v >= 1 && v <= 16384) || v != std::trunc(v)) {
            add_error(s.d, r.pointer_to("resolution"), "out-of-range", json(v).dump(), "two whole numbers from 1 to 16384");
        }
    }
    x.width = int(std::clamp(resolution[0], 1.0f, 16384.0f));
    x.height = int(std::clamp(resolution[1], 1.0f, 16384.0f));
    r.integer("samples", x.samples, 1, 1 << 20);
    r.integer("seed", x.seed, 0, 0xffffffffll);
    r.integer("max_bounces", x.max_bounces, 0, 1024);
    r.integer("diffuse_bounces", x.diffuse_bounces, 0, 1024);
    r.integer("glossy_bounces", x.glossy_bounces, 0, 1024);
    r.integer("transmission_bounces", x.transmission_bounces, 0, 1024);
    r.integer("volume_bounces", x.volume_bounces, 0, 1024);
    r.integer("transparent_bounces", x.transparent_bounces, 0, 1024);
    r.number("clamp_direct", x.clamp_direct, 0);
    r.number("clamp_indirect", x.clamp_indirect, 0);
    r.boolean("film_transparent", x.film_transparent);
    r.number("exposure", x.exposure, 0, 1e6);
    r.number("filter_glossy", x.filter_glossy, 0, 1e6);
    int filter = int(x.filter);
    r.choice("filter", kFilterNames, filter);
    x.filter = RenderSettings::Filter(filter);
    r.number("filter_width", x.filter_width, 0.01, 10);
    r.boolean("caustics_reflective", x.caustics_reflective);
    r.boolean("texture_filter", x.texture_filter);
    r.boolean("noise_filter", x.noise_filter);
    r.boolean("caustics_refractive", x.caustics_refractive);
    if (const json* curve = r.member("shutter_curve")) {
        s.arrays.floats(*curve, r.pointer_to("shutter_curve"), 1, SIZE_MAX, x.shutter_curve);
        for (const float v : x.shutter_curve)
            if (!(v >= 0)) add_error(s.d, r.pointer_to("shutter_curve"), "out-of-range", json(v).dump(), "0 or more");
        if (x.shutter_curve.size() == 1) add_error(s.d, r.pointer_to("shutter_curve"), "wrong-length", "1 number", "none, or 2 and more");
    }
    r.finish();
}

void read_world(SceneReading& s, const json& j, const std::string& pointer) {
    if (j.is_null()) return;
    JsonReader r = s.object(j, pointer);
    if (!r.ok()) return;
    World& w = s.scene.world;
    if (const json* g = r.member("graph"); g && !g->is_null()) w.graph = read_graph(s, *g, r.pointer_to("graph"));
    r.integer("light_group", w.light_group, 0, kMaxLightGroup);
    read_visibility(r, w.visibility);
    r.integer("importance_resolution", w.importance_resolution, 4, 16384);
    r.finish();
}

}  // namespace alder
