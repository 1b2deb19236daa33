// HDR-FLIP: exposures of both pictures, tone mapped, each pair compared as an observer at the screen would see it.
//
// Section numbers are those of the HPG 2020 paper; "HDR" marks the EGSR 2021 one. Filters are separable: the blue-yellow one is
// a sum of two Gaussians, so it is filtered as two, each with the square root of its weight a direction.
#include "clients/cli/compare/flip.h"

#include <algorithm>
#include <cmath>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace alder::cli {
namespace {

using Plane = std::vector<float>;
using Rgb = std::array<float, 3>;

constexpr float kPi = 3.14159265358979f;
// Section 4: exponent of the colour difference, the share of its range that takes most of the scale, and that most of the scale.
constexpr float kColorExponent = 0.7f, kColorKnee = 0.4f, kColorKneeValue = 0.95f;
// Section 4.2: width of an edge in degrees, exponent of the feature difference.
constexpr float kEdgeDegrees = 0.082f, kFeatureExponent = 0.5f;
// White of D65 as the sum of the rows of the matrix below.
constexpr Rgb kWhite{0.950428545f, 1.f, 1.088900371f}, kWhiteInverse{1.052156925f, 1.f, 0.918357670f};

Rgb xyz_from_rgb(const Rgb& c) {
    return {(10135552.f * c[0] + 8788810.f * c[1] + 4435075.f * c[2]) / 24577794.f, (2613072.f * c[0] + 8788810.f * c[1] + 887015.f * c[2]) / 12288897.f,
            (1425312.f * c[0] + 8788810.f * c[1] + 70074185.f * c[2]) / 73733382.f};
}

Rgb rgb_from_xyz(const Rgb& c) {
    return {3.241003275f * c[0] - 1.537398934f * c[1] - 0.498615861f * c[2], -0.969224334f * c[0] + 1.875930071f * c[1] + 0.041554224f * c[2],
            0.055639423f * c[0] - 0.204011202f * c[1] + 1.057148933f * c[2]};
}

/// A linear cousin of CIELAB, so that filtering is linear too.
Rgb ycxcz_from_rgb(const Rgb& c) {
    const Rgb v = xyz_from_rgb(c);
    const float x = v[0] * kWhiteInverse[0], y = v[1] * kWhiteInverse[1], z = v[2] * kWhiteInverse[2];
    return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

Rgb rgb_from_ycxcz(const Rgb& c) {
    const float y = (c[0] + 16) / 116, x = y + c[1] / 500, z = y - c[2] / 200;
    return rgb_from_xyz({x * kWhite[0], y * kWhite[1], z * kWhite[2]});
}

float lab_curve(float t) {
    constexpr float kDelta = 6.f / 29;
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.f / 29;
}

/// CIELAB, with chroma that fades with lightness (the Hunt effect, section 4.1.3).
Rgb hunt_lab(const Rgb& rgb) {
    const Rgb v = xyz_from_rgb(rgb);
    const float x = lab_curve(v[0] * kWhiteInverse[0]), y = lab_curve(v[1] * kWhiteInverse[1]), z = lab_curve(v[2] * kWhiteInverse[2]);
    const float lightness = 116 * y - 16;
    return {lightness, 0.01f * lightness * 500 * (x - y), 0.01f * lightness * 200 * (y - z)};
}

/// City block in lightness, Euclidean in chroma.
float hyab(const Rgb& a, const Rgb& b) { return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]); }

struct Filters {
    int color_radius = 0, feature_radius = 0;
    Plane y, cx, cz1, cz2;              ///< contrast sensitivity of the eye, section 4.1.1
    Plane gauss, first, second;         ///< edges and points, section 4.2
};

Filters make_filters(float ppd) {
    Filters f;
    const auto gaussian = [](float x2, float a, float b) { return a * std::sqrt(kPi / b) * std::exp(-kPi * kPi * x2 / b); };
    const auto root = [](float x2, float a, float b) { return std::sqrt(a * std::sqrt(kPi / b)) * std::exp(-kPi * kPi * x2 / b); };
    f.color_radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04f / (2 * kPi * kPi)) * ppd));
    float sum_y = 0, sum_x = 0, sum_1 = 0, sum_2 = 0;
    for (int i = -f.color_radius; i <= f.color_radius; ++i) {
        const float x2 = (i / ppd) * (i / ppd);
        sum_y += f.y.emplace_back(gaussian(x2, 1, 0.0047f));
        sum_x += f.cx.emplace_back(gaussian(x2, 1, 0.0053f));
        sum_1 += f.cz1.emplace_back(root(x2, 34.1f, 0.04f));
        sum_2 += f.cz2.emplace_back(root(x2, 13.5f, 0.025f));
    }
    for (float& v : f.y) v /= sum_y;
    for (float& v : f.cx) v /= sum_x;
    const float norm = std::hypot(sum_1, sum_2);
    for (float& v : f.cz1) v /= norm;
    for (float& v : f.cz2) v /= norm;

    const float deviation = 0.5f * kEdgeDegrees * ppd;
    f.feature_radius = static_cast<int>(std::ceil(3 * deviation));
    float sum_g = 0, positive_1 = 0, negative_1 = 0, positive_2 = 0, negative_2 = 0;
    for (int i = -f.feature_radius; i <= f.feature_radius; ++i) {
        const float x = static_cast<float>(i), g = std::exp(-x * x / (2 * deviation * deviation));
        const float d = -x * g, dd = (x * x / (deviation * deviation) - 1) * g;
        sum_g += f.gauss.emplace_back(g);
        f.first.push_back(d);
        f.second.push_back(dd);
        (d > 0 ? positive_1 : negative_1) += std::abs(d);
        (dd > 0 ? positive_2 : negative_2) += std::abs(dd);
    }
    for (float& v : f.gauss) v /= sum_g;
    for (float& v : f.first) v /= v > 0 ? positive_1 : negative_1;
    for (float& v : f.second) v /= v > 0 ? positive_2 : negative_2;
    return f;
}

