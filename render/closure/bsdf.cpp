// The mixture of lobes at a point: one-sample choice by albedo, density and value of the whole sum.
#include "render/closure/bsdf.h"

#include <algorithm>
#include <limits>

namespace alder {
namespace {

/// False for NaN.
template <class T>
bool average_positive(Vec3<T> c) { return c.x + c.y + c.z > 0; }

}  // namespace

template <class T>
Bsdf<T>::Bsdf(std::span<Lobe<T>> lobes, const ShadingView<T>& view) : lobes_(lobes), view_(view) {
    T sum = 0;
    Lobe<T>* only = nullptr;
    int candidates = 0;
    for (Lobe<T>& l : lobes_) {
        l.pick = 0;
        if (l.spec->kind == LobeKind::Emission || l.spec->kind == LobeKind::Holdout || l.spec->kind == LobeKind::Absorption ||
            l.spec->kind == LobeKind::Interior)
            continue;
        if (l.weight.x == 0 && l.weight.y == 0 && l.weight.z == 0) continue;
        only = &l;
        ++candidates;
    }
    for (Lobe<T>& l : lobes_) {
        if (candidates > 1) l.pick = lobe_sampling_weight(l, view.wo);
        else if (&l == only) l.pick = average_positive(l.weight) ? 1 : 0;  // no choice to make
        sum += l.pick;
        if (l.pick > 0 && !is_delta(l)) has_density_ = true;
    }
    scatters_ = sum > 0;
    if (!scatters_) return;
    for (Lobe<T>& l : lobes_) l.pick /= sum;
}

template <class T>
BsdfEval<T> Bsdf<T>::eval(Vec3<T> wi, std::span<Vec3<T>> per_lobe) const {
    BsdfEval<T> sum;
    for (size_t i = 0; i < lobes_.size(); ++i) {
        const BsdfEval<T> e = eval_lobe(lobes_[i], view_, wi);
        if (!per_lobe.empty()) per_lobe[i] = e.f_cos;
        sum.f_cos += e.f_cos;
        sum.pdf += lobes_[i].pick * e.pdf;
    }
    return sum;
}

template <class T>
BsdfSample<T> Bsdf<T>::sample(T u1, T u2, T u3, std::span<Vec3<T>> per_lobe) const {
    std::fill(per_lobe.begin(), per_lobe.end(), Vec3<T>(T(0)));
    int chosen = -1;
    T before = 0;
    for (size_t i = 0; i < lobes_.size(); ++i) {
        if (!(lobes_[i].pick > 0)) continue;
        if (chosen >= 0) {
            const T next = before + lobes_[chosen].pick;
            if (u3 < next) break;
            before = next;
        }
        chosen = static_cast<int>(i);  // the last one takes what rounding leaves
    }
    if (chosen < 0) return {};
    const T pick = lobes_[chosen].pick;
    const T rest = std::clamp((u3 - before) / pick, T(0), T(1) - std::numeric_limits<T>::epsilon() / 2);
    BsdfSample<T> s = sample_lobe(lobes_[chosen], view_, u1, u2, rest);
    s.lobe = chosen;
    if (!s.valid) return s;
    if (s.is_delta) {
        s.weight = s.weight / pick;
        s.pdf *= pick;
        if (!per_lobe.empty()) per_lobe[chosen] = s.weight;
        return s;
    }
    // The chosen lobe's own value and density come from its sampler: for narrow lobes they are more exact than what the
    // direction, once rounded, gives back.
    Vec3<T> f = s.weight * s.pdf;
    T pdf = s.pdf * pick;
    if (!per_lobe.empty()) per_lobe[chosen] = f;
    for (size_t i = 0; i < lobes_.size(); ++i) {
        if (static_cast<int>(i) == chosen) continue;
        const BsdfEval<T> e = eval_lobe(lobes_[i], view_, s.wi);
        if (!per_lobe.empty()) per_lobe[i] = e.f_cos;
        f += e.f_cos;
        pdf += lobes_[i].pick * e.pdf;
    }
    s.pdf = pdf;
    s.weight = f / pdf;
    for (Vec3<T>& x : per_lobe) x = x / pdf;
    return s;
}

template <class T>
Vec3<T> Bsdf<T>::albedo(LobeLabel label) const {
    Vec3<T> sum(T(0));
    for (const Lobe<T>& l : lobes_)
        if (l.spec->label == label) sum += lobe_albedo(l, view_.wo);
    return sum;
}

template <class T>
Vec3<T> Bsdf<T>::sum(LobeKind kind) const {
    Vec3<T> sum(T(0));
    for (const Lobe<T>& l : lobes_)
        if (l.spec->kind == kind) sum += l.weight;
    return sum;
}

template class Bsdf<float>;
template class Bsdf<double>;

}  // namespace alder
