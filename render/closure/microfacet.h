// Microfacet distributions: normal density, Smith masking and visible-normal sampling, for GGX and Beckmann.
// Everything is in the local frame (z = shading normal) and uses the tangential components of the half vector, never
// 1 - cos², so that narrow lobes keep their precision.
#pragma once
#include <limits>

#include "nodes/lobe.h"
#include "render/closure/frame.h"

namespace alder::closure {

/// Below this alpha_x alpha_y a lobe is a mirror: sampled, not evaluated (Cycles' limit).
inline constexpr double kDeltaAlphaSquared = 2e-10;

template <class T>
T erf_inverse(T x);

template <class T>
struct Microfacets {
    Distribution distribution;
    T ax, ay;

    bool is_delta() const { return !(ax * ay > T(kDeltaAlphaSquared)); }

    /// Density of normals D(h); 0 for h below the surface.
    T d(Vec3<T> h) const {
        if (!(h.z > 0)) return 0;
        const T tangential = sqr(h.x / ax) + sqr(h.y / ay), z2 = h.z * h.z;
        if (distribution == Distribution::GGX) return 1 / (kPi<T> * ax * ay * sqr(tangential + z2));
        const T e = tangential / z2;
        return e < 80 ? std::exp(-e) / (kPi<T> * ax * ay * sqr(z2)) : 0;
    }
    /// Smith's Lambda; Heitz, "Understanding the Masking-Shadowing Function", JCGT 2014, equation 72 and, for Beckmann, the
    /// rational fit below equation 69.
    T lambda(Vec3<T> v) const {
        const T q = (sqr(ax * v.x) + sqr(ay * v.y)) / sqr(v.z);
        if (distribution == Distribution::GGX) return (std::sqrt(1 + q) - 1) / 2;
        if (q < T(0.39)) return 0;
        const T a = 1 / std::sqrt(q);
        return ((T(0.396) * a - T(1.259)) * a + 1) / ((T(2.181) * a + T(3.535)) * a);
    }
    /// The exact Lambda: the fit above is up to 0.4 % off, which a density may not be.
    T lambda_exact(Vec3<T> v) const {
        if (distribution == Distribution::GGX) return lambda(v);
        const T q = (sqr(ax * v.x) + sqr(ay * v.y)) / sqr(v.z);
        if (q < T(1e-3)) return 0;  // a > 31: erfc is 0 in double
        const T a = 1 / std::sqrt(q);
        return (std::exp(-a * a) * T(0.56418958354775628695) / a - std::erfc(a)) / 2;
    }

    /// A normal visible from wo (wo.z > 0), density D(h) max(wo.h, 0) / (wo.z (1 + Lambda(wo))).
    Vec3<T> sample_visible(Vec3<T> wo, T u1, T u2) const {
        const Vec3<T> w = normalize(Vec3<T>(ax * wo.x, ay * wo.y, wo.z));
        Vec3<T> h = distribution == Distribution::GGX ? sample_cap(w, u1, u2) : sample_slope(w, u1, u2);
        h = Vec3<T>(ax * h.x, ay * h.y, h.z);
        const T l2 = dot(h, h);
        return l2 > 0 ? h / std::sqrt(l2) : Vec3<T>(0, 0, 1);
    }

  private:
    /// Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps", 2023.
    static Vec3<T> sample_cap(Vec3<T> w, T u1, T u2) {
        const T h_z = (1 - u2) * (1 + w.z);  // z of the cap point plus w.z, without cancelling
        const T z = h_z - w.z, r = safe_sqrt((1 - z) * (1 + z)), phi = 2 * kPi<T> * u1;
        return {r * std::cos(phi) + w.x, r * std::sin(phi) + w.y, h_z};
    }
    /// Beckmann slopes of unit width seen along w; Heitz and d'Eon, "Importance Sampling Microfacet-Based BSDFs using the
    /// Distribution of Visible Normals", EGSR 2014. The slope along w is found in the variable erf(slope), where the
    /// cumulative 1 + b + tan/sqrt(pi) exp(-slope²) is smooth (Jakob, "An Improved Visible Normal Sampling Routine", 2014),
    /// by Newton steps kept inside a shrinking bracket.
    static Vec3<T> sample_slope(Vec3<T> w, T u1, T u2) {
        const T sin_w = std::sqrt(w.x * w.x + w.y * w.y);
        T along, across;
        T cos_phi = 1, sin_phi = 0;
        if (sin_w < T(1e-4) * w.z) {
            const T r = std::sqrt(-std::log1p(-std::min(u1, T(1) - T(1e-7)))), phi = 2 * kPi<T> * u2;
            along = r * std::cos(phi);
            across = r * std::sin(phi);
        } else {
            cos_phi = w.x / sin_w;
            sin_phi = w.y / sin_w;
            const T tan_w = std::min(sin_w / std::max(w.z, T(1e-12)), T(1e12)), cot_w = 1 / tan_w;
            const T k = tan_w * T(0.56418958354775628695);
            const T top = std::erf(cot_w);
            const T target = u1 * (1 + top + k * std::exp(-cot_w * cot_w));
            T low = -1, high = top, b = (low + high) / 2;
            T slope = erf_inverse(b);
            for (int i = 0; i < 40; ++i) {
                const T error = 1 + b + k * std::exp(-slope * slope) - target;
                if (std::abs(error) <= 4 * std::numeric_limits<T>::epsilon() * std::max(target, T(1e-3))) break;
                (error < 0 ? low : high) = b;
                const T next = b - error / (1 - slope * tan_w);  // derivative of the cumulative by b
                b = next > low && next < high ? next : (low + high) / 2;
                slope = erf_inverse(b);
            }
            along = slope;
            across = erf_inverse(2 * u2 - 1);
        }
        return {-(cos_phi * along - sin_phi * across), -(sin_phi * along + cos_phi * across), 1};
    }
};

/// Giles, "Approximating the erfinv function", GPU Computing Gems 2010 (single precision form), polished by Halley steps.
template <class T>
T erf_inverse(T x) {
    const T limit = 1 - std::numeric_limits<T>::epsilon() / 2;
    x = std::clamp(x, -limit, limit);
    T w = -std::log((1 - x) * (1 + x)), p;
    if (w < 5) {
        w -= T(2.5);
        p = T(2.81022636e-08);
        for (double c : {3.43273939e-07, -3.5233877e-06, -4.39150654e-06, 0.00021858087, -0.00125372503, -0.00417768164,
                         0.246640727, 1.50140941})
            p = p * w + T(c);
    } else {
        w = std::sqrt(w) - 3;
        p = T(-0.000200214257);
        for (double c : {0.000100950558, 0.00134934322, -0.00367342844, 0.00573950773, -0.0076224613, 0.00943887047,
                         1.00167406, 2.83297682})
            p = p * w + T(c);
    }
    T y = p * x;
    if constexpr (sizeof(T) == 8) {
        for (int i = 0; i < 2; ++i) {
            const T e = (std::erf(y) - x) * T(0.88622692545275801365) * std::exp(y * y);
            y -= e / (1 + y * e);
        }
    }
    return y;
}

}  // namespace alder::closure
