// Huang, Hullin and Hanika, "A Microfacet-based Hair Scattering Model", EGSR 2022, as Cycles 4.5 has it: a fibre of circular or
// elliptical section with a rough GGX surface of tilted scales. Seen from near, the part of the width that a pixel covers is
// integrated; from afar all of it.
//
// R is an integral over the offset h, by Simpson's rule with Cycles' number of intervals. TT and TRT are integrals over h and
// the microfacets met inside: Cycles estimates them with random numbers, so its value is noise. Here the numbers follow from
// the directions, so that the same pair always has the same value, and ShadingView::converged takes many of them.
// What samples is a mixture of simpler shapes with an exact density, not the model itself: the model has none in closed form.
#pragma once
#include <bit>
#include <cstdint>

#include "nodes/surface/energy-inl.h"
#include "render/closure/hair.h"
#include "render/closure/microfacet.h"

namespace alder::closure {

/// PCG: O'Neill, "PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms", 2014.
struct SmallRandom {
    uint64_t state;
    explicit SmallRandom(uint64_t seed) : state(seed) { next(); }
    uint32_t next() {
        const uint64_t old = state;
        state = old * 6364136223846793005ull + 1442695040888963407ull;
        const auto shifted = static_cast<uint32_t>(((old >> 18) ^ old) >> 27);
        return std::rotr(shifted, static_cast<int>(old >> 59));
    }
    template <class T>
    T uniform() { return static_cast<T>(next() >> 8) * T(0x1p-24); }
};

template <class T>
struct HuangHair {
    static constexpr int kConverged = 1 << 16;  ///< rays

    Vec3<T> sigma, wo;  ///< wo: in the frame x = major axis or across the view, y = along the fibre
    T alpha, tilt, eta, aspect, h, coverage, r, tt, trt, radius = 1, e2 = 0;
    Vec3<T> x, y, z;
    Fibre<T> fibre;
    bool near, visible, converged;

    HuangHair(const Lobe<T>& l, const ShadingView<T>& view)
        : sigma(limit(l.p[0]), limit(l.p[1]), limit(l.p[2])), alpha(std::clamp(l.p[3], T(1e-3), T(1))), tilt(std::clamp(l.p[4], T(-1.57), T(1.57))),
          eta(std::clamp(l.p[5], T(1e-3), T(1e3))), aspect(std::clamp(l.p[6], T(1e-3), T(1))), h(l.p[7]), coverage(std::max(l.p[8], T(1e-4))),
          r(limit(l.p[9])), tt(limit(l.p[10])), trt(limit(l.p[11])), fibre(l.t, view.wo), converged(view.converged) {
        y = fibre.frame.z;
        x = dot(l.n, l.n) > T(0.5) ? frame_around(y, l.n).x : fibre.frame.y;  // the major axis, or across the view: T x wo
        z = cross(x, y);
        wo = local(view.wo);
        if (aspect < 1) {
            e2 = (1 - aspect) * (1 + aspect);
            radius = std::sqrt(std::max(1 - e2 * sqr(wo.x) / std::max(sqr(wo.x) + sqr(wo.z), T(1e-20)), sqr(aspect)));
        }
        near = radius > coverage;
        visible = std::abs(h) < radius;
    }

    Vec3<T> f_cos(Vec3<T> wi_world) const {
        const Vec3<T> zero(T(0)), wi = local(wi_world);
        const T cos_o = cos_theta(wo), cos_i = cos_theta(wi), tan_tilt = std::tan(tilt);
        if (!visible || !(cos_o > T(1e-6)) || !(cos_i > T(1e-6)) || tan_tilt * wi.y / cos_i < -1) return zero;
        const T edge = std::max(-tan_tilt * wo.y / cos_o, T(0));
        if (!(edge <= 1)) return zero;
        const T half_span = std::acos(edge), phi_o = circular() ? T(0) : phi_of(wo);
        T lo = h_at(phi_o + half_span), hi = h_at(phi_o - half_span), dh = 2;
        if (near) {
            const T near_lo = std::max(-radius, h - coverage), near_hi = std::min(radius, h + coverage);
            dh = (near_hi - near_lo) / radius;
            lo = std::max(lo, near_lo);
            hi = std::min(hi, near_hi);
        }
        lo = std::max(lo / radius, T(-0.999));
        hi = std::min(hi / radius, T(0.999));
        if (!(hi > lo) || !(dh > 0)) return zero;
        const Vec3<T> sum = reflected(wi, lo, hi) + inside(wi, lo, hi);
        Vec3<T> f = sum / (cos_o * dh);
        for (int c = 0; c < 3; ++c) f[c] = f[c] > 0 ? f[c] : T(0);
        return f;
    }

