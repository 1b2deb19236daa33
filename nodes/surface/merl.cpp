// Reading MERL files.
#include "nodes/surface/merl.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>

namespace alder {
namespace {

constexpr double kPi = 3.14159265358979323846;
/// The database's unit of each channel.
constexpr double kScale[3] = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};

}  // namespace

double MerlTable::band_edge(int k) { return kPi / 2 * (k / 90.0) * (k / 90.0); }
int MerlTable::band_of(double theta_h) {
    // Not (int)NaN: anything that is not a number counts as 0.
    const double x = theta_h > 0 ? std::sqrt(std::min(theta_h / (kPi / 2), 1.0)) * kThetaH : 0;
    return std::min(static_cast<int>(x), kThetaH - 1);
}
int MerlTable::cell(double theta_h, double theta_d, double phi_d) {
    const auto index = [](double x, int n) { return x > 0 ? std::min(static_cast<int>(std::min(x, 1.0) * n), n - 1) : 0; };
    // Reciprocity: phi_d and phi_d + pi are one.
    if (phi_d < 0) phi_d += kPi;
    return index(phi_d / kPi, kPhiD) + kPhiD * (index(theta_d / (kPi / 2), kThetaD) + kThetaD * band_of(theta_h));
}

void MerlTable::set(const double* numbers) {
    values.resize(size_t{3} * kCells);
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < kCells; ++i) {
            const double v = numbers[size_t(c) * kCells + i] * kScale[c];
            values[size_t{3} * i + c] = std::isfinite(v) ? static_cast<float>(std::clamp(v, 0.0, 1e30)) : 0.f;
        }
    // A band's weight: its mean over the differences that a viewer at middling angles meets, times its projected area.
    band.assign(kThetaH, 0.0);
    double total = 0;
    for (int h = 0; h < kThetaH; ++h) {
        double mean = 0;
        for (int d = 0; d < 60; ++d)
            for (int p = 0; p < kPhiD; ++p) {
                const float* v = values.data() + size_t{3} * (p + kPhiD * (d + kThetaD * h));
                mean += (v[0] + v[1] + v[2]) / 3;
            }
        const double a = std::cos(band_edge(h)), b = std::cos(band_edge(h + 1));
        band[h] = std::min(mean / (60 * kPhiD), 1e12) * (a * a - b * b) / 2;
        total += band[h];
    }
    below.assign(kThetaH + 1, 0.0);
    for (int h = 0; h < kThetaH; ++h) {
        band[h] = total > 0 ? band[h] / total : std::cos(band_edge(h)) - std::cos(band_edge(h + 1));
        below[h + 1] = below[h] + band[h];
    }
}

std::shared_ptr<const MerlTable> read_merl(const std::string& path, std::string& error) {
    std::ifstream f(path, std::ios::binary);
    int32_t size[3];
    if (!f.read(reinterpret_cast<char*>(size), sizeof size)) {
        error = "no file of measured reflectance: shorter than its header";
        return nullptr;
    }
    if (size[0] != MerlTable::kThetaH || size[1] != MerlTable::kThetaD || size[2] != MerlTable::kPhiD) {
        error = "a table of " + std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " + std::to_string(size[2]) +
                " values, not of 90 x 90 x 180";
        return nullptr;
    }
    std::vector<double> numbers(size_t{3} * MerlTable::kCells);
    const auto bytes = static_cast<std::streamsize>(numbers.size() * sizeof(double));
    if (!f.read(reinterpret_cast<char*>(numbers.data()), bytes)) {
        error = "cut short: " + std::to_string(f.gcount()) + " of " + std::to_string(bytes) + " bytes of values";
        return nullptr;
    }
    auto table = std::make_shared<MerlTable>();
    table->set(numbers.data());
    return table;
}

}  // namespace alder
