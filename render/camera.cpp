// Camera: perspective and orthographic with thin-lens depth of field, and panoramas.
#include "render/camera.h"

#include <algorithm>
#include <cmath>

#include "render/sampling.h"

namespace alder {
namespace {

/// Rotation and translation only: the scale of a camera object has no meaning (Blender ignores it too).
Transform without_scale(const Transform& t) {
    Transform r = t;
    for (int c = 0; c < 3; ++c) {
        const Vec3f column = safe_normalize(Vec3f(t.m[c], t.m[4 + c], t.m[8 + c]));
        r.m[c] = column.x;
        r.m[4 + c] = column.y;
        r.m[8 + c] = column.z;
    }
    return r;
}

float clamped(float x, float lo, float hi, float otherwise) { return std::isfinite(x) ? std::clamp(x, lo, hi) : otherwise; }

}  // namespace

CameraModel::CameraModel(const Camera& camera, int width, int height)
    : orthographic_(camera.kind == Camera::Kind::Orthographic),
      camera_(camera),
      to_world_(without_scale(camera.to_world)),
      width_(static_cast<float>(std::max(width, 1))),
      height_(static_cast<float>(std::max(height, 1))) {
    if (camera.motion.size() > 1) {
        std::vector<Transform> keys;
        for (const Transform& t : camera.motion) keys.push_back(without_scale(t));
        motion_ = motion_keys(keys);
    }
    const Transform flip{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0}};
    world_to_camera_ = flip * to_world_.inverse();
    const float larger = std::max(width_, height_);
    const float half = orthographic_ ? 0.5f * clamped(camera.ortho_scale, 1e-6f, 1e12f, 6.f)
                                     : std::tan(0.5f * clamped(camera.fov_x, 1e-4f, 3.1f, 0.69f));
    half_x_ = half * width_ / larger;
    half_y_ = half * height_ / larger;
    // Blender's lens shift: in units of the larger side.
    offset_x_ = 2 * half * clamped(camera.shift_x, -1e3f, 1e3f, 0);
    offset_y_ = 2 * half * clamped(camera.shift_y, -1e3f, 1e3f, 0);
    camera_.aperture_ratio = clamped(camera.aperture_ratio, 1e-4f, 1e4f, 1);
    near_ = clamped(camera.near_clip, orthographic_ ? -1e12f : 0.f, 1e12f, 0);
    far_ = clamped(camera.far_clip, near_, 1e30f, 1e30f);
    aperture_ = clamped(camera.aperture_radius, 0, 1e12f, 0);
    focus_ = clamped(camera.focus_distance, 1e-5f, 1e30f, 10);
}

std::array<float, 2> CameraModel::aperture(float u, float v) const {
    float x, y;
    const int blades = camera_.aperture_blades;
    if (blades < 3) {
        const Disk d = uniform_disk(u, v);
        x = d.x;
        y = d.y;
    } else {
        // One of the triangles between the centre and two corners, and a point within it. The rotation is that of an edge's middle.
        const float scaled = u * static_cast<float>(blades), corner = std::min(std::floor(scaled), static_cast<float>(blades - 1));
        const float step = 2 * kPi / static_cast<float>(blades), r = std::sqrt(v), w = (1 - (scaled - corner)) * r, z = (scaled - corner) * r;
        const float a0 = camera_.aperture_rotation + step * (corner - 0.5f), a1 = a0 + step;
        x = w * std::cos(a0) + z * std::cos(a1);
        y = w * std::sin(a0) + z * std::sin(a1);
    }
    return {x / camera_.aperture_ratio, y};
}

CameraRay CameraModel::placed(Vec3f origin, Vec3f direction, float near, float far, float time) const {
    CameraRay r;
    const Transform to_world = motion_.empty() ? to_world_ : transform_at(motion_, time);
    r.direction = safe_normalize(to_world.vector(direction));
    r.origin = to_world.point(origin) + r.direction * near;
    r.length = far - near;
    return r;
}

