// Phase functions of volumes: how light that a medium scatters is distributed over directions.
//
// c is the cosine of the angle by which light is deflected: 1 straight on. Values are per steradian and integrate to 1, so that they
// are their own densities. Henyey and Greenstein 1941; Rayleigh; Draine, "Scattering by Interstellar Dust Grains", ApJ 598, 2003;
// Fournier and Jonasz, "Computer-based underwater imaging analysis", 1999 (their form with a backscattered share).
// Limits of the parameters are those of Cycles 4.5.
#pragma once
#include <algorithm>
#include <cmath>

#include "render/closure/bsdf.h"
#include "render/closure/frame.h"

namespace alder::closure {

template <class T>
T limited_anisotropy(T g) { return g == g ? std::clamp(g, T(-0.999), T(0.999)) : T(0); }

template <class T>
T limited_alpha(T a) { return a == a ? std::clamp(a, T(0), T(1e6)) : T(0); }

template <class T>
T henyey_greenstein(T c, T g) {
    if (std::abs(g) < T(1e-3)) return 1 / (4 * kPi<T>);
    const T d = 1 + g * (g - 2 * c);
    return (1 - g * g) / (4 * kPi<T> * d * std::sqrt(std::max(d, T(1e-12))));
}

template <class T>
T rayleigh(T c) { return 3 / (16 * kPi<T>) * (1 + c * c); }

template <class T>
T draine(T c, T g, T alpha) {
    if (std::abs(g) < T(1e-3) && alpha > T(0.999)) return rayleigh(c);
    if (std::abs(alpha) < T(1e-3)) return henyey_greenstein(c, g);
    const T d = std::max(1 + g * (g - 2 * c), T(1e-12));
    return (1 - g * g) * (1 + alpha * c * c) / (4 * kPi<T> * (1 + alpha * (1 + 2 * g * g) / 3) * d * std::sqrt(d));
}

/// Coefficients of Fournier and Forand's function that depend on the medium alone.
template <class T>
struct FournierForand {
    T v, scale, back;  ///< exponent; delta = scale u with u = sin^2(theta/2); weight of the term in 3c^2 - 1

