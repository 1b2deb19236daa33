// LightSelector: bounds of what an emitter can do for a point, and the choice by them.
#include "render/light/selector.h"

#include <algorithm>
#include <cmath>

#include "render/sampling.h"

namespace alder {
namespace {

/// Never zero where the emitter can reach p: bounds are conservative, with a margin for rounding.
float importance(const EmitterBounds& e, Vec3f p) {
    if (e.distant) return e.irradiance;
    const Vec3f d = p - e.center;
    const float d2 = dot(d, d), r2 = e.radius * e.radius;
    const float base = e.intensity / std::max({d2, r2, 1e-20f});
    if (e.cos_spread <= -1 || d2 <= r2) return base;
    // Smallest angle between the axis and a direction from some point of the sphere to p: theta - theta_u.
    const float inverse = 1 / std::sqrt(d2), cos_theta = dot(d, e.axis) * inverse;
    const float sin_u = std::min(e.radius * inverse + 1e-3f, 1.f), cos_u = safe_sqrt(1 - sin_u * sin_u);
    const float sin_theta = safe_sqrt(1 - cos_theta * cos_theta);
    const float nearest = cos_theta >= cos_u ? 1 : cos_theta * cos_u + sin_theta * sin_u;
    if (nearest < e.cos_spread) return 0;
    return e.lambertian ? base * std::max(nearest, 0.f) : base;
}

}  // namespace

std::vector<float> cumulative_table(std::span<const double> weights) {
    double total = 0;
    for (const double w : weights) total += w;
    if (!(total > 0) || !std::isfinite(total)) return {};
    std::vector<float> cdf{0.f};
    double sum = 0;
    for (const double w : weights) {
        sum += w;
        cdf.push_back(static_cast<float>(sum / total));
    }
    cdf.back() = 1;
    return cdf;
}

size_t pick_from_table(const std::vector<float>& cdf, float& u) {
    const auto it = std::upper_bound(cdf.begin() + 1, cdf.end() - 1, u);
    const size_t i = static_cast<size_t>(it - cdf.begin()) - 1;
    const float step = cdf[i + 1] - cdf[i];
    u = step > 0 ? std::clamp((u - cdf[i]) / step, 0.f, 0.99999994f) : 0.f;
    return i;
}

LightSelector::LightSelector(std::vector<EmitterBounds> emitters) : emitters_(std::move(emitters)) {
    std::vector<double> powers;
    for (const EmitterBounds& e : emitters_) powers.push_back(std::isfinite(e.power) ? std::clamp(e.power, 0.f, 1e30f) : 0.f);
    cdf_ = cumulative_table(powers);
    if (cdf_.empty()) emitters_.clear();
}

int LightSelector::pick(Vec3f p, float& u, float& probability) const {
    if (by_power()) {
        const size_t i = pick_from_table(cdf_, u);
        probability = cdf_[i + 1] - cdf_[i];
        return probability > 0 ? static_cast<int>(i) : -1;
    }
    float weight[kWeighAll], total = 0;
    const size_t n = emitters_.size();
    for (size_t i = 0; i < n; ++i) total += weight[i] = importance(emitters_[i], p);
    if (!(total > 0) || !std::isfinite(total)) return -1;
    float left = u * total;
    size_t i = 0;
    while (i + 1 < n && left >= weight[i]) left -= weight[i++];
    if (!(weight[i] > 0)) return -1;  // rounding ran past the last emitter that counts
    u = std::clamp(left / weight[i], 0.f, 0.99999994f);
    probability = weight[i] / total;
    return static_cast<int>(i);
}

float LightSelector::probability(Vec3f p, uint32_t emitter) const {
    if (emitters_.empty()) return 0;
    if (by_power()) return cdf_[emitter + 1] - cdf_[emitter];
    float total = 0, mine = 0;
    for (size_t i = 0; i < emitters_.size(); ++i) {
        const float w = importance(emitters_[i], p);
        total += w;
        if (i == emitter) mine = w;
    }
    return total > 0 && std::isfinite(total) ? mine / total : 0.f;
}

}  // namespace alder
