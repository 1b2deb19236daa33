// Local frames and the elementary warps from the unit square, shared by the lobes.
#pragma once
#include <algorithm>
#include <cmath>

#include "nodes/num/vec.h"

namespace alder::closure {

template <class T>
inline constexpr T kPi = static_cast<T>(3.14159265358979323846);

template <class T>
T sqr(T x) { return x * x; }
template <class T>
T saturate(T x) { return std::min(std::max(x, T(0)), T(1)); }
template <class T>
T safe_sqrt(T x) { return std::sqrt(std::max(x, T(0))); }
template <class T>
T average(Vec3<T> c) { return (c.x + c.y + c.z) * T(1.0 / 3); }

/// Orthonormal frame with z = a unit normal.
template <class T>
struct Frame {
    Vec3<T> x, y, z;
    Vec3<T> to_local(Vec3<T> v) const { return {dot(x, v), dot(y, v), dot(z, v)}; }
    Vec3<T> to_world(Vec3<T> v) const { return x * v.x + y * v.y + z * v.z; }
};
/// Any frame about n: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017.
template <class T>
Frame<T> frame_around(Vec3<T> n) {
    const T sign = std::copysign(T(1), n.z);
    const T a = T(-1) / (sign + n.z), b = n.x * n.y * a;
    return {Vec3<T>(1 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3<T>(b, sign + n.y * n.y * a, -n.y), n};
}
/// x is t made orthogonal to n; any frame where t is parallel to n or zero.
template <class T>
Frame<T> frame_around(Vec3<T> n, Vec3<T> t) {
    const Vec3<T> y = cross(n, t);
    const T l2 = dot(y, y);
    if (!(l2 > T(1e-20))) return frame_around(n);
    const Vec3<T> yn = y / std::sqrt(l2);
    return {cross(yn, n), yn, n};
}

/// Uniform on the unit disk: Shirley and Chiu, "A Low Distortion Map Between Disk and Square", 1997.
template <class T>
void sample_disk(T u1, T u2, T& x, T& y) {
    const T a = 2 * u1 - 1, b = 2 * u2 - 1;
    if (a == 0 && b == 0) {
        x = y = 0;
        return;
    }
    const bool wide = std::abs(a) > std::abs(b);
    const T r = wide ? a : b;
    const T phi = wide ? kPi<T> / 4 * (b / a) : kPi<T> / 2 - kPi<T> / 4 * (a / b);
    x = r * std::cos(phi);
    y = r * std::sin(phi);
}
/// Cosine-weighted about +z, density z/pi.
template <class T>
Vec3<T> sample_cosine(T u1, T u2) {
    T x, y;
    sample_disk(u1, u2, x, y);
    return {x, y, safe_sqrt(1 - x * x - y * y)};
}
/// Uniform over the cone about +z whose half angle has 1 - cos = `height`.
template <class T>
Vec3<T> sample_cone(T height, T u1, T u2) {
    const T h = height * u2, r = safe_sqrt(h * (2 - h)), phi = 2 * kPi<T> * u1;
    return {r * std::cos(phi), r * std::sin(phi), 1 - h};
}

}  // namespace alder::closure
