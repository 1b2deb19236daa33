// Lamps: point, spot, sun and area lights in Blender's units, sampled from a point and met by a ray.
//
// Units, as Cycles has them (strength S times colour):
//   point, spot   S watt: radiant intensity S / (4 pi) in every direction; as a sphere of radius r radiance S / (4 pi^2 r^2), and
//                 the same as a disk of radius r that faces the point lit (soft falloff)
//   area          S watt: radiance S / (pi A), Lambertian; with a spread below 180 degrees attenuated and renormalised
//   sun           S watt/m^2: irradiance S on a plane that faces it
// Without `normalize` S / pi is the radiance (area, spheres) whatever the size.
#pragma once
#include <array>
#include <memory>

#include "render/light/selector.h"
#include "render/scene.h"

namespace alder {
struct InstanceFrame;

/// A direction towards a lamp.
struct LampSample {
    Vec3f wi{0, 0, 1};
    float distance = 0;    ///< infinite for suns
    float pdf = 0;         ///< by solid angle; 1 where is_delta
    Vec3f radiance{0, 0, 0};  ///< delta: irradiance on a plane that faces the lamp
    Vec3f ng{0, 0, 1};     ///< the lamp's normal there, away from the lamp
    float u = 0, v = 0;    ///< the lamp's own coordinates, for graphs
};

class Lamp {
  public:
    explicit Lamp(const Light& light);

    /// False: nothing reaches p by this sample.
    bool sample(Vec3f p, float u1, float u2, LampSample& s) const;
    /// Where a ray from p meets the lamp: distance (infinite for suns), density with which sample() would have chosen this
    /// direction, radiance. False: it does not, or the lamp has no size. t in (t_min, t_max).
    bool intersect(Vec3f p, Vec3f direction, float t_min, float t_max, LampSample& s) const;

    /// Box of the surface that a ray can meet; of suns none.
    std::array<Vec3f, 2> box() const;
    bool is_delta() const { return is_delta_; }
    /// Radiates nothing whatever the graph says.
    bool is_black() const;
    /// For the choice among lights; a sun's power is what it sends through a disk of the scene's radius.
    EmitterBounds bounds(float scene_radius) const;
    const Light& light() const { return light_; }
    /// The lamp's space, for its graph.
    const InstanceFrame& frame() const { return *frame_; }

  private:
    bool sample_sphere(Vec3f p, float u1, float u2, LampSample& s) const;
    bool sample_area(Vec3f p, float u1, float u2, LampSample& s) const;
    bool sample_disk(Vec3f p, float u1, float u2, LampSample& s) const;
    bool intersect_disk(Vec3f p, Vec3f direction, float t_min, float t_max, LampSample& s) const;
    bool intersect_sphere(Vec3f p, Vec3f direction, float t_min, float t_max, LampSample& s) const;
    bool intersect_area(Vec3f p, Vec3f direction, float t_min, float t_max, LampSample& s) const;
    float sphere_density(float distance2) const;
    float spot_attenuation(Vec3f from_lamp) const;
    float spread_attenuation(Vec3f from_lamp) const;
    struct Region;
    bool area_region(Vec3f p, Region& r) const;
    void area_uv(Vec3f on_lamp, LampSample& s) const;

    Light light_;
    std::shared_ptr<const InstanceFrame> frame_;
    bool is_delta_ = true;
    Vec3f radiance_{0, 0, 0};  ///< or intensity, or irradiance: what a full sample carries
    Vec3f co_{0, 0, 0}, dir_{0, 0, -1};
    float radius_ = 0;
    Transform to_local_;
    float cos_half_spot_ = -1, spot_smooth_ = 0;
    float one_minus_cos_ = 0;  ///< sun
    Vec3f axis_u_{1, 0, 0}, axis_v_{0, 1, 0};
    float len_u_ = 0, len_v_ = 0, area_ = 0;
    bool ellipse_ = false, has_spread_ = false;
    float tan_half_spread_ = 0, normalize_spread_ = 0;
};

}  // namespace alder
