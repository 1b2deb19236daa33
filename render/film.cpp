// Film: the tree of sums.
#include "render/film.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace alder {

void combine_rows(const AovPlan& plan, const float* a, const float* b, float* to) {
    int i = 0;
    for (const int n = plan.film_sums(); i < n; ++i) to[i] = a[i] + b[i];
    for (const int n = plan.film_sums() + plan.minima; i < n; ++i) to[i] = std::min(a[i], b[i]);
    for (const int n = plan.film_row(); i < n; ++i) to[i] = a[i] >= 0 ? a[i] : b[i];
}

void LeafSum::clear() {
    std::fill(sum_.begin(), sum_.end(), 0.0);
    std::fill(last_.begin(), last_.begin() + plan_->minima, kNoDepth);
    std::fill(last_.begin() + plan_->minima, last_.end(), -1.f);
}

void LeafSum::add(const float* row) {
    for (int i = 0; i < plan_->sums; ++i) sum_[i] += row[i];
    for (int c = 0; c < 3; ++c) sum_[plan_->sums + c] += double(row[c]) * row[c];
    const float* const last = row + plan_->sums;
    for (int i = 0; i < plan_->minima; ++i) last_[i] = std::min(last_[i], last[i]);
    for (int i = plan_->minima; i < plan_->minima + plan_->firsts; ++i)
        if (last_[i] < 0) last_[i] = last[i];
}

void LeafSum::load(const double* from) {
    std::copy(from, from + sum_.size(), sum_.begin());
    for (size_t i = 0; i < last_.size(); ++i) last_[i] = static_cast<float>(from[sum_.size() + i]);
}

void LeafSum::store(double* to) const {
    std::copy(sum_.begin(), sum_.end(), to);
    std::copy(last_.begin(), last_.end(), to + sum_.size());
}

void LeafSum::finish(bool odd, uint32_t samples, float* row) const {
    const auto rounded = [](double x) {
        constexpr double kMax = std::numeric_limits<float>::max();
        return static_cast<float>(std::clamp(x, -kMax, kMax));
    };
    float* next = row;
    for (int i = 0; i < plan_->sums; ++i) *next++ = rounded(sum_[i]);
    for (int c = 0; c < 3; ++c) *next++ = rounded(sum_[plan_->sums + c]);
    // Of whole leaves only: a variance over leaves needs them to be alike.
    for (int c = 0; c < 3; ++c) *next++ = samples == kLeafSamples ? rounded(sum_[c] * sum_[c]) : 0.f;
    if (plan_->film_half_b >= 0) {
        for (int c = 0; c < 3; ++c) *next++ = odd ? rounded(sum_[c]) : 0.f;
        *next++ = odd ? static_cast<float>(samples) : 0.f;
    }
    std::copy(last_.begin(), last_.end(), next);
}

Film::Film(const AovPlan& plan, size_t pixels) : plan_(&plan), pixels_(pixels) {}

std::vector<float>& Film::pass_rows() {
    pass_.resize(pixels_ * plan_->film_row());
    return pass_;
}

std::vector<double>& Film::open_leaf(size_t doubles_per_pixel) {
    open_.resize(pixels_ * doubles_per_pixel);
    return open_;
}

void Film::commit(uint64_t first_leaf, uint64_t leaves, uint64_t samples) {
    const bool whole = samples == leaves * kLeafSamples;
    assert((whole || leaves == 1) && "a partial leaf stands alone");
    assert(leaves != 0 && (leaves & (leaves - 1)) == 0 && first_leaf % leaves == 0 && "a pass is a node of the tree");
    samples_ += samples;
    if (whole) whole_ += leaves;
    nodes_.push_back({first_leaf, leaves, whole, std::move(pass_)});
    pass_ = {};
    while (nodes_.size() >= 2) {
        Node& a = nodes_[nodes_.size() - 2];
        Node& b = nodes_.back();
        const bool siblings = a.whole && b.whole && a.leaves == b.leaves && a.first + a.leaves == b.first && a.first % (2 * a.leaves) == 0;
        if (!siblings) break;
        const size_t stride = plan_->film_row();
        for (size_t i = 0; i < pixels_; ++i) combine_rows(*plan_, a.rows.data() + i * stride, b.rows.data() + i * stride, a.rows.data() + i * stride);
        a.leaves *= 2;
        pass_ = std::move(b.rows);  // the next pass reuses the memory
        nodes_.pop_back();
    }
}

std::vector<float> Film::total() const {
    if (nodes_.empty()) return {};
    std::vector<float> sum = nodes_[0].rows;
    const size_t stride = plan_->film_row();
    for (size_t k = 1; k < nodes_.size(); ++k)
        for (size_t i = 0; i < pixels_; ++i)
            combine_rows(*plan_, sum.data() + i * stride, nodes_[k].rows.data() + i * stride, sum.data() + i * stride);
    return sum;
}

}  // namespace alder
