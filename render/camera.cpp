// Camera: perspective with thin-lens depth of field, and orthographic.
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
    near_ = clamped(camera.near_clip, orthographic_ ? -1e12f : 0.f, 1e12f, 0);
    far_ = clamped(camera.far_clip, near_, 1e30f, 1e30f);
    aperture_ = clamped(camera.aperture_radius, 0, 1e12f, 0);
    focus_ = clamped(camera.focus_distance, 1e-5f, 1e30f, 10);
}

CameraRay CameraModel::ray(float x, float y, float lens_u, float lens_v, float time) const {
    const float sx = half_x_ * (2 * x / width_ - 1) + offset_x_;
    const float sy = half_y_ * (1 - 2 * y / height_) + offset_y_;
    Vec3f origin{0, 0, 0}, direction{sx, sy, -1};
    if (orthographic_) {
        origin = {sx, sy, 0};
        direction = {0, 0, -1};
    }
    if (aperture_ > 0) {
        const Vec3f focus = origin + direction * focus_;
        const Disk lens = uniform_disk(lens_u, lens_v);
        origin += Vec3f(lens.x, lens.y, 0) * aperture_;
        direction = focus - origin;
    }
    const float along_axis = -direction.z / length(direction);  // cosine to the viewing axis, > 0
    direction = safe_normalize(direction);

    CameraRay r;
    const Transform to_world = motion_.empty() ? to_world_ : transform_at(motion_, time);
    r.direction = safe_normalize(to_world.vector(direction));
    r.origin = to_world.point(origin) + r.direction * (near_ / along_axis);
    r.length = (far_ - near_) / along_axis;
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

float CameraModel::depth(Vec3f p) const { return world_to_camera_.point(p).z; }

Vec3f CameraModel::window(Vec3f p) const {
    const Vec3f c = world_to_camera_.point(p);
    const float scale = orthographic_ ? 1.f : (c.z != 0 ? 1 / c.z : 0.f);
    return {0.5f * ((c.x * scale - offset_x_) / half_x_ + 1), 0.5f * ((c.y * scale - offset_y_) / half_y_ + 1), c.z};
}

}  // namespace alder
