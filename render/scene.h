// Scene: immutable description of what is rendered; shared between revisions. Built by importers (scene document, glTF,
// preview stages), read by the accelerator, lights and integrator. Right-handed; Blender's axes (Z up) unless an importer says.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "graph/material.h"
#include "nodes/num/vec.h"

namespace alder {

/// Column-vector affine transform: x' = m[0..2] . (x,y,z,1), row major 3x4.
struct Transform {
    std::array<float, 12> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    Vec3f point(Vec3f p) const;
    Vec3f vector(Vec3f v) const;
    Vec3f normal(Vec3f n) const;   ///< by the inverse transpose, not normalised
    Transform inverse() const;     ///< identity where singular
    Transform operator*(const Transform& b) const;
    float determinant() const;
};

enum class Domain : uint8_t { Point, Corner, Face, Mesh };
struct Attribute {
    std::string name;
    Domain domain = Domain::Point;
    int channels = 3;           ///< 1, 2, 3 or 4
    std::vector<float> values;  ///< channels per element
};

struct Mesh {
    std::string name;
    std::vector<Vec3f> positions;
    std::vector<std::array<uint32_t, 3>> triangles;
    std::vector<Vec3f> vertex_normals;      ///< per point; empty = computed (compute_vertex_normals)
    std::vector<Vec3f> corner_normals;      ///< per triangle corner, overrides vertex normals
    std::vector<uint8_t> smooth;            ///< per triangle; empty = all smooth
    std::vector<uint32_t> face_material;    ///< per triangle: index into Instance::materials; empty = 0
    std::vector<std::array<float, 2>> uv;   ///< active UV map, per triangle corner; empty = none
    std::vector<Vec3f> tangents;            ///< per triangle corner, object space; empty = from uv when needed
    std::vector<float> tangent_signs;
    std::vector<Attribute> attributes;
    std::array<Vec3f, 2> generated_bounds{Vec3f(0), Vec3f(0)};  ///< texture space: min, max (object space)
};

/// Ray visibility, one bit a kind of ray.
enum RayVisibility : uint32_t {
    kVisibleCamera = 1, kVisibleDiffuse = 2, kVisibleGlossy = 4, kVisibleTransmission = 8, kVisibleShadow = 16,
    kVisibleVolume = 32, kVisibleAll = 63
};

struct Instance {
    std::string name;
    uint32_t mesh = 0;                ///< index into Scene::meshes
    Transform object_to_world;
    std::vector<uint32_t> materials;  ///< indices into Scene::materials, by face_material; at least one
    uint32_t visibility = kVisibleAll;
    float random = 0;                 ///< Object Info Random
    int pass_index = 0;
    Vec3f color{1, 1, 1};
    int light_group = 0;              ///< of its emission: 0 = none, 1..8
};

struct SceneMaterial {
    std::string name;
    std::shared_ptr<const Material> graph;
    int pass_index = 0;
};

enum class LightKind : uint8_t { Point, Spot, Sun, Area };
struct Light {
    std::string name;
    LightKind kind = LightKind::Point;
    Transform to_world;          ///< lights shine along local -Z
    Vec3f color{1, 1, 1};        ///< multiplies strength
    float strength = 0;          ///< Blender's units: W for point, spot, area; W/m^2 for sun
    float radius = 0;            ///< point, spot: sphere radius
    bool soft_falloff = false;   ///< point, spot: a disk that faces whoever looks takes the place of the sphere (Blender's Soft Falloff)
    float spot_angle = 0.785398f;///< full cone, radians
    float spot_blend = 0.15f;
    float angle = 0;             ///< sun: angular diameter, radians
    enum class Shape : uint8_t { Rectangle, Ellipse } shape = Shape::Rectangle;
    float size_x = 1, size_y = 1;
    float spread = 3.14159265f;  ///< area: full spread angle
    std::shared_ptr<const Material> graph;   ///< optional emission graph; its result multiplies colour and strength
    uint32_t visibility = kVisibleAll;
    bool cast_shadow = true;
    int light_group = 0;
    bool normalize = true;       ///< area and sphere lights: strength is power (true) or radiance (false)
};

struct Camera {
    std::string name;
    enum class Kind : uint8_t { Perspective, Orthographic } kind = Kind::Perspective;
    Transform to_world;          ///< looks along local -Z, +Y up
    float fov_x = 0.6911f;       ///< horizontal field of view, radians, for width >= height (else of the larger side)
    float ortho_scale = 6;       ///< width of the view of the larger side
    float near_clip = 0.001f, far_clip = 1e10f;
    float shift_x = 0, shift_y = 0;
    float aperture_radius = 0, focus_distance = 10;   ///< depth of field
};

struct RenderSettings {
    int width = 512, height = 512;
    int samples = 64;
    uint32_t seed = 0;
    int max_bounces = 12, diffuse_bounces = 12, glossy_bounces = 12, transmission_bounces = 12, volume_bounces = 12, transparent_bounces = 32;
    float clamp_direct = 0, clamp_indirect = 0;   ///< 0 = off
    bool film_transparent = false;
    float filter_width = 1;   ///< pixels; 1 with Box is the pixel itself
    enum class Filter : uint8_t { Box, Gaussian, BlackmanHarris } filter = Filter::Box;
    bool caustics_reflective = true, caustics_refractive = true;
    bool texture_filter = false;  ///< image textures take the mip level of the ray's footprint
    bool noise_filter = false;    ///< octaves of noise that are finer than the ray's footprint fade
    /// How light is found: by sampling lights, by scattered rays that meet them, or both, weighted. The single ones are for
    /// finding out where noise comes from, and for tests: all three have the same mean.
    enum class LightStrategy : uint8_t { Both, Lights, Scattering } light_strategy = LightStrategy::Both;
};

struct World {
    std::shared_ptr<const Material> graph;  ///< surface output emits (Background/Emission); null = black
    int light_group = 0;
    uint32_t visibility = kVisibleAll;
    int importance_resolution = 1024;       ///< width of the map that importance sampling is built from
};

struct Scene {
    std::string name;
    std::vector<std::shared_ptr<const Mesh>> meshes;
    std::vector<Instance> instances;
    std::vector<SceneMaterial> materials;
    std::vector<Light> lights;
    World world;
    Camera camera;
    std::vector<Camera> other_cameras;
    RenderSettings settings;
    std::vector<std::string> warnings;      ///< what an importer did not understand
};

}  // namespace alder
