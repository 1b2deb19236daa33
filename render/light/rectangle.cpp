// Spherical rectangles: section 4 of the paper, with the angles taken as arc sines so that small rectangles do not cancel.
#include "render/light/rectangle.h"

#include <algorithm>
#include <cmath>

#include "render/sampling.h"

namespace alder {
namespace {
float asin_clamped(float x) { return std::asin(std::clamp(x, -1.f, 1.f)); }
}  // namespace

SphericalRectangle::SphericalRectangle(Vec3f center, Vec3f axis_u, Vec3f axis_v, float len_u, float len_v, Vec3f p)
    : p_(p), x_(axis_u), y_(axis_v), z_(cross(axis_u, axis_v)) {
    const Vec3f d = center - p;
    z0_ = dot(d, z_);
    if (z0_ > 0) {  // the frame's z points from the rectangle to p
        z_ = -z_;
        z0_ = -z0_;
    }
    const float xc = dot(d, x_), yc = dot(d, y_);
    x0_ = xc - 0.5f * len_u;
    x1_ = xc + 0.5f * len_u;
    y0_ = yc - 0.5f * len_v;
    y1_ = yc + 0.5f * len_v;
    // z components of the normals of the four planes through p and an edge (equation 2).
    const auto edge = [&](float c) { return c / std::sqrt(c * c + z0_ * z0_); };
    const float nz0 = edge(-y0_), nz1 = edge(x1_), nz2 = edge(y1_), nz3 = edge(-x0_);
    // The paper's inner angles are acos(-nz_i nz_j); their sum less 2 pi is minus the sum of these arc sines.
    const float g0 = asin_clamped(-nz0 * nz1), g1 = asin_clamped(-nz1 * nz2);
    g2_ = asin_clamped(-nz2 * nz3);
    g3_ = asin_clamped(-nz3 * nz0);
    solid_angle_ = -(g0 + g1 + g2_ + g3_);
    b0_ = nz0;
    b1_ = nz2;
    // Below this the solid angle is rounding (each arc sine is good to 1e-7), and seen edge-on its parts cancel.
    const float smallest = std::min({nz0 * nz0, nz1 * nz1, nz2 * nz2, nz3 * nz3});
    small_ = !(solid_angle_ > 1e-3f) || smallest > 0.9999f || !(z0_ < -1e-4f * (len_u + len_v));
}

Vec3f SphericalRectangle::sample(float u1, float u2) const {
    // Equations 5 to 8. pi is moved out of the angle: cos and sin change sign, and with them b1.
    const float au = u1 * solid_angle_ + g2_ + g3_;
    const float s = std::sin(au);
    const float fu = s != 0 ? (std::cos(au) * b0_ + b1_) / s : 0;
    const float cu = std::clamp(std::copysign(1 / std::sqrt(fu * fu + b0_ * b0_), fu), -1.f, 1.f);
    const float xu = std::clamp(-(cu * z0_) / std::max(std::sqrt(1 - cu * cu), 1e-7f), x0_, x1_);
    const float d2 = xu * xu + z0_ * z0_;
    const float h0 = y0_ / std::sqrt(d2 + y0_ * y0_), h1 = y1_ / std::sqrt(d2 + y1_ * y1_);
    const float hv = h0 + u2 * (h1 - h0);
    const float yv = hv * hv < 1 - 1e-6f ? std::clamp(hv * std::sqrt(d2 / (1 - hv * hv)), y0_, y1_) : (hv < 0 ? y0_ : y1_);
    return p_ + x_ * xu + y_ * yv + z_ * z0_;
}

}  // namespace alder