    // ---- sampling: per order a longitudinal lobe and an azimuthal one, and a little of everything ----
    struct Proxy {
        std::array<FibreOrder<T>, 3> orders;
        std::array<T, 3> share;
    };
    static constexpr double kUniformShare = 0.15;
    Proxy proxy() const {
        Proxy p;
        const T offset = near ? std::clamp(h / radius, T(-0.99), T(0.99)) : T(0.5);
        const FibrePath<T> path(fibre.sin_o, fibre.cos_o, offset, eta, sigma);
        const T weight[3] = {r * average(path.carried[0]), tt * average(path.carried[1]), trt * average(path.carried[2] + path.carried[3])};
        const T sum = weight[0] + weight[1] + weight[2];
        const T window = near ? coverage : T(1);
        const T a2 = alpha * alpha;
        const T v[3] = {2 * a2, a2, 4 * a2};
        const T s[3] = {alpha / 2 + window, (alpha + window) / 3, alpha + window};
        const T shift[3] = {-2 * tilt, tilt, 4 * tilt};
        for (int k = 0; k < 3; ++k) {
            p.share[k] = sum > 0 ? weight[k] / sum : T(1) / 3;
            const T turn = near || k == 1 ? (near ? path.turn(k) : kPi<T>) : T(0);
            p.orders[k] = FibreOrder<T>::tilted(fibre, shift[k], fibre_variance(v[k]), fibre_scale(s[k]), turn, !near && k == 2);
        }
        return p;
    }
    T density(const Proxy& p, Vec3<T> wi) const {
        const auto i = fibre.angles(wi);
        T sum = T(kUniformShare) / (4 * kPi<T>);
        for (int k = 0; k < 3; ++k)
            if (p.share[k] > 0) sum += T(1 - kUniformShare) * p.share[k] * p.orders[k].density(i);
        return sum;
    }
    Vec3<T> sample(const Proxy& p, T u1, T u2, T u3) const {
        if (u3 < T(kUniformShare)) {
            const T c = 1 - 2 * u1, s = safe_sqrt((1 - c) * (1 + c)), phi = kTwoPi<T> * u2;
            return {s * std::cos(phi), s * std::sin(phi), c};
        }
        u3 = (u3 - T(kUniformShare)) / T(1 - kUniformShare);
        int k = 0;
        while (k < 2 && !(u3 < p.share[k])) u3 -= p.share[k++];
        while (k > 0 && !(p.share[k] > 0)) --k;
        return p.orders[k].sample(fibre, u1, u2, p.share[k] > 0 ? std::clamp(u3 / p.share[k], T(0), T(1)) : T(0));
    }
    /// As far as smooth surfaces tell.
    Vec3<T> albedo() const {
        const FibrePath<T> path(fibre.sin_o, fibre.cos_o, near ? h / radius : T(0.5), eta, sigma);
        return path.carried[0] * r + path.carried[1] * tt + (path.carried[2] + path.carried[3]) * trt;
    }

  private:
    static T limit(T v) { return std::clamp(v, T(0), T(1e6)); }
    static T cos_theta(Vec3<T> w) { return std::sqrt(w.x * w.x + w.z * w.z); }
    static T phi_of(Vec3<T> w) { return std::atan2(w.x, w.z); }
    bool circular() const { return e2 == 0; }
    Vec3<T> local(Vec3<T> w) const { return {dot(x, w), dot(y, w), dot(z, w)}; }

