// LightTable: collects emitters, weighs them by power, and samples them.
#include "render/light/light_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/emission.h"
#include "render/light/triangle.h"
#include "render/sampling.h"

namespace alder {
namespace {

/// Index i with cdf[i] <= u < cdf[i+1]; u becomes the place within, again uniform.
size_t pick(const std::vector<float>& cdf, float& u) {
    const auto it = std::upper_bound(cdf.begin() + 1, cdf.end() - 1, u);
    const size_t i = static_cast<size_t>(it - cdf.begin()) - 1;
    const float step = cdf[i + 1] - cdf[i];
    u = step > 0 ? std::clamp((u - cdf[i]) / step, 0.f, 0.99999994f) : 0.f;
    return i;
}

/// Cumulative table of non-negative weights, ending in exactly 1; empty where all are zero.
std::vector<float> cumulative(const std::vector<double>& weights) {
    double total = 0;
    for (double w : weights) total += w;
    if (!(total > 0) || !std::isfinite(total)) return {};
    std::vector<float> cdf{0.f};
    double sum = 0;
    for (double w : weights) {
        sum += w;
        cdf.push_back(static_cast<float>(sum / total));
    }
    cdf.back() = 1;
    return cdf;
}

}  // namespace

LightTable::LightTable(const Surfaces& surfaces, std::span<const std::shared_ptr<const MaterialPrograms>> materials,
                       std::span<const Light> lights, std::span<const std::shared_ptr<const SceneProgram>> light_programs,
                       std::shared_ptr<const WorldLight> world, const CameraModel& camera, const EvalContext& context)
    : surfaces_(&surfaces), lamp_programs_(light_programs.begin(), light_programs.end()), world_(std::move(world)) {
    const Vec3f extent = surfaces.accel().bounds_max() - surfaces.accel().bounds_min();
    scene_radius_ = std::clamp(0.5f * length(extent), 1e-6f, 1e15f);
    for (uint32_t i = 0; i < lights.size(); ++i) {
        lamps_.emplace_back(lights[i]);
        const Lamp& lamp = lamps_.back();
        if (!lamp.is_black()) emitters_.push_back({Kind::Lamp, i, lamp.power(scene_radius_)});
    }
    if (world_->map.is_usable())
        emitters_.push_back({Kind::World, 0, double(world_->map.total()) * kPi * sqr(scene_radius_)});
    area_density_.resize(surfaces.instances().size());
    add_meshes(camera, context, materials);

    std::vector<double> powers;
    for (Emitter& e : emitters_) powers.push_back(std::isfinite(e.power) ? std::clamp(e.power, 0.0, 1e30) : 0.0);
    cdf_ = cumulative(powers);
    if (cdf_.empty()) emitters_.clear();
    for (size_t i = 0; i < emitters_.size(); ++i) {
        const Emitter& e = emitters_[i];
        const float probability = cdf_[i + 1] - cdf_[i];
        if (e.kind == Kind::World) world_probability_ = probability;
        if (e.kind == Kind::Lamp && !lamps_[e.index].is_delta()) visible_.push_back({e.index, probability});
        if (e.kind == Kind::Mesh) {
            MeshEmitter& m = meshes_[e.index];
            m.probability = probability;
            for (uint32_t t : m.triangles) area_density_[m.instance][t] *= probability;
        }
    }
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
            MeshEmitter e{i, m, {}, {}, 0};
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
    e.cdf = cumulative(weights);
    if (e.cdf.empty()) return;
    auto& density = area_density_[e.instance];
    density.resize(surfaces_->mesh_of(e.instance).triangles.size(), 0.f);
    for (size_t k = 0; k < areas.size(); ++k) density[e.triangles[k]] = (e.cdf[k + 1] - e.cdf[k]) / areas[k];
    emitters_.push_back({Kind::Mesh, static_cast<uint32_t>(meshes_.size()), 2 * double(kPi) * power});
    meshes_.push_back(std::move(e));
}

bool LightTable::sample_mesh(const MeshEmitter& e, Vec3f p, float u_pick, float u1, float u2, LightSample& s) const {
    const uint32_t triangle = e.triangles[pick(e.cdf, u_pick)];
    const auto corners = surfaces_->world_triangle(e.instance, triangle);
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
    s.point = surfaces_->point(e.instance, triangle, b1, b2, s.wi, s.distance);
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
    const auto& density = area_density_[hit.instance];
    if (density.empty() || density[hit.triangle] == 0) return 0;
    const auto corners = surfaces_->world_triangle(hit.instance, hit.triangle);
    if (const SphericalTriangle spherical(corners, origin); spherical.is_usable()) {
        const float area = 0.5f * length(cross(corners[1] - corners[0], corners[2] - corners[0]));
        return density[hit.triangle] * area / spherical.solid_angle();
    }
    const Vec3f d = hit.p - origin;
    const float d2 = dot(d, d), cos_light = std::abs(dot(hit.ng, d)) / std::sqrt(d2);
    return cos_light > 0 ? density[hit.triangle] * d2 / cos_light : 0.f;
}

float LightTable::world_pdf(Vec3f direction) const {
    return world_probability_ > 0 ? world_probability_ * world_->map.pdf(direction) : 0.f;
}

bool LightTable::sample(Vec3f p, float u_pick, float u1, float u2, LightSample& s) const {
    if (emitters_.empty()) return false;
    const size_t k = pick(cdf_, u_pick);
    const Emitter& e = emitters_[k];
    const float probability = cdf_[k + 1] - cdf_[k];
    if (!(probability > 0)) return false;
    s.program = nullptr;
    s.cast_shadow = true;
    s.is_delta = false;
    s.point = ShadingPoint{};
    if (e.kind == Kind::Mesh) return sample_mesh(meshes_[e.index], p, u_pick, u1, u2, s);
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
    s.point = lamp_point(l, p);
    s.light_group = lamp.light().light_group;
    s.visibility = lamp.light().visibility;
    s.cast_shadow = lamp.light().cast_shadow;
    return s.pdf > 0 && std::isfinite(s.pdf);
}

}  // namespace alder
