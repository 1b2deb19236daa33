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

enum class Domain : uint8_t { Point, Corner, Face, Mesh, Curve };
struct Attribute {
    std::string name;
    Domain domain = Domain::Point;
    int channels = 3;           ///< 1, 2, 3 or 4
    std::vector<float> values;  ///< channels per element
};

/// What the points of a Mesh are joined to. A primitive is a triangle, a segment between two points of a curve, or a sphere.
enum class Shape : uint8_t { Triangles, Curves, Spheres };
/// Curves of Catmull-Rom segments: with the thickness of a thread, or flat and turned to whoever looks (but shaded as if round).
/// Linear: threads of straight pieces.
enum class CurveForm : uint8_t { Round, Ribbon, Linear };

struct Mesh {
    std::string name;
    Shape shape = Shape::Triangles;
    std::vector<Vec3f> positions;
    std::vector<std::array<uint32_t, 3>> triangles;
    std::vector<float> radii;               ///< curves, spheres: per point
    std::vector<uint32_t> curve_first;      ///< curves: first point of each, and one more: the number of points
    CurveForm curve_form = CurveForm::Round;
    int curve_subdivisions = 2;             ///< ribbons: halvings of a segment
    std::vector<Vec3f> curve_normals;       ///< per point: across the thread, along the wide side of its section; empty = none
    /// Deformation over the shutter: positions (and radii) at equally spaced times from its opening to its closing, one after
    /// the other; empty = none. `positions` is the shape by which texture space and emission are found.
    int motion_steps = 0;
    std::vector<Vec3f> motion_positions, motion_normals;
    std::vector<float> motion_radii;
    std::vector<Vec3f> vertex_normals;      ///< per point; empty = computed (compute_vertex_normals)
    std::vector<Vec3f> corner_normals;      ///< per triangle corner, overrides vertex normals
    std::vector<uint8_t> smooth;            ///< per triangle; empty = all smooth
    std::vector<uint32_t> face_material;    ///< per triangle: index into Instance::materials; empty = 0
    std::vector<std::array<float, 2>> uv;   ///< active UV map, per triangle corner; empty = none
    std::vector<Vec3f> tangents;            ///< per triangle corner, object space; empty = from uv when needed
    std::vector<float> tangent_signs;
    std::vector<Attribute> attributes;
    std::array<Vec3f, 2> generated_bounds{Vec3f(0), Vec3f(0)};  ///< texture space: min, max (object space)

    bool moves() const { return motion_steps > 1; }
    size_t primitive_count() const;   ///< triangles, segments or spheres
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
    std::vector<Transform> motion;    ///< at equally spaced times from the shutter's opening to its closing; empty = at rest
    std::vector<uint32_t> materials;  ///< indices into Scene::materials, by face_material; at least one
    uint32_t visibility = kVisibleAll;
    float random = 0;                 ///< Object Info Random
    int pass_index = 0;
    Vec3f color{1, 1, 1};
    int light_group = 0;              ///< of its emission: 0 = none, 1..8
    bool holdout = false;             ///< cuts a hole into the film's alpha where the camera sees it
};

/// What a material's displacement output does: turn normals only, move vertices, or move vertices and turn normals by the rest.
enum class Displacement : uint8_t { Bump, Move, Both };

struct SceneMaterial {
    std::string name;
    std::shared_ptr<const Material> graph;
    int pass_index = 0;
    Displacement displacement = Displacement::Bump;
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
    enum class Kind : uint8_t { Perspective, Orthographic, Panoramic } kind = Kind::Perspective;
    /// Of a panoramic camera: which direction a place on the frame looks in.
    enum class Panorama : uint8_t { Equirectangular, FisheyeEquidistant, FisheyeEquisolid, MirrorBall } panorama = Panorama::Equirectangular;
    float longitude_min = -3.14159265f, longitude_max = 3.14159265f;   ///< equirectangular, radians; 0 is the viewing axis
    float latitude_min = -1.57079633f, latitude_max = 1.57079633f;
    float fisheye_fov = 3.14159265f;   ///< whole angle, radians
    float fisheye_lens = 10.5f, sensor_width = 36, sensor_height = 24;   ///< equisolid, mm
    Transform to_world;          ///< looks along local -Z, +Y up
    std::vector<Transform> motion;   ///< as Instance::motion
    float fov_x = 0.6911f;       ///< horizontal field of view, radians, for width >= height (else of the larger side)
    float ortho_scale = 6;       ///< width of the view of the larger side
    float near_clip = 0.001f, far_clip = 1e10f;
    float shift_x = 0, shift_y = 0;
    float aperture_radius = 0, focus_distance = 10;   ///< depth of field
    int aperture_blades = 0;       ///< 3 and more: a regular polygon in place of the disk
    float aperture_rotation = 0;   ///< of the polygon, radians
    float aperture_ratio = 1;      ///< height over width: an anamorphic lens
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
    float exposure = 1;       ///< factor of all light on the film
    float filter_glossy = 0;  ///< Cycles': how far glossy lobes are blurred behind unlikely scatterings; 0 = off
    std::vector<float> shutter_curve;   ///< how open the shutter is over its time; empty = fully throughout
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