    FournierForand(T backscatter, T ior) {
        const T b = std::min(std::abs(backscatter == backscatter ? backscatter : T(0)), T(0.499));
        const T n = std::clamp(ior == ior ? ior : T(1.33), T(1.001), T(100));
        scale = 4 / (3 * (n - 1) * (n - 1));
        const T d90 = scale / 2, d180 = scale;
        // Both fractions have a limit where delta is 1.
        const T l90 = std::log(d90), l180 = std::log(d180);
        const T argument = 2 * b * (d90 - 1);
        v = std::abs(d90 - 1) < T(1e-5) ? -2 * b : -std::log1p(std::max(argument, T(-0.999999))) / l90;
        back = (std::abs(d180 - 1) < T(1e-5) ? -v : std::expm1(-v * l180) / (d180 - 1)) / (16 * kPi<T>);
    }
    /// u = (1 - c)/2. Infinite at u = 0: the caller limits it.
    T value(T u, T c) const {
        const T d = scale * u, rest = 1 - d;
        T p;
        if (std::abs(rest) < T(1e-3)) {  // first order about the removable singularity
            p = v * ((v - 1) - (v + 1) / u) / (8 * kPi<T>) + v * (v + 1) * rest * (2 * (v - 1) - (2 * v + 1) / u) / (24 * kPi<T>);
        } else {
            const T power = std::pow(d, v), other = 1 - power;
            p = (v * rest - other + (d * other - v * rest) / u) / (4 * kPi<T> * rest * rest * power);
        }
        return p + back * (3 * c * c - 1);
    }
    /// Share deflected by less than the angle.
    T within(T u) const {
        const T d = scale * u, rest = 1 - d, c = 1 - 2 * u;
        T share;
        if (std::abs(rest) < T(1e-3)) {
            share = 1 + v * (1 - u) * (1 - (v + 1) * rest / 2);
        } else {
            const T power = std::pow(d, v);
            share = (1 - power * d - (1 - power) * u) / (rest * power);
        }
        return share + 2 * kPi<T> * back * c * (1 - c * c);
    }
};

inline double sample_henyey_greenstein(double g, double u) {
    if (std::abs(g) < 1e-3) return 1 - 2 * u;
    const double k = (1 - g * g) / (1 - g + 2 * g * u);
    return std::clamp((1 + g * g - k * k) / (2 * g), -1.0, 1.0);
}

inline double sample_rayleigh(double u) {
    const double a = 2 - 4 * u, x = std::cbrt(a + std::sqrt(1 + a * a));
    return std::clamp(1 / x - x, -1.0, 1.0);
}

/// Draine's distribution function, inverted by bisection and Newton's steps within the bracket: the closed inverse loses its digits.
inline double sample_draine(double g, double alpha, double u) {
    if (std::abs(g) < 1e-3 && alpha > 0.999) return sample_rayleigh(u);
    if (std::abs(alpha) < 1e-3) return sample_henyey_greenstein(g, u);
    const double norm = 1 + alpha * (1 + 2 * g * g) / 3, a = 1 + g * g;
    const auto below = [&](double x) {  // integral from -1 to x
        if (std::abs(g) < 1e-3)  // to first order in g
            return ((x + 1) + alpha * (x * x * x + 1) / 3 + 3 * g * ((x * x - 1) / 2 + alpha * (x * x * x * x - 1) / 4)) / (2 * norm);
        const auto antiderivative = [&](double y) {
            const double s2 = std::max(a - 2 * g * y, 1e-300), s = std::sqrt(s2);
            return 1 / (g * s) + alpha / (4 * g * g * g) * (a * a / s + 2 * a * s - s2 * s / 3);
        };
        return (1 - g * g) * (antiderivative(x) - antiderivative(-1)) / (2 * norm);
    };
    double low = -1, high = 1, x = sample_henyey_greenstein(g, u);
    for (int i = 0; i < 60 && high - low > 1e-9; ++i) {
        const double error = below(x) - u;
        (error > 0 ? high : low) = x;
        const double density = 2 * 3.14159265358979323846 * draine(x, g, alpha);
        double next = density > 0 ? x - error / density : low - 1;
        if (!(next > low && next < high)) next = (low + high) / 2;
        if (std::abs(next - x) < 1e-12) break;
        x = next;
    }
    return x;
}

/// sin^2 of half the angle: the function peaks at 0, so that the search is in its logarithm.
inline double sample_fournier_forand(const FournierForand<double>& f, double u) {
    double low = -60, high = 0;
    for (int i = 0; i < 60; ++i) {
        const double middle = (low + high) / 2;
        (f.within(std::exp(middle)) < u ? low : high) = middle;
    }
    return std::exp((low + high) / 2);
}

/// Value per steradian.
template <class T>
T phase_value(const Lobe<T>& l, Vec3<T> wo, Vec3<T> wi) {
    const T c = std::clamp(-dot(wo, wi), T(-1), T(1));
    switch (l.spec->kind) {
        case LobeKind::PhaseHenyeyGreenstein: return henyey_greenstein(c, limited_anisotropy(l.p[0]));
        case LobeKind::PhaseRayleigh: return rayleigh(c);
        case LobeKind::PhaseDraine: return draine(c, limited_anisotropy(l.p[0]), limited_alpha(l.p[1]));
        case LobeKind::PhaseFournierForand: {
            // From the difference of the directions: 1 - c has no digits where the function peaks.
            const Vec3<T> change = wi + wo;
            const T u = std::clamp(dot(change, change) / 4, T(1e-14), T(1));
            return std::max(FournierForand<T>(l.p[0], l.p[1]).value(u, c), T(0));
        }
        default: return 0;
    }
}

template <class T>
Vec3<T> sample_phase(const Lobe<T>& l, Vec3<T> wo, T u1, T u2) {
    double c = 1, half = -1;
    switch (l.spec->kind) {
        case LobeKind::PhaseHenyeyGreenstein: c = sample_henyey_greenstein(limited_anisotropy<double>(l.p[0]), u1); break;
        case LobeKind::PhaseRayleigh: c = sample_rayleigh(u1); break;
        case LobeKind::PhaseDraine: c = sample_draine(limited_anisotropy<double>(l.p[0]), limited_alpha<double>(l.p[1]), u1); break;
        case LobeKind::PhaseFournierForand:
            half = sample_fournier_forand(FournierForand<double>(l.p[0], l.p[1]), u1);
            c = 1 - 2 * half;
            break;
        default: break;
    }
    if (half < 0) half = (1 - c) / 2;
    const T s = static_cast<T>(2 * std::sqrt(std::max(half * (1 - half), 0.0)));
    const T phi = 2 * kPi<T> * u2;
    return normalize(frame_around(-wo).to_world({s * std::cos(phi), s * std::sin(phi), static_cast<T>(c)}));
}

}  // namespace alder::closure
