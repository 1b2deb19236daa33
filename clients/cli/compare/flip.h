// HDR-FLIP: how different two pictures look when one flips between them, per pixel, from 0 to 1.
//
// Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild, "FLIP: A Difference Evaluator for Alternating Images", HPG 2020;
// Andersson, Nilsson, Shirley, Akenine-Moller, "Visualizing Errors in Rendered High Dynamic Range Images", EGSR 2021.
#pragma once
#include <array>
#include <cstddef>
#include <vector>

namespace alder::cli {

/// Planes of linear Rec. 709 r, g, b of one size. What is negative or not finite counts as black.
using RgbPlanes = std::array<const std::vector<float>*, 3>;

/// Pixels per degree of the authors' viewer: 0.7 m from a screen 0.7 m wide with 3840 pixels.
inline constexpr float kFlipPixelsPerDegree = 67.0206432f;

/// The largest FLIP of each pixel over the exposures that the reference calls for.
std::vector<float> hdr_flip(const RgbPlanes& test, const RgbPlanes& reference, int width, int height,
                            float pixels_per_degree = kFlipPixelsPerDegree);

}  // namespace alder::cli
