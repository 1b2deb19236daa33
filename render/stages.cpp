// Preview stages: a shader ball, a sphere, a plate, a cloth, a swatch of hair or a block of something in a small photo studio.
// Studio: grey floor with a faint checker that runs up into the back wall; key softbox from the upper left, broad weak fill
// from the right, a narrow strip behind for the rim, and a soft gradient all round so that polished materials have
// something to reflect. Seen with a 70 mm lens, slightly from above.
#include "render/stages.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/stage_shapes.h"

namespace alder {
namespace {

enum StageMaterial : uint32_t { kSubject, kFloor, kStand };
enum StageLightGroup { kKey = 1, kFill = 2, kRim = 3 };

// The stage's own materials are ordinary graph documents.
// Floor: squares of half a metre, by the parity of the uv's whole parts.
constexpr const char* kFloorGraph = R"({"version": 1, "nodes": {
  "uv": {"type": "ShaderNodeTexCoord"},
  "cells": {"type": "ShaderNodeVectorMath", "params": {"operation": "SCALE", "Vector": {"node": "uv", "output": "UV"}, "Scale": 2.0}},
  "cell": {"type": "ShaderNodeVectorMath", "params": {"operation": "FLOOR", "Vector": {"node": "cells", "output": "Vector"}}},
  "split": {"type": "ShaderNodeSeparateXYZ", "params": {"Vector": {"node": "cell", "output": "Vector"}}},
  "sum": {"type": "ShaderNodeMath", "params": {"operation": "ADD", "Value": {"node": "split", "output": "X"}, "Value_001": {"node": "split", "output": "Y"}}},
  "parity": {"type": "ShaderNodeMath", "params": {"operation": "PINGPONG", "Value": {"node": "sum"}, "Value_001": 1.0}},
  "grey": {"type": "ShaderNodeMath", "params": {"operation": "MULTIPLY_ADD", "Value": {"node": "parity"}, "Value_001": 0.035, "Value_002": 0.17}},
  "bsdf": {"type": "ShaderNodeBsdfDiffuse", "params": {"Color": {"node": "grey"}}}},
  "outputs": {"surface": {"node": "bsdf"}}})";
constexpr const char* kStandGraph = R"({"version": 1, "nodes": {
  "bsdf": {"type": "ShaderNodeBsdfPrincipled", "params": {"Base Color": [0.025, 0.026, 0.028], "Roughness": 0.5}}},
  "outputs": {"surface": {"node": "bsdf"}}})";
constexpr const char* kDefaultGraph = R"({"version": 1, "nodes": {
  "bsdf": {"type": "ShaderNodeBsdfPrincipled", "params": {"Base Color": [0.5, 0.5, 0.5], "Roughness": 0.35}}},
  "outputs": {"surface": {"node": "bsdf"}}})";
constexpr const char* kDefaultHairGraph = R"({"version": 1, "nodes": {"hair": {"type": "ShaderNodeBsdfHairPrincipled"}}, "outputs": {"surface": {"node": "hair"}}})";
constexpr const char* kDefaultVolumeGraph = R"({"version": 1, "nodes": {
  "volume": {"type": "ShaderNodeVolumePrincipled", "params": {"Density": 2.0, "Color": [0.8, 0.8, 0.8]}}},
  "outputs": {"volume": {"node": "volume"}}})";
// Darker below, brightest above the horizon: by the direction's height.
constexpr const char* kWorldGraph = R"({"version": 1, "nodes": {
  "direction": {"type": "ShaderNodeTexCoord"},
  "split": {"type": "ShaderNodeSeparateXYZ", "params": {"Vector": {"node": "direction", "output": "Generated"}}},
  "height": {"type": "ShaderNodeMapRange", "params": {"Value": {"node": "split", "output": "Z"}, "From Min": -0.2, "From Max": 1.0}},
  "sky": {"type": "ShaderNodeValToRGB", "params": {"Fac": {"node": "height", "output": "Result"}, "color_ramp": {
      "color_mode": "RGB", "interpolation": "EASE", "elements": [
        {"position": 0.0, "color": [0.05, 0.05, 0.055, 1]}, {"position": 0.22, "color": [0.25, 0.255, 0.265, 1]},
        {"position": 0.55, "color": [0.55, 0.565, 0.585, 1]}, {"position": 1.0, "color": [1.4, 1.43, 1.47, 1]}]}}},
  "background": {"type": "ShaderNodeBackground", "params": {"Color": {"node": "sky", "output": "Color"}, "Strength": 0.6}}},
  "outputs": {"surface": {"node": "background"}}})";

std::shared_ptr<const Material> built_in(const char* text) {
    Diagnostics d;
    std::shared_ptr<const Material> m = build_material(nlohmann::json::parse(text), {}, d);
    if (!m) throw std::logic_error("a stage's own graph does not compile: " + (d.errors.empty() ? text : d.errors[0].line()));
    return m;
}

