// Spherical triangles: solid angle and sampling.
#include "render/light/triangle.h"

#include <algorithm>
#include <cmath>

#include "render/sampling.h"

namespace alder {

SphericalTriangle::SphericalTriangle(const std::array<Vec3f, 3>& corners, Vec3f p) {
    for (int k = 0; k < 3; ++k) to_[k] = corners[k] - p;
    // Far away cos/d^2 hardly varies over the triangle: not worth the angles.
    const Vec3f center = (to_[0] + to_[1] + to_[2]) * (1.f / 3), e1 = to_[1] - to_[0], e2 = to_[2] - to_[0];
    if (dot(e1, e1) + dot(e2, e2) < 0.25f * dot(center, center)) return;
    for (int k = 0; k < 3; ++k) unit_[k] = safe_normalize(to_[k]);
    const auto& [a, b, c] = unit_;
    // Van Oosterom and Strackee, "The Solid Angle of a Plane Triangle", 1983: no cancellation for small triangles.
    solid_angle_ = 2 * std::atan2(std::abs(dot(a, cross(b, c))), 1 + dot(a, b) + dot(b, c) + dot(c, a));
    // Below, the density by area is nearly constant and cheaper; near a hemisphere the angles of the method degenerate.
    usable_ = solid_angle_ > 5e-3f && solid_angle_ < 6.22f;
}

bool SphericalTriangle::sample(float u1, float u2, Vec3f& direction, float& b1, float& b2) const {
    const auto& [a, b, c] = unit_;
    const Vec3f ab = cross(a, b), ca = cross(c, a), n_ab = safe_normalize(ab), n_ca = safe_normalize(ca);
    // The angle at a, between the planes of ab and ac.
    const float cos_alpha = std::clamp(-dot(n_ab, n_ca), -1.f, 1.f), alpha = std::acos(cos_alpha), sin_alpha = std::sin(alpha);
    // Cut by a great circle from b that leaves the area u1 * A on the side of ab (Arvo's figure 2).
    const float area = u1 * solid_angle_;
    const float s = std::sin(area - alpha), t = std::cos(area - alpha);
    const float cos_c = dot(a, b);
    const float u = t - cos_alpha, v = s + sin_alpha * cos_c;
    const float denominator = (v * s + u * t) * sin_alpha;
    if (denominator == 0) return false;
    const float q = std::clamp(((v * t - u * s) * cos_alpha - v) / denominator, -1.f, 1.f);
    const Vec3f c_orthogonal = safe_normalize(c - a * dot(c, a));
    const Vec3f c_cut = a * q + c_orthogonal * safe_sqrt(1 - q * q);
    const float z = 1 - u2 * (1 - dot(c_cut, b));
    direction = safe_normalize(b * z + safe_normalize(c_cut - b * dot(c_cut, b)) * safe_sqrt(1 - z * z));
    // Moller and Trumbore: where the direction meets the plane triangle.
    const Vec3f e1 = to_[1] - to_[0], e2 = to_[2] - to_[0], h = cross(direction, e2);
    const float det = dot(e1, h);
    if (det == 0) return false;
    const Vec3f from = -to_[0];
    b1 = std::clamp(dot(from, h) / det, 0.f, 1.f);
    b2 = std::clamp(dot(direction, cross(from, e1)) / det, 0.f, 1.f);
    if (b1 + b2 > 1) {
        const float sum = b1 + b2;
        b1 /= sum;
        b2 /= sum;
    }
    return std::isfinite(b1) && std::isfinite(b2);
}

}  // namespace alder
