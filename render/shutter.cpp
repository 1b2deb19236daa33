// Shutter: inversion of a piecewise linear density.
#include "render/shutter.h"

#include <algorithm>
#include <cmath>

namespace alder {

Shutter::Shutter(const std::vector<float>& curve) {
    if (curve.size() < 2 || std::adjacent_find(curve.begin(), curve.end(), std::not_equal_to<>()) == curve.end()) return;
    std::vector<double> sums{0};
    for (size_t i = 0; i + 1 < curve.size(); ++i) sums.push_back(sums.back() + 0.5 * (double(std::max(curve[i], 0.f)) + std::max(curve[i + 1], 0.f)));
    if (!(sums.back() > 0) || !std::isfinite(sums.back())) return;
    for (size_t i = 0; i < curve.size(); ++i) {
        open_.push_back(static_cast<float>(std::max(curve[i], 0.f) / sums.back()));
        integral_.push_back(static_cast<float>(sums[i] / sums.back()));
    }
}

float Shutter::time(float u) const {
    if (integral_.empty()) return u;
    const size_t pieces = integral_.size() - 1;
    const size_t i = std::min<size_t>(std::max<std::ptrdiff_t>(std::upper_bound(integral_.begin(), integral_.end(), u) - integral_.begin(), 1) - 1, pieces - 1);
    // a x + (b - a) x^2 / 2 = what is left; the form that does not cancel for b near a.
    const float a = open_[i], slope = open_[i + 1] - a, rest = std::max(u - integral_[i], 0.f);
    const float root = a + std::sqrt(std::max(a * a + 2 * slope * rest, 0.f));
    const float x = root > 0 ? std::clamp(2 * rest / root, 0.f, 1.f) : 0.f;
    return (static_cast<float>(i) + x) / static_cast<float>(pieces);
}

}  // namespace alder
