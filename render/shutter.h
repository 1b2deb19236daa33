// Shutter: when within its time a ray is cast, by how far open it is.
#pragma once
#include <vector>

namespace alder {

class Shutter {
  public:
    /// Openness at equally spaced times, joined by straight lines; fewer than two, or nowhere open: fully open throughout.
    explicit Shutter(const std::vector<float>& curve);
    /// A time in 0..1 from a uniform number: the inverse of the openness' integral.
    float time(float u) const;

  private:
    std::vector<float> open_, integral_;  ///< integral up to each time, the last is 1; empty: uniform
};

}  // namespace alder
