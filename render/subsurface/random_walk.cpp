// Random walk inside a body, with Dwivedi's guiding towards the surface.
// Chiang, Kutz and Burley, "Practical and Controllable Subsurface Scattering for Production Path Tracing", 2016; guiding: Krivanek
// and d'Eon 2014; Meng, Hanika and Dachsbacher 2016 (equations 9 and 10); d'Eon and Krivanek 2020 (equation 67 and the choice
// between two surfaces). Estimators over colour channels and guiding are combined by the balance heuristic.
#include <algorithm>
#include <cmath>
#include <limits>

#include "render/sampling.h"
#include "render/subsurface/subsurface.h"

namespace alder {
namespace {

constexpr int kMostSteps = 256;
constexpr int kAnisotropicSteps = 10;  ///< then isotropic scattering with reduced coefficients: similar, and guided better
constexpr float kNegligible = 1e-6f;

Vec3f transmittance(Vec3f sigma, float t) { return {std::exp(-sigma.x * t), std::exp(-sigma.y * t), std::exp(-sigma.z * t)}; }
/// Density of ending at t: by scattering there, or by reaching a surface at t.
Vec3f distance_density(Vec3f sigma, float t, bool surface) {
    const Vec3f passed = transmittance(sigma, t);
    return surface ? passed : sigma * passed;
}

float henyey_greenstein(float cos_theta, float g) {
    if (std::abs(g) < 1e-3f) return 0.25f * kInvPi;
    const float s = 1 + g * g - 2 * g * cos_theta;
    return 0.25f * kInvPi * (1 - g * g) / std::max(s * std::sqrt(std::max(s, 0.f)), 1e-12f);
}
float sample_henyey_greenstein(float g, float u) {
    if (std::abs(g) < 1e-3f) return 1 - 2 * u;
    const float k = (1 - g * g) / (1 - g + 2 * g * u);
    return std::clamp((1 + g * g - k * k) / (2 * g), -1.f, 1.f);
}
Vec3f direction_about(Vec3f axis, float cos_theta, float u) {
    const float sin_theta = safe_sqrt(1 - cos_theta * cos_theta), phi = 2 * kPi * u;
    return safe_normalize(frame_about(axis).to_world({sin_theta * std::cos(phi), sin_theta * std::sin(phi), cos_theta}));
}

/// Density over cosines that lead back to a plane, for a medium of this diffusion length.
struct Dwivedi {
    float length, log_term;
    explicit Dwivedi(float alpha)
        : length(1 / std::sqrt(1 - std::pow(alpha, 2.44294f - 0.0215813f * alpha + 0.578637f / alpha))),
          log_term(std::log((length + 1) / (length - 1))) {}
    bool usable() const { return length > 1 && std::isfinite(length) && std::isfinite(log_term); }
    float density(float cos_theta) const { return 1 / ((length - cos_theta) * log_term); }
    float sample(float u) const { return std::clamp(length - (length + 1) * std::exp(-u * log_term), -1.f, 1.f); }
};

struct Coefficients {
    Vec3f sigma_t, sigma_s;
    float g = 0;
    float guided = 0;  ///< share of directions chosen towards the surface
};

/// Direction of the refracted, or for skin in half of the cases diffuse, entry. False: no way in.
bool enter(const ShadingPoint& entry, const Lobe<float>& lobe, float u1, float u2, Vec3f& direction) {
    const Vec3f n = lobe.n;
    if (lobe.spec->order == 1) {
        if (u1 < 0.5f) {
            u1 *= 2;
            const Disk d = uniform_disk(u1, u2);
            direction = frame_about(-n).to_world({d.x, d.y, safe_sqrt(1 - d.x * d.x - d.y * d.y)});
            return true;
        }
        u1 = std::min(2 * (u1 - 0.5f), 0.99999994f);
    }
    const Frame frame = frame_about(n);
    const Vec3f wo = frame.to_local(entry.wo);
    if (!(wo.z > 0)) return false;
    // Visible normal of the GGX distribution (Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT 2018).
    const float alpha = std::clamp(lobe.p[7], 0.f, 1.f), inverse_eta = 1 / lobe.p[6];
    const Vec3f stretched = safe_normalize(Vec3f(alpha * wo.x, alpha * wo.y, wo.z));
    const float flat = stretched.x * stretched.x + stretched.y * stretched.y;
    const Vec3f t1 = flat > 0 ? Vec3f(-stretched.y, stretched.x, 0) / std::sqrt(flat) : Vec3f(1, 0, 0), t2 = cross(stretched, t1);
    const float r = std::sqrt(u1), phi = 2 * kPi * u2, a = r * std::cos(phi), s = 0.5f * (1 + stretched.z);
    const float b = (1 - s) * safe_sqrt(1 - a * a) + s * r * std::sin(phi);
    const Vec3f h = t1 * a + t2 * b + stretched * safe_sqrt(1 - a * a - b * b);
    const Vec3f m = safe_normalize(frame.to_world({alpha * h.x, alpha * h.y, std::max(h.z, 0.f)}));
    const float c = dot(m, entry.wo);
    const float inside = safe_sqrt(1 - inverse_eta * inverse_eta * (1 - c * c));
    direction = safe_normalize(m * (inverse_eta * c - inside) - entry.wo * inverse_eta);
    return true;
}

/// Chooses a colour channel in proportion to what it carries; the densities of all.
int choose_channel(Vec3f weight, float& u, Vec3f& density) {
    const float x = std::abs(weight.x), y = std::abs(weight.y), z = std::abs(weight.z), sum = x + y + z;
    density = sum > 1e-30f && std::isfinite(sum) ? Vec3f(x / sum, y / sum, z / sum) : Vec3f(1.f / 3);
    for (int c = 0; c < 2; ++c) {
        if (u < density[c]) {
            u /= density[c];
            return c;
        }
        u -= density[c];
    }
    u = std::clamp(density.z > 0 ? u / density.z : 0.f, 0.f, 0.99999994f);
    return 2;
}

}  // namespace

float single_scattering_albedo(float albedo, float g) {
    const auto polynomial = [g](std::initializer_list<float> c) {
        float sum = 0, power = 1;
        for (const float k : c) {
            sum += k * power;
            power *= g;
        }
        return sum;
    };
    const float a = polynomial({1.8260523782f, -1.28451056436f, -1.79904629312f, 9.19393289202f, -22.8215585862f, 32.0234874259f, -23.6264803333f,
                                7.21067002658f});
    const float b = 4.98511194385f + 0.127355959438f * std::exp(polynomial({0, 31.1491581433f, -201.847017512f, 841.576016723f, -2018.09288505f,
                                                                            2731.71560286f, -1935.41424244f, 559.009054474f}));
    const float c = polynomial({1.09686102424f, -0.394704063468f, 1.05258115941f, -8.83963712726f, 28.8643230661f, -46.8802913581f, 38.5402837518f,
                                -12.7181042538f});
    const float d = polynomial({0.496310210422f, 0.360146581622f, -2.15139309747f, 17.8896899217f, -55.2984010333f, 82.065982243f, -58.5106008578f,
                                15.8478295021f});
    const float e = 4.23190299701f + 0.00310603949088f * std::exp(polynomial({0, 76.7316253952f, -594.356773233f, 2448.8834203f, -5576.68528998f,
                                                                              7116.60171912f, -4763.54467887f, 1303.5318055f}));
    const float f = polynomial({2.40602999408f, -2.51814844609f, 9.18494908356f, -79.2191708682f, 259.082868209f, -403.613804597f, 302.85712436f,
                                -87.4370473567f});
    const float blend = std::pow(albedo, 0.25f);
    const float alpha = (1 - blend) * a * std::pow(std::atan(b * albedo), c) + blend * d * std::pow(std::atan(e * albedo), f);
    return std::clamp(alpha, 0.f, 0.999999f);
}

bool walk_inside(const Surfaces& surfaces, const ShadingPoint& entry, const Lobe<float>& lobe, Vec3f throughput, WalkNumbers& numbers,
                 SubsurfaceExit& exit, uint64_t& rays) {
    const float anisotropy = std::clamp(lobe.p[8], 0.f, 0.9f);
    Vec3f alpha, sigma_t;
    for (int c = 0; c < 3; ++c) {
        const float albedo = std::clamp(lobe.p[3 + c], 0.f, 1.f);
        alpha[c] = single_scattering_albedo(albedo, anisotropy);
        sigma_t[c] = 1 / std::max(lobe.p[c], 1e-16f) / (1 - anisotropy);
        // The weight has the albedo in it, which the walk brings in again.
        throughput[c] = albedo > 0 ? throughput[c] / albedo : 0.f;
        // A nearly black body has no usable diffusion length: darken the weight instead.
        if (alpha[c] < 0.2f) {
            throughput[c] *= alpha[c] / 0.2f;
            alpha[c] = 0.2f;
        }
    }
    if (!is_finite(throughput) || is_black(throughput)) return false;
    const Dwivedi guide(std::max({alpha.x, alpha.y, alpha.z}));
    if (!guide.usable()) return false;

    Vec3f direction;
    const Sample4& first = numbers.first();
    if (!enter(entry, lobe, first.u[0], first.u[1], direction) || !(dot(entry.ng, direction) < 0)) return false;
    const Vec3f n = entry.n;

    Coefficients as_given, reduced;
    as_given.sigma_t = sigma_t;
    as_given.sigma_s = sigma_t * alpha;
    as_given.g = anisotropy;
    as_given.guided = 1 - std::max(0.5f, std::pow(anisotropy, 0.125f));
    reduced.sigma_s = as_given.sigma_s * (1 - anisotropy);
    reduced.sigma_t = sigma_t - as_given.sigma_s + reduced.sigma_s;
    reduced.guided = 0.75f;

    // From the surface itself: a start moved off it by its rounding error would lengthen the way out of a dense body. The first ray
    // overlooks what is that near instead.
    Vec3f p = entry.p;
    const Vec3f start = p;
    const float clear = entry.error / std::max(-dot(entry.ng, direction), 1e-3f);
    bool opposite = false;  // the body is thin here: a second surface was seen at the first step
    float thickness = 0;
    for (int step = 0; step < kMostSteps; ++step) {
        const Coefficients& m = step < kAnisotropicSteps ? as_given : reduced;
        float u_channel = step == 0 ? first.u[2] : numbers.next();
        const float u_distance = step == 0 ? first.u[3] : numbers.next();
        Vec3f channel_density;
        const int channel = choose_channel(throughput * alpha, u_channel, channel_density);
        float sigma = m.sigma_t[channel];

        float backward_share = 0, forward_factor = 0, backward_factor = 0, forward_stretch = 1, backward_stretch = 1;
        if (step > 0) {
            const bool guided = numbers.next() < m.guided;
            bool backward = false;
            if (opposite) {
                const float depth = std::clamp(-dot(p - start, n), 0.f, thickness);
                backward_share = 1 / (1 + std::exp((thickness - 2 * depth) / guide.length));
                backward = numbers.next() < backward_share;
            }
            const float u1 = numbers.next(), u2 = numbers.next();
            float cos_theta;  // to the normal
            Vec3f next;
            if (guided) {
                cos_theta = guide.sample(u1);
                if (backward) cos_theta = -cos_theta;
                next = direction_about(n, cos_theta, u2);
            } else {
                next = direction_about(direction, sample_henyey_greenstein(m.g, u1), u2);
                cos_theta = std::clamp(dot(next, n), -1.f, 1.f);
            }
            const float phase = henyey_greenstein(dot(direction, next), m.g);
            direction = next;
            forward_factor = 0.5f * kInvPi * guide.density(cos_theta) / phase;
            backward_factor = 0.5f * kInvPi * guide.density(-cos_theta) / phase;
            forward_stretch = 1 - cos_theta / guide.length;
            backward_stretch = 1 + cos_theta / guide.length;
            if (guided) sigma *= backward ? backward_stretch : forward_stretch;
        }

        float t = -std::log1p(-u_distance) / sigma;
        if (!std::isfinite(t)) return false;
        const float longest = step == 0 ? std::max(t, 10 / std::min({m.sigma_t.x, m.sigma_t.y, m.sigma_t.z})) : t;
        ++rays;
        bool surface = surfaces.accel().intersect_instance(entry.instance, {p, direction, step == 0 ? clear : 0.f, std::max(clear, std::min(longest, 1e30f)), entry.time}, exit.hit);
        if (step == 0 && surface) {
            opposite = true;
            thickness = std::max(dot(p + direction * exit.hit.t - start, -n), 0.f);
            surface = exit.hit.t < t;
        }
        if (surface) t = exit.hit.t;
        p = p + direction * t;

        const Vec3f passed = transmittance(m.sigma_t, t);
        Vec3f density = surface ? passed : m.sigma_t * passed;
        if (step > 0) {
            Vec3f guided_density = distance_density(m.sigma_t * forward_stretch, t, surface) * forward_factor;
            if (opposite)
                guided_density = lerp(guided_density, distance_density(m.sigma_t * backward_stretch, t, surface) * backward_factor, backward_share);
            density = lerp(density, guided_density, m.guided);
        }
        const float all = dot(channel_density, density);
        if (!(all > 0)) return false;
        throughput *= (surface ? passed : m.sigma_s * passed) / all;
        if (!is_finite(throughput)) return false;
        if (surface) {
            exit.direction = -direction;
            exit.throughput = throughput;
            return true;
        }
        if (std::max({throughput.x, throughput.y, throughput.z}) < kNegligible) return false;
    }
    return false;
}

}  // namespace alder
