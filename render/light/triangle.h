// A triangle seen from a point: sampled uniformly in solid angle.
// Arvo, "Stratified Sampling of Spherical Triangles", SIGGRAPH 1995.
#pragma once
#include <array>

#include "nodes/num/vec.h"

namespace alder {

class SphericalTriangle {
  public:
    SphericalTriangle(const std::array<Vec3f, 3>& corners, Vec3f p);
    float solid_angle() const { return solid_angle_; }
    /// Whether sampling by solid angle pays and is precise; others are sampled by area.
    bool is_usable() const { return usable_; }
    /// Direction, and the barycentrics of the second and third corner there. False where rounding finds no point.
    bool sample(float u1, float u2, Vec3f& direction, float& b1, float& b2) const;

  private:
    Vec3f to_[3], unit_[3];
    float solid_angle_ = 0;
    bool usable_ = false;
};

}  // namespace alder