Vec3f unit(Vec3f v) { return v / std::sqrt(dot(v, v)); }

/// Places something that looks or shines along its -Z at `from`, aimed at `to`, with +Y as far up as that allows.
Transform aimed(Vec3f from, Vec3f to) {
    const Vec3f z = unit(from - to), x = unit(cross(Vec3f(0, 0, 1), z)), y = cross(z, x);
    return {{x.x, y.x, z.x, from.x, x.y, y.y, z.y, from.y, x.z, y.z, z.z, from.z}};
}

Transform placed(float x, float y, float z, float tilt = 0) {
    const float c = std::cos(tilt), s = std::sin(tilt);   // about X
    return {{1, 0, 0, x, 0, c, -s, y, 0, s, c, z}};
}

Light area_light(const char* name, Vec3f from, Vec3f to, float size_x, float size_y, float watts, Vec3f color, StageLightGroup group) {
    Light l;
    l.name = name;
    l.kind = LightKind::Area;
    l.to_world = aimed(from, to);
    l.size_x = size_x;
    l.size_y = size_y;
    l.strength = watts;
    l.color = color;
    l.light_group = group;
    l.visibility = kVisibleAll & ~uint32_t(kVisibleCamera);   // seen in reflections only
    return l;
}

/// Everything but the subject: shared by all stages.
Scene make_studio() {
    Scene s;
    s.materials.resize(3);
    s.materials[kSubject].name = "subject";
    s.materials[kFloor] = {"floor", built_in(kFloorGraph)};
    s.materials[kStand] = {"stand", built_in(kStandGraph)};
    s.meshes.push_back(make_cyclorama(14, -9, 6, 3.5f, 9));
    Instance studio;
    studio.name = "studio";
    studio.materials = {kFloor};
    s.instances.push_back(studio);

    const Vec3f subject(0, 0, 1.1f);
    s.lights.push_back(area_light("key", {-3.4f, -3.0f, 4.9f}, subject, 2.0f, 2.0f, 290, {1.0f, 0.97f, 0.93f}, kKey));
    s.lights.push_back(area_light("fill", {4.6f, -3.4f, 2.4f}, subject, 2.6f, 3.4f, 70, {0.90f, 0.95f, 1.0f}, kFill));
    s.lights.push_back(area_light("rim", {2.9f, 3.1f, 3.6f}, subject, 0.6f, 3.2f, 150, {1.0f, 1.0f, 1.0f}, kRim));
    s.world.graph = built_in(kWorldGraph);
    s.world.importance_resolution = 64;   // a smooth gradient

    constexpr float kLens = 70, kSensor = 36;
    s.camera.name = "camera";
    s.camera.fov_x = 2 * std::atan(kSensor / (2 * kLens));
    s.settings.samples = 64;
    s.settings.clamp_indirect = 4;            // a preview wants no fireflies,
    s.settings.caustics_reflective = false;   // and light by way of polished metal is one
    s.settings.max_bounces = 8;
    s.settings.diffuse_bounces = 3;
    s.settings.glossy_bounces = 4;
    s.settings.transmission_bounces = 8;
    return s;
}

void aim_camera(Scene& s, Vec3f target, float distance, float elevation_degrees) {
    const float e = elevation_degrees * 3.14159265f / 180;
    s.camera.to_world = aimed(target + Vec3f(0, -std::cos(e), std::sin(e)) * distance, target);
    s.camera.focus_distance = distance;
}

void add(Scene& s, const char* name, std::shared_ptr<const Mesh> mesh, const Transform& where, uint32_t material) {
    Instance i;
    i.name = name;
    i.mesh = uint32_t(s.meshes.size());
    i.object_to_world = where;
    i.materials = {material};
    s.meshes.push_back(std::move(mesh));
    s.instances.push_back(std::move(i));
}

Scene shader_ball_stage() {
    // Outlines run up from the floor on the outside and end inside: turned that way round, surfaces face outwards.
    constexpr OutlinePoint kStandOutline[] = {{0.90f, 0, 0},          {0.88f, 0.075f, 0.04f}, {0.60f, 0.11f, 0.1f},
                                              {0.52f, 0.22f, 0.1f},   {0.60f, 0.32f, 0.04f},  {0.60f, 0.375f, 0.03f},
                                              {0.535f, 0.375f, 0.015f}, {0.47f, 0.31f, 0.02f}, {0, 0.31f, 0}};
    constexpr OutlinePoint kRingOutline[] = {{1.06f, 0, 0}, {1.04f, 0.085f, 0.035f}, {0.92f, 0.085f, 0.035f}, {0.92f, 0, 0}};
    Scene s = make_studio();
    s.name = "shaderball";
    add(s, "ball", make_shader_ball(), placed(0, 0, 1.2f), kSubject);
    add(s, "ring", make_turned("ring", kRingOutline, 128), Transform{}, kSubject);
    add(s, "stand", make_turned("stand", kStandOutline, 96), Transform{}, kStand);
    aim_camera(s, {0, 0, 1.05f}, 6.05f, 13);
    return s;
}

