// Light scattered by fibres: what the models have in common, Cycles' Hair BSDF, and Chiang et al.'s near-field model.
//
// Angles: theta is measured from the plane across the fibre (sine = component along it), phi around it. Directions point away
// from the fibre; `o` is the viewer's, `i` the light's. Every function returns f times |cos| as the renderer means it: the
// cosine to the fibre's normal plane that belongs to f and to the solid angle is inside. Densities are per solid angle.
//
// Marschner et al., "Light Scattering from Human Hair Fibers", SIGGRAPH 2003; d'Eon et al., "An Energy-Conserving Hair
// Reflectance Model", EGSR 2011; Chiang et al., "A Practical and Controllable Hair and Fur Model for Production Path Tracing",
// EGSR 2016.
#pragma once
#include <array>
#include <limits>

#include "nodes/surface/fresnel-inl.h"
#include "render/closure/bsdf.h"
#include "render/closure/frame.h"

namespace alder::closure {

template <class T>
inline constexpr T kTwoPi = 2 * kPi<T>;

/// Frame of a fibre: z along it, x towards the viewer (any direction where he looks along the fibre).
template <class T>
struct Fibre {
    Frame<T> frame;
    T sin_o, cos_o;
    Fibre(Vec3<T> axis, Vec3<T> wo) {
        const T l = length(axis);
        const Vec3<T> along = l > 0 ? axis / l : Vec3<T>(0, 0, 1);
        frame = frame_around(along, wo);
        sin_o = std::clamp(dot(along, wo), T(-1), T(1));
        const Vec3<T> across = wo - along * sin_o;
        cos_o = length(across);
    }
    /// Sine, cosine of theta and azimuth from the viewer's, in -pi..pi.
    struct Angles {
        T sin, cos, phi;
    };
    Angles angles(Vec3<T> w) const {
        const Vec3<T> l = frame.to_local(w);
        return {std::clamp(l.z, T(-1), T(1)), std::sqrt(l.x * l.x + l.y * l.y), std::atan2(l.y, l.x)};
    }
    Vec3<T> direction(T sin_i, T cos_i, T phi) const {
        return normalize(frame.to_world({cos_i * std::cos(phi), cos_i * std::sin(phi), sin_i}));
    }
};

/// To -pi..pi.
template <class T>
T wrap_angle(T a) {
    return a - kTwoPi<T> * std::floor((a + kPi<T>) / kTwoPi<T>);
}

// ---- along the fibre -----------------------------------------------------------------------------------------------------

/// exp(-x) I0(x), x >= 0: the power series where it is short, else the asymptotic one (Abramowitz and Stegun 9.6.12, 9.7.1).
template <class T>
T bessel_i0_scaled(T x) {
    T sum = 1, term = 1;
    if (x < 20) {
        const T q = x * x / 4;
        for (int k = 1; k < 80 && term > std::numeric_limits<T>::epsilon() / 4 * sum; ++k) sum += term *= q / (T(k) * k);
        return sum * std::exp(-x);
    }
    for (int k = 1; k < 30; ++k) {
        const T next = term * sqr(T(2 * k - 1)) / (8 * x * k);
        if (!(next > std::numeric_limits<T>::epsilon() / 4)) break;
        sum += term = next;
    }
    return sum / std::sqrt(kTwoPi<T> * x);
}
/// The same as Cycles has it: ten terms below 12, one term of the asymptotic series, halved, above; up to 2 % off near 12. Its
/// values need it, densities do not.
template <class T>
T bessel_i0_scaled_cycles(T x) {
    if (x > 12) return std::exp(1 / (16 * x)) / std::sqrt(kTwoPi<T> * x);
    T sum = 1, term = 1;
    const T q = x * x / 4;
    for (int k = 1; k < 10; ++k) sum += term *= q / (T(k) * k);
    return sum * std::exp(-x);
}

/// d'Eon et al. 2011, equation 7: the longitudinal scattering of variance v about theta_i = -theta_o. Normalised over the
/// sphere together with an azimuthal density.
template <class T>
struct Longitudinal {
    T sin_i, cos_i, sin_o, cos_o, v;
    /// (cos cos - sin sin - 1)/v, without cancelling near the peak.
    T exponent() const {
        const T c = cos_i * cos_o - sin_i * sin_o, s = sin_i * cos_o + cos_i * sin_o;
        return (c > 0 ? -s * s / (1 + c) : c - 1) / v;
    }
    T density() const {
        return std::exp(exponent()) * bessel_i0_scaled(cos_i * cos_o / v) / (v * -std::expm1(-2 / v));
    }
    /// Cycles' value: its Bessel function, and ln 2 as 0.6931 where v is small.
    T cycles() const {
        const T e = std::exp(exponent()) * bessel_i0_scaled_cycles(cos_i * cos_o / v);
        return v <= T(0.1) ? e * T(0.99995282) / v : e / (v * -std::expm1(-2 / v));
    }
};
/// d'Eon, Marschner and Hanika, "Importance Sampling for Physically-Based Hair Fiber Models", SIGGRAPH Asia 2013 (technical brief).
template <class T>
void sample_longitudinal(T sin_o, T cos_o, T v, T u1, T u2, T& sin_i, T& cos_i) {
    // 1 - fac, and sin from it without cancelling
    const T fall = -v * std::log(std::max(u1 + (1 - u1) * std::exp(-2 / v), std::numeric_limits<T>::min()));
    const T rise = std::clamp(fall, T(0), T(2)), s = safe_sqrt(rise * (2 - rise));
    sin_i = std::clamp(-(1 - rise) * sin_o + s * std::cos(kTwoPi<T> * u2) * cos_o, T(-1), T(1));
    // The component across: through the same two vectors, so that it does not cancel near the poles.
    const T a = (1 - rise) * cos_o + s * std::cos(kTwoPi<T> * u2) * sin_o, b = s * std::sin(kTwoPi<T> * u2);
    cos_i = std::sqrt(a * a + b * b);
}

// ---- around the fibre ----------------------------------------------------------------------------------------------------

/// Logistic density of scale s, trimmed to -pi..pi.
template <class T>
T trimmed_logistic(T x, T s) {
    const T e = std::exp(-std::abs(x) / s);
    return e / (s * sqr(1 + e)) / std::tanh(kPi<T> / (2 * s));
}
template <class T>
T sample_trimmed_logistic(T u, T s) {
    // Symmetric: the upper half and a sign, so that neither tail cancels. 2F - 1 = tanh(x / 2s).
    const T k = std::tanh(kPi<T> / (2 * s)), t = std::abs(2 * u - 1) * k;
    const T x = s * (std::log1p(t) - std::log1p(-std::min(t, 1 - std::numeric_limits<T>::epsilon() / 2)));
    return std::copysign(std::min(x, kPi<T>), u - T(0.5));
}

// ---- Chiang et al. -------------------------------------------------------------------------------------------------------

/// How a ray that meets the fibre at offset h goes on: deflections, and what each order of passes carries.
template <class T>
struct FibrePath {
    T gamma_o, gamma_t;
    std::array<Vec3<T>, 4> carried;  ///< R, TT, TRT, all further: sums to 1 without absorption

