// Worker: ways through bodies. A path that chose a subsurface lobe leaves the body elsewhere, and is lit and scattered there as by
// a Lambert surface of albedo 1; that counts as the diffuse scattering of this depth.
#include "render/subsurface/subsurface.h"

#include <algorithm>

#include "render/sampling.h"
#include "render/worker.h"

namespace alder {

const LobeSpec& subsurface_lambert() {
    static const LobeSpec spec{.kind = LobeKind::Diffuse, .label = LobeLabel::Sss, .cycles_normal = true, .smooth = true};
    return spec;
}

void Worker::scatter_subsurface() {
    leaving_.clear();
    bumped_.clear();
    const Surfaces& surfaces = *plan_->scene.surfaces;
    for (const PendingWalk& w : walks_) {
        if (plan_->stopped()) return;
        Path& path = paths_[w.path];
        WalkNumbers numbers(path.key, set_walk(path.vertex));
        SubsurfaceExit exit;
        const bool profile = w.lobe.spec->kind == LobeKind::Profile;
        if (!(profile ? probe_profile : walk_inside)(surfaces, w.entry, w.lobe, path.throughput, numbers, exit, counters_.subsurface_rays)) continue;
        path.throughput = exit.throughput;
        const Hit& h = exit.hit;
        ShadingPoint point = surfaces.point(h.instance, h.triangle, h.u, h.v, exit.direction, w.entry.distance, w.entry.time);
        path.hit = h;
        point.footprint = w.entry.footprint;
        if (w.lobe.spec->own_normal) bumped_.push_back(static_cast<uint32_t>(leaving_.size()));
        leaving_.push_back({w.path, point, point.n});
    }
    if (!bumped_.empty()) bump_leaving(bumped_);
    for (const Leaving& l : leaving_) {
        Path& path = paths_[l.path];
        ++path.vertex;
        Lobe<float> lobe;
        lobe.spec = &subsurface_lambert();
        lobe.weight = Vec3f(1.f);
        lobe.n = l.n;
        const Bsdf<float> bsdf(std::span(&lobe, 1), {l.point.wo, l.point.ng, l.point.n});
        if (!plan_->scene.lights->empty()) sample_light(path, l.path, l.point, bsdf);
        if (scatter(path, l.path, l.point, bsdf)) next_.push_back(l.path);
    }
}

/// Evaluates surface programs where light leaves, for the normal that the subsurface lobe has there.
void Worker::bump_leaving(std::span<const uint32_t> which) {
    const Surfaces& surfaces = *plan_->scene.surfaces;
    const auto program_of = [&](uint32_t k) {
        const ShadingPoint& p = leaving_[k].point;
        return plan_->surface[surfaces.material(p.instance, p.triangle)].plain;
    };
    order_by_program_.assign(which.begin(), which.end());
    std::stable_sort(order_by_program_.begin(), order_by_program_.end(),
                     [&](uint32_t a, uint32_t b) { return std::less<>()(program_of(a), program_of(b)); });
    for (size_t first = 0; first < order_by_program_.size();) {
        const SceneProgram* const program = program_of(order_by_program_[first]);
        size_t n = 0;
        const size_t batch = program ? program->program->batch() : order_by_program_.size();
        points_.clear();
        histories_.clear();
        while (first + n < order_by_program_.size() && n < batch && program_of(order_by_program_[first + n]) == program) {
            const Leaving& l = leaving_[order_by_program_[first + n++]];
            points_.push_back(l.point);
            histories_.push_back(&paths_[l.path].history);
        }
        if (program) {
            counters_.shading_points += n;
            const auto inputs = gather_.gather(program->plan, plan_->inputs, points_, histories_.data());
            executor_.run(*program->program, static_cast<uint32_t>(n), inputs);
            for (const ProgramLobe& lobe : program->program->lobes()) {
                if (!lobe.spec.is_subsurface()) continue;
                for (size_t i = 0; i < n; ++i) {
                    Vec3f normal;
                    for (int c = 0; c < 3; ++c) {
                        const Channel<float> channel = executor_.channel(lobe.register_first + 3 + c);
                        normal[c] = channel.p[i * channel.stride];
                    }
                    normal = safe_normalize(normal);
                    if (is_finite(normal) && !is_black(normal)) leaving_[order_by_program_[first + i]].n = normal;
                }
                break;
            }
        }
        first += n;
    }
}

}  // namespace alder