Scene sphere_stage() {
    Scene s = make_studio();
    s.name = "sphere";
    add(s, "sphere", make_sphere(), placed(0, 0, 1), kSubject);
    aim_camera(s, {0, 0, 0.98f}, 5.6f, 13);
    return s;
}

Scene plane_stage() {
    Scene s = make_studio();
    s.name = "plane";
    constexpr float kTilt = -0.35f;   // leans back
    add(s, "plane", make_plate(), placed(0, 0, 1.02f, kTilt), kSubject);
    aim_camera(s, {0, 0, 0.98f}, 5.2f, 13);
    return s;
}

Scene cloth_stage() {
    Scene s = make_studio();
    s.name = "cloth";
    add(s, "drape", make_drape(), placed(0, 0, 1.33f), kSubject);
    aim_camera(s, {0, 0, 0.98f}, 5.9f, 20);
    return s;
}

Scene hair_stage() {
    Scene s = make_studio();
    s.name = "hair";
    constexpr OutlinePoint kBarOutline[] = {{0, -1.0f, 0}, {0.41f, -1.0f, 0.02f}, {0.41f, 1.0f, 0.02f}, {0, 1.0f, 0}};
    const Transform lying{{0, 0, 1, 0, 0, 1, 0, 0, -1, 0, 0, 1.5f}};   // the outline's axis along X
    add(s, "bar", make_turned("bar", kBarOutline, 64), lying, kStand);
    add(s, "hair", make_hair_swatch(), placed(0, 0, 1.5f), kSubject);
    aim_camera(s, {0, 0, 1.1f}, 5.6f, 13);
    return s;
}

Scene volume_stage() {
    Scene s = make_studio();
    s.name = "volume";
    constexpr float kTurn = 0.6f;   // about Z: two faces are seen
    const float c = std::cos(kTurn), n = std::sin(kTurn);
    add(s, "block", make_block(), {{c, -n, 0, 0, n, c, 0, 0, 0, 0, 1, 0.95f}}, kSubject);
    s.settings.volume_bounces = 4;
    aim_camera(s, {0, 0, 0.95f}, 5.6f, 16);
    return s;
}

/// Built when first asked for, then kept: geometry is shared by every preview of the process.
const Scene* base_stage(std::string_view name) {
    if (name == "shaderball") {
        static const Scene scene = shader_ball_stage();
        return &scene;
    }
    if (name == "sphere") {
        static const Scene scene = sphere_stage();
        return &scene;
    }
    if (name == "plane") {
        static const Scene scene = plane_stage();
        return &scene;
    }
    if (name == "cloth") {
        static const Scene scene = cloth_stage();
        return &scene;
    }
    if (name == "hair") {
        static const Scene scene = hair_stage();
        return &scene;
    }
    if (name == "volume") {
        static const Scene scene = volume_stage();
        return &scene;
    }
    return nullptr;
}

/// What a stage's subject wears where nothing is given.
const char* default_graph(std::string_view stage) {
    if (stage == "hair") return kDefaultHairGraph;
    return stage == "volume" ? kDefaultVolumeGraph : kDefaultGraph;
}

}  // namespace

std::vector<std::string_view> stage_names() { return {"shaderball", "sphere", "plane", "cloth", "hair", "volume"}; }

std::shared_ptr<const Scene> make_stage(std::string_view name, std::shared_ptr<const Material> material, int size, Diagnostics& d) {
    const Scene* base = nullptr;
    try {
        base = base_stage(name);
        if (base && !material) material = built_in(default_graph(name));
    } catch (const std::logic_error& e) {   // a build without one of the nodes that stages are made of
        d.errors.push_back({"/stage", "unsupported", std::string(name), e.what(), ""});
        return nullptr;
    }
    if (!base) {
        const auto names = stage_names();
        const std::vector<std::string> known(names.begin(), names.end());
        std::string list;
        for (const std::string& n : known) list += (list.empty() ? "one of " : ", ") + n;
        d.errors.push_back({"/stage", "unknown-stage", std::string(name), list, nearest_name(name, known)});
        return nullptr;
    }
    auto scene = std::make_shared<Scene>(*base);
    scene->materials[kSubject].graph = std::move(material);
    scene->settings.width = scene->settings.height = std::max(size, 1);
    return scene;
}

std::shared_ptr<const Scene> make_stage(std::string_view name, std::shared_ptr<const Material> material, int size) {
    Diagnostics d;
    return make_stage(name, std::move(material), size, d);
}

}  // namespace alder