CameraRay CameraModel::ray(float x, float y, float lens_u, float lens_v, float time) const {
    if (camera_.kind == Camera::Kind::Panoramic) return panorama_ray(x, y, lens_u, lens_v, time);
    const float sx = half_x_ * (2 * x / width_ - 1) + offset_x_;
    const float sy = half_y_ * (1 - 2 * y / height_) + offset_y_;
    Vec3f origin{0, 0, 0}, direction{sx, sy, -1};
    if (orthographic_) {
        origin = {sx, sy, 0};
        direction = {0, 0, -1};
    }
    if (aperture_ > 0) {
        const Vec3f focus = origin + direction * focus_;
        const std::array<float, 2> lens = aperture(lens_u, lens_v);
        origin += Vec3f(lens[0], lens[1], 0) * aperture_;
        direction = focus - origin;
    }
    const float along_axis = -direction.z / length(direction);  // cosine to the viewing axis, > 0
    CameraRay r = placed(origin, safe_normalize(direction), near_ / along_axis, far_ / along_axis, time);
    const float pixel_x = 2 * half_x_ / width_, pixel_y = 2 * half_y_ / height_;
    if (orthographic_) {
        r.footprint = 0.5f * (pixel_x + pixel_y);
    } else {
        // Turn of the unit direction v/|v| per pixel step dv: |dv - n (n.dv)| / |v|.
        const float l2 = sx * sx + sy * sy + 1, inverse2 = 1 / l2;
        r.spread = 0.5f * (pixel_x * std::sqrt((l2 - sx * sx) * inverse2) + pixel_y * std::sqrt((l2 - sy * sy) * inverse2)) * std::sqrt(inverse2);
        r.footprint = r.spread * near_ / along_axis;
    }
    return r;
}

/// Direction in camera space (-Z ahead, +X right, +Y up) that a place on the frame looks in, 0..1 from the lower left.
/// Zero where the frame shows nothing.
Vec3f CameraModel::panorama_direction(float x, float y) const {
    const Camera& c = camera_;
    switch (c.panorama) {
        case Camera::Panorama::Equirectangular: {
            const float longitude = c.longitude_min + (c.longitude_max - c.longitude_min) * x, latitude = c.latitude_min + (c.latitude_max - c.latitude_min) * y;
            return {std::cos(latitude) * std::sin(longitude), std::sin(latitude), -std::cos(latitude) * std::cos(longitude)};
        }
        case Camera::Panorama::FisheyeEquidistant: {
            const float u = 2 * (x - 0.5f), v = 2 * (y - 0.5f), r = std::sqrt(u * u + v * v);
            if (r > 1) return Vec3f(0.f);
            const float theta = 0.5f * r * c.fisheye_fov, s = r > 0 ? std::sin(theta) / r : 0.f;
            return {u * s, v * s, -std::cos(theta)};
        }
        case Camera::Panorama::FisheyeEquisolid: {
            const float u = (x - 0.5f) * c.sensor_width, v = (y - 0.5f) * c.sensor_height, r = std::sqrt(u * u + v * v);
            // r = 2 f sin(theta / 2): areas on the sensor are solid angles.
            const float most = 2 * c.fisheye_lens * std::sin(0.25f * c.fisheye_fov);
            if (!(r <= most)) return Vec3f(0.f);
            const float theta = 2 * std::asin(std::clamp(r / (2 * c.fisheye_lens), 0.f, 1.f)), s = r > 0 ? std::sin(theta) / r : 0.f;
            return {u * s, v * s, -std::cos(theta)};
        }
        case Camera::Panorama::MirrorBall: {
            // Mirrored by the ball's normal above this place of its outline, seen from afar; its middle looks ahead, as in Blender.
            const float u = 2 * x - 1, v = 2 * y - 1, r2 = u * u + v * v;
            if (r2 > 1) return Vec3f(0.f);
            const float z = std::sqrt(1 - r2);  // of the normal, towards the viewer
            return safe_normalize(Vec3f(2 * z * u, 2 * z * v, 1 - 2 * z * z));
        }
    }
    return Vec3f(0.f);
}

