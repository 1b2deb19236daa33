// Lamps: sampling, densities and radiance. Conventions and constants are those of Cycles' lights.
#include "render/light/lamp.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "render/geometry/surface.h"
#include "render/light/rectangle.h"
#include "render/sampling.h"

namespace alder {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

Vec3f column(const Transform& t, int c) { return {t.m[c], t.m[4 + c], t.m[8 + c]}; }
Vec3f finite_or_zero(Vec3f v) { return is_finite(v) ? v : Vec3f(0.f); }
float smoothstep(float x) {
    x = std::clamp(x, 0.f, 1.f);
    return x * x * (3 - 2 * x);
}

}  // namespace

/// The part of an area light that is sampled from a point: all of it, or the rectangle that its spread lets through.
struct Lamp::Region {
    Vec3f center;
    float len_u, len_v;
    bool ellipse;
};

Lamp::Lamp(const Light& light) : light_(light), frame_(std::make_shared<const InstanceFrame>(frame_of(light.to_world))) {
    const Transform& t = light.to_world;
    co_ = column(t, 3);
    dir_ = safe_normalize(-column(t, 2));
    const Vec3f full = finite_or_zero(light.color * light.strength);
    radius_ = std::isfinite(light.radius) ? std::max(light.radius, 0.f) : 0.f;
    switch (light.kind) {
        case LightKind::Point:
        case LightKind::Spot: {
            is_delta_ = radius_ == 0;
            const float sphere_area = 4 * kPi * radius_ * radius_;
            // Radiance S/(pi A) of a sphere; as a point its limit, the intensity S/(4 pi).
            radiance_ = full * kInvPi * (light.normalize ? 1 / (is_delta_ ? 4.f : sphere_area) : 1.f);
            to_local_ = t.inverse();
            const float half = 0.5f * std::clamp(light.spot_angle, 0.f, kPi);
            cos_half_spot_ = std::cos(half);
            const float edge = (1 - cos_half_spot_) * std::clamp(light.spot_blend, 0.f, 1.f);
            spot_smooth_ = edge > 0 ? 1 / edge : kInfinity;
            break;
        }
        case LightKind::Sun: {
            const float half = 0.5f * std::clamp(std::isfinite(light.angle) ? light.angle : 0.f, 0.f, kPi);
            is_delta_ = half == 0;
            one_minus_cos_ = 2 * sqr(std::sin(0.5f * half));
            radiance_ = full;
            // Irradiance of a cone of unit radiance: pi sin^2 of its half angle.
            if (!is_delta_ && light.normalize) radiance_ = full * (1 / (kPi * sqr(std::sin(half))));
            break;
        }
        case LightKind::Area: {
            const Vec3f eu = column(t, 0) * light.size_x, ev = column(t, 1) * light.size_y;
            len_u_ = length(eu);
            len_v_ = length(ev);
            axis_u_ = safe_normalize(eu);
            axis_v_ = safe_normalize(ev);
            ellipse_ = light.shape == Light::Shape::Ellipse;
            area_ = len_u_ * len_v_ * (ellipse_ ? kPi / 4 : 1.f);
            is_delta_ = false;
            radiance_ = full * kInvPi * (light.normalize && area_ > 0 ? 1 / area_ : 1.f);
            const float half = 0.5f * std::clamp(light.spread, 0.f, kPi);
            has_spread_ = half < 0.5f * kPi - 1e-6f;
            if (has_spread_) {
                // A soft box's grid hides tan(a)/tan(half) of the light; normalised so that the power stays:
                // integral of cos x (1 - tan x / tan a) sin x from 0 to a, times tan a. Series below 0.05 rad.
                const float a = std::max(half, 1e-3f);
                tan_half_spread_ = std::tan(a);
                normalize_spread_ = a > 0.05f ? 1 / (tan_half_spread_ - a) : 3 / (a * a * a);
            }
            break;
        }
    }
    radiance_ = finite_or_zero(radiance_);
}

bool Lamp::is_black() const {
    return alder::is_black(radiance_) || (light_.kind == LightKind::Area && area_ == 0) || !is_finite(co_) || !is_finite(dir_);
}

