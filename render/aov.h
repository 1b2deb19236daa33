// AOVs: which layers a request asks for, where each lies in a sample's row of numbers, and how the film's sums become layers.
//
// A row is what one sample of one pixel records. Its first channels are sums (beauty, shading layers, data), then come minima
// (depth) and firsts (ids): these combine over samples by +, min, and "the earlier one that hit something".
#pragma once
#include <array>
#include <span>
#include <string>
#include <vector>

#include "nodes/lobe.h"
#include "render/render.h"

namespace alder {

/// Light layers. The direct and indirect of a label are neighbours: layer_of.
enum ShadingLayer : int {
    kDirectDiffuse, kIndirectDiffuse, kDirectSpecular, kIndirectSpecular, kDirectSpecular2, kIndirectSpecular2,
    kDirectBacklight, kIndirectBacklight, kDirectRefraction, kIndirectRefraction, kDirectGlint, kIndirectGlint,
    kDirectHairTransmission, kIndirectHairTransmission, kDirectLocal, kIndirectLocal, kDirectGlobal, kIndirectGlobal, kSssLayer, kSingleScatterLayer,
    kDirectVolume, kIndirectVolume, kEmissionLayer, kBackgroundLayer, kShadingLayers
};
/// Labels a path may be attributed to by its first scattering: all but Emission and Transparent, which no path has.
inline constexpr int kScatterLabels = static_cast<int>(LobeLabel::kCount);
ShadingLayer layer_of(LobeLabel label, bool direct);

inline constexpr int kLightGroups = 9;  ///< default, 1 .. 8
inline constexpr float kNoDepth = 1e10f;

/// A user's AOV: computed by the materials that have it.
struct UserAov {
    std::string name;
    Type type = Type::Color;
    int channel = -1;
    bool scalar() const { return type == Type::Float || type == Type::Int || type == Type::Bool; }
};

class AovPlan {
  public:
    /// requested: as expanded by expand_aovs. scene_aovs: what the materials of the scene compute, with its type.
    AovPlan(const std::vector<std::string>& requested, const std::vector<std::pair<std::string, Type>>& scene_aovs);

    // Channels in a sample's row; -1 = not recorded.
    int rgb = 0, alpha = 3;
    std::array<int, kShadingLayers> layer;
    int refraction = -1;  ///< direct and indirect together
    std::array<int, kLightGroups> group;
    int hits = -1, p = -1, n = -1, ng = -1, uv = -1;
    int denoise_albedo = -1, denoise_normal = -1, diffuse_color = -1, specular_color = -1, refraction_color = -1;
    int z = -1, id_object = -1, id_material = -1;
    std::vector<UserAov> user;

    bool any_layer = false, any_group = false, any_data = false, any_color = false;
    int sums = 0, minima = 0, firsts = 0;  ///< of a row, in this order
    int row() const { return sums + minima + firsts; }
    /// Neutral values of a row.
    void clear(float* row) const;

    // Channels that the film derives per leaf, after the sums: squares of the samples, squares of the leaf, half B.
    int film_square() const { return sums; }
    int film_leaf_square() const { return sums + 3; }
    int film_half_b = -1;  ///< rgb and the number of samples
    int film_sums() const { return sums + 6 + (film_half_b >= 0 ? 4 : 0); }
    int film_row() const { return film_sums() + minima + firsts; }

    /// Layers of the image, beauty first, from the film's rows (one a pixel).
    struct FilmTotals {
        std::span<const float> rows;
        uint64_t samples = 0;
        uint64_t whole_leaves = 0;  ///< 0 where not all samples lie in whole leaves
    };
    /// only: beauty and these.
    std::vector<Layer> layers(const FilmTotals& film, size_t pixels, const std::vector<std::string>* only = nullptr) const;
    std::vector<std::string> names() const;
    /// Root mean square of the relative error over all pixels but the worst 0.1 %.
    double estimated_error(const FilmTotals& film, size_t pixels) const;

  private:
    enum class Source : uint8_t {
        Black, Mean, MeanOverHits, Direct, Count, Variance, Error, HalfB
    };
    struct Output {
        std::string name;
        std::vector<std::string> channels;
        bool data = false;
        Source source = Source::Black;
        int channel = -1;  ///< in the row
    };
    void request(const std::string& name, const std::vector<std::pair<std::string, Type>>& scene_aovs);
    int take(int count);
    void add(Output o) { outputs_.push_back(std::move(o)); }
    float variance_of_mean(const float* row, int channel, const FilmTotals& film) const;
    float relative_error(const float* row, const FilmTotals& film) const;

    std::vector<Output> outputs_;
};

/// Names a request stands for: groups replaced by their members, duplicates removed, order kept.
std::vector<std::string> expand_aovs(const std::vector<std::string>& requested, const std::vector<std::string>& graph_aovs);

}  // namespace alder