/// The inverse: where on the frame a point of camera space (ahead is +Z here) appears.
Vec3f CameraModel::panorama_window(Vec3f p) const {
    const Camera& c = camera_;
    const Vec3f d = safe_normalize(p);
    const float sine = std::sqrt(d.x * d.x + d.y * d.y), theta = std::atan2(sine, d.z);
    const auto across = [&](float x) { return sine > 0 ? x / sine : 0.f; };
    switch (c.panorama) {
        case Camera::Panorama::Equirectangular: {
            const float longitude = std::atan2(d.x, d.z), latitude = std::asin(std::clamp(d.y, -1.f, 1.f));
            return {(longitude - c.longitude_min) / (c.longitude_max - c.longitude_min), (latitude - c.latitude_min) / (c.latitude_max - c.latitude_min), length(p)};
        }
        case Camera::Panorama::FisheyeEquidistant: {
            const float r = theta / c.fisheye_fov;
            return {0.5f + r * across(d.x), 0.5f + r * across(d.y), length(p)};
        }
        case Camera::Panorama::FisheyeEquisolid: {
            const float r = 2 * c.fisheye_lens * std::sin(0.5f * theta);
            return {0.5f + r * across(d.x) / c.sensor_width, 0.5f + r * across(d.y) / c.sensor_height, length(p)};
        }
        case Camera::Panorama::MirrorBall: {
            const float z = std::sqrt(std::max(0.5f * (1 + d.z), 0.f)), scale = z > 0 ? 0.5f / z : 0.f;
            return {0.5f * (d.x * scale + 1), 0.5f * (d.y * scale + 1), length(p)};
        }
    }
    return Vec3f(0.f);
}

CameraRay CameraModel::panorama_ray(float x, float y, float lens_u, float lens_v, float time) const {
    const auto look = [&](float px, float py) { return panorama_direction(px / width_, 1 - py / height_); };
    Vec3f direction = look(x, y), origin(0.f);
    if (is_black(direction)) return {{0, 0, 0}, {0, 0, -1}, -1, 0, 0};  // nothing is seen: a ray without length
    // The footprint from the neighbouring places; at the rim of a fisheye from the side that is seen.
    const auto step = [&](float dx, float dy) {
        Vec3f other = look(x + dx, y + dy);
        if (is_black(other)) other = look(x - dx, y - dy);
        return is_black(other) ? 0.f : length(other - direction);
    };
    const float spread = 0.5f * (step(1, 0) + step(0, 1));
    if (aperture_ > 0) {
        // The lens stands across the direction looked in; its first axis points as far ahead as it can (Cycles).
        const Vec3f ahead = std::abs(direction.z) < 0.99999f ? Vec3f(0, 0, -1) : Vec3f(0, 1, 0);
        const Vec3f right = safe_normalize(ahead - direction * dot(ahead, direction)), above = cross(direction, right);
        const std::array<float, 2> lens = aperture(lens_u, lens_v);
        origin = (right * lens[0] + above * lens[1]) * aperture_;
        direction = safe_normalize(direction * focus_ - origin);
    }
    CameraRay r = placed(origin, direction, near_, far_, time);
    r.spread = spread;
    r.footprint = spread * near_;
    return r;
}

float CameraModel::depth(Vec3f p) const {
    const Vec3f c = world_to_camera_.point(p);
    return camera_.kind == Camera::Kind::Panoramic ? length(c) : c.z;
}

Vec3f CameraModel::window(Vec3f p) const {
    const Vec3f c = world_to_camera_.point(p);
    if (camera_.kind == Camera::Kind::Panoramic) return panorama_window(c);
    const float scale = orthographic_ ? 1.f : (c.z != 0 ? 1 / c.z : 0.f);
    return {0.5f * ((c.x * scale - offset_x_) / half_x_ + 1), 0.5f * ((c.y * scale - offset_y_) / half_y_ + 1), c.z};
}

}  // namespace alder