/// Sum over a row or a column; pixels beyond the edge are those at the edge.
class Convolution {
  public:
    Convolution(int width, int height) : width_(width), height_(height) {}
    void rows(const Plane& from, const Plane& weights, Plane& to) const {
        each_row([&](int y) {
            for (int x = 0; x < width_; ++x) {
                float sum = 0;
                const int r = static_cast<int>(weights.size()) / 2;
                for (int i = -r; i <= r; ++i) sum += weights[size_t(i + r)] * from[at(std::clamp(x + i, 0, width_ - 1), y)];
                to[at(x, y)] = sum;
            }
        });
    }
    void columns(const Plane& from, const Plane& weights, Plane& to, bool add = false) const {
        each_row([&](int y) {
            const int r = static_cast<int>(weights.size()) / 2;
            if (!add) std::fill_n(to.begin() + std::ptrdiff_t(at(0, y)), width_, 0.f);
            for (int i = -r; i <= r; ++i) {
                const size_t source = at(0, std::clamp(y + i, 0, height_ - 1));
                for (int x = 0; x < width_; ++x) to[at(x, y)] += weights[size_t(i + r)] * from[source + size_t(x)];
            }
        });
    }
    template <class Body>
    void each_row(const Body& body) const {
        tbb::parallel_for(tbb::blocked_range<int>(0, height_), [&](const tbb::blocked_range<int>& range) {
            for (int y = range.begin(); y < range.end(); ++y) body(y);
        });
    }
    size_t at(int x, int y) const { return size_t(y) * size_t(width_) + size_t(x); }

  private:
    int width_, height_;
};

/// What the eye takes from one picture: colours blurred as it blurs them, and the strength of edges and points.
struct Percept {
    std::array<Plane, 3> lab;
    Plane edge, point;
};

float aces(float x) {
    // Narkowicz's fit, with the 0.6 that cancels its exposure (HDR, section 3).
    return std::clamp((0.36f * 2.51f * x * x + 0.6f * 0.03f * x) / (0.36f * 2.43f * x * x + 0.6f * 0.59f * x + 0.14f), 0.f, 1.f);
}

Percept perceive(const RgbPlanes& picture, float scale, const Filters& f, const Convolution& c, size_t pixels) {
    std::array<Plane, 3> opponent;   // Y, Cx, Cz
    for (Plane& p : opponent) p.resize(pixels);
    Plane grey(pixels);
    const auto channel = [&](int k, size_t i) {
        const float v = (*picture[size_t(k)])[i];
        return std::isfinite(v) && v > 0 ? aces(std::min(v * scale, 1e9f)) : 0.f;   // above, the curve has long reached its end
    };
    for (size_t i = 0; i < pixels; ++i) {
        const Rgb o = ycxcz_from_rgb({channel(0, i), channel(1, i), channel(2, i)});
        for (size_t k = 0; k < 3; ++k) opponent[k][i] = o[k];
        grey[i] = (o[0] + 16) / 116;
    }
    Percept out;
    Plane pass(pixels), blurred_y(pixels), blurred_x(pixels), blurred_z(pixels);
    c.rows(opponent[0], f.y, pass);
    c.columns(pass, f.y, blurred_y);
    c.rows(opponent[1], f.cx, pass);
    c.columns(pass, f.cx, blurred_x);
    c.rows(opponent[2], f.cz1, pass);
    c.columns(pass, f.cz1, blurred_z);
    c.rows(opponent[2], f.cz2, pass);
    c.columns(pass, f.cz2, blurred_z, true);
    for (Plane& p : out.lab) p.resize(pixels);
    tbb::parallel_for(tbb::blocked_range<size_t>(0, pixels, 4096), [&](const tbb::blocked_range<size_t>& range) {
        for (size_t i = range.begin(); i < range.end(); ++i) {
            Rgb rgb = rgb_from_ycxcz({blurred_y[i], blurred_x[i], blurred_z[i]});
            for (float& v : rgb) v = std::clamp(v, 0.f, 1.f);
            const Rgb lab = hunt_lab(rgb);
            for (size_t k = 0; k < 3; ++k) out.lab[k][i] = lab[k];
        }
    });

    // Section 4.2: gradients and second derivatives, each along one axis and smoothed along the other.
    Plane& dx = blurred_y;
    Plane& dy = blurred_x;
    Plane smooth(pixels);
    c.rows(grey, f.gauss, smooth);
    const auto magnitude = [&](const Plane& derivative, Plane& to) {
        c.rows(grey, derivative, pass);
        c.columns(pass, f.gauss, dx);
        c.columns(smooth, derivative, dy);
        to.resize(pixels);
        for (size_t i = 0; i < pixels; ++i) to[i] = std::sqrt(dx[i] * dx[i] + dy[i] * dy[i]);
    };
    magnitude(f.first, out.edge);
    magnitude(f.second, out.point);
    return out;
}

