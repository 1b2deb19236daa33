// Pixel filter: where within (or around) its pixel a sample is taken. Importance sampled, so a sample belongs to one pixel
// and weighs 1; tiles need no borders.
#pragma once
#include <vector>

#include "render/scene.h"

namespace alder {

class PixelFilter {
  public:
    PixelFilter(RenderSettings::Filter kind, float width_pixels);
    /// Offset from the pixel's centre, in pixels, for a uniform u in [0,1). Separable: call once per axis.
    float offset(float u) const;

  private:
    std::vector<float> cdf_;  ///< empty: box
    float box_width_ = 1, support_ = 1;
};

}  // namespace alder
