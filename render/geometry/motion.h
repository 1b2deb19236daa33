// Motion of objects and cameras between keys at equally spaced times of the shutter: rotations turn along the shorter arc,
// translation, scale and skew go straight. This is what Embree does with quaternion keys, and what Cycles shades with.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "render/scene.h"

namespace alder {

/// x' = translation + rotation (stretch x), with an upper triangular stretch.
struct MotionKey {
    std::array<float, 4> rotation{1, 0, 0, 0};  ///< unit quaternion, real part first
    Vec3f scale{1, 1, 1};                       ///< diagonal of the stretch
    Vec3f skew{0, 0, 0};                        ///< its xy, xz and yz
    Vec3f translation{0, 0, 0};
};
/// Keys whose quaternions follow each other without a jump of sign.
std::vector<MotionKey> motion_keys(std::span<const Transform> transforms);
Transform transform_of(const MotionKey& key);
/// time: 0 at the first key, 1 at the last; outside it stands still. At least one key.
Transform transform_at(std::span<const MotionKey> keys, float time);

/// Where among `steps` equally spaced keys a time lies: step and step + 1, weighted 1 - t and t.
struct MotionSpan {
    size_t step = 0;
    float t = 0;
};
MotionSpan motion_span(size_t steps, float time);

/// A point of the mesh, its radius and its normal at a time.
Vec3f position_at(const Mesh& mesh, uint32_t point, float time);
float radius_at(const Mesh& mesh, uint32_t point, float time);

}  // namespace alder