EmitterBounds Lamp::bounds(float scene_radius) const {
    const float l = luminance({std::abs(radiance_.x), std::abs(radiance_.y), std::abs(radiance_.z)});
    EmitterBounds b;
    b.center = co_;
    b.axis = dir_;
    switch (light_.kind) {
        case LightKind::Point:
        case LightKind::Spot:
            b.radius = radius_;
            b.intensity = l * (is_delta_ ? 1 : kPi * sqr(radius_));
            b.power = 4 * kPi * b.intensity;
            if (light_.kind == LightKind::Spot) {
                b.power *= std::max(0.5f * (1 - cos_half_spot_), 1e-4f);
                // The cone is widened where the lamp is scaled unevenly across its axis.
                const Transform& t = light_.to_world;
                const float across = std::max(length(column(t, 0)), length(column(t, 1))), along = length(column(t, 2));
                const float tangent = safe_sqrt(1 - sqr(cos_half_spot_)) / std::max(cos_half_spot_, 1e-6f) * across / std::max(along, 1e-20f);
                if (cos_half_spot_ > 0.01f) b.cos_spread = 1 / std::sqrt(1 + sqr(tangent)) - 1e-3f;
            }
            break;
        case LightKind::Sun:
            b.distant = true;
            b.irradiance = l * (is_delta_ ? 1 : 2 * kPi * one_minus_cos_);
            b.power = b.irradiance * kPi * sqr(scene_radius);
            break;
        case LightKind::Area:
            b.radius = 0.5f * (ellipse_ ? std::max(len_u_, len_v_) : std::sqrt(sqr(len_u_) + sqr(len_v_)));
            b.intensity = l * area_ * (has_spread_ ? normalize_spread_ * tan_half_spread_ : 1.f);
            b.power = l * kPi * area_;
            b.cos_spread = (has_spread_ ? std::cos(std::atan(tan_half_spread_)) : 0.f) - 1e-3f;
            b.lambertian = true;
            break;
    }
    return b;
}

std::array<Vec3f, 2> Lamp::box() const {
    Vec3f half(radius_);
    if (light_.kind == LightKind::Area)
        for (int c = 0; c < 3; ++c) half[c] = 0.5f * (std::abs(axis_u_[c]) * len_u_ + std::abs(axis_v_[c]) * len_v_);
    // Widened by rounding: the box must not lose what the exact test finds.
    half += Vec3f(1e-6f * (max_abs(half) + max_abs(co_)));
    return {co_ - half, co_ + half};
}

float Lamp::spot_attenuation(Vec3f from_lamp) const {
    if (light_.kind != LightKind::Spot) return 1;
    Vec3f local = safe_normalize(to_local_.vector(from_lamp));
    const float above = -local.z - cos_half_spot_;
    if (!(above > 0)) return 0;
    return smoothstep(above * spot_smooth_);
}

float Lamp::spread_attenuation(Vec3f from_lamp) const {
    if (!has_spread_) return 1;
    const float c = dot(from_lamp, dir_);
    if (!(c > 0)) return 0;
    const float tan_angle = safe_sqrt(1 - c * c) / c;
    return std::max((tan_half_spread_ - tan_angle) * normalize_spread_, 0.f);
}

// ---- spheres: point and spot lights with a radius ------------------------------------------------------------------

float Lamp::sphere_density(float distance2) const {
    const float r2 = sqr(radius_);
    if (distance2 <= r2) return 1 / (4 * kPi);  // from inside every direction meets it
    return cone_density(one_minus_cos_from_sin2(r2 / distance2));
}

/// The disk about the lamp's centre that faces p: its light falls off softly where a surface cuts through the lamp.
bool Lamp::sample_disk(Vec3f p, float u1, float u2, LampSample& s) const {
    const Vec3f axis = safe_normalize(p - co_);
    if (alder::is_black(axis)) return false;
    const Frame frame = frame_about(axis);
    const Disk d = uniform_disk(u1, u2);
    const Vec3f to = co_ + (frame.x * d.x + frame.y * d.y) * radius_ - p;
    const float d2 = dot(to, to);
    s.distance = std::sqrt(d2);
    if (!(s.distance > 0)) return false;
    s.wi = to / s.distance;
    const float cos_lamp = -dot(axis, s.wi);
    if (!(cos_lamp > 0)) return false;
    s.pdf = kInvPi * d2 / (sqr(radius_) * cos_lamp);
    s.ng = -s.wi;
    s.radiance = radiance_ * spot_attenuation(-s.wi);
    s.u = s.v = 0.5f;
    return std::isfinite(s.pdf) && !alder::is_black(s.radiance);
}

bool Lamp::intersect_disk(Vec3f p, Vec3f direction, float t_min, float t_max, LampSample& s) const {
    const Vec3f to_center = co_ - p, axis = safe_normalize(-to_center);
    const float cos_lamp = -dot(axis, direction);
    if (!(cos_lamp > 0)) return false;
    const float t = length(to_center) / cos_lamp;
    if (!(t > t_min && t < t_max)) return false;
    const Vec3f off = direction * t - to_center;
    if (!(dot(off, off) <= sqr(radius_))) return false;
    s.wi = direction;
    s.distance = t;
    s.pdf = kInvPi * sqr(t) / (sqr(radius_) * cos_lamp);
    s.ng = -direction;
    s.radiance = radiance_ * spot_attenuation(-direction);
    s.u = s.v = 0.5f;
    return std::isfinite(s.pdf);
}

