// Procedural meshes of the preview stages: each is made in a few milliseconds, has uv, normals and a texture space.
#pragma once
#include <memory>
#include <span>

#include "render/scene.h"

namespace alder {

/// Sphere of radius 1 with a rounded window cut into its front (-Y, turned to +X), behind which a smaller sphere shows.
/// One closed surface, so that glass and skin work. uv: twice round the equator, once from pole to pole.
std::shared_ptr<const Mesh> make_shader_ball();
/// Sphere of radius 1, uv as above.
std::shared_ptr<const Mesh> make_sphere();
/// Square of side 2 in the XZ plane facing -Y, uv 0..1.
std::shared_ptr<const Mesh> make_plate();

/// Cube of side 1.5 around the origin, flat faces, uv 0..1 on each: a body for what fills it.
std::shared_ptr<const Mesh> make_block();
/// A square sheet laid over a ball of radius 0.62 around the origin, hanging in folds; uv 0..1.
std::shared_ptr<const Mesh> make_drape();
/// A swatch of hair over a bar of radius 0.42 along X at the origin, as hairdressers show it: slightly wavy threads, front and back.
std::shared_ptr<const Mesh> make_hair_swatch();

/// One corner of an outline (radius, height) and how much it is rounded.
struct OutlinePoint {
    float r, z, rounding;
};
/// Turns an outline about the Z axis. uv: once round, and along the outline by its length.
std::shared_ptr<const Mesh> make_turned(const char* name, std::span<const OutlinePoint> outline, int segments);

/// Studio floor that curves up into a back wall; uv in metres along the surface. Floor at z = 0 from y = front to
/// y = back - radius, wall from z = radius to `top`.
std::shared_ptr<const Mesh> make_cyclorama(float half_width, float front, float back, float radius, float top);

}  // namespace alder
