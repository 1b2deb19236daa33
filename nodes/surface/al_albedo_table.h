// Three-point Gauss rules over the microfacet angle, for the directional albedo of rough specular reflection. See
// al_albedo_table.py for their derivation and al_albedo-inl.h for their use.
#pragma once

namespace alder {
inline constexpr int kAlbedoSize = 16;           ///< rows (width) and columns (view angle)
inline constexpr double kAlbedoMinAlpha = 1e-3, kAlbedoMinRoot = 0.0316227766;  ///< first row, and its square root
inline constexpr float kAlbedoStretch = 6.0f;    ///< of the view angle's axis
inline constexpr int kAlbedoRuleFloats = kAlbedoSize * kAlbedoSize * 6;
extern const float kAlbedoRulesGgx[kAlbedoRuleFloats];
extern const float kAlbedoRulesBeckmann[kAlbedoRuleFloats];
}  // namespace alder