bool Lamp::sample_sphere(Vec3f p, float u1, float u2, LampSample& s) const {
    if (light_.soft_falloff && !is_delta_) return sample_disk(p, u1, u2, s);
    const Vec3f to_center = co_ - p;
    const float d2 = dot(to_center, to_center), d = std::sqrt(d2);
    if (is_delta_) {
        if (!(d > 0)) return false;
        s.wi = to_center / d;
        s.distance = d;
        s.pdf = 1;
        s.ng = -s.wi;
        s.radiance = radiance_ * (spot_attenuation(-s.wi) / d2);
        return !alder::is_black(s.radiance);
    }
    const float r2 = sqr(radius_);
    if (d2 > r2) {
        const float one_minus_cos = one_minus_cos_from_sin2(r2 / d2);
        s.wi = uniform_cone(to_center / d, one_minus_cos, u1, u2);
    } else {
        const float z = 1 - 2 * u1, r = safe_sqrt(1 - z * z), phi = 2 * kPi * u2;
        s.wi = {r * std::cos(phi), r * std::sin(phi), z};
    }
    s.pdf = sphere_density(d2);
    // Distance along wi to the sphere's near side (far side from inside); at the rim the discriminant may round below zero.
    const float b = dot(to_center, s.wi), h = safe_sqrt(r2 - (d2 - b * b));
    s.distance = d2 > r2 ? b - h : b + h;
    s.ng = safe_normalize(p + s.wi * s.distance - co_);
    s.radiance = radiance_ * (d2 > r2 ? spot_attenuation(-s.wi) : 1.f);
    s.u = 0.5f;
    s.v = 0.5f;
    return s.distance > 0 && !alder::is_black(s.radiance);
}

bool Lamp::intersect_sphere(Vec3f p, Vec3f direction, float t_min, float t_max, LampSample& s) const {
    if (light_.soft_falloff) return intersect_disk(p, direction, t_min, t_max, s);
    const Vec3f to_center = co_ - p;
    const float d2 = dot(to_center, to_center), b = dot(to_center, direction), r2 = sqr(radius_);
    // Distance of the ray from the centre by the cross product: no cancellation for far, small lamps.
    const Vec3f off = to_center - direction * b;
    const float h2 = r2 - dot(off, off);
    if (h2 < 0) return false;
    const float h = std::sqrt(h2);
    const float t = d2 > r2 ? b - h : b + h;
    if (!(t > t_min && t < t_max)) return false;
    s.wi = direction;
    s.distance = t;
    s.pdf = sphere_density(d2);
    s.ng = safe_normalize(p + direction * t - co_);
    s.radiance = radiance_ * (d2 > r2 ? spot_attenuation(-direction) : 1.f);
    s.u = 0.5f;
    s.v = 0.5f;
    return true;
}

// ---- area lights ----------------------------------------------------------------------------------------------------

bool Lamp::area_region(Vec3f p, Region& r) const {
    r = {co_, len_u_, len_v_, ellipse_};
    const float height = dot(dir_, p - co_);
    if (!(height > 0)) return false;  // one-sided
    if (!has_spread_) return true;
    // Only a disk about the foot point can be seen through the grid: sample the part of the light around it.
    const Vec3f foot = p - dir_ * height - co_;
    const float reach = height * tan_half_spread_, u = dot(foot, axis_u_), v = dot(foot, axis_v_);
    const float u0 = std::max(u - reach, -0.5f * len_u_), u1 = std::min(u + reach, 0.5f * len_u_);
    const float v0 = std::max(v - reach, -0.5f * len_v_), v1 = std::min(v + reach, 0.5f * len_v_);
    if (u0 >= u1 || v0 >= v1) return false;
    if (ellipse_ && (u1 - u0) * (v1 - v0) >= area_) return true;
    r = {co_ + axis_u_ * (0.5f * (u0 + u1)) + axis_v_ * (0.5f * (v0 + v1)), u1 - u0, v1 - v0, false};
    return true;
}

void Lamp::area_uv(Vec3f on_lamp, LampSample& s) const {
    const Vec3f d = on_lamp - co_;
    s.u = dot(d, axis_u_) / len_u_ + 0.5f;
    s.v = dot(d, axis_v_) / len_v_ + 0.5f;
}

