// LightSelector: which emitter to sample from a point, and how probable that choice was. What each emitter could at most do
// for the point is estimated from its bounds (Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree
// Splitting", 2018, section 4: intensity over squared distance, times a bound of its orientation term).
//
// Few emitters are all weighed for each point; many are chosen by power until there is a tree. Callers see no difference.
#pragma once
#include <span>
#include <vector>

#include "nodes/num/vec.h"

namespace alder {

struct EmitterBounds {
    bool distant = false;
    float irradiance = 0;  ///< distant: on a plane that faces it
    // local: within a sphere, radiating no further than an angle from an axis
    Vec3f center{0, 0, 0};
    float radius = 0;
    float intensity = 0;            ///< radiant intensity along the axis, luminance
    Vec3f axis{0, 0, 1};
    float cos_spread = -1;          ///< of the largest angle to the axis; -1 = all around
    bool lambertian = false;        ///< intensity falls off by the cosine to the axis
    float power = 0;
};

class LightSelector {
  public:
    LightSelector() = default;
    explicit LightSelector(std::vector<EmitterBounds> emitters);
    bool empty() const { return emitters_.empty(); }

    /// An emitter for p, or -1 where none reaches it. u is uniform in [0,1) and comes back uniform again.
    int pick(Vec3f p, float& u, float& probability) const;
    /// The probability with which pick(p) chooses this emitter.
    float probability(Vec3f p, uint32_t emitter) const;

  private:
    bool by_power() const { return emitters_.size() > kWeighAll; }
    static constexpr size_t kWeighAll = 24;  ///< some 5 ns an emitter and point

    std::vector<EmitterBounds> emitters_;
    std::vector<float> cdf_;  ///< by power
};

/// Cumulative table of non-negative weights, from 0 to exactly 1; empty where all are zero.
std::vector<float> cumulative_table(std::span<const double> weights);
/// Index i with cdf[i] <= u < cdf[i+1]; u becomes the place within, again uniform.
size_t pick_from_table(const std::vector<float>& cdf, float& u);

}  // namespace alder
