// The process's Embree device, and rays in its form. Private to the files that talk to Embree: accel.cpp, box_index.cpp.
#pragma once
#include <embree3/rtcore.h>

#include "render/accel.h"

namespace alder {

/// One device for the process: Embree's devices carry thread state and are meant to be few.
RTCDevice embree_device();
RTCRayHit embree_ray(const Ray& ray, uint32_t mask);
/// Embree takes coordinates up to this (its FLT_LARGE, 1.8e18, with room for rounding), and some builds stop the process at
/// others: what would exceed it is left out of the scene, or met by no ray.
inline constexpr float kLargestCoordinate = 1e18f;
/// False for NaN, infinities and origins beyond the limit.
bool embree_takes(const Ray& ray, float largest_origin = kLargestCoordinate);

}  // namespace alder