    // Section 3 of the paper: gamma is the parameter of the ellipse (sin, b cos), phi the azimuth of its normal.
    T to_phi(T gamma) const { return circular() ? gamma : std::atan2(aspect * std::sin(gamma), std::cos(gamma)); }
    T h_at(T phi) const {
        if (circular()) return -std::sin(phi);
        const T gamma = std::atan2(std::sin(phi), aspect * std::cos(phi)), c = cos_theta(wo);
        return -wo.z / c * std::sin(gamma) + aspect * wo.x / c * std::cos(gamma);
    }
    T gamma_at(T h_over_radius) const {
        if (circular()) return -std::asin(h_over_radius);
        return std::atan2(wo.z, -aspect * wo.x) - std::acos(-h_over_radius);
    }
    /// d gamma / d h
    T stretch(T gamma) const {
        const T c = cos_theta(wo);
        const T d = circular() ? std::cos(gamma) : wo.z / c * std::cos(gamma) + aspect * wo.x / c * std::sin(gamma);
        return d != 0 ? 1 / d : T(0);
    }
    T arc(T gamma) const { return circular() ? T(1) : std::sqrt(1 - e2 * sqr(std::sin(gamma))); }
    /// The section's normal at gamma, raised by theta.
    Vec3<T> normal(T theta, T gamma) const {
        const T c = std::cos(theta), phi = to_phi(gamma);
        return {std::sin(phi) * c, std::sin(theta), std::cos(phi) * c};
    }
    T chord(T gamma_a, T gamma_b) const {
        return std::hypot(std::sin(gamma_a) - std::sin(gamma_b), aspect * (std::cos(gamma_a) - std::cos(gamma_b)));
    }
    T energy_scale(T mu, T ior) const { return 1 / HWY_NAMESPACE::ggx_glass_energy(std::sqrt(alpha), mu, ior).e; }
    static T lambda(T a2, T c) { return (std::sqrt(1 + a2 * (1 / std::max(c * c, T(1e-12)) - 1)) - 1) / 2; }
    T masking(T ci, T co) const { return 1 / (1 + lambda(alpha * alpha, ci) + lambda(alpha * alpha, co)); }
    T shadowing(T ci, T co) const {  ///< G2/G1
        const T li = lambda(alpha * alpha, ci);
        return (1 + li) / (1 + li + lambda(alpha * alpha, co));
    }
    T facets(T c, Vec3<T> m, Vec3<T> wh) const {
        const Vec3<T> s = cross(m, wh);  // the sine does not cancel
        const T a2 = alpha * alpha, t = dot(s, s) + a2 * c * c;
        return a2 / (kPi<T> * t * t);
    }
    static bool seen(Vec3<T> v, Vec3<T> m, Vec3<T> wh) { return dot(v, wh) > 0 && dot(v, m) > 0; }
    static bool seen(Vec3<T> v, Vec3<T> w, Vec3<T> m, Vec3<T> wh) { return seen(v, m, wh) && seen(w, m, wh); }
    static Vec3<T> mirrored(Vec3<T> w, Vec3<T> m) { return m * (2 * dot(w, m)) - w; }
    Vec3<T> sample_facet(Vec3<T> w, Vec3<T> m, T u1, T u2) const {
        const Frame<T> f = frame_around(m);
        const Vec3<T> wm = f.to_local(w);
        if (!(wm.z > T(-0.9999))) return m;  // from below too, as Cycles does: what goes on inside then counts as met
        return f.to_world(Microfacets<T>{Distribution::GGX, alpha, alpha}.sample_visible(wm, u1, u2));
    }

    struct Simpson {
        T first, step;
        int intervals;
        Simpson(T lo, T hi, T resolution) : first(lo), intervals(2 * static_cast<int>(std::ceil((hi - lo) / resolution / 2))) {
            intervals = std::max(intervals, 2);
            step = (hi - lo) / intervals;
        }
        T at(int i) const { return first + i * step; }
        T weight(int i) const { return (i == 0 || i == intervals ? T(0.5) : T(i % 2 + 1)) * step * T(2) / 3; }
    };

    Vec3<T> reflected(Vec3<T> wi, T lo, T hi) const {
        if (!(r > 0)) return Vec3<T>(T(0));
        const Vec3<T> sum_w = wo + wi;
        const T l = length(sum_w);
        if (!(l > 0)) return Vec3<T>(T(0));
        const Vec3<T> wh = sum_w / l;
        const Simpson simpson(lo, hi, alpha * T(0.7));
        T integral = 0;
        for (int i = 0; i <= simpson.intervals; ++i) {
            const T gamma = gamma_at(simpson.at(i));
            const Vec3<T> m = normal(tilt, gamma);
            if (!seen(wo, wi, {m.x, 0, m.z}, wh)) continue;
            const T co = dot(m, wo);
            integral += simpson.weight(i) * stretch(gamma) * arc(gamma) * facets(dot(m, wh), m, wh) * masking(co, dot(m, wi)) *
                        energy_scale(co, eta);
        }
        return Vec3<T>(r * HWY_NAMESPACE::fresnel_dielectric(dot(wo, wh), eta) / 4 * integral);
    }