    FibrePath(T sin_o, T cos_o, T h, T eta, Vec3<T> sigma) {
        eta = std::clamp(eta, T(1e-4), T(1e4));
        h = std::clamp(h, T(-1), T(1));
        gamma_o = std::asin(h);
        const T cos_gamma_o = safe_sqrt((1 - h) * (1 + h));
        const T sin_t = sin_o / eta, cos_t = safe_sqrt((1 - sin_t) * (1 + sin_t));
        const T across2 = eta * eta - sin_o * sin_o;
        const T sin_gamma_t = across2 > 0 ? std::clamp(h * cos_o / std::sqrt(across2), T(-1), T(1)) : std::copysign(T(1), h);
        gamma_t = std::asin(sin_gamma_t);
        const T cos_gamma_t = safe_sqrt((1 - sin_gamma_t) * (1 + sin_gamma_t));
        const T f = HWY_NAMESPACE::fresnel_dielectric(cos_o * cos_gamma_o, eta);
        const T path = 2 * cos_gamma_t / std::max(cos_t, T(1e-9));
        for (int c = 0; c < 3; ++c) {
            const T a = std::exp(-std::max(sigma[c], T(0)) * path);
            const T tt = sqr(1 - f) * a, trt = tt * a * f;
            carried[0][c] = f;
            carried[1][c] = tt;
            carried[2][c] = trt;
            carried[3][c] = 1 - a * f > T(1e-12) ? trt * a * f / (1 - a * f) : T(0);
        }
    }
    T turn(int p) const { return 2 * p * gamma_t - 2 * gamma_o + p * kPi<T>; }
};

/// One order at one point: its place along and around the fibre.
template <class T>
struct FibreOrder {
    T sin_o, cos_o, v, s, turn;
    bool uniform;  ///< in azimuth
    static FibreOrder tilted(const Fibre<T>& f, T shift, T v, T s, T turn, bool uniform) {
        const T a = std::sin(shift), b = std::cos(shift);
        return {f.sin_o * b + f.cos_o * a, std::abs(f.cos_o * b - f.sin_o * a), v, s, turn, uniform};
    }
    T around(T phi) const { return uniform ? 1 / kTwoPi<T> : trimmed_logistic(wrap_angle(phi - turn), s); }
    Longitudinal<T> along(const typename Fibre<T>::Angles& i) const { return {i.sin, i.cos, sin_o, cos_o, v}; }
    T density(const typename Fibre<T>::Angles& i) const { return along(i).density() * around(i.phi); }
    Vec3<T> sample(const Fibre<T>& f, T u1, T u2, T u3) const {
        T sin_i, cos_i;
        sample_longitudinal(sin_o, cos_o, v, u3, u2, sin_i, cos_i);
        return f.direction(sin_i, cos_i, uniform ? kTwoPi<T> * u1 : turn + sample_trimmed_logistic(u1, s));
    }
};
template <class T>
T fibre_variance(T v) { return std::clamp(v, T(1e-7), T(1e3)); }
template <class T>
T fibre_scale(T s) { return std::clamp(s, T(1e-5), T(1e3)); }

/// All orders; the residual ones are spread evenly around the fibre.
template <class T>
struct ChiangHair {
    Fibre<T> fibre;
    FibrePath<T> path;
    std::array<FibreOrder<T>, 4> orders;
    std::array<T, 4> share;

