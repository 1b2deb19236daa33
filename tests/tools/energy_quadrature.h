// Quadrature of the energy tables: what fraction of light a GGX surface sends on after one scattering, by integration over
// the normals that the viewer sees. Used by the generator of the tables and by the test that recomputes some of their nodes.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "nodes/surface/fresnel-inl.h"
#include "render/closure/microfacet.h"

namespace alder::energy {

/// Nodes of an axis: k/(n-1), with 1e-4 in place of 0.
inline double axis_node(int k, int n) { return k == 0 ? 1e-4 : static_cast<double>(k) / (n - 1); }
/// Index whose fourth root of F0 is z; 1 stands for 0.99.
inline double ior_of(double z) {
    z = std::min(z, 0.99);
    return (1 + z * z) / (1 - z * z);
}

/// Mean over the visible normals of integrand(microfacets, wo, h, h.wo), by a grid of n x n points of the sampler's unit square
/// (one half of it: the other mirrors). The second coordinate is stretched towards 1, where steep normals crowd: they are what
/// a narrow lobe loses.
template <class Integrand>
double over_visible_normals(double rough, double mu, int n, const Integrand& integrand) {
    const closure::Microfacets<double> m{Distribution::GGX, rough * rough, rough * rough};
    const Vec3d wo(std::sqrt(1 - mu * mu), 0, mu);
    double sum = 0;
    for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) {
            const double v = 1 - (b + 0.5) / n;
            const Vec3d h = m.sample_visible(wo, 0.5 * (a + 0.5) / n, 1 - v * v * v);
            sum += integrand(m, wo, h, dot(wo, h)) * 3 * v * v;
        }
    return sum / (static_cast<double>(n) * n);
}
/// G2/G1 of height-correlated Smith masking for light leaving along wi, on either side.
inline double shadowing(const closure::Microfacets<double>& m, Vec3d wo, Vec3d wi) {
    const double lo = m.lambda(wo);
    return (1 + lo) / (1 + lo + m.lambda(wi));
}

/// Albedo with F = 1.
inline double ggx_albedo(double rough, double mu, int n) {
    return over_visible_normals(rough, mu, n, [](const auto& m, Vec3d wo, Vec3d h, double ho) {
        const Vec3d wi = h * (2 * ho) - wo;
        return wi.z > 0 ? shadowing(m, wo, wi) : 0.0;
    });
}
/// Reflected and refracted albedo of a dielectric. From inside, refracted rays that end on the viewer's side count too: so
/// does Cycles' table, and its energy compensation follows from that.
inline double ggx_glass_albedo(double rough, double mu, double ior, bool from_inside, int n) {
    const double eta = from_inside ? 1 / ior : ior;
    return over_visible_normals(rough, mu, n, [&](const auto& m, Vec3d wo, Vec3d h, double ho) {
        const Vec3d r = h * (2 * ho) - wo;
        const double f = HWY_NAMESPACE::fresnel_dielectric(ho, eta);
        double sum = r.z > 0 ? f * shadowing(m, wo, r) : 0;
        if (f < 1) {
            const double cos_t = HWY_NAMESPACE::fresnel_amplitudes(ho, eta).cos_t;
            const Vec3d t = h * (ho / eta - cos_t) - wo / eta;
            if (t.z < 0 || from_inside) sum += (1 - f) * shadowing(m, wo, t);
        }
        return sum;
    });
}
/// How far the Fresnel curve has risen from F0 towards 1 (0 where it dips below), over the normals whose reflection leaves
/// the surface.
inline double ggx_fresnel_rise(double rough, double mu, double ior, int n) {
    const double f0 = HWY_NAMESPACE::f0_from_ior(ior);
    return over_visible_normals(rough, mu, n, [&](const auto&, Vec3d wo, Vec3d h, double ho) {
        const Vec3d wi = h * (2 * ho) - wo;
        return wi.z > 0 ? HWY_NAMESPACE::fresnel_rise(HWY_NAMESPACE::fresnel_dielectric(ho, ior), f0) : 0.0;
    });
}
/// 2 int mu E(mu) dmu: Gauss–Legendre of `points` nodes in sqrt(mu), where E is smoothest.
template <class E>
double hemispherical(int points, const E& e) {
    double sum = 0;
    for (int i = 0; i < points; ++i) {
        double x = std::cos(closure::kPi<double> * (i + 0.75) / (points + 0.5)), slope = 1;
        for (int step = 0; step < 20; ++step) {  // Newton on the Legendre polynomial
            double p0 = 1, p1 = x;
            for (int k = 2; k <= points; ++k) {
                const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
                p0 = p1;
                p1 = p2;
            }
            slope = points * (x * p1 - p0) / (x * x - 1);
            x -= p1 / slope;
        }
        const double s = (x + 1) / 2, weight = 1 / ((1 - x * x) * slope * slope);
        sum += weight * 2 * s * 2 * s * s * e(s * s);  // dmu = 2 s ds
    }
    return sum;
}

}  // namespace alder::energy
