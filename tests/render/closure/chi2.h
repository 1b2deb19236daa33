// Chi-squared test of directions against a density on the sphere.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "render/closure/bsdf.h"
#include "render/closure/frame.h"

namespace alder::testing {

using closure::kPi;

/// Cells of equal area about an axis, on a sphere stretched so that narrow lobes fill many of them: the polar coordinate is
/// s = (1-c)/2 warped to s^(1/warp).
struct Cells {
    static constexpr int kRows = 24, kColumns = 32;
    closure::Frame<double> frame;
    double warp;
    int at(Vec3d w) const {
        const Vec3d l = frame.to_local(w);
        const double s = std::clamp((l.x * l.x + l.y * l.y) / (2 * (1 + std::abs(l.z))), 0.0, 0.5);
        const double polar = l.z >= 0 ? s : 1 - s;
        const int row = std::min(static_cast<int>(std::pow(polar, 1 / warp) * kRows), kRows - 1);
        const double phi = std::atan2(l.y, l.x) / (2 * kPi<double>) + 0.5;
        return row * kColumns + std::min(static_cast<int>(phi * kColumns), kColumns - 1);
    }
    Vec3d direction(double row, double column, double& jacobian) const {
        const double u = row / kRows, s = std::pow(u, warp), z = 1 - 2 * s, r = 2 * std::sqrt(std::max(s * (1 - s), 0.0));
        const double phi = (column / kColumns - 0.5) * 2 * kPi<double>;
        jacobian = 2 * warp * std::pow(u, warp - 1) / kRows * 2 * kPi<double> / kColumns;
        return frame.to_world({r * std::cos(phi), r * std::sin(phi), z});
    }
};

/// Probability that a chi-squared variable of k degrees exceeds x: Wilson and Hilferty's normal approximation.
inline double chi2_tail(double x, double k) {
    const double t = (std::cbrt(x / k) - (1 - 2 / (9 * k))) / std::sqrt(2 / (9 * k));
    return 0.5 * std::erfc(t / std::sqrt(2.0));
}

/// Midpoint rule over a square of cell coordinates.
template <class Pdf>
double midpoint(const Pdf& pdf, const Cells& cells, double row, double column, double size) {
    const int n = 4;
    double sum = 0;
    for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) {
            double jacobian;
            const Vec3d wi = cells.direction(row + size * (a + 0.5) / n, column + size * (b + 0.5) / n, jacobian);
            sum += pdf(wi) * jacobian;
        }
    return sum * size * size / (n * n);
}
/// The density integrated over the square, refined where halving it still changes the result.
template <class Pdf>
double integrate(const Pdf& pdf, const Cells& cells, double row, double column, double size, int depth) {
    const double h = size / 2, coarse = midpoint(pdf, cells, row, column, size);
    double fine = 0;
    for (int q = 0; q < 4; ++q) fine += midpoint(pdf, cells, row + h * (q & 1), column + h * (q >> 1), h);
    if (depth == 6 || std::abs(fine - coarse) < 4e-7 + 3e-4 * fine) return fine;
    fine = 0;
    for (int q = 0; q < 4; ++q) fine += integrate(pdf, cells, row + h * (q & 1), column + h * (q >> 1), h, depth + 1);
    return fine;
}

/// Draws `samples` from sample() (a BsdfSample) and compares their distribution with pdf(wi). Delta samples are one cell and
/// rejected ones another, without expectation of their own; all cells sum to 1. Fails where p < significance.
template <class Pdf, class Sample>
void expect_samples_follow_density(const Pdf& pdf, const Sample& sample, int samples, double significance, const std::string& text) {
    // Cells narrow towards the direction of the highest density.
    Vec3d axis(0, 0, 1);
    double density = 0;
    for (int i = 0; i < 200; ++i) {
        const BsdfSample<double> x = sample();
        if (x.valid && !x.is_delta && x.pdf > density) density = x.pdf, axis = x.wi;
    }
    const Cells cells{closure::frame_around(axis), 2.5};
    const int count = Cells::kRows * Cells::kColumns;
    std::vector<double> expected(count, 0.0), observed(count, 0.0);
    for (int row = 0; row < Cells::kRows; ++row)
        for (int column = 0; column < Cells::kColumns; ++column)
            expected[row * Cells::kColumns + column] = integrate(pdf, cells, row, column, 1, 0);
    double outside = 0, total = 0;
    for (int k = 0; k < samples; ++k) {
        const BsdfSample<double> x = sample();
        if (x.valid && !x.is_delta) ++observed[cells.at(x.wi)];
        else ++outside;
    }
    for (double e : expected) total += e;
    const double rest = outside / samples;
    // `rest` is a binomial estimate: 4.5 standard deviations, and the quadrature's own error.
    EXPECT_NEAR(total + rest, 1, 4.5 * std::sqrt(rest * (1 - rest) / samples) + 2e-3) << text;
    expected.push_back(std::max(1 - total, 0.0));
    observed.push_back(outside);
    double chi2 = 0, pooled_expected = 0, pooled_observed = 0;
    int degrees = -1;
    for (size_t k = 0; k < expected.size(); ++k) {
        const double e = expected[k] * samples;
        if (e < 12) {
            pooled_expected += e;
            pooled_observed += observed[k];
            continue;
        }
        chi2 += (observed[k] - e) * (observed[k] - e) / e;
        ++degrees;
    }
    if (pooled_expected > 12) {
        chi2 += (pooled_observed - pooled_expected) * (pooled_observed - pooled_expected) / pooled_expected;
        ++degrees;
    }
    if (rest < 0.9) {
        EXPECT_GT(degrees, 3) << text;
    }
    if (degrees < 1) return;
    EXPECT_GT(chi2_tail(chi2, degrees), significance) << text << " chi2 " << chi2 << " of " << degrees;
}

}  // namespace alder::testing
