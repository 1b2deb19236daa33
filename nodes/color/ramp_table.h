// RampTable: a colour ramp (Blender's color_ramp structure) sampled at i/256, i = 0 ... 256, as Cycles looks it up at shading points.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "nodes/schema.h"

namespace alder {

inline constexpr int kRampSize = 257;

struct RampTable : Prepared {
    std::array<std::array<float, kRampSize>, 4> rgba{};
    bool interpolate = true;  ///< false: CONSTANT
};

/// From the JSON text of the structure; "null" is Blender's default (black to white). What is wrong is appended to `errors`, and
/// the result is null then. Other keys (Blender's own samples) are ignored.
std::shared_ptr<const RampTable> bake_ramp(const std::string& json_text, std::vector<std::string>& errors);

}  // namespace alder
