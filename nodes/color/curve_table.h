// CurveTable: Blender's curve mappings (RGB, Float and Vector Curves) sampled as Cycles looks them up at shading points.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "nodes/schema.h"

namespace alder {

inline constexpr int kCurveSize = 257;

struct CurveTable : Prepared {
    std::vector<std::array<float, kCurveSize>> channels;  ///< one per output component
    float min_x = 0, max_x = 1;
    bool extrapolate = false;
};

enum class CurveKind { Float, Vector, Rgb };

/// From the JSON text of the structure; "null" is Blender's default (the diagonal). `Rgb`: the fourth curve goes before the other
/// three. Heights are not clipped, and levels of black and white have no effect (reference tables). What is wrong is appended to `errors`, and the result is null then.
std::shared_ptr<const CurveTable> bake_curves(const std::string& json_text, CurveKind kind, std::vector<std::string>& errors);

}  // namespace alder
