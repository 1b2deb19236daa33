// BoxIndex: which of many boxes a ray meets. For lamps, which hide nothing: a ray wants all of them, not the nearest.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "render/accel.h"

namespace alder {

class BoxIndex {
  public:
    using Box = std::array<Vec3f, 2>;  ///< lower, upper corner
    explicit BoxIndex(std::vector<Box> boxes);
    ~BoxIndex();
    BoxIndex(BoxIndex&&) noexcept;

    /// Indices of the boxes that the ray may meet, ascending: sums over them must not depend on how the tree was built.
    void query(const Ray& ray, std::vector<uint32_t>& found) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace alder
