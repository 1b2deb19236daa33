// Evaluation and sampling of one lobe. Formulas and conventions: nodes/lobe.h and the sources cited in the headers here.
#include <algorithm>
#include <limits>

#include "nodes/surface/energy-inl.h"
#include "nodes/surface/fresnel-inl.h"
#include "render/closure/bsdf.h"
#include "render/closure/diffuse.h"
#include "render/closure/hair_lobes.h"
#include "render/closure/measured.h"
#include "render/closure/microfacet.h"
#include "render/closure/phase.h"

namespace alder {
namespace closure {
namespace {
namespace hw = alder::HWY_NAMESPACE;

/// Kinds that send light on in some direction.
bool scatters(const LobeSpec& s) {
    return s.kind != LobeKind::Emission && s.kind != LobeKind::Holdout && s.kind != LobeKind::Absorption && s.kind != LobeKind::Interior;
}

template <class T>
bool is_zero(Vec3<T> c) { return c.x == 0 && c.y == 0 && c.z == 0; }

/// Products of huge weights and narrow lobes stay finite, with room for sums over lobes. NaN stays NaN: it is counted later.
template <class T>
T bounded(T x) { return x > T(1e30) ? T(1e30) : x < T(-1e30) ? T(-1e30) : x; }
template <class T>
Vec3<T> bounded(Vec3<T> c) { return {bounded(c.x), bounded(c.y), bounded(c.z)}; }

bool transmits_only(const LobeSpec& s) {
    return s.kind == LobeKind::Translucent || s.kind == LobeKind::MicrofacetTransmission ||
           (s.kind == LobeKind::OrenNayar && s.transmits);
}

/// Microfacet lobe at a point: parameters read out.
template <class T>
struct MicrofacetLobe {
    const LobeSpec& spec;
    const T* p;
    MicrofacetLayout at;
    Microfacets<T> facets;
    T eta;

    explicit MicrofacetLobe(const Lobe<T>& l)
        : spec(*l.spec), p(l.p), at(spec), facets{spec.distribution, saturate(p[at.alpha_x]), saturate(p[at.alpha_y])},
          eta(at.eta < 0 ? T(1) : std::clamp(p[at.eta], T(1e-9), T(1e9))) {}

    bool reflects() const { return spec.kind != LobeKind::MicrofacetTransmission; }
    bool transmits() const { return spec.kind != LobeKind::MicrofacetReflection; }
    /// Refraction that close to straight through has no usable density.
    bool refraction_is_delta() const { return std::abs(eta - 1) < T(1e-4); }
    Vec3<T> rgb(int first) const { return {p[first], p[first + 1], p[first + 2]}; }

    /// Reflected and transmitted share at a microfacet seen under cosine c.
    void fresnel(T c, Vec3<T>& r, Vec3<T>& t) const {
        r = t = Vec3<T>(T(0));
        Vec3<T> tint(T(1));
        switch (spec.fresnel) {
            case FresnelMode::None:
                r = Vec3<T>(T(1));
                if (transmits() && hw::fresnel_amplitudes(c, eta).total) return limit(r, t);
                break;
            case FresnelMode::TotalReflection:
                r = Vec3<T>(hw::fresnel_amplitudes(c, eta).total ? T(1) : T(0));
                break;
            case FresnelMode::Dielectric: {
                T f = hw::fresnel_dielectric(c, eta);
                // Cycles' Glass: not below the value at normal incidence, where the curve of a high index dips.
                if (spec.kind == LobeKind::MicrofacetGlass) f = std::max(f, hw::f0_from_ior(eta));
                r = Vec3<T>(f);
                break;
            }
            case FresnelMode::Principled: {
                const bool film = at.film >= 0 && p[at.film] > T(0.1);
                r = film ? hw::fresnel_principled_film(c, eta, rgb(at.f0), p[at.film], p[at.film + 1])
                         : hw::fresnel_principled(c, eta, rgb(at.f0));
                if (at.trans >= 0) tint = rgb(at.trans);
                break;
            }
            case FresnelMode::F82: r = hw::fresnel_f82(c, rgb(at.f0), rgb(at.edge)); break;
            case FresnelMode::Conductor: r = hw::fresnel_conductor(c, rgb(at.f0), rgb(at.edge)); break;
        }
        t = Vec3<T>(T(1));
        if (spec.fresnel != FresnelMode::None)  // under a film a strong f0 lifts r above 1
            for (int i = 0; i < 3; ++i) t[i] = std::max(1 - r[i], T(0)) * tint[i];
        limit(r, t);
    }
    /// Probability of reflecting given the two shares.
    T reflect_probability(Vec3<T> r, Vec3<T> t) const {
        const T a = std::max(average(r), T(0)), b = std::max(average(t), T(0));
        return a + b > 0 ? a / (a + b) : T(0);
    }

