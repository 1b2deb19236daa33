// Worker: rays within media. Constant media have closed forms; the others are tracked, all rays of a stage together, so that
// their programs run in batches. Media that overlap add up.
#include <algorithm>
#include <cmath>
#include <limits>

#include "render/sampling.h"
#include "render/worker.h"

namespace alder {
namespace {

constexpr float kEndless = std::numeric_limits<float>::infinity();
/// Tracks whose weight falls below this are ended by roulette.
constexpr float kFaint = 0.1f;

float largest(Vec3f v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

/// What scatters light within an Interior: alSurface's single scattering.
const LobeSpec& interior_phase() {
    static const LobeSpec spec{.kind = LobeKind::PhaseHenyeyGreenstein, .label = LobeLabel::SingleScatter};
    return spec;
}

/// A point that is on no surface: normals face the viewer.
ShadingPoint medium_point(Vec3f origin, Vec3f direction, float t, uint32_t instance) {
    ShadingPoint s;
    s.p = origin + direction * t;
    s.n = s.ng = s.wo = -direction;
    s.instance = instance;
    s.triangle = kNothing;
    s.distance = t;
    return s;
}

}  // namespace

// ---- boundaries -----------------------------------------------------------------------------------------------------

/// The media that camera rays start in.
void Worker::start_inside() {
    const MediaPlan& media = *plan_->media;
    inside_.resize(paths_.size() * media.depth());
    for (const uint32_t index : active_) {
        Path& path = paths_[index];
        if (media.world()) {
            *inside(index) = *media.world();
            path.media = 1;
        }
        if (media.may_contain(path.history.origin)) find_media(path, index);
    }
}

/// Looks out from where a path starts: a boundary met from behind, but not entered before, is around it.
void Worker::find_media(Path& path, uint32_t index) {
    const Surfaces& surfaces = *plan_->scene.surfaces;
    std::vector<std::pair<uint32_t, uint32_t>> entered;
    Ray ray{path.history.origin, Vec3f(0, 0, 1), 0, kEndless, path.history.time};
    Hit hit;
    for (int i = 0; i < kMostBoundaries && surfaces.accel().intersect(ray, kVisibleAll, hit); ++i) {
        ++counters_.bounce_rays;
        const uint32_t material = surfaces.material(hit.instance, hit.triangle);
        if (plan_->media->has(material)) {
            const std::pair key{hit.instance, material};
            const ShadingPoint point = surfaces.point(hit.instance, hit.triangle, hit.u, hit.v, ray.direction, hit.t, ray.time);
            if (!point.backfacing) {
                entered.push_back(key);
            } else if (std::find(entered.begin(), entered.end(), key) == entered.end()) {
                const InsideOf m{hit.instance, material, plan_->media->grid(hit.instance, material)};
                if (!cross_boundary(inside(index), path.media, plan_->media->depth(), m, false)) ++counters_.media_ignored;
            }
        }
        ray.t_min = std::nextafter(hit.t, kEndless);
    }
}

/// A ray goes through a surface.
void Worker::cross(InsideOf* inside, uint8_t& count, const ShadingPoint& point, const Lobe<float>* interior) {
    if (point.instance == kNothing) return;
    const uint32_t material = plan_->scene.surfaces->material(point.instance, point.triangle);
    const uint32_t depth = plan_->media->depth();
    if (plan_->media->has(material)) {
        const InsideOf m{point.instance, material, plan_->media->grid(point.instance, material)};
        if (!cross_boundary(inside, count, depth, m, point.backfacing)) ++counters_.media_ignored;
    }
    if (interior || point.backfacing) {
        InsideOf m{point.instance, kInterior};
        if (interior) {
            // A layer's share weighs the extinction only: scattering is never more than that.
            for (int c = 0; c < 3; ++c) {
                m.extinction[c] = interior->weight[c] > 0 && std::isfinite(interior->weight[c]) ? interior->weight[c] : 0.f;
                m.scattering[c] = interior->p[c] > 0 ? std::min(interior->p[c], m.extinction[c]) : 0.f;
            }
            m.anisotropy = interior->p[3];
        }
        if (!cross_boundary(inside, count, depth, m, point.backfacing)) ++counters_.media_ignored;
    }
}

/// Through the boundary of a volume that has no surface.
void Worker::pass_boundary(Path& path, uint32_t index) {
    const Hit& h = path.hit;
    if (++path.boundaries > kMostBoundaries) return;
    cross(inside(index), path.media, plan_->scene.surfaces->point(h.instance, h.triangle, h.u, h.v, path.history.direction, h.t, path.history.time), nullptr);
    ++path.vertex;
    path.t_min = std::nextafter(h.t, kEndless);
    if (path.t_min < path.t_max) next_.push_back(index);
}

/// Media at the beginning of a shadow ray.
void Worker::start_in_media(ShadowRay& s, const Path& path, uint32_t index, const ShadingPoint& point, Vec3f wi) {
    s.inside = static_cast<uint32_t>(shadow_inside_.size());
    s.media = path.media;
    s.numbers.state = hash32(hash32(path.key.stream, path.key.index), set_light(path.vertex) ^ 0x68e31da4u);
    shadow_inside_.resize(shadow_inside_.size() + plan_->media->depth());
    std::copy_n(inside(index), path.media, shadow_inside_.begin() + s.inside);
    if (dot(point.ng, wi) < 0) cross(shadow_inside_.data() + s.inside, s.media, point, has_interior_ ? &interior_ : nullptr);
}

// ---- what lies along a part of a ray --------------------------------------------------------------------------------

MediumValues Worker::own_values(const Path* path, const InsideOf& m) const {
    if (m.medium != kInterior) return plan_->media->medium(m.medium).values;
    MediumValues v;
    v.scattering = m.scattering;
    v.absorption = m.extinction - m.scattering;
    if (!path || path->flags & kInnerDone) {  // scattered light is lost to it now
        v.absorption = m.extinction;
        v.scattering = Vec3f(0.f);
    }
    return v;
}

/// Sum over the homogeneous media; `varies`: there are others.
MediumValues Worker::constant_part(const InsideOf* inside, uint32_t count, bool& varies) const {
    MediumValues sum;
    varies = false;
    for (uint32_t i = 0; i < count; ++i) {
        if (inside[i].grid) varies = true;
        else sum += own_values(nullptr, inside[i]);
    }
    return sum;
}

/// Paths from their last vertex to the surface, or to nothing: what they find on the way, and whether they scatter before.
void Worker::traverse_media() {
    tracks_.clear();
    for (const uint32_t index : active_) {
        Path& path = paths_[index];
        path.flags &= static_cast<uint8_t>(~kWithin);
        if (path.media == 0) continue;
        ++counters_.medium_segments;
        const InsideOf* const m = inside(index);
        MediumValues constant;
        bool varies = false;
        for (uint32_t i = 0; i < path.media; ++i) {
            if (m[i].grid) varies = true;
            else constant += own_values(&path, m[i]);
        }
        if (!varies) {
            traverse_homogeneous(path, index, constant, path.hit.t);
            continue;
        }
        Track t{.target = index, .is_path = true, .can_scatter = !(path.flags & kLastVertex), .inside = m, .count = path.media};
        t.origin = path.history.origin;
        t.direction = path.history.direction;
        t.t = path.t_min;
        t.t_end = path.hit.t;
        t.constant = constant;
        t.numbers.state = hash32(hash32(path.key.stream, path.key.index), set_media(path.vertex) ^ 0x5bd1e995u);
        Vec3f passed(1.f);
        if (begin_track(t, passed)) tracks_.push_back(t);
        else path.throughput *= passed;
    }
    if (!tracks_.empty()) run_tracks();
    for (const Track& t : tracks_) {
        Path& path = paths_[t.target];
        if (!is_black(t.light)) add_path_light(path, path.throughput * t.light, 0, false);
        path.throughput *= t.weight;
    }
    const auto gone = [&](uint32_t index) { return (paths_[index].flags & kWithin) != 0 || is_black(paths_[index].throughput); };
    std::erase_if(hits_, gone);
    std::erase_if(missed_, gone);
}

/// Kulla and Fajardo, "Importance Sampling Techniques for Path Tracing in Participating Media", EGSR 2012, section 3: distances by
/// transmittance, of a channel chosen by what it can scatter (one-sample MIS over channels).
void Worker::traverse_homogeneous(Path& path, uint32_t index, const MediumValues& v, float t_end) {
    const float length = t_end - path.t_min;
    if (!is_black(v.emission)) add_path_light(path, path.throughput * emitted_along(v, length), 0, false);
    const Vec3f extinction = v.extinction();
    const Vec3f all = transmittance(extinction, length);
    Vec3f pick(0.f);
    if (!(path.flags & kLastVertex))
        for (int c = 0; c < 3; ++c) pick[c] = v.scattering[c] > 0 ? std::abs(path.throughput[c]) * v.scattering[c] / extinction[c] : 0.f;
    const float sum = pick.x + pick.y + pick.z;
    if (!(sum > 0)) {
        path.throughput *= all;
        return;
    }
    pick = pick / sum;
    const Sample4 u = sample_set(path.key, set_media(path.vertex));
    const int c = u.u[1] < pick.x ? 0 : u.u[1] < pick.x + pick.y || pick.z == 0 ? 1 : 2;
    const int channel = pick[c] > 0 ? c : pick.x > 0 ? 0 : 1;
    const float distance = -std::log1p(-u.u[0]) / extinction[channel];
    if (!(distance < length)) {
        path.throughput *= all / dot(pick, all);
        return;
    }
    const Vec3f reached = transmittance(extinction, distance);
    path.throughput *= v.scattering * reached / dot(pick, extinction * reached);
    const uint32_t first = static_cast<uint32_t>(event_lobes_.size());
    append_constant_phases(path, index);
    path.flags |= kWithin;
    events_.push_back({index, path.t_min + distance, first, static_cast<uint32_t>(event_lobes_.size()) - first});
}

// ---- tracking -------------------------------------------------------------------------------------------------------

/// False where the closed form of the constant part is all there is; `passed` receives it.
bool Worker::begin_track(Track& t, Vec3f& passed) const {
    bool meets = false;
    for (uint32_t i = 0; i < t.count && !meets; ++i)
        if (t.inside[i].grid) {
            const MajorantGrid::Cell c = t.inside[i].grid->at(t.origin, t.direction, t.t);
            meets = c.majorant > 0 || c.exit < t.t_end;
        }
    // An endless ray through what leaves some channel as it is would never end. Beyond the boxes nothing is found.
    const Vec3f constant = t.constant.extinction();
    if (!std::isfinite(t.t_end) && std::min({constant.x, constant.y, constant.z}) <= 0) {
        t.weight = transmittance(constant, kEndless);
        float last = t.t;
        for (uint32_t i = 0; i < t.count; ++i)
            if (const MajorantGrid* const g = t.inside[i].grid) last = std::max(last, length(g->high() - t.origin) + length(g->high() - g->low()));
        t.t_end = last;
    }
    if (!is_black(t.constant.emission) && std::isfinite(t.t_end)) t.least = 8 / std::max(t.t_end - t.t, 1e-20f);
    if (meets || !t.is_path) return true;
    if (t.can_scatter || !is_black(t.constant.emission)) return true;
    passed = transmittance(t.constant.extinction(), t.t_end - t.t);
    return false;
}

/// Goes on to the next collision, real or not; false: reaches the end.
bool Worker::next_collision(Track& t) const {
    const Vec3f constant = t.constant.extinction();
    const float base = std::max({constant.x, constant.y, constant.z, t.least});
    for (;;) {
        float majorant = base, exit = t.t_end;
        for (uint32_t i = 0; i < t.count; ++i) {
            if (!t.inside[i].grid) continue;
            const MajorantGrid::Cell c = t.inside[i].grid->at(t.origin, t.direction, t.t);
            majorant += c.majorant;
            exit = std::min(exit, c.exit);
        }
        if (majorant > 0) {
            const float step = -std::log1p(-t.numbers.next()) / majorant;
            if (t.t + step < exit) {
                t.t += step;
                t.majorant = majorant;
                return true;
            }
        }
        t.t = exit;
        if (!(t.t < t.t_end)) return false;
    }
}

/// Novak et al., "Residual Ratio Tracking", 2014; Miller, Georgiev and Jarosz, "A Null-Scattering Path Integral Formulation", 2019:
/// weights keep the estimate unbiased in each channel and where the bound is too low. False: the track ends here.
bool Worker::resolve_collision(Track& t) {
    const Vec3f extinction = t.here.extinction(), rest = Vec3f(t.majorant) - extinction;
    if (t.is_path) t.light += t.weight * t.here.emission / t.majorant;
    if (t.can_scatter) {
        const Vec3f real = t.weight * t.here.scattering, null = t.weight * rest;
        const float a = real.x + real.y + real.z, b = std::abs(null.x) + std::abs(null.y) + std::abs(null.z);
        const float p = std::abs(a) / (std::abs(a) + b);
        if (!(std::abs(a) + b > 0)) {
            t.weight = Vec3f(0.f);
            return false;
        }
        if (t.numbers.next() < p) {
            t.weight = real / (t.majorant * p);
            t.scattered = true;
            return false;
        }
        t.weight = null / (t.majorant * (1 - p));
    } else {
        t.weight *= rest / t.majorant;
    }
    const float left = largest(t.weight);
    if (left < kFaint) {
        const float survive = left / kFaint;
        if (!(t.numbers.next() < survive)) {
            t.weight = Vec3f(0.f);
            return false;
        }
        t.weight *= 1 / survive;
    }
    return true;
}

void Worker::run_tracks() {
    tracks_alive_.resize(tracks_.size());
    for (uint32_t i = 0; i < tracks_.size(); ++i) tracks_alive_[i] = i;
    while (!tracks_alive_.empty() && !plan_->stopped()) {
        lookups_.clear();
        size_t left = 0;
        for (const uint32_t i : tracks_alive_) {
            Track& t = tracks_[i];
            if (!next_collision(t)) continue;
            t.here = t.constant;
            for (uint32_t k = 0; k < t.count; ++k) {
                const MajorantGrid* const g = t.inside[k].grid;
                if (g && g->at(t.origin, t.direction, t.t).majorant > 0) lookups_.push_back({i, t.inside[k].medium, t.inside[k].instance});
            }
            tracks_alive_[left++] = i;
        }
        tracks_alive_.resize(left);
        look_up();
        left = 0;
        for (const uint32_t i : tracks_alive_)
            if (resolve_collision(tracks_[i])) tracks_alive_[left++] = i;
            else if (tracks_[i].scattered) take_event(i);
        tracks_alive_.resize(left);
    }
}

/// Runs the programs of media at the tracks' collisions.
void Worker::look_up() {
    looked_up_.clear();
    looked_up_track_.clear();
    std::stable_sort(lookups_.begin(), lookups_.end(), [](const Lookup& a, const Lookup& b) { return a.medium < b.medium; });
    counters_.medium_points += lookups_.size();
    for (size_t first = 0; first < lookups_.size();) {
        const uint32_t medium = lookups_[first].medium;
        const SceneProgram& program = *plan_->media->medium(medium).program;
        const size_t batch = program.program->batch();
        points_.clear();
        media_history_.clear();
        size_t n = 0;
        while (first + n < lookups_.size() && n < batch && lookups_[first + n].medium == medium) {
            const Lookup& l = lookups_[first + n++];
            const Track& t = tracks_[l.track];
            points_.push_back(medium_point(t.origin, t.direction, t.t, l.instance));
            RayHistory& h = media_history_.emplace_back(paths_[t.is_path ? t.target : shadows_[t.target].path].history);
            points_.back().time = h.time;
            h.origin = t.origin;
            h.direction = t.direction;
            if (!t.is_path) h.kinds = kRayShadow;
        }
        histories_.clear();
        for (const RayHistory& h : media_history_) histories_.push_back(&h);
        const auto inputs = gather_.gather(program.plan, plan_->inputs, points_, histories_.data());
        executor_.run(*program.program, static_cast<uint32_t>(n), inputs);
        gather_lobes(*program.program);
        for (size_t i = 0; i < n; ++i) {
            Track& t = tracks_[lookups_[first + i].track];
            for (size_t k = 0; k < current_lobes_->size(); ++k) {
                const Lobe<float> lobe = load_lobe((*current_lobes_)[k].spec, lobe_channels_.data() + lobe_first_[k], i);
                add_lobe(t.here, lobe);
                if (!t.can_scatter || !lobe.spec->is_phase() || is_black(lobe.weight)) continue;
                looked_up_.push_back(lobe);
                looked_up_track_.push_back(lookups_[first + i].track);
            }
        }
        first += n;
    }
}

/// Keeps the phase functions of a track that scatters.
void Worker::take_event(uint32_t track) {
    const Track& t = tracks_[track];
    Path& path = paths_[t.target];
    const uint32_t first = static_cast<uint32_t>(event_lobes_.size());
    for (size_t k = 0; k < looked_up_.size(); ++k)
        if (looked_up_track_[k] == track) event_lobes_.push_back(looked_up_[k]);
    append_constant_phases(path, t.target);
    path.flags |= kWithin;
    events_.push_back({t.target, t.t, first, static_cast<uint32_t>(event_lobes_.size()) - first});
}

/// Phase functions of the homogeneous media that a path is in.
void Worker::append_constant_phases(const Path& path, uint32_t index) {
    const InsideOf* const m = inside(index);
    for (uint32_t i = 0; i < path.media; ++i) {
        if (m[i].medium != kInterior) {
            const auto& phases = plan_->media->medium(m[i].medium).phases;
            event_lobes_.insert(event_lobes_.end(), phases.begin(), phases.end());
        } else if (const Vec3f s = own_values(&path, m[i]).scattering; !is_black(s)) {
            Lobe<float> lobe;
            lobe.spec = &interior_phase();
            lobe.weight = s;
            lobe.p[0] = m[i].anisotropy;
            event_lobes_.push_back(lobe);
        }
    }
}

// ---- transmittance --------------------------------------------------------------------------------------------------

/// Shadow rays from where they are to shadow_hits_[i].t.
void Worker::attenuate(std::span<const uint32_t> shadows) {
    tracks_.clear();
    for (const uint32_t i : shadows) {
        ShadowRay& s = shadows_[i];
        if (is_black(s.value)) continue;
        ++counters_.medium_segments;
        const InsideOf* const m = shadow_inside_.data() + s.inside;
        bool varies = false;
        const MediumValues constant = constant_part(m, s.media, varies);
        const float t_end = shadow_hits_[i].t;
        if (!varies) {
            s.value *= transmittance(constant.extinction(), t_end - s.ray.t_min);
            continue;
        }
        Track t{.target = i, .is_path = false, .can_scatter = false, .inside = m, .count = s.media};
        t.origin = s.ray.origin;
        t.direction = s.ray.direction;
        t.t = s.ray.t_min;
        t.t_end = t_end;
        // What is constant need not be tracked.
        s.value *= transmittance(constant.extinction(), t_end - s.ray.t_min);
        t.numbers = s.numbers;
        Vec3f passed(1.f);
        if (!is_black(s.value) && begin_track(t, passed)) tracks_.push_back(t);
    }
    if (tracks_.empty()) return;
    run_tracks();
    for (const Track& t : tracks_) {
        shadows_[t.target].value *= t.weight;
        shadows_[t.target].numbers = t.numbers;
    }
}

/// Lamps that paths meet within media: as if by shadow rays.
void Worker::dim_lamps() {
    tracks_.clear();
    std::vector<uint32_t> of_track;
    for (uint32_t k = 0; k < met_.size(); ++k) {
        MetLamp& m = met_[k];
        const Path& path = paths_[m.path];
        if (path.media == 0) continue;
        bool varies = false;
        const InsideOf* const in = inside(m.path);
        const MediumValues constant = constant_part(in, path.media, varies);
        const float t_end = m.sample.distance;
        m.factor *= transmittance(constant.extinction(), t_end - path.t_min);
        if (!varies || is_black(m.factor)) continue;
        Track t{.target = m.path, .is_path = true, .can_scatter = false, .inside = in, .count = path.media};
        t.origin = path.history.origin;
        t.direction = path.history.direction;
        t.t = path.t_min;
        t.t_end = t_end;
        t.numbers.state = hash32(hash32(path.key.stream, path.key.index), set_media(path.vertex) ^ (0x2545f491u + m.lamp));
        Vec3f passed(1.f);
        if (!begin_track(t, passed)) continue;
        tracks_.push_back(t);
        of_track.push_back(k);
    }
    if (tracks_.empty()) return;
    run_tracks();
    for (size_t i = 0; i < tracks_.size(); ++i) met_[of_track[i]].factor *= tracks_[i].weight;
}

// ---- scattering -----------------------------------------------------------------------------------------------------

void Worker::scatter_in_media() {
    for (const Event& e : events_) {
        Path& path = paths_[e.path];
        RayHistory& h = path.history;
        ShadingPoint point = medium_point(h.origin, h.direction, e.t, kNothing);
        point.time = h.time;
        point.footprint = path.footprint + path.spread * e.t;
        // The throughput has the sum of the scattering coefficients: lobes have their share of it.
        const std::span<Lobe<float>> lobes(event_lobes_.data() + e.first, e.count);
        Vec3f sum(0.f);
        for (const Lobe<float>& l : lobes) sum += l.weight;
        bool inner = false;
        for (Lobe<float>& l : lobes) {
            for (int c = 0; c < 3; ++c) l.weight[c] = sum[c] > 0 ? l.weight[c] / sum[c] : 0.f;
            inner |= l.spec == &interior_phase();
        }
        if (per_lobe_.size() < lobes.size()) per_lobe_.resize(lobes.size());
        has_interior_ = false;
        const Bsdf<float> bsdf(lobes, {point.wo, point.ng, point.n});
        if (!bsdf.scatters()) continue;
        if (inner) path.flags |= kInnerDone;
        path.flags |= kDataDone;  // what is behind shows no more
        if (!plan_->scene.lights->empty()) sample_light(path, e.path, point, bsdf);

        const Sample4 u = sample_set(path.key, set_scatter(path.vertex));
        const bool layers = plan_->aovs->any_layer && !(path.flags & kScattered);
        const std::span<Vec3f> per_lobe = layers ? std::span(per_lobe_).first(lobes.size()) : std::span<Vec3f>{};
        const BsdfSample<float> s = bsdf.sample(u.u[0], u.u[1], u.u[2], per_lobe);
        if (!s.valid || is_black(s.weight)) continue;
        ++path.vertex;
        path.throughput *= s.weight;
        if (!is_finite(path.throughput)) {
            bad_[path.slot] = 1;
            continue;
        }
        if (layers) remember_shares(path, bsdf, s, per_lobe);
        path.flags |= kScattered;
        ++h.depth;
        const bool last = h.depth > plan_->settings.max_bounces;
        if (++h.volume > plan_->settings.volume_bounces || last) path.flags |= kLastVertex;
        h.kinds = kRayVolume;
        path.scatter_pdf = s.pdf;
        path.min_pdf = std::min(path.min_pdf, s.pdf);
        path.hit = {};  // the ray leaves no surface
        if (!survives(path, u.u[3])) continue;
        h.origin = point.p;
        h.direction = s.wi;
        path.footprint = point.footprint;
        path.t_min = 0;
        path.t_max = std::numeric_limits<float>::max();
        next_.push_back(e.path);
    }
}

}  // namespace alder
