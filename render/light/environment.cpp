// EnvironmentMap: construction and lookups.
#include "render/light/environment.h"

#include <algorithm>
#include <cmath>

#include "render/sampling.h"

namespace alder {
namespace {

/// Index i with table[i] <= u < table[i+1], and the place in between.
int find_cell(const float* table, int n, float u, float& inside) {
    const float* const it = std::upper_bound(table, table + n + 1, u);
    const int i = std::clamp(static_cast<int>(it - table) - 1, 0, n - 1);
    const float step = table[i + 1] - table[i];
    inside = step > 0 ? std::clamp((u - table[i]) / step, 0.f, 0.99999994f) : 0.5f;
    return i;
}

}  // namespace

Vec3f EnvironmentMap::cell_direction(int width, int height, int x, int y) {
    const float theta = kPi * (static_cast<float>(y) + 0.5f) / static_cast<float>(height);
    const float phi = 2 * kPi * (static_cast<float>(x) + 0.5f) / static_cast<float>(width);
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

EnvironmentMap::EnvironmentMap(int width, int height, const std::vector<Vec3f>& radiance)
    : width_(width), height_(height), rows_(height + 1, 0.f), cells_(size_t(width + 1) * height, 0.f), density_(radiance.size(), 0.f) {
    const double d_phi = 2 * 3.14159265358979 / width;
    const auto solid_angle = [&](int y) {  // of one cell: exact, so that densities integrate to one
        return d_phi * (std::cos(3.14159265358979 * y / height) - std::cos(3.14159265358979 * (y + 1) / height));
    };
    double total = 0;
    std::vector<double> row(height, 0.0);
    for (int y = 0; y < height; ++y) {
        double sum = 0;
        for (int x = 0; x < width; ++x) {
            const float l = luminance(radiance[size_t(y) * width + x]);
            const float value = std::isfinite(l) ? std::clamp(l, 0.f, 1e18f) : 0.f;
            density_[size_t(y) * width + x] = value;
            sum += value;
            cells_[size_t(y) * (width + 1) + x + 1] = static_cast<float>(sum);
        }
        for (int x = 1; x <= width; ++x) cells_[size_t(y) * (width + 1) + x] *= sum > 0 ? static_cast<float>(1 / sum) : 0.f;
        row[y] = sum * solid_angle(y);
        total += row[y];
    }
    total_ = std::isfinite(total) ? static_cast<float>(std::min(total, 1e30)) : 0.f;
    if (total_ <= 0) return;
    double sum = 0;
    for (int y = 0; y < height; ++y) {
        sum += row[y];
        rows_[y + 1] = static_cast<float>(sum / total);
    }
    for (float& d : density_) d = static_cast<float>(d / total);
}

Vec3f EnvironmentMap::sample(float u1, float u2, float& pdf) const {
    float fx, fy;
    const int y = find_cell(rows_.data(), height_, u2, fy);
    const int x = find_cell(cells_.data() + size_t(y) * (width_ + 1), width_, u1, fx);
    // Uniform in solid angle within the cell: uniform in cos theta and phi.
    const float c0 = std::cos(kPi * static_cast<float>(y) / static_cast<float>(height_));
    const float c1 = std::cos(kPi * static_cast<float>(y + 1) / static_cast<float>(height_));
    const float z = c0 + fy * (c1 - c0), r = safe_sqrt(1 - z * z);
    const float phi = 2 * kPi * (static_cast<float>(x) + fx) / static_cast<float>(width_);
    pdf = density_[size_t(y) * width_ + x];
    return {r * std::cos(phi), r * std::sin(phi), z};
}

float EnvironmentMap::pdf(Vec3f d) const {
    if (total_ <= 0) return 0;
    const float theta = std::acos(std::clamp(d.z, -1.f, 1.f));
    float phi = std::atan2(d.y, d.x);
    if (phi < 0) phi += 2 * kPi;
    const int y = std::clamp(static_cast<int>(theta * kInvPi * static_cast<float>(height_)), 0, height_ - 1);
    const int x = std::clamp(static_cast<int>(phi * (0.5f * kInvPi) * static_cast<float>(width_)), 0, width_ - 1);
    return density_[size_t(y) * width_ + x];
}

}  // namespace alder
