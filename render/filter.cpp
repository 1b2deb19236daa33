// Pixel filter: cumulative tables of Blender's filters.
#include "render/filter.h"

#include <algorithm>
#include <cmath>

namespace alder {
namespace {
constexpr int kSteps = 1024;
constexpr double kPi = 3.14159265358979323846;

/// Blender's filter curves; `width` is the setting, the support is a multiple of it.
double curve(RenderSettings::Filter kind, double x, double support) {
    if (kind == RenderSettings::Filter::Gaussian) {
        const double v = 6 * x / support;
        return std::exp(-2 * v * v);
    }
    // Harris, "On the use of windows for harmonic analysis", 1978: the minimum four-term window.
    const double v = 2 * kPi * (x / support + 0.5);
    return 0.35875 - 0.48829 * std::cos(v) + 0.14128 * std::cos(2 * v) - 0.01168 * std::cos(3 * v);
}
}  // namespace

PixelFilter::PixelFilter(RenderSettings::Filter kind, float width_pixels) {
    box_width_ = std::isfinite(width_pixels) ? std::clamp(width_pixels, 0.f, 64.f) : 1.f;
    if (kind == RenderSettings::Filter::Box || box_width_ == 0) return;
    support_ = box_width_ * (kind == RenderSettings::Filter::Gaussian ? 3.f : 2.f);
    std::vector<double> cdf(kSteps + 1, 0.0);
    for (int i = 0; i < kSteps; ++i) {
        const double x = ((i + 0.5) / kSteps - 0.5) * support_;
        cdf[i + 1] = cdf[i] + std::max(0.0, curve(kind, x, support_));
    }
    for (const double c : cdf) cdf_.push_back(static_cast<float>(c / cdf.back()));
}

// Searched, not tabulated the other way round: a table over u would smear the tails, where a step of u spans half the support.
float PixelFilter::offset(float u) const {
    if (cdf_.empty()) return box_width_ * (u - 0.5f);
    const auto it = std::upper_bound(cdf_.begin() + 1, cdf_.end() - 1, u);
    const size_t i = static_cast<size_t>(it - cdf_.begin()) - 1;
    const float step = cdf_[i + 1] - cdf_[i];
    const float inside = step > 0 ? std::clamp((u - cdf_[i]) / step, 0.f, 1.f) : 0.5f;
    return ((static_cast<float>(i) + inside) / kSteps - 0.5f) * support_;
}

}  // namespace alder
