// The sigma figure: whether two noisy images can be the same picture.
#include <algorithm>
#include <cmath>

#include "clients/cli/compare/figures.h"

namespace alder::cli {
namespace {

constexpr int kSide = 16;   // pixels of a square: some hundred samples of noise, small against an object

/// Rounding of the stored value, so that pixels without noise may differ by it.
double rounding(double value, bool single_precision) {
    const double step = std::abs(value) * (single_precision ? 0x1p-22 : 0x1p-11) + 1e-7;
    return step * step;
}

/// |z| of the worst of n squares, less what the worst of n normal numbers reaches anyway.
double discounted(double worst, double n) {
    // Expected maximum of n half-normal numbers: sqrt(2 ln(2 n)) less a slowly falling term, which is left as margin.
    return worst - std::max(0.0, std::sqrt(2 * std::log(std::max(2 * n, 1.0))) - 1);
}

}  // namespace

std::optional<double> noise_sigma(const Image& test, const Image& reference, std::string& why_not) {
    std::string ignored;
    const LayerView x = find_layer(test, "beauty", ignored), r = find_layer(reference, "beauty", ignored);
    const Layer *vx = test.find("variance"), *vr = reference.find("variance");
    for (const auto& [image, layer] : {std::pair{"the test image", vx}, std::pair{"the reference", vr}})
        if (!layer || layer->planes.size() != 3) {
            why_not = std::string(image) + " has no layer 'variance': render with --aov variance";
            return std::nullopt;
        }
    if (x.planes.size() != 3 || r.planes.size() != 3) {
        why_not = "the images have no colour";
        return std::nullopt;
    }
    double sigma = 0;
    for (size_t c = 0; c < 3; ++c) {
        double sum = 0, variance = 0, squares = 0, chi = 0, worst = 0;
        for (int y0 = 0; y0 < test.height; y0 += kSide)
            for (int x0 = 0; x0 < test.width; x0 += kSide) {
                double d = 0, v = 0;
                for (int y = y0; y < std::min(y0 + kSide, test.height); ++y)
                    for (int i = x0; i < std::min(x0 + kSide, test.width); ++i) {
                        const size_t at = size_t(y) * size_t(test.width) + size_t(i);
                        const double a = (*x.planes[c])[at], b = (*r.planes[c])[at], va = vx->planes[c][at], vb = vr->planes[c][at];
                        if (!std::isfinite(a) || !std::isfinite(b) || !std::isfinite(va) || !std::isfinite(vb)) continue;
                        d += a - b;
                        v += std::max(va, 0.0) + std::max(vb, 0.0) + rounding(a, x.single_precision) + rounding(b, r.single_precision);
                    }
                if (v <= 0) continue;
                sum += d;
                variance += v;
                ++squares;
                chi += d * d / v;
                worst = std::max(worst, std::abs(d) / std::sqrt(v));
            }
        if (squares == 0) continue;
        sigma = std::max({sigma, std::abs(sum) / std::sqrt(variance), (chi - squares) / std::sqrt(2 * squares), discounted(worst, squares)});
    }
    return sigma;
}

}  // namespace alder::cli