    /// Through a facet: index seen from w's side. The negative cosine is inside.
    static Vec3<T> refracted(Vec3<T> w, Vec3<T> m, T ior) {
        const T c = dot(w, m), cos_t = HWY_NAMESPACE::fresnel_amplitudes(c, ior).cos_t;
        return m * (c / ior - cos_t) - w / ior;
    }
    static T fresnel(T c, T ior) { return HWY_NAMESPACE::fresnel_dielectric(c, ior); }
    Vec3<T> absorbed(T path) const {
        return {std::exp(-sigma.x * path), std::exp(-sigma.y * path), std::exp(-sigma.z * path)};
    }
    /// Light beyond TRT, as a geometric series of what the first passes did.
    static Vec3<T> beyond(T t1, T r2, Vec3<T> a) {
        const T t = std::max(1 - r2, T(1e-5));
        Vec3<T> sum;
        for (int c = 0; c < 3; ++c) sum[c] = t1 * sqr(r2) * t * a[c] * a[c] * a[c] / std::max(1 - a[c] * (1 - t), T(1e-6));
        return sum;
    }

    struct Sums {
        Vec3<T> through{T(0), T(0), T(0)}, rest{T(0), T(0), T(0)};
    };
    uint64_t seed(Vec3<T> wi) const {
        uint64_t s = 0x9e3779b97f4a7c15ull;
        for (const T v : {wo.x, wo.y, wi.x, wi.y, wi.z, h}) s = (s ^ std::bit_cast<uint32_t>(static_cast<float>(v))) * 0xff51afd7ed558ccdull, s ^= s >> 32;
        return s;
    }
    Vec3<T> inside(Vec3<T> wi, T lo, T hi) const {
        if (!(tt > 0) && !(trt > 0)) return Vec3<T>(T(0));
        const Simpson simpson(lo, hi, alpha * T(0.8));
        Sums sums;
        // Converged: the same numbers for every pair of directions, so that the value is a smooth function of them.
        SmallRandom random(converged ? 1 : seed(wi));
        T all = 0;
        for (int i = 0; converged && i <= simpson.intervals; ++i) all += simpson.weight(i) * stretch(gamma_at(simpson.at(i)));
        for (int i = 0; i <= simpson.intervals; ++i) {
            // The ends weigh most: rays where they matter.
            const T weight = simpson.weight(i);
            const int repeats = converged ? std::max(static_cast<int>(kConverged * std::min(weight * stretch(gamma_at(simpson.at(i))) / all, T(1))), 64) : 1;
            double shift[4];
            for (double& v : shift) v = random.uniform<double>();
            for (int k = 0; k < repeats; ++k) {
                // Roberts' additive recurrence in four dimensions: steps are powers of 1/1.16730397826142
                T u[4];
                double step = 1;
                for (int c = 0; c < 4; ++c) {
                    step /= 1.16730397826141868426;
                    const double v = shift[c] + k * step;
                    u[c] = std::min(static_cast<T>(v - std::floor(v)), 1 - std::numeric_limits<T>::epsilon() / 2);
                }
                pass(wi, simpson.at(i), weight / repeats, u, sums);
            }
        }
        // Spread over all azimuths, as Chiang et al. spread theirs.
        const Longitudinal<T> along{wi.y, cos_theta(wi), wo.y, cos_theta(wo), 4 * alpha};
        const T everywhere = along.cycles() / kTwoPi<T> * 2 / kPi<T>;
        return sums.through / sqr(eta) + sums.rest * everywhere;
    }

