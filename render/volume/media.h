// Media: what lies within closed surfaces and in the world, and what a ray is inside of.
//
// A material's volume output gives absorption, scattering and emission per unit length. Where a program reads nothing, these are
// constants and distances have closed forms; else they are bounded by a grid (majorants) for tracking with null collisions
// (Woodcock et al. 1965; ratio tracking, Novak et al. 2014), which stays unbiased where a bound is too low. Media that overlap add up.
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "render/closure/bsdf.h"
#include "render/programs.h"

namespace alder {

struct MediumValues {
    Vec3f absorption{0, 0, 0}, scattering{0, 0, 0}, emission{0, 0, 0};
    Vec3f extinction() const { return absorption + scattering; }
    MediumValues& operator+=(const MediumValues& b) {
        absorption += b.absorption;
        scattering += b.scattering;
        emission += b.emission;
        return *this;
    }
};
/// Adds what one lobe of a volume contributes. Coefficients that are negative or not finite count as 0.
void add_lobe(MediumValues& sum, const Lobe<float>& lobe);

/// exp(-extinction * length) a channel; length may be infinite.
Vec3f transmittance(Vec3f extinction, float length);
/// The light that a constant medium adds over a length. Endless light of a medium that absorbs nothing is left out.
Vec3f emitted_along(const MediumValues& v, float length);

/// Upper bounds of the extinction over a box, world space.
class MajorantGrid {
  public:
    MajorantGrid(Vec3f low, Vec3f high, std::array<int, 3> cells, std::vector<float> bounds);
    struct Cell {
        float majorant;
        float exit;  ///< along the ray: where the bound no longer holds
    };
    /// The cell at distance t of a ray; outside the box there is nothing.
    Cell at(Vec3f origin, Vec3f direction, float t) const;
    Vec3f low() const { return low_; }
    Vec3f high() const { return high_; }

  private:
    Vec3f low_, high_, cell_;
    std::array<int, 3> cells_;
    std::vector<float> bounds_;
};

/// The medium of one material, or of the world.
struct Medium {
    const SceneProgram* program = nullptr;  ///< null: none
    bool homogeneous = false;
    MediumValues values;                    ///< where homogeneous
    std::vector<Lobe<float>> phases;        ///< where homogeneous; weights are scattering coefficients
};

/// One of the media that a ray is inside of.
struct InsideOf {
    uint32_t instance = kNothing;    ///< whose surface bounds it; kNothing: the world
    uint32_t medium = 0;             ///< index into MediaPlan::media, or kInterior
    const MajorantGrid* grid = nullptr;  ///< null: homogeneous
    // kInterior: what the surface said where the ray came in (LobeKind::Interior)
    Vec3f extinction{0, 0, 0}, scattering{0, 0, 0};
    float anisotropy = 0;
};
inline constexpr uint32_t kInterior = ~uint32_t{0};

/// All media of a scene. Immutable.
class MediaPlan {
  public:
    /// Null where the scene has none.
    static std::unique_ptr<const MediaPlan> make(std::span<const std::shared_ptr<const MaterialPrograms>> materials, const SceneProgram* world,
                                                 const InputScene& inputs, Vec3f camera, const EvalContext& context);

    const Medium& medium(uint32_t index) const { return media_[index]; }
    bool has(uint32_t material) const { return media_[material].program != nullptr; }
    const InsideOf* world() const { return world_.medium < media_.size() ? &world_ : nullptr; }
    const MajorantGrid* grid(uint32_t instance, uint32_t medium) const;
    /// How many a ray can be inside of at once.
    uint32_t depth() const { return depth_; }
    /// Whether p may lie within a medium with a boundary.
    bool may_contain(Vec3f p) const;

  private:
    std::vector<Medium> media_;  ///< by material, then the world's
    InsideOf world_{kNothing, kInterior};
    struct Bounded {
        uint32_t instance, medium;
        Vec3f low, high;
        std::unique_ptr<const MajorantGrid> grid;
    };
    std::vector<Bounded> bounded_;   ///< by instance
    std::vector<uint32_t> first_of_instance_;
    uint32_t depth_ = 1;
};

/// A ray crosses the boundary of a medium. False if there was no room for it.
bool cross_boundary(InsideOf* inside, uint8_t& count, uint32_t depth, const InsideOf& medium, bool leaving);

}  // namespace alder
