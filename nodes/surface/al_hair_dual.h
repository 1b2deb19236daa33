// alHair's dual scattering: what a volume of fibres sends back, from averages over one fibre's lobes.
// Zinke, Yuksel, Weber and Keyser, "Dual Scattering Approximation for Fast Multiple Scattering in Hair", SIGGRAPH 2008, as the
// alshaders specification has it (7.6). Everything in the tables is a sum over R, TT and TRT times the attenuation of each, and
// the attenuation is all that depends on colour: so the sums are kept apart, and any colour follows without a table of its own.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace alder::al_hair {

/// The fibre as the node is configured, radians. Shifts and widths without the per-point ones.
struct Fibre {
    bool operator==(const Fibre&) const = default;
    double alpha_r, beta_r, gamma_tt, gamma_g;
    std::array<double, 3> alpha() const { return {alpha_r, -alpha_r / 2, -1.5 * alpha_r}; }
    std::array<double, 3> beta() const { return {beta_r, beta_r / 2, 2 * beta_r}; }
};
/// What R, TT and TRT carry given the absorption -ln C (radius one half, section 7.3).
template <class T>
std::array<T, 3> attenuation(T color) {
    const T c = std::max(color, T(1e-4));
    return {T(0.05), T(0.8) * std::sqrt(c), T(0.3) * c};
}
template <class T>
T normal_density(T variance, T x) {
    const T v = std::max(variance, T(1e-10));
    return std::exp(-x * x / (2 * v)) / std::sqrt(T(6.28318530717958648) * v);
}

struct DualTables {
    static constexpr int kAngles = 64, kColumns = 32;
    Fibre fibre;
    std::array<std::array<float, 3>, kAngles> forward, backward;  ///< by theta_i: sums of the lobes times cos theta_i
    std::array<std::array<float, 3>, kColumns> around;             ///< forward scattering by phi in pi/2..pi
    explicit DualTables(const Fibre& f);

    template <class T>
    struct Averages {
        T a_f, a_b, alpha_f, alpha_b, beta_f, beta_b;  ///< attenuation, shift, variance: forward and back
        T back, shift, spread;                         ///< A_b, Delta_b, sigma_b: equations 14, 16, 17 of the paper
    };
    template <class T>
    Averages<T> averages(int node, T color) const {
        const std::array<T, 3> k = attenuation(color);
        const auto alpha = fibre.alpha(), beta = fibre.beta();
        const T area = T(2 / 3.14159265358979 * (3.14159265358979 / 63) * (3.14159265358979 / 126));
        Averages<T> r{};
        const auto sum = [&](const std::array<float, 3>& s, T& a, T& shift, T& variance) {
            for (int l = 0; l < 3; ++l) {
                const T f = T(s[l]) * k[l];
                a += f;
                shift += f * T(alpha[l]);
                variance += f * T(beta[l] * beta[l]);
            }
            if (a != 0) shift /= a, variance /= a;
            a *= area;
        };
        sum(forward[node], r.a_f, r.alpha_f, r.beta_f);
        sum(backward[node], r.a_b, r.alpha_b, r.beta_b);
        const T f2 = r.a_f * r.a_f, b = r.a_b, b2 = b * b, b3 = b * b2, rest = 1 - f2;
        const T o = std::abs(rest) > T(1e-6) ? rest : T(1e-6);
        r.back = b * f2 / o + b3 * f2 / (o * o * o);
        r.shift = r.alpha_b * (1 - 2 * b2 / (o * o)) + r.alpha_f * (2 * o * o + 4 * f2 * b2) / (o * o * o);
        const T once = 2 * r.beta_f + r.beta_b, thrice = 2 * r.beta_f + 3 * r.beta_b, below = b + b3 * thrice;
        r.spread = below != 0 ? std::min((1 + T(0.7) * f2) * (b * std::sqrt(once) + b3 * std::sqrt(thrice)) / below, T(1)) : T(0);
        return r;
    }
    /// Place of an angle in -pi/2..pi/2 on the grid.
    template <class T>
    static void place(T theta, int& node, int& next, T& share) {
        const T t = std::clamp((theta / T(3.14159265358979) + T(0.5)) * (kAngles - 1), T(0), T(kAngles - 1));
        node = static_cast<int>(t);
        next = std::min(node + 1, kAngles - 1);
        share = t - node;
    }
    /// Average forward attenuation a_f.
    template <class T>
    T forward_attenuation(T theta_i, T color) const {
        int a, b;
        T s;
        place(theta_i, a, b, s);
        return averages(a, color).a_f * (1 - s) + averages(b, color).a_f * s;
    }
    /// f_back with the variance that the way through other fibres has added.
    template <class T>
    T back_scattering(T theta_d, T theta_h, T added_variance, T color) const {
        int a, b;
        T s;
        place(theta_d, a, b, s);
        const Averages<T> p = averages(a, color), q = averages(b, color);
        const T back = p.back * (1 - s) + q.back * s, shift = p.shift * (1 - s) + q.shift * s, spread = p.spread * (1 - s) + q.spread * s;
        return back * normal_density(spread + added_variance, theta_h - shift) * T(2 / 3.14159265358979) / cos2(theta_d);
    }
    /// f_s: light that came through other fibres, scattered on by this one. phi in pi/2..pi; less counts as pi/2.
    template <class T>
    T forward_scattering(T theta_d, T theta_h, T phi, T added_variance, T color) const {
        const T x = std::clamp((phi / T(1.57079632679490) - 1) * (kColumns - 1), T(0), T(kColumns - 1));
        const int column = std::min(static_cast<int>(x), kColumns - 2);
        const std::array<T, 3> k = attenuation(color);
        const auto alpha = fibre.alpha(), beta = fibre.beta();
        T sum = 0;
        for (int l = 0; l < 3; ++l) {
            const T n = T(around[column][l]) + (T(around[column + 1][l]) - T(around[column][l])) * (x - column);
            sum += normal_density(T(beta[l] * beta[l]) + added_variance, theta_h - T(alpha[l])) * n * k[l];
        }
        return sum / cos2(theta_d);
    }

  private:
    template <class T>
    static T cos2(T theta_d) {
        const T c = std::cos(theta_d);
        return std::max(c * c, T(1e-3));
    }
};

/// Tables of a fibre: those last used are kept. Thread safe.
std::shared_ptr<const DualTables> dual_tables(const Fibre& fibre);

}  // namespace alder::al_hair
