// Bsdf: the scattering at one point, as the sum of the lobes that a material's closure nodes emitted.
//
// Directions are unit vectors in world space; wo points to the viewer, wi to the light, both away from the surface. `ng` and
// `ns` are turned towards wo: ng geometric, ns the interpolated normal without bump (equal to ng on flat faces).
// Values are f times |cos theta_i| ("f_cos") and solid-angle densities. Everything here is a pure function of its arguments,
// thread safe, and instantiated for float and double. Finite arguments never give NaN or infinities.
//
//   Lobe<float> lobes[n];  for (...) lobes[i] = load_lobe(spec, channels, point);
//   Bsdf<float> bsdf(lobes, {wo, ng, ns});
//   BsdfEval<float> e = bsdf.eval(wi);                // light sampling: value and density of the mixture
//   BsdfSample<float> s = bsdf.sample(u1, u2, u3);    // next direction
#pragma once
#include <span>

#include "nodes/lobe.h"
#include "nodes/num/vec.h"
#include "nodes/schema.h"

namespace alder {

/// One lobe at one point. Meaning of p by kind: nodes/lobe.h.
template <class T>
struct Lobe {
    const LobeSpec* spec = nullptr;
    Vec3<T> weight{0, 0, 0}, n{0, 0, 1}, t{1, 0, 0};
    T p[kMaxLobeParams] = {};
    T pick = 0;  ///< probability of being chosen by Bsdf::sample; set by Bsdf
};

/// Reads point `i` of a lobe's channels (spec.channels() of them, in LobeSpec order).
template <class T>
Lobe<T> load_lobe(const LobeSpec& spec, const Channel<T>* channels, size_t i);

/// The viewer and the surface's own normals at a point.
template <class T>
struct ShadingView {
    Vec3<T> wo, ng, ns;
    /// Evaluate directions that sampling never produces, as Cycles does: refraction where no microfacet that wo sees connects
    /// the two (its albedo exceeds 1 by that), Ashikhmin's sheen and glossy toon below ng. For comparing with its tables;
    /// their density is 0. A renderer wants false: then these are 0.
    bool unreachable_too = false;
    /// Integrate models that are defined by an integral (Huang's hair) until they have converged, instead of estimating them
    /// with numbers that follow from the directions. For comparing and for tests: a thousand times slower.
    bool converged = false;
    /// alHair's dual scattering: fibres between the point and the light evaluated, weighted by opacity, and the variance they
    /// have added. A renderer that does not count them leaves 0: then all light is direct.
    T fibres = 0, fibre_variance = 0;
};

template <class T>
struct BsdfEval {
    Vec3<T> f_cos{0, 0, 0};
    T pdf = 0;
};

template <class T>
struct BsdfSample {
    Vec3<T> wi{0, 0, 1};
    Vec3<T> weight{0, 0, 0};  ///< f_cos/pdf with the lobe weight
    T pdf = 0;                ///< delta lobes: the probability of the choice, no density
    bool is_delta = false;
    bool is_transmission = false;  ///< wi lies on the far side of ng
    bool is_diffuse = false;       ///< sampled from a diffuse kind (else glossy, or delta)
    T eta = 1;                     ///< index of the far medium over the near one where refracted
    T roughness = 1;               ///< larger width alpha of the sampled lobe; 1 for diffuse kinds, 0 for delta
    bool valid = false;            ///< false: no direction (absorbed, or below the surface)
    int lobe = -1;                 ///< index of the lobe sampled (Bsdf)
};

// ---- single lobes ---------------------------------------------------------------------------------------------------

/// Zero for delta lobes, for lobes that do not scatter and where the weight is zero.
template <class T>
BsdfEval<T> eval_lobe(const Lobe<T>& lobe, const ShadingView<T>& view, Vec3<T> wi);
/// u1, u2 choose the direction, u3 reflection or refraction. All in [0, 1).
template <class T>
BsdfSample<T> sample_lobe(const Lobe<T>& lobe, const ShadingView<T>& view, T u1, T u2, T u3);
/// Mirror, clear glass and Transparent: sampled, never evaluated.
template <class T>
bool is_delta(const Lobe<T>& lobe);
/// Estimate of the directional albedo towards wo, lobe weight included. Good for choosing lobes and for AOVs, not exact.
template <class T>
Vec3<T> lobe_albedo(const Lobe<T>& lobe, Vec3<T> wo);
/// Proportional to the probability with which a mixture should choose this lobe; >= 0.
template <class T>
T lobe_sampling_weight(const Lobe<T>& lobe, Vec3<T> wo);

// ---- the mixture ----------------------------------------------------------------------------------------------------

template <class T>
class Bsdf {
  public:
    /// Keeps a reference to `lobes` and sets Lobe::pick. Emission and Holdout lobes may be among them; they do not scatter.
    Bsdf(std::span<Lobe<T>> lobes, const ShadingView<T>& view);

    /// False where nothing can be sampled.
    bool scatters() const { return scatters_; }
    /// Whether some lobe has a density (a point with delta lobes only needs no light sampling).
    bool has_density() const { return has_density_; }

    /// Sum over the lobes and density of the mixture. per_lobe (empty, or one entry a lobe) receives each lobe's f_cos.
    BsdfEval<T> eval(Vec3<T> wi, std::span<Vec3<T>> per_lobe = {}) const;
    /// Chooses a lobe by Lobe::pick with u3 and a direction; pdf and weight are the mixture's (a delta lobe's: its own over
    /// the probability of the choice). per_lobe receives each lobe's share of `weight`.
    BsdfSample<T> sample(T u1, T u2, T u3, std::span<Vec3<T>> per_lobe = {}) const;
    /// Estimated directional albedo of the lobes with this label.
    Vec3<T> albedo(LobeLabel label) const;

    /// Sums of weights of the kinds that do not scatter.
    Vec3<T> emission() const { return sum(LobeKind::Emission); }
    Vec3<T> transparency() const { return sum(LobeKind::Transparent); }
    Vec3<T> holdout() const { return sum(LobeKind::Holdout); }

    std::span<const Lobe<T>> lobes() const { return lobes_; }
    const ShadingView<T>& view() const { return view_; }

  private:
    Vec3<T> sum(LobeKind kind) const;

    std::span<Lobe<T>> lobes_;
    ShadingView<T> view_;
    bool scatters_ = false, has_density_ = false;
};

extern template class Bsdf<float>;
extern template class Bsdf<double>;

}  // namespace alder
