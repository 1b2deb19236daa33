// Pixel filter: inverse cumulative tables of Blender's filters.
#include "render/filter.h"

#include <algorithm>
#include <cmath>

namespace alder {
namespace {
constexpr int kCdfSteps = 8192, kTableSize = 1025;
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
    const double support = box_width_ * (kind == RenderSettings::Filter::Gaussian ? 3.0 : 2.0);
    std::vector<double> cdf(kCdfSteps + 1, 0.0);
    for (int i = 0; i < kCdfSteps; ++i) {
        const double x = ((i + 0.5) / kCdfSteps - 0.5) * support;
        cdf[i + 1] = cdf[i] + std::max(0.0, curve(kind, x, support));
    }
    for (double& c : cdf) c /= cdf.back();
    inverse_cdf_.resize(kTableSize);
    size_t k = 0;
    for (int i = 0; i < kTableSize; ++i) {
        const double target = double(i) / (kTableSize - 1);
        while (k + 1 < cdf.size() - 1 && cdf[k + 1] < target) ++k;
        const double step = cdf[k + 1] - cdf[k];
        const double f = step > 0 ? std::clamp((target - cdf[k]) / step, 0.0, 1.0) : 0.5;
        inverse_cdf_[i] = static_cast<float>(((k + f) / kCdfSteps - 0.5) * support);
    }
}

float PixelFilter::offset(float u) const {
    if (inverse_cdf_.empty()) return box_width_ * (u - 0.5f);
    const float x = u * (kTableSize - 1);
    const int i = std::min(static_cast<int>(x), kTableSize - 2);
    const float f = x - static_cast<float>(i);
    return inverse_cdf_[i] + f * (inverse_cdf_[i + 1] - inverse_cdf_[i]);
}

}  // namespace alder