    ChiangHair(const Lobe<T>& l, const ShadingView<T>& view)
        : fibre(l.t, view.wo), path(fibre.sin_o, fibre.cos_o, l.p[8], l.p[7], {l.p[0], l.p[1], l.p[2]}) {
        const T m0 = fibre_variance(l.p[3]), v = fibre_variance(l.p[4]), s = fibre_scale(l.p[5]), tilt = l.p[6];
        orders[0] = FibreOrder<T>::tilted(fibre, -2 * tilt, m0, s, path.turn(0), false);
        orders[1] = FibreOrder<T>::tilted(fibre, tilt, v / 4, s, path.turn(1), false);
        orders[2] = FibreOrder<T>::tilted(fibre, 4 * tilt, 4 * v, s, path.turn(2), false);
        orders[3] = FibreOrder<T>::tilted(fibre, T(0), 4 * v, s, T(0), true);
        T sum = 0;
        for (int p = 0; p < 4; ++p) sum += share[p] = average(path.carried[p]);
        for (T& x : share) x = sum > 0 ? x / sum : T(0);
    }
    BsdfEval<T> eval(Vec3<T> wi) const {
        const auto i = fibre.angles(wi);
        BsdfEval<T> e;
        for (int p = 0; p < 4; ++p) {
            if (!(share[p] > 0)) continue;
            const T around = orders[p].around(i.phi);
            const Longitudinal<T> along = orders[p].along(i);
            e.f_cos += path.carried[p] * (along.cycles() * around);
            e.pdf += share[p] * along.density() * around;
        }
        return e;
    }
    Vec3<T> sample(T u1, T u2, T u3) const {
        int p = 0;
        while (p < 3 && !(u3 < share[p])) u3 -= share[p++];
        while (p > 0 && !(share[p] > 0)) --p;  // rounding left too much
        u3 = share[p] > 0 ? std::clamp(u3 / share[p], T(0), T(1)) : T(0);
        return orders[p].sample(fibre, u1, u2, u3);
    }
};

/// One order, by its own variance and shift.
template <class T>
struct SingleOrder {
    Fibre<T> fibre;
    FibrePath<T> path;
    int p;
    FibreOrder<T> order;
    SingleOrder(const Lobe<T>& l, const ShadingView<T>& view)
        : fibre(l.t, view.wo), path(fibre.sin_o, fibre.cos_o, l.p[7], l.p[6], {l.p[0], l.p[1], l.p[2]}),
          p(std::clamp<int>(l.spec->order, 0, 3)),
          order(FibreOrder<T>::tilted(fibre, l.p[5], fibre_variance(l.p[3]), fibre_scale(l.p[4]), path.turn(p), p == 3)) {}
    BsdfEval<T> eval(Vec3<T> wi) const {
        BsdfEval<T> e;
        e.pdf = order.density(fibre.angles(wi));
        e.f_cos = path.carried[p] * e.pdf;
        return e;
    }
};

// ---- Cycles' Hair BSDF, and the longitudinal part that alHair's sampler shares with it -----------------------------------

/// Cauchy density of the half angle about a shift, for theta_i in -pi/2..pi/2; per solid angle (the cosine divides).
template <class T>
struct CauchyAlong {
    T theta_o, shift, width, a, b;
    CauchyAlong(T theta_o_, T shift_, T width_) : theta_o(theta_o_), shift(shift_), width(width_) {
        a = std::atan(((kPi<T> / 2 + theta_o) / 2 - shift) / width);
        b = std::atan(((-kPi<T> / 2 + theta_o) / 2 - shift) / width);
    }
    T density(T theta_i, T cos_i) const {
        const T t = (theta_i + theta_o) / 2 - shift;
        return width / (2 * (t * t + width * width) * (a - b) * cos_i);
    }
    T sample(T u) const { return 2 * (width * std::tan(u * (a - b) + b) + shift) - theta_o; }
};

/// Ou et al., "ISHair: Importance Sampling for Hair Scattering", EGSR 2012: both lobes of the Hair BSDF.
template <class T>
struct CyclesHair {
    Fibre<T> fibre;
    T theta_o, around;
    bool transmits;
    CauchyAlong<T> along;
    Vec3<T> n;

