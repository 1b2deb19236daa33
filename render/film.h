// Film: sums per pixel, added in one canonical order, so that bits do not depend on threads, tiles, cuts or retries.
//
// A leaf is 16 consecutive samples of a pixel (by absolute index), added in double and rounded once to float. Whole leaves are
// added pairwise: node(k, j) = float(node(k-1, 2j) + node(k-1, 2j+1)). A film holds the canonical cover of what was
// rendered, and its total adds that cover from the left; a run of samples that does not fill a leaf is its own leaf.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "render/aov.h"

namespace alder {

inline constexpr uint32_t kLeafSamples = 16;

/// Adds rows by their rules: sums, minima, firsts (a stays where it hit something). to may be a.
void combine_rows(const AovPlan& plan, const float* a, const float* b, float* to);

/// Double sums of one pixel over one leaf.
class LeafSum {
  public:
    explicit LeafSum(const AovPlan& plan) : plan_(&plan), sum_(plan.sums + 3), last_(plan.minima + plan.firsts) {}
    void clear();
    /// The next sample; shading values of a bad one (not finite) count as zero.
    void add(const float* row);
    /// Continues from, or is stored in, numbers kept elsewhere (a leaf that several passes fill). size() doubles.
    size_t size() const { return sum_.size() + last_.size(); }
    void load(const double* from);
    void store(double* to) const;
    /// A row of the film. `odd`: the leaf counts for half B. samples: of the leaf.
    void finish(bool odd, uint32_t samples, float* film_row) const;

  private:
    const AovPlan* plan_;
    std::vector<double> sum_;  ///< sums, then squares of r, g, b
    std::vector<float> last_;  ///< minima and firsts
};

class Film {
  public:
    Film(const AovPlan& plan, size_t pixels);

    /// Memory for the rows of a pass, one a pixel; commit() takes it over.
    std::vector<float>& pass_rows();
    /// The pass rendered leaves [first_leaf, first_leaf + leaves), aligned to a power of two, or one partial leaf.
    void commit(uint64_t first_leaf, uint64_t leaves, uint64_t samples);

    /// Sums of a leaf that is filled by several passes; empty unless asked for. LeafSum::size() doubles a pixel.
    std::vector<double>& open_leaf(size_t doubles_per_pixel);
    const std::vector<double>& open_leaf() const { return open_; }
    void close_leaf() { open_.clear(); }

    /// The total over all that was committed. The open leaf is not part of it.
    std::vector<float> total() const;
    uint64_t samples() const { return samples_; }
    /// Whole leaves, or 0 if some samples lie in a partial one.
    uint64_t whole_leaves() const { return samples_ == whole_ * kLeafSamples ? whole_ : 0; }
    /// Everything but pass_rows(), for a checkpoint (film_file.cpp).
    void save(const std::function<void(const void*, size_t)>& write) const;

  private:
    friend class ProgressiveRender;  // loads it
    struct Node {
        uint64_t first, leaves;
        bool whole;
        std::vector<float> rows;
    };
    const AovPlan* plan_;
    size_t pixels_;
    std::vector<Node> nodes_;
    std::vector<float> pass_;
    std::vector<double> open_;
    uint64_t samples_ = 0, whole_ = 0;
};

}  // namespace alder
