// LightTable: collects emitters, weighs them by power, and samples them.
#include "render/light/light_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/emission.h"
#include "render/light/triangle.h"
#include "render/sampling.h"

namespace alder {

LightTable::LightTable(const Surfaces& surfaces, std::span<const std::shared_ptr<const MaterialPrograms>> materials,
                       std::span<const Light> lights, std::span<const std::shared_ptr<const SceneProgram>> light_programs,
                       std::shared_ptr<const WorldLight> world, const CameraModel& camera, const EvalContext& context)
    : surfaces_(&surfaces), lamp_programs_(light_programs.begin(), light_programs.end()), world_(std::move(world)) {
    const Vec3f extent = surfaces.accel().bounds_max() - surfaces.accel().bounds_min();
    scene_radius_ = std::clamp(0.5f * length(extent), 1e-6f, 1e15f);
    lamp_emitter_.assign(lights.size(), kNotSampled);
    for (uint32_t i = 0; i < lights.size(); ++i) {
        lamps_.emplace_back(lights[i]);
        const Lamp& lamp = lamps_.back();
        if (lamp.is_black()) continue;
        lamp_emitter_[i] = static_cast<uint32_t>(emitters_.size());
        add(Kind::Lamp, i, lamp.bounds(scene_radius_));
        if (!lamp.is_delta()) visible_.push_back(i);
    }
    std::vector<BoxIndex::Box> boxes;
    for (const uint32_t i : visible_) {
        const bool sun = lights[i].kind == LightKind::Sun;
        (sun ? visible_suns_ : visible_local_).push_back(i);
        if (!sun) boxes.push_back(lamps_[i].box());
    }
    // A box query costs about as much as testing a dozen lamps.
    if (boxes.size() > 12) visible_boxes_.emplace(std::move(boxes));
    if (world_->map.is_usable()) {
        world_emitter_ = static_cast<uint32_t>(emitters_.size());
        EmitterBounds b;
        b.distant = true;
        // Between that of an even sky, total/4, and of one small sun, total.
        b.irradiance = 0.5f * world_->map.total();
        b.power = world_->map.total() * kPi * sqr(scene_radius_);
        add(Kind::World, 0, b);
    }
    area_density_.resize(surfaces.instances().size());
    add_meshes(camera, context, materials);
    selector_ = LightSelector(std::move(bounds_));
    if (selector_.empty()) emitters_.clear();
}

void LightTable::add(Kind kind, size_t index, const EmitterBounds& bounds) {
    emitters_.push_back({kind, static_cast<uint32_t>(index)});
    bounds_.push_back(bounds);
}

void LightTable::add_meshes(const CameraModel& camera, const EvalContext& context,
                            std::span<const std::shared_ptr<const MaterialPrograms>> materials) {
    EmissionEvaluator evaluate({surfaces_, &camera, {}}, context);
    for (uint32_t i = 0; i < surfaces_->instances().size(); ++i) {
        const Instance& instance = surfaces_->instances()[i];
        const Mesh& mesh = surfaces_->mesh_of(i);
        std::vector<uint32_t> used(instance.materials);
        std::sort(used.begin(), used.end());
        used.erase(std::unique(used.begin(), used.end()), used.end());
        for (uint32_t material : used) {
            const MaterialPrograms* const m = materials[material].get();
            if (!m->emission || instance.visibility == 0) continue;
            MeshEmitter e{i, m, {}, {}};
            std::vector<float> areas;
            std::vector<ShadingPoint> centers;
            for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
                if (surfaces_->material(i, t) != material) continue;
                const auto p = surfaces_->world_triangle(i, t);
                const Vec3f n = cross(p[1] - p[0], p[2] - p[0]);
                const float area = 0.5f * length(n);
                if (!(area > 0) || !std::isfinite(area)) continue;
                e.triangles.push_back(t);
                areas.push_back(area);
                if (!m->emission_constant) centers.push_back(surfaces_->point(i, t, 1.f / 3, 1.f / 3, -safe_normalize(n), 0));
            }
            std::vector<float> brightness(areas.size(), luminance(m->emission_value));
            if (!m->emission_constant) {
                const std::vector<Vec3f> radiance = evaluate(*m->emission, centers);
                for (size_t k = 0; k < radiance.size(); ++k) brightness[k] = luminance(radiance[k]);
            }
            add_mesh_emitter(std::move(e), areas, brightness);
        }
    }
}

