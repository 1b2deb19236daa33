// Subsurface scattering: where light that enters a body at one point leaves it, and what share of it does.
//
// Two methods, by the lobe's kind: a random walk inside (RandomWalk), or a radial profile, probed for other points of the same
// object (Profile). Both are estimators: `throughput` of the exit, times the light that a Lambert surface of albedo 1 sends out
// there, is on average what the entry point shows. Everything is a function of its arguments; thread safe.
#pragma once
#include <cstdint>

#include "render/closure/bsdf.h"
#include "render/geometry/surface.h"
#include "render/sampler.h"

namespace alder {

struct SubsurfaceExit {
    Hit hit;
    Vec3f direction;   ///< of a ray that comes from outside to the exit: against the way light took
    Vec3f throughput;  ///< of the path, the way inside included
};

/// Uniform numbers of one way through a body: the first four stratified over the samples of a pixel, then independent ones.
class WalkNumbers {
  public:
    WalkNumbers(SampleKey key, uint32_t set)
        : first_(sample_set(key, set)), state_(hash32(hash32(key.stream, key.index), set ^ 0x5bd1e995u)) {}
    const Sample4& first() const { return first_; }
    float next() { return unit_float(hash32(state_ + 0x9e3779b9u * ++count_)); }

  private:
    Sample4 first_;
    uint32_t state_, count_ = 0;
};

/// `throughput`: of the path, the lobe's weight included. False where no light comes out. Adds the rays traced to `rays`.
bool walk_inside(const Surfaces& surfaces, const ShadingPoint& entry, const Lobe<float>& lobe, Vec3f throughput, WalkNumbers& numbers,
                 SubsurfaceExit& exit, uint64_t& rays);
bool probe_profile(const Surfaces& surfaces, const ShadingPoint& entry, const Lobe<float>& lobe, Vec3f throughput, WalkNumbers& numbers,
                   SubsurfaceExit& exit, uint64_t& rays);

/// Single-scattering albedo that gives a half space the reflectance `albedo` (fit of Cycles 4.5, after Chiang, Kutz and Burley 2016,
/// with anisotropy g).
float single_scattering_albedo(float albedo, float g);

/// Radial profiles, unit integral over the plane: R(r) 2 pi r dr sums to 1.
/// d: scale. Christensen and Burley 2015, equation 3, without the radius' dependence on albedo, cut at 16 d.
float burley_radial_density(float d, float r);
float sample_burley_radius(float d, float u);
/// 10 (R-r)^3 / (pi R^5) for r < R.
float cubic_radial_density(float radius, float r);
float sample_cubic_radius(float radius, float u);

}  // namespace alder
