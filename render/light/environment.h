// EnvironmentMap: directions in proportion to the brightness of the world, from a latitude-longitude grid of it (z up).
// Marginal and conditional distributions by cumulative tables, so that stratified numbers stay stratified.
#pragma once
#include <vector>

#include "nodes/num/vec.h"

namespace alder {

class EnvironmentMap {
  public:
    EnvironmentMap() = default;
    /// radiance: width x height, row 0 at the zenith; the value of a cell is taken at its centre (cell_direction).
    EnvironmentMap(int width, int height, const std::vector<Vec3f>& radiance);

    static Vec3f cell_direction(int width, int height, int x, int y);
    /// False where the map is black: then the world is not sampled.
    bool is_usable() const { return total_ > 0; }
    Vec3f sample(float u1, float u2, float& pdf) const;
    float pdf(Vec3f direction) const;
    /// Integral of the luminance over all directions.
    float total() const { return total_; }

  private:
    int width_ = 0, height_ = 0;
    std::vector<float> rows_;     ///< cumulative over rows, height + 1
    std::vector<float> cells_;    ///< cumulative in each row, width + 1 a row
    std::vector<float> density_;  ///< by solid angle, per cell
    float total_ = 0;
};

}  // namespace alder
