// Worker: what the rays of this depth meet: surfaces, lamps on the way, the world behind.
#include <algorithm>
#include <limits>

#include "render/emission.h"
#include "render/sampling.h"
#include "render/worker.h"

namespace alder {

void Worker::intersect() {
    const Accel& accel = plan_->scene.surfaces->accel();
    const bool lamps = plan_->scene.lights->has_visible_lamps();
    hits_.clear();
    missed_.clear();
    next_.clear();
    pending_.clear();
    found_.clear();
    shadows_.clear();
    shares_.clear();
    walks_.clear();
    events_.clear();
    event_lobes_.clear();
    shadow_inside_.clear();
    for (const uint32_t index : active_) {
        Path& path = paths_[index];
        if (path.vertex > 0) ++counters_.bounce_rays;
        const Ray ray{path.history.origin, path.history.direction, path.t_min, path.t_max, path.history.time, path.hit.instance, path.hit.triangle};
        const bool hit = accel.intersect(ray, ray_visibility(path.history), path.hit);
        if (!hit) path.hit = {.t = std::numeric_limits<float>::infinity()};
        (hit ? hits_ : missed_).push_back(index);
    }
    if (lamps) meet_lamps();
    if (plan_->media) traverse_media();
    meet_background();
}

/// Lamps are seen, and lit by, but hide nothing: a ray collects all of them up to its first surface.
void Worker::meet_lamps() {
    const LightTable& lights = *plan_->scene.lights;
    met_.clear();
    for (const uint32_t index : active_) {
        const Path& path = paths_[index];
        const Ray ray{path.history.origin, path.history.direction, path.t_min, path.hit.t};
        for (const uint32_t v : lights.lamps_along(ray, lamps_)) {
            const Lamp& lamp = lights.lamp(v);
            if (!(lamp.light().visibility & ray_visibility(path.history))) continue;
            LampSample s;
            if (!lamp.intersect(path.history.origin, path.history.direction, path.t_min, path.hit.t, s)) continue;
            const float light_pdf = path.scatter_pdf > 0 ? lights.lamp_pdf(path.history.origin, v, s.pdf) : 0.f;
            const float weight = met_weight(light_pdf, path.scatter_pdf);
            const Vec3f value = path.throughput * s.radiance * weight;
            if (!is_black(value)) met_.push_back({index, v, s, value});
        }
    }
    if (plan_->media) dim_lamps();
    for (const MetLamp& m : met_) {
        const Path& path = paths_[m.path];
        const Lamp& lamp = lights.lamp(m.lamp);
        if (const SceneProgram* const program = lights.lamp_program(m.lamp)) {
            RayHistory h = path.history;
            h.kinds = 0;
            ++h.depth;
            pending_.push_back({program, lamp_point(lamp, m.sample, h.origin), h, static_cast<uint32_t>(found_.size())});
            found_.push_back({m.path, m.factor, lamp.light().light_group, false});
        } else {
            add_path_light(path, m.factor, lamp.light().light_group, false);
        }
    }
}

void Worker::meet_background() {
    const LightTable& lights = *plan_->scene.lights;
    const WorldLight& world = lights.world();
    const AovPlan& a = *plan_->aovs;
    for (const uint32_t index : missed_) {
        const Path& path = paths_[index];
        if (!(path.flags & kScattered) && plan_->settings.film_transparent) {
            row(path.slot)[a.alpha] -= average(path.throughput);
            continue;
        }
        if (world.is_black() || !(world.visibility & ray_visibility(path.history))) continue;
        const float light_pdf = path.scatter_pdf > 0 ? lights.world_pdf(path.history.origin, path.history.direction) : 0.f;
        const float weight = met_weight(light_pdf, path.scatter_pdf);
        const Vec3f value = path.throughput * weight;
        if (!world.program) {
            add_path_light(path, value * world.constant, world.light_group, true);
            continue;
        }
        RayHistory h = path.history;
        ++h.depth;  // Cycles counts the background as a bounce
        pending_.push_back({world.program.get(), world_point(h.direction), h, static_cast<uint32_t>(found_.size())});
        found_.push_back({index, value, world.light_group, true});
    }
    // What was found is evaluated before any surface adds light: a path's sums keep one order.
    evaluate_emission();
}

/// Counting sort by program: material, and whether the program that computes AOVs is wanted. Stable: paths keep their order.
void Worker::group_hits() {
    const Surfaces& surfaces = *plan_->scene.surfaces;
    keys_.resize(hits_.size());
    key_count_.assign(2 * plan_->surface.size() + 1, 0);
    for (size_t i = 0; i < hits_.size(); ++i) {
        const Path& path = paths_[hits_[i]];
        const uint32_t material = surfaces.material(path.hit.instance, path.hit.triangle);
        const RenderPlan::SurfacePrograms& p = plan_->surface[material];
        const bool aovs = p.with_aovs != p.plain && !(path.flags & kDataDone);
        keys_[i] = 2 * material + (aovs ? 1 : 0);
        ++key_count_[keys_[i] + 1];
    }
    for (size_t k = 1; k < key_count_.size(); ++k) key_count_[k] += key_count_[k - 1];
    order_.resize(hits_.size());
    std::vector<uint32_t>& place = alive_;
    place.assign(key_count_.begin(), key_count_.end() - 1);
    for (size_t i = 0; i < hits_.size(); ++i) order_[place[keys_[i]]++] = hits_[i];
}

}  // namespace alder
