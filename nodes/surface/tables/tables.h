// Tables of the closure nodes: energy of GGX lobes and the microfibre sheen's fit. Read through nodes/surface/energy-inl.h.
#pragma once

namespace alder {

extern const float kGgxE[32 * 32];
extern const float kGgxEavg[32];
extern const float kGgxGlassE[16 * 16 * 16];
extern const float kGgxGlassEavg[16 * 16];
extern const float kGgxGlassInsideE[16 * 16 * 16];
extern const float kGgxGlassInsideEavg[16 * 16];
extern const float kGgxFresnelRise[16 * 16 * 16];
/// A, B and albedo of the microfibre sheen: cosine of the viewer runs fastest, then roughness. 0 = the lobe is absent.
extern const float kSheenLtc[3][32 * 32];

}  // namespace alder
