// Worker: beginning of the paths of a tile, and the end: their rows become leaf sums.
#include "render/sampling.h"
#include "render/worker.h"

namespace alder {

Worker::Worker(const EvalContext& context) : executor_(context) {}

void Worker::begin(const RenderPlan& plan) {
    plan_ = &plan;
    row_stride_ = plan.aovs->row();
    counters_ = {};
    before_ = executor_.stats();
    leaf_sums.clear();
}

void Worker::start_paths(const Tile& tile, uint64_t first, uint32_t count) {
    const size_t n = size_t(tile.pixels()) * count;
    paths_.assign(n, Path{});
    rows_.resize(n * row_stride_);
    bad_.assign(n, 0);
    if (plan_->aovs->any_layer) path_weights_.resize(n);
    active_.clear();
    uint32_t slot = 0;
    for (int y = tile.y0; y < tile.y1; ++y)
        for (int x = tile.x0; x < tile.x1; ++x)
            for (uint32_t i = 0; i < count; ++i, ++slot) {
                Path& path = paths_[slot];
                const int px = plan_->crop_x + x, py = plan_->crop_y + y;
                path.key = sample_key(plan_->seed, px, py, first + i);
                path.slot = slot;
                const Sample4 u = sample_set(path.key, kSetCamera);
                if (plan_->moves) path.history.time = plan_->shutter.time(sample_set(path.key, kSetTime).u[0]);
                const CameraRay ray = plan_->camera.ray(static_cast<float>(px) + 0.5f + plan_->filter.offset(u.u[0]),
                                                        static_cast<float>(py) + 0.5f + plan_->filter.offset(u.u[1]), u.u[2], u.u[3], path.history.time);
                path.history.origin = ray.origin;
                path.history.direction = ray.direction;
                path.t_max = ray.length;
                path.footprint = ray.footprint;
                path.spread = ray.spread;
                plan_->aovs->clear(row(slot));
                row(slot)[plan_->aovs->alpha] = 1;
                if (ray.length < 0) continue;  // outside a fisheye's circle
                active_.push_back(slot);
            }
    counters_.camera_rays += n;
    if (plan_->moves) counters_.timed_paths += n;
    if (plan_->media) start_inside();
}

void Worker::resolve(const Tile& tile, uint32_t count, std::span<LeafSum> leaf) {
    const AovPlan& a = *plan_->aovs;
    uint32_t slot = 0;
    for (int pixel = 0; pixel < tile.pixels(); ++pixel)
        for (uint32_t i = 0; i < count; ++i, ++slot) {
            float* const r = row(slot);
            bool bad = bad_[slot];
            for (int c = 0; c < a.row(); ++c) bad = bad || !std::isfinite(r[c]);
            if (bad) {  // a sample that is not finite says nothing: it counts as black, and is counted
                ++counters_.nonfinite_samples;
                const float alpha = r[a.alpha];
                a.clear(r);
                r[a.alpha] = std::isfinite(alpha) ? alpha : 1.f;
            }
            if (plan_->settings.exposure != 1) expose(r);
            leaf[pixel].add(r);
        }
}

/// Light is scaled on the film, after clamping and whatever else happens to samples; data are not.
void Worker::expose(float* r) const {
    const AovPlan& a = *plan_->aovs;
    const auto scale = [&](int channel) {
        if (channel < 0) return;
        for (int c = 0; c < 3; ++c) r[channel + c] *= plan_->settings.exposure;
    };
    scale(a.rgb);
    for (const int g : a.group) scale(g);
    for (const int l : a.layer) scale(l);
    scale(a.refraction);
}

bool Worker::trace(const Tile& tile, uint64_t first, uint32_t count, std::span<LeafSum> leaf) {
    start_paths(tile, first, count);
    while (!active_.empty()) {
        if (plan_->stopped()) return false;
        intersect();
        if (plan_->stopped()) return false;
        group_hits();
        shade_surfaces();
        if (plan_->stopped()) return false;
        if (!walks_.empty()) scatter_subsurface();
        if (!events_.empty()) scatter_in_media();
        evaluate_emission();
        trace_shadows();
        active_.swap(next_);
    }
    resolve(tile, count, leaf);
    return true;
}

// ---- contributions --------------------------------------------------------------------------------------------------

Vec3f Worker::clamped(Vec3f value, bool direct) const {
    // Blender's limit is of the mean of the channels.
    const float limit = 3 * (direct ? plan_->settings.clamp_direct : plan_->settings.clamp_indirect);
    if (!(limit > 0)) return value;
    const float sum = std::abs(value.x) + std::abs(value.y) + std::abs(value.z);
    return sum > limit ? value * (limit / sum) : value;
}

void Worker::add_light(uint32_t slot, Vec3f value, int light_group) {
    if (!is_finite(value)) {
        bad_[slot] = 1;
        return;
    }
    const AovPlan& a = *plan_->aovs;
    float* const r = row(slot);
    r[a.rgb] += value.x;
    r[a.rgb + 1] += value.y;
    r[a.rgb + 2] += value.z;
    if (!a.any_group) return;
    const int group = light_group >= 0 && light_group < kLightGroups ? a.group[light_group] : a.group[0];
    if (group < 0) return;
    r[group] += value.x;
    r[group + 1] += value.y;
    r[group + 2] += value.z;
}

void Worker::add_layer(uint32_t slot, ShadingLayer layer, Vec3f value) {
    const AovPlan& a = *plan_->aovs;
    const auto add = [&](int channel) {
        if (channel < 0) return;
        float* const r = row(slot) + channel;
        r[0] += value.x;
        r[1] += value.y;
        r[2] += value.z;
    };
    add(a.layer[layer]);
    if (layer == kDirectRefraction || layer == kIndirectRefraction) add(a.refraction);
}

void Worker::add_by_labels(uint32_t slot, const LabelWeights& weights, bool direct, Vec3f value) {
    for (int l = 0; l < kScatterLabels; ++l)
        if (!is_black(weights[l])) add_layer(slot, layer_of(static_cast<LobeLabel>(l), direct), value * weights[l]);
}

/// Light that a path's own ray met: seen directly, or through its first scattering.
void Worker::add_path_light(const Path& path, Vec3f value, int light_group, bool background) {
    const bool scattered = path.flags & kScattered, direct = path.history.depth <= 1;
    value = clamped(value, direct);
    add_light(path.slot, value, light_group);
    if (!plan_->aovs->any_layer || bad_[path.slot]) return;
    if (scattered) add_by_labels(path.slot, path_weights_[path.slot], direct, value);
    else add_layer(path.slot, background ? kBackgroundLayer : kEmissionLayer, value);
}

float Worker::sampled_weight(float light_pdf, float scatter_pdf, bool is_delta_light) const {
    if (is_delta_light || plan_->settings.light_strategy == RenderSettings::LightStrategy::Lights) return 1;
    if (plan_->settings.light_strategy == RenderSettings::LightStrategy::Scattering) return 0;
    return power_heuristic(light_pdf, scatter_pdf);
}

float Worker::met_weight(float light_pdf, float scatter_pdf) const {
    if (scatter_pdf == 0 || light_pdf == 0 || plan_->settings.light_strategy == RenderSettings::LightStrategy::Scattering) return 1;
    if (plan_->settings.light_strategy == RenderSettings::LightStrategy::Lights) return 0;
    return power_heuristic(scatter_pdf, light_pdf);
}

uint32_t Worker::ray_visibility(const RayHistory& h) const {
    if (h.kinds & kRayCamera) return kVisibleCamera;
    if (h.kinds & kRayVolume) return kVisibleVolume;
    if (h.kinds & kRayTransmission) return kVisibleTransmission;
    return h.kinds & kRayDiffuse ? kVisibleDiffuse : kVisibleGlossy;
}

}  // namespace alder