    CyclesHair(const Lobe<T>& l, const ShadingView<T>& view)
        : fibre(l.t, view.wo), theta_o(std::atan2(fibre.sin_o, fibre.cos_o)), around(std::clamp(l.p[2], T(1e-3), T(1))),
          transmits(l.spec->kind == LobeKind::HairTransmission), along(theta_o, std::clamp(l.p[0], T(-4), T(4)), std::clamp(l.p[1], T(1e-3), T(1))), n(l.n) {}

    /// `beyond`: values where sampling does not reach.
    BsdfEval<T> eval(Vec3<T> wi, bool beyond) const {
        BsdfEval<T> e;
        if (transmits ? !(dot(n, wi) < 0) : !(dot(n, wi) >= 0)) return e;
        const auto i = fibre.angles(wi);
        const T theta_i = std::atan2(i.sin, i.cos), phi = std::abs(i.phi);
        if (kPi<T> / 2 - std::abs(theta_i) < T(1e-3)) return e;
        T azimuth;
        if (transmits) {
            const T p = kPi<T> - phi;
            if (p > kPi<T> / 2 && !beyond) return e;
            azimuth = around / (2 * std::atan(kPi<T> / (2 * around)) * (p * p + around * around));
        } else {
            if (phi > kPi<T> / 2) return e;
            azimuth = std::cos(std::min(phi / around, kPi<T>) / 2) / (4 * around);
        }
        const T value = std::max(azimuth * along.density(theta_i, i.cos), T(0));
        e.f_cos = Vec3<T>(value);
        e.pdf = transmits && phi < kPi<T> / 2 ? T(0) : value;
        return e;
    }
    Vec3<T> sample(T u1, T u2) const {
        const T theta_i = along.sample(u1);
        const T phi = transmits ? kPi<T> + around * std::tan(2 * std::atan(kPi<T> / (2 * around)) * (u2 - T(0.5)))
                                : 2 * std::asin(std::clamp(1 - 2 * u2, T(-1), T(1))) * around;
        return fibre.direction(std::sin(theta_i), std::cos(theta_i), phi);
    }
};

}  // namespace alder::closure
