// The Voronoi Texture's kernels, one a dimension: each is a translation unit, so that they compile side by side.
#pragma once
#include "nodes/schema.h"

namespace alder {

namespace tex_voronoi {
// Parameters, and the channels of the dynamic ones.
enum Parameter {
    kMapping, kDimensions, kDistance, kFeature, kVector, kW, kScale, kDetail, kRoughness, kLacunarity, kSmoothness, kExponent,
    kRandomness, kNormalize
};
enum Channel {
    kVectorIn = 0, kWIn = 3, kScaleIn, kDetailIn, kRoughnessIn, kLacunarityIn, kSmoothnessIn, kExponentIn, kRandomnessIn
};
enum Out { kDistanceOut = 0, kColorOut = 1, kPositionOut = 4, kWOut = 7, kRadiusOut = 8, kOutputs = 9 };
}  // namespace tex_voronoi

Kernel tex_voronoi_1d();
Kernel tex_voronoi_2d();
Kernel tex_voronoi_3d();
Kernel tex_voronoi_4d();

}  // namespace alder