bool Lamp::sample_area(Vec3f p, float u1, float u2, LampSample& s) const {
    Region r;
    if (area_ == 0 || !area_region(p, r)) return false;
    Vec3f q;
    float pdf = 0;
    if (r.ellipse) {
        const Disk d = uniform_disk(u1, u2);
        q = r.center + axis_u_ * (0.5f * r.len_u * d.x) + axis_v_ * (0.5f * r.len_v * d.y);
    } else {
        const bool far = SphericalRectangle::is_far(r.center, r.len_u, r.len_v, p);
        std::optional<SphericalRectangle> rectangle;
        if (!far) rectangle.emplace(r.center, axis_u_, axis_v_, r.len_u, r.len_v, p);
        if (far || rectangle->is_small()) {
            q = r.center + axis_u_ * (r.len_u * (u1 - 0.5f)) + axis_v_ * (r.len_v * (u2 - 0.5f));
        } else {
            q = rectangle->sample(u1, u2);
            pdf = 1 / rectangle->solid_angle();
        }
    }
    if (ellipse_ && !r.ellipse) {  // a clipped ellipse is sampled by its bounding rectangle
        const Vec3f d = q - co_;
        if (sqr(2 * dot(d, axis_u_) / len_u_) + sqr(2 * dot(d, axis_v_) / len_v_) > 1) return false;
    }
    const Vec3f to = q - p;
    const float d2 = dot(to, to);
    s.distance = std::sqrt(d2);
    if (!(s.distance > 0)) return false;
    s.wi = to / s.distance;
    const float cos_light = -dot(s.wi, dir_);
    if (!(cos_light > 0)) return false;
    const float sampled_area = r.len_u * r.len_v * (r.ellipse ? kPi / 4 : 1.f);
    s.pdf = pdf > 0 ? pdf : d2 / (cos_light * sampled_area);
    s.ng = dir_;
    s.radiance = radiance_ * spread_attenuation(-s.wi);
    area_uv(q, s);
    return !alder::is_black(s.radiance) && std::isfinite(s.pdf);
}

bool Lamp::intersect_area(Vec3f p, Vec3f direction, float t_min, float t_max, LampSample& s) const {
    const float cos_light = -dot(direction, dir_);
    if (area_ == 0 || !(cos_light > 0)) return false;
    const float t = dot(dir_, p - co_) / cos_light;
    if (!(t > t_min && t < t_max)) return false;
    const Vec3f q = p + direction * t, d = q - co_;
    const float u = 2 * dot(d, axis_u_) / len_u_, v = 2 * dot(d, axis_v_) / len_v_;
    if (ellipse_ ? u * u + v * v > 1 : std::abs(u) > 1 || std::abs(v) > 1) return false;
    s.wi = direction;
    s.distance = t;
    s.ng = dir_;
    s.radiance = radiance_ * spread_attenuation(-direction);
    area_uv(q, s);
    s.pdf = 0;
    Region r;
    if (area_region(p, r)) {
        if (!r.ellipse && !SphericalRectangle::is_far(r.center, r.len_u, r.len_v, p)) {
            const SphericalRectangle rectangle(r.center, axis_u_, axis_v_, r.len_u, r.len_v, p);
            if (!rectangle.is_small()) s.pdf = 1 / rectangle.solid_angle();
        }
        if (s.pdf == 0) s.pdf = t * t / (cos_light * r.len_u * r.len_v * (r.ellipse ? kPi / 4 : 1.f));
    }
    return true;
}

// ---- all kinds ------------------------------------------------------------------------------------------------------

bool Lamp::sample(Vec3f p, float u1, float u2, LampSample& s) const {
    switch (light_.kind) {
        case LightKind::Point:
        case LightKind::Spot: return sample_sphere(p, u1, u2, s);
        case LightKind::Area: return sample_area(p, u1, u2, s);
        case LightKind::Sun: {
            s.wi = is_delta_ ? -dir_ : uniform_cone(-dir_, one_minus_cos_, u1, u2);
            s.distance = kInfinity;
            s.pdf = is_delta_ ? 1 : cone_density(one_minus_cos_);
            s.radiance = radiance_;
            s.ng = -s.wi;
            return true;
        }
    }
    return false;
}

bool Lamp::intersect(Vec3f p, Vec3f direction, float t_min, float t_max, LampSample& s) const {
    if (is_delta_) return false;
    switch (light_.kind) {
        case LightKind::Point:
        case LightKind::Spot: return intersect_sphere(p, direction, t_min, t_max, s);
        case LightKind::Area: return intersect_area(p, direction, t_min, t_max, s);
        case LightKind::Sun: {
            if (std::isfinite(t_max)) return false;
            // 1 - cos by half the squared chord: exact for a disk of half a degree, where 1 - dot would be noise.
            const Vec3f chord = direction + dir_;
            if (0.5f * dot(chord, chord) > one_minus_cos_) return false;
            s.wi = direction;
            s.distance = kInfinity;
            s.pdf = cone_density(one_minus_cos_);
            s.radiance = radiance_;
            s.ng = -direction;
            return true;
        }
    }
    return false;
}

}  // namespace alder