  private:
    void limit(Vec3<T>& r, Vec3<T>& t) const {
        if (!reflects()) r = Vec3<T>(T(0));
        if (!transmits()) t = Vec3<T>(T(0));
    }
};

template <class T>
Frame<T> lobe_frame(const Lobe<T>& l) {
    return l.spec->has_tangent() ? frame_around(l.n, l.t) : frame_around(l.n);
}

// Cosines below this are treated as grazing-invisible: ratios of masking terms are no longer finite in float.
inline constexpr double kGrazing = 1e-12;

template <class T>
BsdfEval<T> eval_microfacet(const Lobe<T>& l, const ShadingView<T>& view, Vec3<T> wi_world) {
    BsdfEval<T> e;
    const MicrofacetLobe<T> m(l);
    if (m.facets.is_delta()) return e;
    const Frame<T> frame = lobe_frame(l);
    const Vec3<T> wo = frame.to_local(view.wo), wi = frame.to_local(wi_world);
    const bool refracted = wi.z < 0;
    if (!(wo.z > T(kGrazing)) || std::abs(wi.z) < T(kGrazing) || (refracted ? !m.transmits() : !m.reflects())) return e;

    Vec3<T> h = refracted ? -(wi * m.eta + wo) : wi + wo;
    const T h_length = length(h);
    if (!(h_length > 0)) return e;
    h = h / h_length;
    const T ho = dot(h, wo), hi = dot(h, wi);
    Vec3<T> r, t;
    m.fresnel(std::abs(ho), r, t);
    const T p_reflect = m.reflect_probability(r, t);
    const T lo = m.facets.lambda(wo), li = m.facets.lambda(wi), lo_exact = m.facets.lambda_exact(wo);
    if (!refracted) {
        const T common = m.facets.d(h) / 4;
        e.f_cos = r * (common / (wo.z * (1 + lo + li)));
        e.pdf = p_reflect * common / (wo.z * (1 + lo_exact));
        return e;
    }
    // Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007, equations 17, 21. The half vector
    // lies on the side of the rarer medium; the facet is real if, turned towards wo, it faces up and has wi behind it.
    const bool reachable = ho * h.z > 0 && ho * hi < 0;
    if (!view.unreachable_too && (!reachable || m.refraction_is_delta())) return e;
    const T common = m.facets.d({h.x, h.y, std::abs(h.z)}) * sqr(m.eta / h_length) * std::abs(ho * hi);
    e.f_cos = t * (common / (wo.z * (1 + lo + li)));
    if (reachable && !m.refraction_is_delta()) e.pdf = (1 - p_reflect) * common / (wo.z * (1 + lo_exact));
    return e;
}

template <class T>
BsdfSample<T> sample_microfacet(const Lobe<T>& l, const ShadingView<T>& view, T u1, T u2, T u3) {
    BsdfSample<T> s;
    const MicrofacetLobe<T> m(l);
    const Frame<T> frame = lobe_frame(l);
    const Vec3<T> wo = frame.to_local(view.wo);
    if (!(wo.z > T(kGrazing))) return s;
    const bool mirror = m.facets.is_delta();
    const Vec3<T> h = mirror ? Vec3<T>(0, 0, 1) : m.facets.sample_visible(wo, u1, u2);
    const T ho = dot(h, wo);
    if (!(ho > 0)) return s;
    Vec3<T> r, t;
    m.fresnel(ho, r, t);
    const T p_reflect = m.reflect_probability(r, t);
    if (is_zero(r) && is_zero(t)) return s;
    const bool refract = u3 >= p_reflect;
    Vec3<T> wi;
    T jacobian = T(0.25), p_choice = p_reflect;
    if (refract) {
        const T cos_t = hw::fresnel_amplitudes(ho, m.eta).cos_t;
        wi = h * (ho / m.eta - cos_t) - wo / m.eta;
        p_choice = 1 - p_reflect;
        s.eta = m.eta;
        s.is_delta = mirror || m.refraction_is_delta();
        jacobian = ho * cos_t * sqr(m.eta / (ho - m.eta * cos_t));
    } else {
        wi = h * (2 * ho) - wo;
        s.is_delta = mirror;
    }
    if (refract ? !(wi.z < -T(kGrazing)) : !(wi.z > T(kGrazing))) return s;
    if (!(p_choice > 0)) return s;
    s.wi = normalize(frame.to_world(wi));
    s.is_transmission = refract;
    s.weight = (refract ? t : r) / p_choice;
    s.roughness = std::max(m.facets.ax, m.facets.ay);
    if (s.is_delta) {
        s.pdf = p_choice;
        s.roughness = 0;
    } else {
        const T lo = m.facets.lambda(wo), li = m.facets.lambda(wi), lo_exact = m.facets.lambda_exact(wo);
        s.pdf = p_choice * m.facets.d(h) * jacobian / (wo.z * (1 + lo_exact));
        s.weight = s.weight * ((1 + lo_exact) / (1 + lo + li));
        if (!(s.pdf > 0)) return s;
    }
    s.valid = true;
    return s;
}

/// Ashikhmin and Shirley, "An Anisotropic Phong BRDF Model", 2000, without its Fresnel term.
template <class T>
struct Phong {
    T ax, ay, ex, ey;
    explicit Phong(const Lobe<T>& l) {
        const MicrofacetLayout at(*l.spec);
        ax = std::clamp(l.p[at.alpha_x], T(1e-4), T(1));
        ay = std::clamp(l.p[at.alpha_y], T(1e-4), T(1));
        ex = 2 / (ax * ax) - 2;
        ey = 2 / (ay * ay) - 2;
    }
    bool is_delta() const { return !(std::max(ax, ay) > T(1e-4)); }
    BsdfEval<T> eval(Vec3<T> wo, Vec3<T> wi) const {
        BsdfEval<T> e;
        if (!(wo.z > 0 && wi.z > 0) || is_delta()) return e;
        const Vec3<T> h = normalize(wo + wi);
        const T s2 = h.x * h.x + h.y * h.y;
        const T exponent = s2 > 0 ? (ex * h.x * h.x + ey * h.y * h.y) / s2 : T(0);
        // ln(h.z) from the tangential part: exponents reach 1e8
        const T power = s2 < 1 ? std::exp(exponent * std::log1p(-s2) / 2) : T(exponent > 0 ? 0 : 1);
        const T hv = std::max(dot(h, wo), T(1e-6));
        const T norm = std::sqrt((ex + 1) * (ey + 1)) / (8 * kPi<T>);
        e.pdf = norm * power / hv;
        e.f_cos = Vec3<T>(e.pdf * wi.z / std::max(std::max(wo.z, wi.z), T(1e-6)));
        return e;
    }
    Vec3<T> sample_h(T u1, T u2) const {
        // The quadrant, then its angle; section 3 of the paper.
        const T quarter = std::min(std::floor(4 * u1), T(3)), u = 4 * u1 - quarter;
        const T a = kPi<T> / 2 * u;
        T x = std::sqrt(ey + 1) * std::cos(a), y = std::sqrt(ex + 1) * std::sin(a);
        const T l = std::sqrt(x * x + y * y);
        x /= l;
        y /= l;
        // 1 - u2^(1/(e+1)) without cancelling
        const T rise = -std::expm1(std::log(std::max(1 - u2, T(1e-30))) / (ex * x * x + ey * y * y + 1));
        const T s = safe_sqrt(rise * (2 - rise)), z = 1 - rise;
        const int q = static_cast<int>(quarter);
        if (q == 1 || q == 2) x = -x;
        if (q >= 2) y = -y;
        return {s * x, s * y, z};
    }
};

/// Conty, Lecocq and Stein, "A Microfacet-Based Shadowing Function to Solve the Bump Terminator Problem", 2019.
template <class T>
T bump_shadowing(Vec3<T> ns, Vec3<T> n, Vec3<T> wi) {
    const T cos_i = dot(ns, wi), cos_d = dot(ns, n);
    if (cos_i * cos_d * dot(n, wi) < 0) return 0;
    const T c = std::abs(cos_i), d = std::abs(cos_d);
    if (d >= 1 || c >= 1) return 1;
    if (c < T(1e-6)) return 0;
    const T alpha2 = saturate((1 / sqr(d) - 1) / 8);
    return 2 / (1 + std::sqrt(1 + alpha2 * (1 / sqr(c) - 1)));
}

const MerlTable* measured_table(const LobeSpec& spec) {
    const auto* const t = dynamic_cast<const MerlTable*>(spec.prepared.get());
    return t && t->usable() ? t : nullptr;
}

/// f cos and density of the kinds that are simplest in world space; wi is on the right side already.
template <class T>
BsdfEval<T> eval_diffuse(const Lobe<T>& l, const ShadingView<T>& view, Vec3<T> wi) {
    BsdfEval<T> e;
    const LobeSpec& spec = *l.spec;
    const Vec3<T> n = l.n, wo = view.wo;
    const T nl = dot(n, wi), nv = dot(n, wo);
    switch (spec.kind) {
        case LobeKind::Diffuse:
            e.pdf = nl / kPi<T>;
            e.f_cos = spec.smooth || !(l.p[0] > 0)
                          ? Vec3<T>(e.pdf)
                          : EnergyOrenNayar<T>(l.p[0]).f_cos(nl, nv, dot(wi, wo), {l.p[1], l.p[2], l.p[3]});
            break;
        case LobeKind::OrenNayar: {
            const Vec3<T> mirrored = spec.transmits ? wi - n * (2 * nl) : wi;
            e.pdf = std::abs(nl) / kPi<T>;
            e.f_cos = Vec3<T>(oren_nayar_qualitative(std::abs(nl), nv, dot(mirrored, wo), l.p[0]));
            break;
        }
        case LobeKind::Translucent:
            e.pdf = -nl / kPi<T>;
            e.f_cos = Vec3<T>(e.pdf);
            break;
        case LobeKind::SheenMicrofiber:
            e.pdf = sheen_ltc(frame_around(n, wo).to_local(wi), l.p[0], l.p[1]);
            e.f_cos = Vec3<T>(e.pdf);
            break;
        case LobeKind::SheenAshikhmin: {
            const Vec3<T> h = hw::safe_normalize(wi + wo), x = cross(n, h);
            e.pdf = 1 / (2 * kPi<T>);
            e.f_cos = Vec3<T>(velvet(nl, nv, dot(n, h), std::abs(dot(h, wo)), dot(x, x), l.p[0]));
            break;
        }
        case LobeKind::ToonDiffuse:
        case LobeKind::ToonGlossy: {
            const bool glossy = spec.kind == LobeKind::ToonGlossy;
            if (glossy && !(nv > 0)) break;
            const Vec3<T> axis = glossy ? n * (2 * nv) - wo : n;
            T f;
            Toon<T>(l.p[0], l.p[1]).eval(angle_between(axis, wi), f, e.pdf);
            e.f_cos = Vec3<T>(f);
            break;
        }
        case LobeKind::Measured:
            if (const MerlTable* t = measured_table(spec)) e = MeasuredLobe<T>(*t, n, wo).eval(wi);
            break;
        default: break;
    }
    if (spec.cycles_normal) e.f_cos = e.f_cos * bump_shadowing(view.ns, n, wi);
    return e;
}

/// A direction of the non-microfacet kinds, world space.
template <class T>
Vec3<T> sample_direction(const Lobe<T>& l, const ShadingView<T>& view, T u1, T u2, T u3) {
    switch (l.spec->kind) {
        case LobeKind::SheenMicrofiber:
            return frame_around(l.n, view.wo).to_world(sample_sheen_ltc(l.p[0], l.p[1], u1, u2));
        case LobeKind::SheenAshikhmin: return frame_around(l.n).to_world(sample_cone(T(1), u1, u2));
        case LobeKind::ToonDiffuse:
            return frame_around(l.n).to_world(sample_cone(Toon<T>(l.p[0], l.p[1]).height, u1, u2));
        case LobeKind::ToonGlossy:
            return frame_around(l.n * (2 * dot(l.n, view.wo)) - view.wo)
                .to_world(sample_cone(Toon<T>(l.p[0], l.p[1]).height, u1, u2));
        case LobeKind::AshikhminShirley: {
            const Frame<T> frame = lobe_frame(l);
            const Vec3<T> wo = frame.to_local(view.wo);
            const Phong<T> phong(l);
            const Vec3<T> h = phong.is_delta() ? Vec3<T>(0, 0, 1) : phong.sample_h(u1, u2);
            return frame.to_world(h * (2 * dot(h, wo)) - wo);
        }
        case LobeKind::Measured:
            if (const MerlTable* t = measured_table(*l.spec)) return MeasuredLobe<T>(*t, l.n, view.wo).sample(u1, u2, u3);
            [[fallthrough]];
        default: return frame_around(transmits_only(*l.spec) ? -l.n : l.n).to_world(sample_cosine(u1, u2));
    }
}

/// Unweighted value; all kinds.
template <class T>
BsdfEval<T> eval_shape(const Lobe<T>& l, const ShadingView<T>& view, Vec3<T> wi) {
    const LobeSpec& spec = *l.spec;
    if (spec.kind < LobeKind::Diffuse) return {};
    if (spec.is_hair()) return eval_hair(l, view, wi);  // fibres scatter to all sides
    if (spec.is_phase()) {
        const T p = phase_value(l, view.wo, wi);
        return {Vec3<T>(p), p};
    }
    if (!scatters(spec) || spec.kind == LobeKind::RayPortal) return {};
    // The light must be on the same side of the lobe's normal and of the geometry, and on the side the lobe scatters to.
    const T nl = dot(l.n, wi), gl = dot(view.ng, wi);
    if (spec.kind == LobeKind::MicrofacetGlass) {
        if (!(nl * gl > 0)) return {};
    } else if (transmits_only(spec) ? !(nl < 0 && gl < 0) : !(nl > 0 && gl > 0)) {
        const bool loose = spec.kind == LobeKind::SheenAshikhmin || spec.kind == LobeKind::ToonGlossy;
        if (!(view.unreachable_too && loose && nl > 0)) return {};
        BsdfEval<T> e = eval_diffuse(l, view, wi);
        e.pdf = 0;
        return e;
    }
    if (spec.kind == LobeKind::AshikhminShirley) {
        const Frame<T> frame = lobe_frame(l);
        return Phong<T>(l).eval(frame.to_local(view.wo), frame.to_local(wi));
    }
    return spec.is_microfacet() ? eval_microfacet(l, view, wi) : eval_diffuse(l, view, wi);
}

}  // namespace
}  // namespace closure

template <class T>
Lobe<T> load_lobe(const LobeSpec& spec, const Channel<T>* channels, size_t i) {
    const auto at = [&](int c) { return channels[c].p[i * channels[c].stride]; };
    Lobe<T> l;
    l.spec = &spec;
    l.weight = Vec3<T>(at(0), at(1), at(2));
    if (closure::is_zero(l.weight)) return l;
    l.n = Vec3<T>(at(3), at(4), at(5));
    int c = 6;
    if (spec.has_tangent()) {
        l.t = Vec3<T>(at(6), at(7), at(8));
        c = 9;
    }
    for (int k = 0, n = spec.params(); k < n; ++k) l.p[k] = at(c + k);
    return l;
}

template <class T>
bool is_delta(const Lobe<T>& l) {
    if (l.spec->kind == LobeKind::Transparent || l.spec->kind == LobeKind::RayPortal || l.spec->is_subsurface()) return true;
    if (l.spec->kind == LobeKind::AshikhminShirley) return closure::Phong<T>(l).is_delta();
    return l.spec->is_microfacet() && closure::MicrofacetLobe<T>(l).facets.is_delta();
}

template <class T>
BsdfEval<T> eval_lobe(const Lobe<T>& l, const ShadingView<T>& view, Vec3<T> wi) {
    if (closure::is_zero(l.weight)) return {};
    BsdfEval<T> e = closure::eval_shape(l, view, wi);
    e.f_cos = closure::bounded(e.f_cos * l.weight);
    e.pdf = closure::bounded(e.pdf);
    return e;
}

template <class T>
BsdfSample<T> sample_lobe(const Lobe<T>& l, const ShadingView<T>& view, T u1, T u2, T u3) {
    BsdfSample<T> s;
    if (closure::is_zero(l.weight) || !closure::scatters(*l.spec)) return s;
    if (l.spec->kind == LobeKind::Transparent) {
        s.wi = -view.wo;
        s.weight = closure::bounded(l.weight);
        s.pdf = 1;
        s.is_delta = s.is_transmission = s.valid = true;
        s.roughness = 0;
        return s;
    }
    if (l.spec->kind == LobeKind::RayPortal) {
        const Vec3<T> direction(l.p[3], l.p[4], l.p[5]);
        s.wi = closure::is_zero(direction) ? -view.wo : safe_normalize(direction);
        s.weight = closure::bounded(l.weight);
        s.pdf = 1;
        s.is_delta = s.is_transmission = true;
        s.valid = dot(s.wi, s.wi) > T(0.5);
        s.roughness = 0;
        return s;
    }
    if (l.spec->is_subsurface()) {  // only the choice is made here: where light leaves is found by a walk
        s.wi = -l.n;
        s.weight = closure::bounded(l.weight);
        s.pdf = 1;
        s.is_delta = s.is_diffuse = s.is_transmission = s.valid = true;
        return s;
    }
    const bool phong = l.spec->kind == LobeKind::AshikhminShirley;
    if (l.spec->is_phase()) {  // drawn by its own value
        s.wi = closure::sample_phase(l, view.wo, u1, u2);
        s.pdf = closure::phase_value(l, view.wo, s.wi);
        s.weight = Vec3<T>(T(1));
        s.valid = s.pdf > 0;
    } else if (l.spec->is_hair()) {
        s = closure::sample_hair(l, view, u1, u2, u3);
    } else if (l.spec->is_microfacet() && !phong) {
        s = closure::sample_microfacet(l, view, u1, u2, u3);
        if (s.valid && (dot(view.ng, s.wi) < 0) != s.is_transmission) s.valid = false;
    } else {
        s.wi = closure::sample_direction(l, view, u1, u2, u3);
        s.is_transmission = closure::transmits_only(*l.spec);
        s.is_diffuse = !phong && l.spec->kind != LobeKind::Measured;
        if (phong && is_delta(l)) {
            s.is_delta = true;
            s.roughness = 0;
            s.pdf = 1;
            s.weight = Vec3<T>(T(1));
            s.valid = dot(view.ng, s.wi) > 0 && dot(l.n, view.wo) > 0;
        } else {
            const BsdfEval<T> e = closure::eval_shape(l, view, s.wi);
            s.pdf = e.pdf;
            s.valid = e.pdf > 0;
            if (s.valid) s.weight = e.f_cos / e.pdf;
            if (phong) s.roughness = std::max(closure::Phong<T>(l).ax, closure::Phong<T>(l).ay);
        }
    }
    s.weight = s.valid ? closure::bounded(s.weight * l.weight) : Vec3<T>(T(0));
    s.pdf = s.valid ? closure::bounded(s.pdf) : T(0);
    return s;
}

template <class T>
Vec3<T> lobe_albedo(const Lobe<T>& l, Vec3<T> wo) {
    using namespace closure;
    const LobeSpec& spec = *l.spec;
    if (is_zero(l.weight) || !scatters(spec)) return Vec3<T>(T(0));
    if (spec.is_hair()) return bounded(l.weight * hair_albedo(l, wo));
    if (!spec.is_microfacet() || spec.kind == LobeKind::AshikhminShirley) return bounded(l.weight);
    const T c = dot(l.n, wo);
    if (!(c > 0)) return Vec3<T>(T(0));
    const MicrofacetLobe<T> m(l);
    Vec3<T> r, t;
    m.fresnel(c, r, t);
    const T rough = hw::table_roughness(m.facets.ax, m.facets.ay);
    // Rough facets are seen at other angles than the surface is: tables for dielectrics, the average for metals.
    const bool film = m.at.film >= 0 && m.p[m.at.film] > T(0.1);
    if (spec.fresnel == FresnelMode::F82 || spec.fresnel == FresnelMode::Conductor) {
        const Vec3<T> f0 = m.rgb(m.at.f0), edge = m.rgb(m.at.edge);
        const Vec3<T> mean = spec.fresnel == FresnelMode::F82 ? hw::f82_average(f0, edge) : hw::fresnel_conductor_average(f0, edge);
        r = lerp(r, mean, rough);
    } else if (m.reflects() && m.eta > 1 && !film &&
               (spec.fresnel == FresnelMode::Dielectric || spec.fresnel == FresnelMode::Principled)) {
        const Vec3<T> f0 = m.at.f0 >= 0 ? m.rgb(m.at.f0) : Vec3<T>(hw::f0_from_ior(m.eta));
        const T rise = hw::layer_fresnel_rise(rough, c, m.eta);
        for (int i = 0; i < 3; ++i) {
            const T before = 1 - r[i];
            r[i] = f0[i] + (1 - f0[i]) * rise;
            t[i] = before > T(1e-6) ? t[i] * (1 - r[i]) / before : T(0);
        }
    }
    T single = 1;
    if (spec.distribution == Distribution::GGX)
        single = spec.kind == LobeKind::MicrofacetReflection ? hw::ggx_energy(rough, c).e
                 : spec.kind == LobeKind::MicrofacetGlass    ? hw::ggx_glass_energy(rough, c, m.eta).e
                                                             : T(1);
    return bounded(l.weight * (r + t) * single);
}

template <class T>
T lobe_sampling_weight(const Lobe<T>& l, Vec3<T> wo) {
    const T w = closure::average(lobe_albedo(l, wo));
    return w > 0 ? w : T(0);  // NaN and negative weights are never chosen
}

#define ALDER_INSTANTIATE(T)                                                                        \
    template Lobe<T> load_lobe(const LobeSpec&, const Channel<T>*, size_t);                         \
    template bool is_delta(const Lobe<T>&);                                                         \
    template BsdfEval<T> eval_lobe(const Lobe<T>&, const ShadingView<T>&, Vec3<T>);                 \
    template BsdfSample<T> sample_lobe(const Lobe<T>&, const ShadingView<T>&, T, T, T);             \
    template Vec3<T> lobe_albedo(const Lobe<T>&, Vec3<T>);                                          \
    template T lobe_sampling_weight(const Lobe<T>&, Vec3<T>);
ALDER_INSTANTIATE(float)
ALDER_INSTANTIATE(double)
#undef ALDER_INSTANTIATE

}  // namespace alder
