// Worker: shading of surfaces in batches of one program, and the choice of the next direction.
#include <algorithm>
#include <cmath>

#include "render/sampling.h"
#include "render/worker.h"

namespace alder {
namespace {

/// Widths no smaller than `width`, as Cycles widens each kind.
void blur_lobe(Lobe<float>& lobe, float width) {
    const LobeSpec& spec = *lobe.spec;
    const auto widen = [&](int p) { lobe.p[p] = std::max(lobe.p[p], width); };
    if (spec.is_microfacet()) {
        const MicrofacetLayout layout(spec);
        widen(layout.alpha_x);
        widen(layout.alpha_y);
    } else if (spec.kind == LobeKind::HairChiang) {
        for (const int p : {3, 4, 5}) widen(p);
    } else if (spec.kind == LobeKind::HairHuang) {
        widen(3);
    }
}

/// Portals are looked through as transparent surfaces are.
Vec3f seen_through(const Bsdf<float>& bsdf) {
    Vec3f sum(0.f);
    for (const Lobe<float>& l : bsdf.lobes())
        if (l.spec->kind == LobeKind::Transparent || l.spec->kind == LobeKind::RayPortal) sum += l.weight;
    return sum;
}

}  // namespace

void Worker::shade_surfaces() {
    for (size_t key = 0; key + 1 < key_count_.size(); ++key) {
        const size_t first = key_count_[key], last = key_count_[key + 1];
        if (first == last) continue;
        const RenderPlan::SurfacePrograms& programs = plan_->surface[key / 2];
        const bool with_aovs = key & 1;
        const SceneProgram* const program = with_aovs ? programs.with_aovs : programs.plain;
        if (!program) {  // no surface shader: black, or the boundary of a volume
            if (plan_->media && plan_->scene.materials[key / 2]->boundary_only)
                for (size_t i = first; i < last; ++i) pass_boundary(paths_[order_[i]], order_[i]);
            continue;
        }
        const size_t batch = program->program->batch();
        for (size_t i = first; i < last; i += batch) {
            if (plan_->stopped()) return;
            shade_batch(*program, programs, with_aovs, std::span(order_).subspan(i, std::min(batch, last - i)));
        }
    }
}

void Worker::shade_batch(const SceneProgram& program, const RenderPlan::SurfacePrograms& programs, bool with_aovs,
                         std::span<const uint32_t> paths) {
    const Surfaces& surfaces = *plan_->scene.surfaces;
    points_.clear();
    histories_.clear();
    for (const uint32_t index : paths) {
        const Path& path = paths_[index];
        const Hit& h = path.hit;
        points_.push_back(surfaces.point(h.instance, h.triangle, h.u, h.v, path.history.direction, h.t, path.history.time));
        points_.back().footprint = path.footprint + path.spread * h.t;
        histories_.push_back(&path.history);
    }
    counters_.shading_points += paths.size();
    const auto inputs = gather_.gather(program.plan, plan_->inputs, points_, histories_.data());
    const SceneQueryScope scope(&plan_->query);
    executor_.run(*program.program, static_cast<uint32_t>(paths.size()), inputs);
    gather_lobes(*program.program);
    for (size_t i = 0; i < paths.size(); ++i)
        if (shade_point(paths_[paths[i]], paths[i], points_[i], programs, *program.program, with_aovs, i)) next_.push_back(paths[i]);
}

void Worker::gather_lobes(const Program& program) {
    lobe_channels_.clear();
    lobe_first_.clear();
    for (const ProgramLobe& lobe : program.lobes()) {
        lobe_first_.push_back(lobe_channels_.size());
        for (int c = 0; c < lobe.spec.channels(); ++c) lobe_channels_.push_back(executor_.channel(lobe.register_first + c));
    }
    if (lobes_.size() < program.lobes().size()) {
        lobes_.resize(program.lobes().size());
        per_lobe_.resize(program.lobes().size());
    }
    current_lobes_ = &program.lobes();
}

/// What lies behind a surface of several layers is their sum.
void Worker::add_interior(const Lobe<float>& lobe) {
    if (!has_interior_) {
        interior_ = lobe;
    } else {
        const float a = average(interior_.weight), b = average(lobe.weight);
        interior_.weight += lobe.weight;
        for (int c = 0; c < 3; ++c) interior_.p[c] += lobe.p[c];
        if (a + b > 0) interior_.p[3] = (interior_.p[3] * a + lobe.p[3] * b) / (a + b);
    }
    has_interior_ = true;
}

/// The lobes that exist at point i for this path.
std::span<Lobe<float>> Worker::load_lobes(const Path& path, size_t i) {
    size_t count = 0;
    has_interior_ = false;
    const RenderSettings& s = plan_->settings;
    // Cycles' Filter Glossy: behind scatterings in unlikely directions glossy lobes are widened, the more the less likely.
    const float likely = s.filter_glossy > 0 ? path.min_pdf / s.filter_glossy : 1.f;
    const float blur = likely < 1 ? 0.5f * std::sqrt(1 - likely) : 0.f;
    for (size_t k = 0; k < current_lobes_->size(); ++k) {
        const LobeSpec& spec = (*current_lobes_)[k].spec;
        const Channel<float>* const c = lobe_channels_.data() + lobe_first_[k];
        if (c[0].p[i * c[0].stride] == 0 && c[1].p[i * c[1].stride] == 0 && c[2].p[i * c[2].stride] == 0) continue;
        if (spec.shadow_only) continue;
        if (spec.kind == LobeKind::Interior) {
            add_interior(load_lobe(spec, c, i));
            continue;
        }
        const bool scatters = spec.kind != LobeKind::Emission && spec.kind != LobeKind::Transparent && spec.kind != LobeKind::Holdout &&
                              spec.kind != LobeKind::RayPortal;
        if (scatters && path.flags & kLastVertex) continue;
        if (path.flags & kDiffuseBefore && spec.is_microfacet()) {
            const bool refracts = spec.kind == LobeKind::MicrofacetTransmission;
            const bool both = spec.kind == LobeKind::MicrofacetGlass;
            if (both ? !s.caustics_reflective && !s.caustics_refractive : refracts ? !s.caustics_refractive : !s.caustics_reflective) continue;
        }
        lobes_[count] = load_lobe(spec, c, i);
        if (blur > 0) blur_lobe(lobes_[count], blur);
        // Subsurface light is worth its noise where the eye sees it: after a diffuse scattering Cycles takes Lambert instead.
        if (spec.cycles_profile && path.flags & kDiffuseBefore) lobes_[count].spec = &subsurface_lambert();
        ++count;
    }
    return {lobes_.data(), count};
}

bool Worker::shade_point(Path& path, uint32_t index, const ShadingPoint& point, const RenderPlan::SurfacePrograms& programs,
                         const Program& program, bool with_aovs, size_t i) {
    const std::span<Lobe<float>> lobes = load_lobes(path, i);
    const Bsdf<float> bsdf(lobes, {point.wo, point.ng, point.n});
    const AovPlan& a = *plan_->aovs;

    if (plan_->scene.surfaces->instances()[point.instance].holdout && !(path.flags & kScattered)) {
        // All but what is transparent becomes a hole.
        const Vec3f open = bsdf.transparency();
        row(path.slot)[a.alpha] -= average((Vec3f(1.f) - open) * path.throughput);
        path.throughput *= open;
        if (is_black(open) || ++path.history.transparent > plan_->settings.transparent_bounces) return false;
        ++path.vertex;
        path.t_min = std::nextafter(point.distance, std::numeric_limits<float>::infinity());
        return path.t_min < path.t_max;
    }
    if (program.facts().has_emission) emit(path, point, bsdf);
    if (!(path.flags & kScattered))
        if (const Vec3f holdout = bsdf.holdout(); !is_black(holdout)) row(path.slot)[a.alpha] -= average(holdout * path.throughput);
    if (!(path.flags & kDataDone) && average(seen_through(bsdf)) <= 0.5f) {  // Cycles' pass alpha threshold
        path.flags |= kDataDone;
        if (a.any_data || a.any_color || with_aovs) record_data(path, point, bsdf, programs, program, with_aovs, i);
    }
    if (!bsdf.scatters()) return false;
    if (bsdf.has_density() && !plan_->scene.lights->empty()) sample_light(path, index, point, bsdf);
    return scatter(path, index, point, bsdf);
}

void Worker::emit(const Path& path, const ShadingPoint& point, const Bsdf<float>& bsdf) {
    const Vec3f radiance = bsdf.emission();
    if (is_black(radiance)) return;
    // The density of light sampling is that of the vertex the ray left; surfaces passed straight through do not change it.
    const float light_pdf = path.scatter_pdf > 0 ? plan_->scene.lights->mesh_pdf(path.history.origin, point) : 0.f;
    const float weight = met_weight(light_pdf, path.scatter_pdf);
    add_path_light(path, path.throughput * radiance * weight, plan_->scene.surfaces->instances()[point.instance].light_group, false);
}

void Worker::record_data(const Path& path, const ShadingPoint& point, const Bsdf<float>& bsdf,
                         const RenderPlan::SurfacePrograms& programs, const Program& program, bool with_aovs, size_t i) {
    const AovPlan& a = *plan_->aovs;
    float* const r = row(path.slot);
    const auto put = [r](int channel, Vec3f v) {
        if (channel < 0) return;
        r[channel] = v.x;
        r[channel + 1] = v.y;
        r[channel + 2] = v.z;
    };
    if (a.hits >= 0) r[a.hits] = 1;
    put(a.p, point.p);
    put(a.n, point.n);
    put(a.ng, point.ng);
    if (a.uv >= 0) {
        const Mesh& mesh = plan_->scene.surfaces->mesh_of(point.instance);
        if (!mesh.uv.empty() && mesh.uv.size() == 3 * mesh.triangles.size()) {
            const auto* const uv = mesh.uv.data() + size_t{3} * point.triangle;
            for (int c = 0; c < 2; ++c) r[a.uv + c] = uv[0][c] * (1 - point.u - point.v) + uv[1][c] * point.u + uv[2][c] * point.v;
        }
    }
    if (a.z >= 0) r[a.z] = plan_->camera.depth(point.p);
    if (a.id_object >= 0) r[a.id_object] = static_cast<float>(point.instance);
    if (a.id_material >= 0) r[a.id_material] = static_cast<float>(plan_->scene.surfaces->material(point.instance, point.triangle));
    if (a.any_color) {
        const auto albedo = [&](LobeLabel l) { return bsdf.albedo(l); };
        const Vec3f diffuse = albedo(LobeLabel::Diffuse) + albedo(LobeLabel::Backlight) + albedo(LobeLabel::Sss) +
                              albedo(LobeLabel::Local) + albedo(LobeLabel::Global);
        const Vec3f specular = albedo(LobeLabel::Specular) + albedo(LobeLabel::Specular2) + albedo(LobeLabel::Glint);
        const Vec3f refraction = albedo(LobeLabel::Refraction) + albedo(LobeLabel::HairTransmission);
        put(a.diffuse_color, diffuse);
        put(a.specular_color, specular);
        put(a.refraction_color, refraction);
        put(a.denoise_albedo, diffuse + specular + refraction);
        put(a.denoise_normal, point.n);
    }
    if (!with_aovs) return;
    for (size_t o = 0; o < programs.aov_user.size(); ++o) {
        const UserAov& u = a.user[programs.aov_user[o]];
        const ProgramOutput& out = program.outputs()[o];
        Vec3f v(0.f);
        const int have = channels(out.type);
        for (int c = 0; c < 3; ++c) {
            const Channel<float> ch = executor_.channel(out.register_first + (have == 3 ? c : 0));
            v[c] = ch.p[i * ch.stride];
        }
        if (u.scalar()) r[u.channel] = have == 3 ? average(v) : v.x;
        else put(u.channel, v);
    }
}

/// To which layers the light belongs that a path finds after its first scattering.
void Worker::remember_shares(const Path& path, const Bsdf<float>& bsdf, const BsdfSample<float>& s, std::span<const Vec3f> per_lobe) {
    LabelWeights& w = path_weights_[path.slot];
    w.fill(Vec3f(0.f));
    for (size_t k = 0; k < per_lobe.size(); ++k) {
        const int label = static_cast<int>(label_of(*bsdf.lobes()[k].spec, s.is_transmission));
        if (label < kScatterLabels) w[label] += per_lobe[k];
    }
    for (Vec3f& x : w)
        for (int c = 0; c < 3; ++c) x[c] = s.weight[c] != 0 ? x[c] / s.weight[c] : 0.f;
}

/// Roulette by throughput, from the third scattering on; the square root kills later than the throughput itself would, which
/// costs rays but not variance in dark corners.
bool Worker::survives(Path& path, float u) {
    if (path.history.depth < 2) return true;
    const float survive = std::sqrt(std::max({path.throughput.x, path.throughput.y, path.throughput.z}));
    if (survive >= 1) return true;
    if (!(u < survive)) return false;
    path.throughput *= 1 / survive;
    return true;
}

/// Chooses the next direction; false: the path ends here.
bool Worker::scatter(Path& path, uint32_t index, const ShadingPoint& point, const Bsdf<float>& bsdf) {
    const Sample4 u = sample_set(path.key, set_scatter(path.vertex));
    const bool layers = plan_->aovs->any_layer && !(path.flags & kScattered);
    const std::span<Vec3f> per_lobe = layers ? std::span(per_lobe_).first(bsdf.lobes().size()) : std::span<Vec3f>{};
    const BsdfSample<float> s = bsdf.sample(u.u[0], u.u[1], u.u[2], per_lobe);
    if (!s.valid || is_black(s.weight)) return false;
    const RenderSettings& settings = plan_->settings;
    RayHistory& h = path.history;
    const LobeSpec& spec = *bsdf.lobes()[s.lobe].spec;
    ++path.vertex;
    path.throughput *= s.weight;
    if (!is_finite(path.throughput)) {
        bad_[path.slot] = 1;
        return false;
    }

    if (spec.kind == LobeKind::Transparent) {
        // The ray goes on as it was, from the same origin: densities of lights still refer to the vertex it left.
        if (++h.transparent > settings.transparent_bounces) return false;
        if (plan_->media) cross(inside(index), path.media, point, nullptr);
        path.t_min = std::nextafter(point.distance, std::numeric_limits<float>::infinity());
        return path.t_min < path.t_max;
    }

    if (spec.kind == LobeKind::RayPortal) {
        // Light sampling does not find the way through, so that what the ray meets counts in full.
        if (++h.transparent > settings.transparent_bounces) return false;
        const auto& p = bsdf.lobes()[s.lobe].p;
        const Vec3f to(p[0], p[1], p[2]);
        if (!is_finite(to)) return false;
        if (plan_->media) cross(inside(index), path.media, point, nullptr);
        const Vec3f step = to - point.p;
        h.origin = dot(step, step) > 1e-9f ? to : leave_surface(point, s.wi);
        h.direction = s.wi;
        path.footprint = point.footprint;
        path.scatter_pdf = 0;
        path.t_min = 0;
        path.t_max = std::numeric_limits<float>::max();
        return true;
    }
    if (spec.kind == LobeKind::MicrofacetGlass && path.flags & kDiffuseBefore &&
        !(s.is_transmission ? settings.caustics_refractive : settings.caustics_reflective))
        return false;
    if (layers) remember_shares(path, bsdf, s, per_lobe);
    path.flags |= kScattered;
    if (spec.is_subsurface()) {  // goes on from where it leaves the body, after the surfaces of this depth
        walks_.push_back({index, point, bsdf.lobes()[s.lobe]});
        return false;
    }
    ++h.depth;
    bool last = h.depth > settings.max_bounces;
    h.kinds = s.is_diffuse ? kRayDiffuse : kRayGlossy;
    if (s.is_delta) h.kinds |= kRaySingular;
    if (s.is_diffuse) path.flags |= kDiffuseBefore;
    if (s.is_transmission) {
        h.kinds |= kRayTransmission;
        last = last || ++h.transmission > settings.transmission_bounces;
    } else {
        h.kinds |= kRayReflection;
        if (s.is_diffuse) last = last || ++h.diffuse > settings.diffuse_bounces;
        else last = last || ++h.glossy > settings.glossy_bounces;
    }
    if (last) path.flags |= kLastVertex;
    if (!s.is_diffuse) h.previous_alpha = s.roughness;  // alSurface's message: diffuse rays pass on what they found
    path.scatter_pdf = s.is_delta ? 0 : s.pdf;
    if (!s.is_delta) path.min_pdf = std::min(path.min_pdf, s.pdf);

    if (!survives(path, u.u[3])) return false;
    if (plan_->media && dot(point.ng, s.wi) < 0) cross(inside(index), path.media, point, has_interior_ ? &interior_ : nullptr);
    h.origin = leave_surface(point, s.wi);
    h.direction = s.wi;
    path.footprint = point.footprint;
    path.t_min = 0;
    path.t_max = std::numeric_limits<float>::max();
    return true;
}

}  // namespace alder
