// Warps from uniform numbers to directions and shapes, with their densities; small shared vector helpers.
#pragma once
#include <algorithm>
#include <cmath>

#include "nodes/num/vec.h"

namespace alder {

inline constexpr float kPi = 3.14159265358979323846f, kInvPi = 1 / kPi;

inline float sqr(float x) { return x * x; }
inline float safe_sqrt(float x) { return std::sqrt(std::max(x, 0.f)); }
inline float max_abs(Vec3f v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }
inline float average(Vec3f v) { return (v.x + v.y + v.z) * (1.f / 3); }
inline bool is_black(Vec3f v) { return v.x == 0 && v.y == 0 && v.z == 0; }
inline bool is_finite(Vec3f v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
/// Rec.709 luminance.
inline float luminance(Vec3f c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }

struct Frame {
    Vec3f x, y, z;
    Vec3f to_world(Vec3f v) const { return x * v.x + y * v.y + z * v.z; }
    Vec3f to_local(Vec3f v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
};
/// Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017.
inline Frame frame_about(Vec3f z) {
    const float sign = std::copysign(1.f, z.z);
    const float a = -1 / (sign + z.z), b = z.x * z.y * a;
    return {{1 + sign * z.x * z.x * a, sign * b, -sign * z.x}, {b, sign + z.y * z.y * a, -z.y}, z};
}
/// The two tangents Cycles derives from a normal (its bump footprints depend on them).
inline Frame cycles_frame(Vec3f n) {
    const Vec3f a = n.x != n.y || n.x != n.z ? Vec3f(n.z - n.y, n.x - n.z, n.y - n.x)
                                             : Vec3f(n.z - n.y, n.x + n.z, -n.y - n.x);
    const Vec3f x = safe_normalize(a);
    return {x, cross(n, x), n};
}

struct Disk {
    float x, y;
};
/// Concentric map (Shirley and Chiu 1997): keeps the stratification of the square.
inline Disk uniform_disk(float u, float v) {
    const float a = 2 * u - 1, b = 2 * v - 1;
    if (a == 0 && b == 0) return {0, 0};
    float r, phi;
    if (std::abs(a) > std::abs(b)) {
        r = a;
        phi = kPi / 4 * (b / a);
    } else {
        r = b;
        phi = kPi / 2 - kPi / 4 * (a / b);
    }
    return {r * std::cos(phi), r * std::sin(phi)};
}
/// Direction within the cone about `axis` whose 1 - cos(half angle) is given; uniform in solid angle.
/// Working with 1 - cos keeps precision for cones of arc seconds.
inline Vec3f uniform_cone(Vec3f axis, float one_minus_cos, float u, float v) {
    const Disk d = uniform_disk(u, v);
    const float r2 = d.x * d.x + d.y * d.y;
    const float one_minus_z = r2 * one_minus_cos;                        // uniform in the disk's area = uniform in z
    const float sin_over_r = safe_sqrt(one_minus_cos * (2 - one_minus_z));  // sqrt(1 - z^2) / r
    return safe_normalize(frame_about(axis).to_world({d.x * sin_over_r, d.y * sin_over_r, 1 - one_minus_z}));
}
inline float cone_density(float one_minus_cos) { return 1 / (2 * kPi * one_minus_cos); }
/// 1 - cos x from sin^2 x without cancellation, x in [0, pi/2].
inline float one_minus_cos_from_sin2(float sin2) { return sin2 / (1 + safe_sqrt(1 - sin2)); }

/// Veach and Guibas 1995: power heuristic with exponent 2. Safe for infinite and zero densities.
inline float power_heuristic(float a, float b) {
    if (b == 0) return 1;
    if (a == 0) return 0;
    const float r = b / a;  // the squares themselves would overflow for sharp densities
    return 1 / (1 + r * r);
}

}  // namespace alder
