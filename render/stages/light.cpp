// Worker: light sampling, and the evaluation of emission that depends on a graph.
#include <algorithm>
#include <cmath>

#include "render/emission.h"
#include "render/sampling.h"
#include "render/worker.h"

namespace alder {
namespace {

/// Whether light that is hidden from some kinds of ray reaches this lobe (Cycles' rule).
bool lobe_sees(const LobeSpec& spec, uint32_t visibility) {
    switch (spec.kind) {
        case LobeKind::MicrofacetGlass: return visibility & (kVisibleGlossy | kVisibleTransmission);
        case LobeKind::MicrofacetTransmission: return visibility & kVisibleTransmission;
        case LobeKind::MicrofacetReflection:
        case LobeKind::AshikhminShirley:
        case LobeKind::ToonGlossy:
        case LobeKind::HairReflection:
        case LobeKind::HairGlossy:
        case LobeKind::HairGlint: return visibility & kVisibleGlossy;
        case LobeKind::HairTransmission:
        case LobeKind::HairForward: return visibility & kVisibleTransmission;
        case LobeKind::HairChiang:
        case LobeKind::HairOrder:
        case LobeKind::HairHuang: return visibility & (kVisibleGlossy | kVisibleTransmission);
        case LobeKind::PhaseHenyeyGreenstein:
        case LobeKind::PhaseRayleigh:
        case LobeKind::PhaseDraine:
        case LobeKind::PhaseFournierForand: return visibility & kVisibleVolume;
        default: return visibility & kVisibleDiffuse;
    }
}

}  // namespace

void Worker::sample_light(const Path& path, uint32_t index, const ShadingPoint& point, const Bsdf<float>& bsdf) {
    const Sample4 u = sample_set(path.key, set_light(path.vertex));
    LightSample light;
    if (!plan_->scene.lights->sample(point.p, u.u[2], u.u[0], u.u[1], point.time, light)) return;
    constexpr uint32_t kLit = kVisibleDiffuse | kVisibleGlossy | kVisibleTransmission | kVisibleVolume;
    const bool partly_hidden = (light.visibility & kLit) != kLit;
    const bool scattered = path.flags & kScattered, layers = plan_->aovs->any_layer && !scattered;
    const bool is_transmission = dot(point.ng, light.wi) < 0;
    const bool split_glass = path.flags & kDiffuseBefore &&
                             !(is_transmission ? plan_->settings.caustics_refractive : plan_->settings.caustics_reflective);
    const std::span<Vec3f> per_lobe =
        layers || partly_hidden || split_glass ? std::span(per_lobe_).first(bsdf.lobes().size()) : std::span<Vec3f>{};
    BsdfEval<float> e = bsdf.eval(light.wi, per_lobe);
    if (partly_hidden || split_glass) {
        e.f_cos = Vec3f(0.f);
        for (size_t k = 0; k < per_lobe.size(); ++k) {
            const LobeSpec& spec = *bsdf.lobes()[k].spec;
            if (!lobe_sees(spec, light.visibility) || (split_glass && spec.kind == LobeKind::MicrofacetGlass)) per_lobe[k] = Vec3f(0.f);
            e.f_cos += per_lobe[k];
        }
    }
    if (is_black(e.f_cos)) return;
    const float weight = sampled_weight(light.pdf, e.pdf, light.is_delta);

    ShadowRay s;
    s.value = path.throughput * e.f_cos * light.radiance * (weight / light.pdf);
    if (is_black(s.value)) return;
    s.path = index;
    s.depth = path.history.depth;
    s.transparent = path.history.transparent;
    s.light_group = static_cast<uint8_t>(std::clamp(light.light_group, 0, kLightGroups - 1));
    s.scattered = scattered;
    s.direct = path.history.depth == 0;
    s.casts = light.cast_shadow;
    s.ray.origin = leave_surface(point, light.wi);
    s.ray.time = point.time;
    s.ray.self_instance = point.instance;
    s.ray.self_primitive = point.triangle;
    if (std::isfinite(light.distance)) {
        // Ends clear of the emitter as it begins clear of the receiver.
        Vec3f target = light.point.p;
        if (light.point.instance != kNothing) target = leave_surface(light.point, -light.wi);
        const Vec3f d = target - s.ray.origin;
        const float distance = length(d);
        if (!(distance > 0)) return;
        s.ray.direction = d / distance;
        s.ray.t_max = distance * (1 - 4e-7f);
    } else {
        s.ray.direction = light.wi;
        s.ray.t_max = std::numeric_limits<float>::max();
    }
    if (layers) {
        s.shares = static_cast<uint32_t>(shares_.size());
        LabelWeights& w = shares_.emplace_back();
        w.fill(Vec3f(0.f));
        for (size_t k = 0; k < per_lobe.size(); ++k) {
            const int label = static_cast<int>(label_of(*bsdf.lobes()[k].spec, is_transmission));
            if (label < kScatterLabels) w[label] += per_lobe[k];
        }
        for (Vec3f& x : w)
            for (int c = 0; c < 3; ++c) x[c] = e.f_cos[c] != 0 ? x[c] / e.f_cos[c] : 0.f;
    }
    if (light.program) {
        RayHistory h = path.history;
        h.origin = point.p;
        h.direction = light.wi;
        h.kinds = 0;
        ++h.depth;
        pending_.push_back({light.program, light.point, h, static_cast<uint32_t>(shadows_.size())});
    }
    if (plan_->media) start_in_media(s, path, index, point, light.wi);
    shadows_.push_back(s);
}

/// Runs emission programs for what waits: light that rays found, or (once surfaces are shaded) samples of lights.
void Worker::evaluate_emission() {
    if (pending_.empty()) return;
    order_by_program_.resize(pending_.size());
    for (uint32_t i = 0; i < pending_.size(); ++i) order_by_program_[i] = i;
    std::stable_sort(order_by_program_.begin(), order_by_program_.end(),
                     [&](uint32_t a, uint32_t b) { return std::less<>()(pending_[a].program, pending_[b].program); });
    emission_.resize(pending_.size());
    for (size_t first = 0; first < order_by_program_.size();) {
        const SceneProgram& program = *pending_[order_by_program_[first]].program;
        const size_t batch = program.program->batch();
        points_.clear();
        histories_.clear();
        size_t n = 0;
        while (first + n < order_by_program_.size() && n < batch && pending_[order_by_program_[first + n]].program == &program) {
            const PendingEmission& p = pending_[order_by_program_[first + n]];
            points_.push_back(p.point);
            histories_.push_back(&p.history);
            ++n;
        }
        counters_.shading_points += n;
        const auto inputs = gather_.gather(program.plan, plan_->inputs, points_, histories_.data());
        const SceneQueryScope scope(&plan_->query);
        executor_.run(*program.program, static_cast<uint32_t>(n), inputs);
        for (size_t i = 0; i < n; ++i) emission_[order_by_program_[first + i]] = emission_of(*program.program, executor_, i);
        first += n;
    }
    for (size_t i = 0; i < pending_.size(); ++i) {
        if (found_.empty()) {
            shadows_[pending_[i].target].value *= emission_[i];
        } else {
            const FoundLight& f = found_[pending_[i].target];
            add_path_light(paths_[f.path], f.factor * emission_[i], f.light_group, f.background);
        }
    }
    pending_.clear();
    found_.clear();
}

}  // namespace alder
