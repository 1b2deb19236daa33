// Camera: turns a raster position and a lens sample into a ray with its footprint.
#pragma once
#include <array>

#include "render/geometry/motion.h"
#include "render/scene.h"

namespace alder {

/// A ray that leaves the camera at its near plane. The footprint is a cone: a radius and its growth per unit length
/// (Cycles' compact differentials).
struct CameraRay {
    Vec3f origin, direction;
    float length = 0;             ///< to the far clip plane; below 0: this place of the frame shows nothing
    float footprint = 0, spread = 0;
};

class CameraModel {
  public:
    /// Full frame in pixels, without any crop.
    CameraModel(const Camera& camera, int width, int height);
    /// Raster position in pixels of the full frame, row 0 at the top; lens sample in [0,1)^2.
    CameraRay ray(float x, float y, float lens_u, float lens_v, float time = 0.5f) const;
    bool moves() const { return !motion_.empty(); }

    /// Columns of the matrix into camera space, which here looks along +Z (Cycles' convention).
    const Transform& world_to_camera() const { return world_to_camera_; }
    /// Distance along the viewing axis; of a panorama from the camera.
    float depth(Vec3f p) const;
    /// Position on the frame, 0..1 from the lower left (Blender's Window coordinate); z is the depth.
    Vec3f window(Vec3f p) const;

  private:
    Vec3f panorama_direction(float x, float y) const;
    Vec3f panorama_window(Vec3f p) const;
    CameraRay panorama_ray(float x, float y, float lens_u, float lens_v, float time) const;
    CameraRay placed(Vec3f origin, Vec3f direction, float near, float far, float time) const;
    /// Point of the aperture in units of its radius.
    std::array<float, 2> aperture(float u, float v) const;

    bool orthographic_ = false;
    Camera camera_;
    Transform to_world_;         ///< scale removed
    std::vector<MotionKey> motion_;
    Transform world_to_camera_;
    float half_x_ = 1, half_y_ = 1;    ///< half extents of the image at distance 1 (perspective) or in world units
    float offset_x_ = 0, offset_y_ = 0;
    float width_ = 1, height_ = 1;
    float near_ = 0, far_ = 1;
    float aperture_ = 0, focus_ = 1;
};

}  // namespace alder
