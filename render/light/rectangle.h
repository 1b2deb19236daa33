// A rectangle seen from a point: sampled uniformly in solid angle.
// Urena, Fajardo and King, "An Area-Preserving Parametrization for Spherical Rectangles", EGSR 2013.
#pragma once
#include "nodes/num/vec.h"

namespace alder {

class SphericalRectangle {
  public:
    /// Centre, unit orthogonal axes, full lengths; p: the point it is seen from.
    SphericalRectangle(Vec3f center, Vec3f axis_u, Vec3f axis_v, float len_u, float len_v, Vec3f p);
    /// Whether the rectangle is so far away that sampling its area is as good: cos/d^2 varies little over it. Cheap.
    static bool is_far(Vec3f center, float len_u, float len_v, Vec3f p) {
        const Vec3f d = center - p;
        return len_u * len_u + len_v * len_v < 0.25f * dot(d, d);
    }
    /// Steradians. Small or grazing rectangles are left to area sampling: is_small().
    float solid_angle() const { return solid_angle_; }
    bool is_small() const { return small_; }
    /// Point on the rectangle.
    Vec3f sample(float u1, float u2) const;

  private:
    Vec3f p_, x_, y_, z_;
    float x0_, x1_, y0_, y1_, z0_;
    float b0_, b1_, g2_, g3_, solid_angle_;
    bool small_;
};

}  // namespace alder
