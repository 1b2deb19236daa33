// alHair's lobes: R and TRT, TT, the glint, Kajiya and Kay's diffuse. alshaders specification, sections 7.3 to 7.5.
// Ou et al., "ISHair: Importance Sampling for Hair Scattering", EGSR 2012. Values have the constants of the fibre's attenuation
// and the colours in the lobe's weight.
#pragma once
#include "render/closure/hair.h"

namespace alder::closure {

/// Normal density of variance v.
template <class T>
T gaussian(T v, T x) {
    return std::exp(-x * x / (2 * v)) / std::sqrt(kTwoPi<T> * v);
}

/// The part that all of them share: K and the Gaussian of the half angle.
template <class T>
struct AlHairLobe {
    LobeKind kind;
    Fibre<T> fibre;
    T shift, width, gamma, phi_glint, theta_o;
    CauchyAlong<T> along;

    AlHairLobe(const Lobe<T>& l, const ShadingView<T>& view)
        : kind(l.spec->kind), fibre(l.t, view.wo), shift(std::clamp(l.p[0], T(-10), T(10))), width(std::clamp(std::abs(l.p[1]), T(1e-4), T(1e3))),
          gamma(std::clamp(std::abs(l.p[2]), T(1e-6), T(1e6))), phi_glint(std::clamp(l.p[3], T(-10), T(10))),
          theta_o(std::atan2(fibre.sin_o, fibre.cos_o)), along(theta_o, shift, width) {}

    BsdfEval<T> eval(Vec3<T> wi) const {
        BsdfEval<T> e;
        const auto i = fibre.angles(wi);
        const T theta_i = std::atan2(i.sin, i.cos), phi = std::abs(i.phi);
        if (!(i.cos > T(1e-9))) return e;
        const T half = (theta_i + theta_o) / 2, difference = (theta_o - theta_i) / 2;
        const T k = i.cos / (std::max(T(1e-3), sqr(std::cos(difference))) * kPi<T>);
        e.f_cos = Vec3<T>(gaussian(width * width, half - shift) * value_around(phi) * k);
        e.pdf = along.density(theta_i, i.cos) * density_around(phi);
        return e;
    }
    Vec3<T> sample(T u1, T u2, T u3) const {
        const T theta_i = along.sample(u1);
        return fibre.direction(std::sin(theta_i), std::cos(theta_i), std::copysign(sample_around(u2), u3 - T(0.5)));
    }

  private:
    T value_around(T phi) const {
        switch (kind) {
            case LobeKind::HairForward: return gaussian(gamma, kPi<T> - phi);
            case LobeKind::HairGlint: return gaussian(gamma, phi - phi_glint);
            default: return std::max(std::cos(phi / 2), T(0));
        }
    }
    /// Half width of the sampler's Cauchy shape. The Gaussians have `gamma` as variance: a Cauchy of their deviation covers them.
    T cauchy() const { return std::min(std::sqrt(gamma), T(1e2)); }
    T center() const { return kind == LobeKind::HairForward ? kPi<T> : std::clamp(phi_glint, T(0), kPi<T>); }
    T end(T phi) const { return std::atan((phi - center()) / cauchy()); }
    /// Of |phi| in 0..pi, both signs together.
    T density_around(T phi) const {
        if (kind == LobeKind::HairGlossy) return std::max(std::cos(phi / 2), T(0)) / 4;
        const T c = cauchy(), p = phi - center();
        return c / (2 * (end(kPi<T>) - end(0)) * (p * p + c * c));
    }
    T sample_around(T u) const {
        if (kind == LobeKind::HairGlossy) return 2 * std::asin(std::min(u, T(1)));
        const T lo = end(0), hi = end(kPi<T>);
        return std::clamp(center() + cauchy() * std::tan(lo + u * (hi - lo)), T(0), kPi<T>);
    }
};

/// Kajiya and Kay, "Rendering Fur with Three Dimensional Textures", SIGGRAPH 1989: sine of the angle to the fibre, over 4 pi.
template <class T>
BsdfEval<T> eval_kajiya(const Lobe<T>& l, const ShadingView<T>& view, Vec3<T> wi) {
    const T sine = Fibre<T>(l.t, view.wo).angles(wi).cos;
    BsdfEval<T> e;
    e.f_cos = Vec3<T>(sine / (4 * kPi<T>));
    e.pdf = sine / (kPi<T> * kPi<T>);
    return e;
}
/// The cosine to the fibre is distributed as a coordinate of a point in the unit disk.
template <class T>
Vec3<T> sample_kajiya(const Lobe<T>& l, const ShadingView<T>& view, T u1, T u2, T u3) {
    T x, y;
    sample_disk(u1, u2, x, y);
    return Fibre<T>(l.t, view.wo).direction(x, safe_sqrt((1 - x) * (1 + x)), kTwoPi<T> * u3);
}

}  // namespace alder::closure