void LightTable::add_mesh_emitter(MeshEmitter e, const std::vector<float>& areas, const std::vector<float>& brightness) {
    double power = 0, area = 0;
    for (size_t k = 0; k < areas.size(); ++k) {
        const double b = std::isfinite(brightness[k]) ? std::max(brightness[k], 0.f) : 0.f;
        power += areas[k] * b;
        area += areas[k];
    }
    if (!(power > 0)) return;
    // A tenth by area alone: a triangle that is dark at its centre may still glow elsewhere.
    std::vector<double> weights(areas.size());
    for (size_t k = 0; k < areas.size(); ++k) {
        const double b = std::isfinite(brightness[k]) ? std::max(brightness[k], 0.f) : 0.f;
        weights[k] = areas[k] * (0.9 * b + 0.1 * power / area);
    }
    e.cdf = cumulative_table(weights);
    if (e.cdf.empty()) return;
    auto& density = area_density_[e.instance];
    density.resize(surfaces_->mesh_of(e.instance).triangles.size());
    const uint32_t emitter = static_cast<uint32_t>(emitters_.size());
    for (size_t k = 0; k < areas.size(); ++k) density[e.triangles[k]] = {emitter, (e.cdf[k + 1] - e.cdf[k]) / areas[k]};
    add(Kind::Mesh, meshes_.size(), bounds_of(e, power));
    meshes_.push_back(std::move(e));
}

EmitterBounds LightTable::bounds_of(const MeshEmitter& e, double power) const {
    Vec3f lo(1e30f), hi(-1e30f);
    for (const uint32_t t : e.triangles)
        for (const Vec3f p : surfaces_->world_triangle(e.instance, t))
            for (int c = 0; c < 3; ++c) {
                lo[c] = std::min(lo[c], p[c]);
                hi[c] = std::max(hi[c], p[c]);
            }
    EmitterBounds b;
    b.center = (lo + hi) * 0.5f;
    b.radius = 0.5f * length(hi - lo);
    // Radiance x area; seen from somewhere a closed shape shows a quarter of its surface, a flat one up to all of it.
    b.intensity = static_cast<float>(0.5 * power);
    b.power = static_cast<float>(2 * double(kPi) * power);
    return b;
}

bool LightTable::sample_mesh(const MeshEmitter& e, Vec3f p, float u_pick, float u1, float u2, float time, LightSample& s) const {
    const uint32_t triangle = e.triangles[pick_from_table(e.cdf, u_pick)];
    const auto corners = surfaces_->world_triangle(e.instance, triangle, time);
    const SphericalTriangle spherical(corners, p);
    float b1 = u1, b2 = u2;
    if (spherical.is_usable()) {
        Vec3f direction;
        if (!spherical.sample(u1, u2, direction, b1, b2)) return false;
    } else if (b2 > b1) {  // low-distortion map of the square (Heitz, "A Low-Distortion Map Between Triangle and Square", 2019)
        b1 *= 0.5f;
        b2 -= b1;
    } else {
        b2 *= 0.5f;
        b1 -= b2;
    }
    const Vec3f q = corners[0] * (1 - b1 - b2) + corners[1] * b1 + corners[2] * b2, to = q - p;
    const float d2 = dot(to, to);
    s.distance = std::sqrt(d2);
    if (!(s.distance > 0) || !std::isfinite(s.distance)) return false;
    s.wi = to / s.distance;
    s.point = surfaces_->point(e.instance, triangle, b1, b2, s.wi, s.distance, time);
    s.pdf = mesh_pdf(p, s.point);
    if (!(s.pdf > 0) || !std::isfinite(s.pdf)) return false;
    s.radiance = e.material->emission_constant ? e.material->emission_value : Vec3f(1.f);
    s.program = e.material->emission_constant ? nullptr : e.material->emission.get();
    const Instance& instance = surfaces_->instances()[e.instance];
    s.light_group = instance.light_group;
    s.visibility = instance.visibility;
    return true;
}

