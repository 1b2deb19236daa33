// Worker: shadow rays. Opaque scenes need one query a ray; where materials may let light through, only rays that met nothing
// opaque follow their surfaces one by one.
#include <algorithm>
#include <cmath>
#include <limits>

#include "render/sampling.h"
#include "render/worker.h"

namespace alder {
namespace {

struct MaterialFilter final : ShadowFilter {
    const PreparedScene* scene;
    explicit MaterialFilter(const PreparedScene& s) : scene(&s) {}
    bool may_pass(uint32_t instance, uint32_t triangle) const override {
        const MaterialPrograms& m = *scene->materials[scene->surfaces->material(instance, triangle)];
        return m.shadow != nullptr || m.boundary_only;
    }
};

}  // namespace

void Worker::trace_shadows() {
    const MaterialFilter filter(plan_->scene);
    const ShadowFilter* const use = plan_->scene.has_transparent_shadows ? &filter : nullptr;
    const Accel& accel = plan_->scene.surfaces->accel();
    filtered_.clear();
    media_rays_.clear();
    for (uint32_t i = 0; i < shadows_.size(); ++i) {
        ShadowRay& s = shadows_[i];
        if (is_black(s.value)) continue;
        if (!s.casts) continue;
        ++counters_.shadow_rays;
        const Occlusion o = accel.occluded(s.ray, use);
        if (o == Occlusion::Blocked) s.value = Vec3f(0.f);
        if (o == Occlusion::Filtered) filtered_.push_back(i);
        else if (s.media > 0) media_rays_.push_back(i);
    }
    if (!media_rays_.empty()) {
        shadow_hits_.resize(shadows_.size());
        for (const uint32_t i : media_rays_) shadow_hits_[i].t = shadows_[i].ray.t_max;
        attenuate(media_rays_);
    }
    if (!filtered_.empty()) shade_shadows(filtered_);
    for (const ShadowRay& s : shadows_)
        if (!is_black(s.value)) land(s);
}

/// Multiplies rays by the transmittance of the surfaces they pass; those that pass too many are blocked.
void Worker::shade_shadows(std::vector<uint32_t>& rays) {
    const Surfaces& surfaces = *plan_->scene.surfaces;
    shadow_hits_.resize(shadows_.size());
    while (!rays.empty() && !plan_->stopped()) {
        size_t count = 0;
        media_rays_.clear();
        for (const uint32_t i : rays) {
            ShadowRay& s = shadows_[i];
            ++counters_.shadow_rays;
            const bool hit = surfaces.accel().intersect(s.ray, kVisibleShadow, shadow_hits_[i]);
            if (!hit) shadow_hits_[i].t = s.ray.t_max;
            if (s.media > 0) media_rays_.push_back(i);
            if (!hit) continue;
            const bool boundary = plan_->scene.materials[surfaces.material(shadow_hits_[i].instance, shadow_hits_[i].triangle)]->boundary_only;
            if (boundary ? ++s.boundaries > kMostBoundaries : ++s.transparent > plan_->settings.transparent_bounces) {
                s.value = Vec3f(0.f);
                continue;
            }
            rays[count++] = i;
        }
        rays.resize(count);
        if (!media_rays_.empty()) attenuate(media_rays_);
        const auto material = [&](uint32_t i) { return surfaces.material(shadow_hits_[i].instance, shadow_hits_[i].triangle); };
        std::stable_sort(rays.begin(), rays.end(), [&](uint32_t a, uint32_t b) { return material(a) < material(b); });
        alive_.clear();
        for (size_t first = 0; first < rays.size();) {
            const uint32_t m = material(rays[first]);
            const SceneProgram* const program = plan_->scene.materials[m]->shadow.get();
            const size_t batch = program ? program->program->batch() : rays.size();
            size_t n = 0;
            while (first + n < rays.size() && n < batch && material(rays[first + n]) == m) ++n;
            shade_shadow_batch(program, std::span(rays).subspan(first, n));
            first += n;
        }
        rays = alive_;
        std::sort(rays.begin(), rays.end());
    }
}

void Worker::shade_shadow_batch(const SceneProgram* program, std::span<const uint32_t> rays) {
    if (!program) {
        pass_shadow_boundaries(rays);
        return;
    }
    const Surfaces& surfaces = *plan_->scene.surfaces;
    points_.clear();
    histories_.clear();
    shadow_history_.clear();
    for (const uint32_t i : rays) {
        const ShadowRay& s = shadows_[i];
        const Hit& h = shadow_hits_[i];
        points_.push_back(surfaces.point(h.instance, h.triangle, h.u, h.v, s.ray.direction, h.t, s.ray.time));
        RayHistory history = paths_[s.path].history;
        history.origin = s.ray.origin;
        history.direction = s.ray.direction;
        history.kinds = kRayShadow;
        history.depth = static_cast<uint16_t>(s.depth + 1);
        history.transparent = s.transparent;
        shadow_history_.push_back(history);
    }
    for (const RayHistory& h : shadow_history_) histories_.push_back(&h);
    counters_.shading_points += rays.size();
    const auto inputs = gather_.gather(program->plan, plan_->inputs, points_, histories_.data());
    const SceneQueryScope scope(&plan_->query);
    executor_.run(*program->program, static_cast<uint32_t>(rays.size()), inputs);
    for (size_t k = 0; k < rays.size(); ++k) {
        ShadowRay& s = shadows_[rays[k]];
        Vec3f transmittance(0.f);
        has_interior_ = false;
        for (const ProgramLobe& lobe : program->program->lobes()) {
            if (lobe.spec.kind == LobeKind::Interior && plan_->media) {
                Channel<float> channels[16];
                for (int c = 0; c < lobe.spec.channels(); ++c) channels[c] = executor_.channel(lobe.register_first + c);
                add_interior(load_lobe(lobe.spec, channels, k));
            }
            if (lobe.spec.kind != LobeKind::Transparent) continue;
            for (int c = 0; c < 3; ++c) {
                const Channel<float> w = executor_.channel(lobe.register_first + c);
                transmittance[c] += w.p[k * w.stride];
            }
        }
        s.value *= transmittance;
        if (is_black(s.value)) continue;
        if (plan_->media) cross(shadow_inside_.data() + s.inside, s.media, points_[k], has_interior_ ? &interior_ : nullptr);
        s.ray.t_min = std::nextafter(shadow_hits_[rays[k]].t, std::numeric_limits<float>::infinity());
        s.ray.self_instance = shadow_hits_[rays[k]].instance;
        s.ray.self_primitive = shadow_hits_[rays[k]].triangle;
        if (s.ray.t_min < s.ray.t_max) alive_.push_back(rays[k]);
    }
}

/// Surfaces without shader are black, but for those that only bound a volume.
void Worker::pass_shadow_boundaries(std::span<const uint32_t> rays) {
    const Surfaces& surfaces = *plan_->scene.surfaces;
    for (const uint32_t i : rays) {
        ShadowRay& s = shadows_[i];
        const Hit& h = shadow_hits_[i];
        if (is_black(s.value)) continue;
        if (!plan_->media || !plan_->scene.materials[surfaces.material(h.instance, h.triangle)]->boundary_only) {
            s.value = Vec3f(0.f);
            continue;
        }
        cross(shadow_inside_.data() + s.inside, s.media, surfaces.point(h.instance, h.triangle, h.u, h.v, s.ray.direction, h.t, s.ray.time), nullptr);
        s.ray.t_min = std::nextafter(h.t, std::numeric_limits<float>::infinity());
        if (s.ray.t_min < s.ray.t_max) alive_.push_back(i);
    }
}

/// Light that arrived.
void Worker::land(const ShadowRay& s) {
    const Path& path = paths_[s.path];
    const Vec3f value = clamped(s.value, s.direct);
    add_light(path.slot, value, s.light_group);
    if (!plan_->aovs->any_layer || bad_[path.slot]) return;
    if (s.scattered) add_by_labels(path.slot, path_weights_[path.slot], false, value);
    else add_by_labels(path.slot, shares_[s.shares], true, value);
}

}  // namespace alder
