// Diffuse-type lobe shapes: Oren–Nayar (two of them), sheen, velvet and toon. Values are f cos without the lobe's weight.
#pragma once
#include <limits>

#include "render/closure/frame.h"

namespace alder::closure {

/// Oren–Nayar as Cycles 4.5 has it: Fujii's improved form ("A tiny improvement of Oren–Nayar reflectance model") plus the
/// multiple scattering of OpenPBR, which depends on the colour k. The lobe's weight carries one factor of the colour.
template <class T>
struct EnergyOrenNayar {
    // 1 - E(c) = b (kLoss - G(c)) and the same for the averages: no cancellation where the roughness is small.
    static constexpr T kLoss = kPi<T> / 2 - T(2) / 3, kAverageG = (2 * kPi<T> - T(5.6)) / 3;
    T a, b;
    explicit EnergyOrenNayar(T roughness) {
        const T s = saturate(roughness);
        a = 1 / (kPi<T> + s * kLoss);
        b = s * a;
    }
    static T g(T c) {
        if (c < T(1e-6)) return kLoss - c;
        const T s = safe_sqrt((1 - c) * (1 + c)), theta = std::acos(std::min(c, T(1)));
        return s * (theta - T(2) / 3 - s * c) + T(2) / 3 * (s / c) * (1 - s * s * s);
    }
    Vec3<T> f_cos(T nl, T nv, T lv, Vec3<T> color) const {
        nv = std::max(nv, T(0));
        T t = lv - nl * nv;
        if (t > 0) t /= std::max(std::max(nl, nv), std::numeric_limits<T>::min());
        const T single = a + b * t;
        const T missing_average = b * (kLoss - kAverageG);
        const T missing = b * (kLoss - g(nl)) * (kLoss - g(nv)) * (1 - missing_average) / (kPi<T> * (kLoss - kAverageG));
        Vec3<T> f;
        for (int i = 0; i < 3; ++i) {
            const T k = saturate(color[i]);
            f[i] = nl * (single + missing * k * k / (1 - k * missing_average));
        }
        return f;
    }
};

/// Qualitative Oren–Nayar: Oren and Nayar, "Generalization of Lambert's Reflectance Model", SIGGRAPH 1994, equation 30.
template <class T>
T oren_nayar_qualitative(T nl, T nv, T lv, T sigma) {
    nv = std::max(nv, T(0));
    const T s2 = std::min(sigma * sigma, T(1e9));
    const T a = 1 - s2 / (2 * (s2 + T(0.33))), b = T(0.45) * s2 / (s2 + T(0.09));
    // sin a tan b max(0, cos dphi) = max(0, l.v - nl nv) / max(nl, nv)
    const T t = std::max(lv - nl * nv, T(0)) / std::max(std::max(nl, nv), std::numeric_limits<T>::min());
    return nl / kPi<T> * (a + b * t);
}

/// Microfibre sheen: a cosine lobe under the linear map that Zeltner, Burley and Chiang fitted, "Practical
/// Multiple-Scattering Sheen Using Linearly Transformed Cosines", SIGGRAPH 2022 (talk). Frame: x in the plane of wo.
/// Fits lie well inside; keeps the squares finite.
template <class T>
void limit_sheen(T& a, T& b) {
    a = std::clamp(a, T(1e-5), T(1e2));
    b = std::clamp(b, T(-1e2), T(1e2));
}
template <class T>
T sheen_ltc(Vec3<T> w, T a, T b) {
    if (!(w.z > 0)) return 0;
    limit_sheen(a, b);
    const T l2 = sqr(a * w.x + b * w.z) + sqr(a * w.y) + sqr(w.z);
    return w.z / kPi<T> * sqr(a / l2);
}
template <class T>
Vec3<T> sample_sheen_ltc(T a, T b, T u1, T u2) {
    limit_sheen(a, b);
    const Vec3<T> c = sample_cosine(u1, u2);
    const Vec3<T> w(c.x - c.z * b, c.y, c.z * a);
    return w / std::max(length(w), T(1e-20));
}

/// Velvet: Ashikhmin, Premože and Shirley, "A Microfacet-Based BRDF Generator", SIGGRAPH 2000, section 5.4.
template <class T>
T velvet(T nl, T nv, T nh, T hv, T sin2_h, T sigma) {
    sigma = std::max(sigma, T(0.01));
    if (!(nv > 0) || !(sin2_h > T(2e-5)) || !(hv > T(1e-5))) return 0;
    const T i = 1 / (sigma * sigma), q = std::max(nh / hv, T(1e-5));
    const T d = i * std::exp(-i * nh * nh / sin2_h) / (kPi<T> * sqr(sin2_h));
    const T g = std::min(T(1), std::min(2 * q * nv, 2 * q * nl));
    return d * g / (4 * nv);
}

/// Toon: constant within `size`, falling linearly to 0 over `smooth`, about an axis; angles in radians. No cosine.
template <class T>
struct Toon {
    T size, smooth, top, height;  ///< top: half angle of the cone sampled; height = 1 - cos top
    Toon(T size_, T smooth_)
        : size(std::clamp(size_, T(1e-5), kPi<T> / 2)), smooth(std::clamp(smooth_, T(0), kPi<T> / 2)),
          top(std::min(size + smooth, kPi<T> / 2)), height(2 * sqr(std::sin(top / 2))) {}
    T pdf() const { return 1 / (2 * kPi<T> * height); }
    /// angle to the axis; pdf is 0 outside the cone
    void eval(T angle, T& f, T& p) const {
        f = p = 0;
        if (!(angle < top)) return;
        p = pdf();
        f = angle < size ? p : smooth > 0 ? p * std::max(1 - (angle - size) / smooth, T(0)) : 0;
    }
};

/// Angle between unit vectors, accurate where it is small.
template <class T>
T angle_between(Vec3<T> a, Vec3<T> b) {
    return 2 * std::atan2(length(a - b), length(a + b));
}

}  // namespace alder::closure