float LightTable::mesh_pdf(Vec3f origin, const ShadingPoint& hit) const {
    const auto& densities = area_density_[hit.instance];
    if (densities.empty()) return 0;
    const TriangleDensity& t = densities[hit.triangle];
    if (t.emitter == kNotSampled) return 0;
    float density = t.density * selector_.probability(origin, t.emitter);
    const auto corners = surfaces_->world_triangle(hit.instance, hit.triangle, hit.time);
    if (surfaces_->anything_moves()) {  // chosen by its area at the middle of the shutter, of whatever area it has now
        const auto middle = surfaces_->world_triangle(hit.instance, hit.triangle);
        const float before = length(cross(middle[1] - middle[0], middle[2] - middle[0])), now = length(cross(corners[1] - corners[0], corners[2] - corners[0]));
        if (!(now > 0)) return 0;
        density *= before / now;
    }
    if (const SphericalTriangle spherical(corners, origin); spherical.is_usable()) {
        const float area = 0.5f * length(cross(corners[1] - corners[0], corners[2] - corners[0]));
        return density * area / spherical.solid_angle();
    }
    const Vec3f d = hit.p - origin;
    const float d2 = dot(d, d), cos_light = std::abs(dot(hit.ng, d)) / std::sqrt(d2);
    return cos_light > 0 ? density * d2 / cos_light : 0.f;
}

float LightTable::world_pdf(Vec3f origin, Vec3f direction) const {
    if (world_emitter_ == kNotSampled) return 0;
    return selector_.probability(origin, world_emitter_) * world_->map.pdf(direction);
}

float LightTable::lamp_pdf(Vec3f origin, uint32_t lamp, float own_pdf) const {
    if (lamp_emitter_[lamp] == kNotSampled) return 0;
    return selector_.probability(origin, lamp_emitter_[lamp]) * own_pdf;
}

std::span<const uint32_t> LightTable::lamps_along(const Ray& ray, std::vector<uint32_t>& found) const {
    if (!visible_boxes_) return visible_;
    visible_boxes_->query(ray, found);
    for (uint32_t& i : found) i = visible_local_[i];
    if (!std::isfinite(ray.t_max)) found.insert(found.end(), visible_suns_.begin(), visible_suns_.end());
    return found;
}

bool LightTable::sample(Vec3f p, float u_pick, float u1, float u2, float time, LightSample& s) const {
    float probability = 0;
    const int k = emitters_.empty() ? -1 : selector_.pick(p, u_pick, probability);
    if (k < 0) return false;
    const Emitter& e = emitters_[k];
    s.program = nullptr;
    s.cast_shadow = true;
    s.is_delta = false;
    s.point = ShadingPoint{};
    if (e.kind == Kind::Mesh) return sample_mesh(meshes_[e.index], p, u_pick, u1, u2, time, s);
    if (e.kind == Kind::World) {
        s.wi = world_->map.sample(u1, u2, s.pdf);
        s.pdf *= probability;
        s.distance = std::numeric_limits<float>::infinity();
        s.radiance = Vec3f(1.f);
        s.program = world_->program.get();
        s.point.p = s.wi;
        s.point.n = s.point.ng = s.point.wo = -s.wi;
        s.point.distance = std::numeric_limits<float>::max();
        s.light_group = world_->light_group;
        s.visibility = world_->visibility;
        return s.pdf > 0;
    }
    const Lamp& lamp = lamps_[e.index];
    LampSample l;
    if (!lamp.sample(p, u1, u2, l)) return false;
    s.wi = l.wi;
    s.distance = l.distance;
    s.pdf = l.pdf * probability;
    s.is_delta = lamp.is_delta();
    s.radiance = l.radiance;
    s.program = lamp_programs_[e.index].get();
    s.point = lamp_point(lamp, l, p);
    s.light_group = lamp.light().light_group;
    s.visibility = lamp.light().visibility;
    s.cast_shadow = lamp.light().cast_shadow;
    return s.pdf > 0 && std::isfinite(s.pdf);
}

}  // namespace alder