/// HDR, section 4: the exposures at which the reference's brightest pixel and its median leave the range of the curve.
void exposure_range(const RgbPlanes& reference, size_t pixels, float& start, float& stop) {
    // Where the curve reaches 0.85.
    constexpr float kTarget = 0.85f;
    constexpr float kA = 0.36f * (2.51f - kTarget * 2.43f), kB = 0.6f * (0.03f - kTarget * 0.59f), kC = -kTarget * 0.14f;
    const float half = -0.5f * kB / kA, x = half + std::sqrt(half * half - kC / kA);
    std::vector<float> luminance(pixels);
    const auto value = [&](size_t k, size_t i) {
        const float v = (*reference[k])[i];
        return std::isfinite(v) ? std::max(v, 0.f) : 0.f;
    };
    for (size_t i = 0; i < pixels; ++i) luminance[i] = 0.2126f * value(0, i) + 0.7152f * value(1, i) + 0.0722f * value(2, i);
    const float brightest = std::min(*std::max_element(luminance.begin(), luminance.end()), 1e30f);
    start = stop = 0;
    if (!(brightest > 0)) return;
    auto middle = luminance.begin() + std::ptrdiff_t(pixels / 2);
    std::nth_element(luminance.begin(), middle, luminance.end());
    if (!(*middle > 0)) {
        // More than half of the picture is black: the median of what is not. (The authors' program finds no exposure then.)
        luminance.erase(std::remove_if(luminance.begin(), luminance.end(), [](float v) { return !(v > 0); }), luminance.end());
        middle = luminance.begin() + std::ptrdiff_t(luminance.size() / 2);
        std::nth_element(luminance.begin(), middle, luminance.end());
    }
    start = std::log2(x / brightest);
    stop = std::log2(x / std::clamp(*middle, 1e-30f, brightest));
}

}  // namespace

std::vector<float> hdr_flip(const RgbPlanes& test, const RgbPlanes& reference, int width, int height, float pixels_per_degree) {
    const size_t pixels = size_t(width) * size_t(height);
    std::vector<float> worst(pixels, 0.f);
    if (pixels == 0) return worst;
    const Filters filters = make_filters(pixels_per_degree);
    const Convolution convolution(width, height);
    const float largest = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), kColorExponent), knee = kColorKnee * largest;
    float start = 0, stop = 0;
    exposure_range(reference, pixels, start, stop);
    const int exposures = static_cast<int>(std::max(2.f, std::ceil(stop - start)));
    for (int e = 0; e < exposures; ++e) {
        const float scale = std::exp2(start + static_cast<float>(e) * (stop - start) / static_cast<float>(exposures - 1));
        const Percept a = perceive(reference, scale, filters, convolution, pixels), b = perceive(test, scale, filters, convolution, pixels);
        tbb::parallel_for(tbb::blocked_range<size_t>(0, pixels, 4096), [&](const tbb::blocked_range<size_t>& range) {
            for (size_t i = range.begin(); i < range.end(); ++i) {
                float color = std::pow(hyab({a.lab[0][i], a.lab[1][i], a.lab[2][i]}, {b.lab[0][i], b.lab[1][i], b.lab[2][i]}), kColorExponent);
                color = color < knee ? color * kColorKneeValue / knee : kColorKneeValue + (color - knee) / (largest - knee) * (1 - kColorKneeValue);
                const float feature = std::max(std::abs(a.edge[i] - b.edge[i]), std::abs(a.point[i] - b.point[i])) / std::sqrt(2.f);
                worst[i] = std::max(worst[i], std::pow(color, 1 - std::pow(feature, kFeatureExponent)));
            }
        });
    }
    return worst;
}

}  // namespace alder::cli
