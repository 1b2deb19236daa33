// Measured reflectance in the form of the MERL database: isotropic, tabulated by half and difference angles.
// Matusik, Pfister, Brand and McMillan, "A Data-Driven Reflectance Model", SIGGRAPH 2003; angles: Rusinkiewicz, "A New Change of
// Variables for Efficient BRDF Representation", EGWR 1998.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "nodes/schema.h"

namespace alder {

struct MerlTable : Prepared {
    static constexpr int kThetaH = 90, kThetaD = 90, kPhiD = 180, kCells = kThetaH * kThetaD * kPhiD;
    /// Red, green, blue of each cell, scaled, not negative, finite. Cell: phi_d fastest, then theta_d, then theta_h.
    std::vector<float> values;
    /// Shape of a half-vector sampler: probability of each band of theta_h (uniform in solid angle within it), and its sum.
    std::vector<double> band, below;

    bool usable() const { return !values.empty(); }
    /// Bands are narrow where highlights are: theta_h = pi/2 (k/90)².
    static double band_edge(int k);
    static int band_of(double theta_h);
    static int cell(double theta_h, double theta_d, double phi_d);
    /// Fills `values` and the sampler from 3 x kCells numbers as the file has them: all of red, then green, then blue.
    void set(const double* numbers);
};

/// Reads a file: three 32-bit sizes whose product is kCells, then as many doubles per channel. Empty and a sentence where it is
/// not that.
std::shared_ptr<const MerlTable> read_merl(const std::string& path, std::string& error);

}  // namespace alder