    /// A ray inside, as it leaves the first surface.
    struct Inside {
        Vec3<T> wt, m2, n2, a_t;
        T gamma_i, gamma_t, phi_t, weight, t1, scale, g1, cos_m1, cos_o1, cos_m2;
    };
    /// One ray that enters at offset h: what reaches wi through TT and TRT, and what goes on. Cycles takes to_phi for the
    /// azimuths of directions as well.
    void pass(Vec3<T> wi, T offset, T simpson_weight, const T* u, Sums& sums) const {
        const T inverse = 1 / eta;
        Inside s;
        s.gamma_i = gamma_at(offset);
        const Vec3<T> m1 = normal(tilt, s.gamma_i), wh1 = sample_facet(wo, m1, u[0], u[1]);
        const T cos_h1 = dot(wo, wh1);
        if (!(cos_h1 > 0)) return;
        s.cos_m1 = dot(wo, m1);
        // Where the tilt bounds the visible width, the ends of the integral lie on the horizon. Cycles' rounding never sees the
        // first and sees the last one or not, which a pixel's samples average: half.
        const bool horizon = std::abs(s.cos_m1) < T(1e-5);
        if (horizon && offset < 0) return;
        if (horizon) s.cos_m1 = T(1e-5);
        s.t1 = 1 - fresnel(cos_h1, eta);
        s.wt = refracted(wo, wh1, eta);
        // Cycles asks the refracted ray turned back to be on the viewer's side of the facet.
        if (!(s.cos_m1 > 0) || !(dot(-s.wt, m1) > 0) || !seen(wo, -s.wt, normal(0, s.gamma_i), wh1)) return;
        s.phi_t = phi_of(s.wt);
        s.gamma_t = 2 * to_phi(s.phi_t) - s.gamma_i;
        s.m2 = normal(-tilt, s.gamma_t);
        s.n2 = normal(0, s.gamma_t);
        s.cos_o1 = dot(-s.wt, m1);
        s.cos_m2 = dot(-s.wt, s.m2);
        s.g1 = shadowing(s.cos_m1, s.cos_o1);
        s.weight = simpson_weight * stretch(s.gamma_i) * (horizon ? T(0.5) : T(1));
        const T path = circular() ? -2 * std::cos(s.gamma_i - s.phi_t) : chord(s.gamma_i, s.gamma_t + kPi<T>);
        s.a_t = absorbed(std::max(path, T(0)) / std::max(cos_theta(s.wt), T(1e-6)));
        s.scale = energy_scale(s.cos_m1, eta) * energy_scale(s.cos_m2, inverse);
        if (tt > 0 && dot(wi, s.wt) >= inverse - T(1e-5)) {
            const Vec3<T> sum_w = wi * inverse - s.wt;
            const T l = length(sum_w);
            const Vec3<T> wh2 = sum_w / l;
            const T cos_mh2 = dot(s.m2, wh2), ci = dot(-s.wt, wh2), co = dot(-wi, wh2);
            if (cos_mh2 >= 0)
                add(sums.through, s.a_t,
                    tt * s.weight * s.t1 * s.scale * (1 - fresnel(ci, inverse)) * facets(cos_mh2, s.m2, wh2) * s.g1 *
                        masking(s.cos_m2, dot(-wi, s.m2)) / s.cos_o1 * s.cos_m1 * ci * co / sqr(l) * arc(s.gamma_t));
        }
        if (trt > 0) pass_again(wi, s, u, sums);
    }
    /// Reflected inside, then out.
    void pass_again(Vec3<T> wi, const Inside& s, const T* u, Sums& sums) const {
        const T inverse = 1 / eta;
        const Vec3<T> wh2 = sample_facet(-s.wt, s.m2, u[2], u[3]);
        const T cos_h2 = dot(-s.wt, wh2);
        if (!(cos_h2 > 0)) return;
        const T r2 = fresnel(cos_h2, inverse);
        const Vec3<T> rest = beyond(s.t1, r2, s.a_t) * s.weight;
        const Vec3<T> wtr = -mirrored(-s.wt, wh2);  // back along the ray that meets the third surface
        if (dot(-wtr, wi) < inverse - T(1e-5)) {
            sums.rest += rest;
            return;
        }
        if (!seen(-s.wt, -wtr, s.m2, wh2) || !seen(-s.wt, -wtr, s.n2, wh2)) return;
        const T phi_tr = phi_of(wtr), gamma_tr = s.gamma_i - 2 * (to_phi(s.phi_t) - to_phi(phi_tr)) + kPi<T>;
        const Vec3<T> m3 = normal(-tilt, gamma_tr), n3 = normal(0, gamma_tr);
        const Vec3<T> sum_w = wtr + wi * inverse;
        const T l = length(sum_w);
        const Vec3<T> wh3 = sum_w / l;
        sums.rest += rest;
        if (!(dot(m3, wh3) >= 0) || !seen(wtr, -wi, m3, wh3) || !seen(wtr, -wi, n3, wh3)) return;
        const T ci = dot(wh3, wtr), co = dot(wh3, -wi), cos_m3 = dot(m3, wtr), cos_o2 = dot(s.m2, -wtr);
        const T path = circular() ? 2 * std::abs(std::cos(phi_tr - s.gamma_t)) : chord(gamma_tr, s.gamma_t);
        const Vec3<T> a_tr = absorbed(path / std::max(cos_theta(wtr), T(1e-6)));
        const T t3 = (1 - fresnel(ci, inverse)) * energy_scale(cos_m3, inverse);
        add(sums.through, s.a_t * a_tr,
            trt * s.weight * s.t1 * s.scale * r2 * t3 * facets(dot(m3, wh3), m3, wh3) * s.g1 * shadowing(s.cos_m2, cos_o2) *
                masking(cos_m3, dot(m3, -wi)) / (s.cos_o1 * cos_o2) * s.cos_m1 * s.cos_m2 * ci * co / sqr(l) * arc(gamma_tr));
    }
    static void add(Vec3<T>& sum, Vec3<T> a, T x) {
        if (std::isfinite(x)) sum += a * x;
    }
};

}  // namespace alder::closure
