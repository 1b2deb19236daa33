// The sums behind alHair's dual scattering, once per configured fibre.
#include "nodes/surface/al_hair_dual.h"

#include <mutex>
#include <vector>

namespace alder::al_hair {
namespace {

constexpr double kPi = 3.14159265358979323846, kHalfPi = kPi / 2;
// The original reads its lobes from a grid of this many angles, by truncation. Its angles are floats and its constants doubles: which
// cell an angle at an edge falls in depends on that.
constexpr int kGrid = 256;

/// R, TT and TRT without attenuation at a place of that grid. The glint stands at 35 radians, as in the original.
struct Lobes {
    std::array<double, 3> alpha, variance;
    double gamma_tt, gamma_g;
    std::array<double, 3> along(double theta_h) const {
        std::array<double, 3> m;
        for (int l = 0; l < 3; ++l) m[l] = normal_density(variance[l], theta_h - alpha[l]);
        return m;
    }
    std::array<double, 3> around(double phi, double phi_g) const {
        const double c = std::cos(phi / 2);
        return {c, normal_density(gamma_tt, kPi - phi), c + normal_density(gamma_g, phi - phi_g)};
    }
};

}  // namespace

DualTables::DualTables(const Fibre& f) : fibre(f), forward{}, backward{}, around{} {
    const auto beta = f.beta();
    const Lobes lobes{f.alpha(), {beta[0] * beta[0], beta[1] * beta[1], beta[2] * beta[2]}, f.gamma_tt, f.gamma_g};
    // Which azimuths of the grid the sums meet: accumulated in single precision, whereby the forward sum loses its last term.
    const auto step = static_cast<float>(kHalfPi / (kAngles - 1));
    const auto sum_around = [&](double first, double last) {
        std::array<double, 3> n{};
        for (auto phi = static_cast<float>(first); phi <= last; phi += step) {
            const int p = std::min(static_cast<int>(phi / kPi * (kGrid - 1)), kGrid - 1);
            const auto v = lobes.around(p * (kPi / (kGrid - 1)), 35.0);
            for (int l = 0; l < 3; ++l) n[l] += v[l];
        }
        return n;
    };
    const auto angle = [](int i) { return static_cast<float>(i * static_cast<float>(kPi / (kAngles - 1)) - kHalfPi); };
    const auto ahead = sum_around(kHalfPi, kPi), back = sum_around(0, kHalfPi);
    for (int i = 0; i < kAngles; ++i) {
        const float theta_i = angle(i);
        const double cosine = std::max(std::cos(double{theta_i}), 0.0);
        std::array<double, 3> m{};
        for (int r = 0; r < kAngles; ++r) {
            const float theta_h = (theta_i + angle(r)) * 0.5f;
            const int t = std::clamp(static_cast<int>((theta_h / kPi + 0.5) * (kGrid - 1)), 0, kGrid - 1);
            const auto v = lobes.along(t * (kPi / (kGrid - 1)) - kHalfPi);
            for (int l = 0; l < 3; ++l) m[l] += v[l];
        }
        for (int l = 0; l < 3; ++l) {
            forward[i][l] = static_cast<float>(m[l] * ahead[l] * cosine);
            backward[i][l] = static_cast<float>(m[l] * back[l] * cosine);
        }
    }
    // Equation 25: over the azimuths that the light may come from behind; 31 of 32 steps, as in the original.
    const double width = kPi / (kColumns - 1);
    for (int p = 0; p < kColumns; ++p) {
        const double phi = kHalfPi * (1 + static_cast<double>(p) / (kColumns - 1));
        std::array<double, 3> n{};
        for (int i = 0; i < kColumns - 1; ++i) {
            double d = phi - (i * width - kHalfPi);
            if (d > kPi) d = 2 * kPi - d;
            const auto v = lobes.around(d, 0.611);
            for (int l = 0; l < 3; ++l) n[l] += v[l];
        }
        for (int l = 0; l < 3; ++l) around[p][l] = static_cast<float>(n[l] * width);
    }
}

std::shared_ptr<const DualTables> dual_tables(const Fibre& fibre) {
    thread_local std::shared_ptr<const DualTables> last;
    if (last && last->fibre == fibre) return last;
    static std::mutex mutex;
    static std::vector<std::shared_ptr<const DualTables>> kept;  // a scene has few kinds of hair
    const std::lock_guard lock(mutex);
    for (const auto& t : kept)
        if (t->fibre == fibre) return last = t;
    if (kept.size() == 32) kept.erase(kept.begin());
    kept.push_back(std::make_shared<const DualTables>(fibre));
    return last = kept.back();
}

}  // namespace alder::al_hair
