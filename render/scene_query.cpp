// Rays for shading nodes. Ambient occlusion: cosine-weighted rays. Bevel: probes along three axes with a cubic falloff, after King
// et al., "BSSRDF Importance Sampling", SIGGRAPH 2013 talks, as Cycles does it.
#include "render/scene_query.h"

#include <algorithm>
#include <cmath>

#include "render/sampling.h"

namespace alder {
namespace {

constexpr int kMostProbeHits = 64;  ///< along one probe; what lies behind is left out

Vec3f vec(const float (&v)[3]) { return {v[0], v[1], v[2]}; }

/// How far a ray starts off the surface: beyond the rounding of positions, those of an evaluation request too.
float clearance(const SceneQuery::Point& point, Vec3f p, const Accel& accel) {
    const float size = std::max(max_abs(p), max_abs(accel.bounds_max() - accel.bounds_min()));
    return std::max(point.position_error, 0x1p-20f * size);
}

/// A square's points, well spread for any count: a rank-1 lattice with the golden ratio, shifted at random.
class Lattice {
  public:
    Lattice(uint32_t seed, int count) : count_(count), shift_u_(unit(scrambled(seed))), shift_v_(unit(scrambled(seed ^ 0x9e3779b9u))) {}
    Disk point(int i) const {
        const float u = (static_cast<float>(i) + shift_u_) / static_cast<float>(count_);
        const double v = shift_v_ + i * 0.6180339887498949;
        return {std::min(u, 0x1.fffffep-1f), std::min(static_cast<float>(v - std::floor(v)), 0x1.fffffep-1f)};
    }

  private:
    static uint32_t scrambled(uint32_t x) {  // Wellons' lowbias32
        x = (x ^ (x >> 16)) * 0x7feb352du;
        x = (x ^ (x >> 15)) * 0x846ca68bu;
        return x ^ (x >> 16);
    }
    static float unit(uint32_t x) { return static_cast<float>(x >> 8) * 0x1p-24f; }
    int count_;
    float shift_u_, shift_v_;
};

/// Density of the falloff (R - r)^3 over the disk of radius R.
float falloff(float radius, float r) {
    if (!(r < radius)) return 0;
    const float t = 1 - r / radius;
    return 10 * t * t * t / (kPi * radius * radius);
}
/// Distance within which a share xi of it lies: 10x² - 20x³ + 15x⁴ - 4x⁵ = xi, by Newton's method.
float sampled_distance(float xi) {
    float x = 0.25f;
    for (int i = 0; i < 10; ++i) {
        const float x2 = x * x, rest = 1 - x;
        const float f = x2 * (10 + x * (-20 + x * (15 - 4 * x))) - xi, slope = 20 * x * rest * rest * rest;
        if (std::abs(f) < 1e-6f || slope == 0) break;
        x = std::clamp(x - f / slope, 0.f, 1.f);
    }
    return x;
}

}  // namespace

float SurfaceQuery::unoccluded(const Point& point, const float normal[3], float distance, int samples, bool only_local) const {
    if (point.instance < 0 || samples < 1) return 1;
    const Vec3f n(normal[0], normal[1], normal[2]), p = vec(point.p), ng = vec(point.ng);
    if (!is_finite(n) || !is_finite(p) || is_black(n)) return 1;
    const Frame frame = frame_about(n);
    const Lattice lattice(point.seed, samples);
    const Vec3f step = ng * clearance(point, p, surfaces_.accel());
    int open = 0;
    for (int i = 0; i < samples; ++i) {
        const Disk s = lattice.point(i), d = uniform_disk(s.x, s.y);
        const Vec3f direction = frame.to_world({d.x, d.y, safe_sqrt(1 - d.x * d.x - d.y * d.y)});
        const Ray ray{dot(ng, direction) < 0 ? p - step : p + step, direction, 0, distance};
        Hit hit;
        open += only_local ? !surfaces_.accel().intersect_instance(static_cast<uint32_t>(point.instance), ray, hit) : surfaces_.accel().occluded(ray, nullptr) == Occlusion::Clear;
    }
    return static_cast<float>(open) / static_cast<float>(samples);
}

void SurfaceQuery::bevel(const Point& point, float radius, int samples, float normal[3]) const {
    for (int c = 0; c < 3; ++c) normal[c] = point.n[c];
    const Vec3f p = vec(point.p), ng = vec(point.ng);
    if (point.instance < 0 || samples < 1 || !(radius > 0) || !std::isfinite(radius) || !is_finite(p) || !is_finite(ng)) return;
    const auto instance = static_cast<uint32_t>(point.instance);
    const Frame about = cycles_frame(ng);
    const Lattice lattice(point.seed, samples);
    // Of a probe's hits four are taken at random, as Cycles does: the mean of the normalised sums is the shorter, the fewer there are.
    constexpr int kHitsKept = 4;
    auto random = static_cast<uint32_t>(point.seed) ^ 0x64c6a40eu;
    Vec3f sum(0.f);
    for (int i = 0; i < samples; ++i) {
        Disk xi = lattice.point(i);
        // Half of the probes go along the normal, a quarter along each tangent.
        Vec3f axis = about.z, t = about.x, b = about.y;
        float pick_axis = 0.5f, pick_t = 0.25f, pick_b = 0.25f;
        if (xi.x < 0.5f) {
            xi.x *= 2;
        } else if (xi.x < 0.75f) {
            std::swap(axis, t);
            std::swap(pick_axis, pick_t);
            xi.x = (xi.x - 0.5f) * 4;
        } else {
            std::swap(axis, b);
            std::swap(pick_axis, pick_b);
            xi.x = (xi.x - 0.75f) * 4;
        }
        const float r = radius * sampled_distance(xi.y), height = safe_sqrt(radius * radius - r * r), phi = 2 * kPi * xi.x;
        const float density = falloff(radius, r);
        if (!(density > 0) || !(height > 0)) continue;
        Ray ray{p + axis * height + t * (r * std::cos(phi)) + b * (r * std::sin(phi)), -axis, 0, 2 * height};
        Hit kept[kHitsKept];
        int hits = 0;
        while (hits < kMostProbeHits) {
            Hit hit;
            if (!surfaces_.accel().intersect_instance(instance, ray, hit)) break;
            const int place = hits < kHitsKept ? hits : static_cast<int>((random = random * 1664525u + 1013904223u) >> 8) % (hits + 1);
            if (place < kHitsKept) kept[place] = hit;
            ++hits;
            ray.t_min = std::nextafter(hit.t, std::numeric_limits<float>::infinity());
            if (!(ray.t_min < ray.t_max)) break;
        }
        const float share = std::max(1.f, static_cast<float>(hits) / kHitsKept);
        for (int h = 0; h < std::min(hits, kHitsKept); ++h) {
            const Hit& hit = kept[h];
            const ShadingPoint s = surfaces_.point(hit.instance, hit.triangle, hit.u, hit.v, ray.direction, hit.t);
            const Vec3f outside = s.backfacing ? -s.n : s.n;
            const float along = pick_axis * std::abs(dot(axis, s.ng)), along_t = pick_t * std::abs(dot(t, s.ng)), along_b = pick_b * std::abs(dot(b, s.ng));
            const float squares = along * along + along_t * along_t + along_b * along_b;
            // Power heuristic over the axes; the axis' own density cancels.
            if (squares > 0) sum += outside * (share * along / squares * falloff(radius, length(s.p - p)) / density);
        }
    }
    const Vec3f n = safe_normalize(sum);
    if (is_black(n) || !is_finite(n)) return;
    for (int c = 0; c < 3; ++c) normal[c] = point.backfacing ? -n[c] : n[c];
}

bool SurfaceQuery::curvature(const Point& point, const float view[3], float radius, int side, float& value) const {
    const Vec3f p = vec(point.p), n = vec(point.n), along = safe_normalize(Vec3f(view[0], view[1], view[2]));
    if (point.instance < 0 || side < 1 || !(radius > 0) || !std::isfinite(radius) || !is_finite(p) || !is_finite(along) || is_black(along)) return false;
    const Frame frame = frame_about(n);
    SphereFit fit(radius);
    for (int i = 0; i < side * side; ++i) {
        // The middle of each stratum: the same for every sample of a pixel.
        const Disk d = uniform_disk((static_cast<float>(i % side) + 0.5f) / static_cast<float>(side), (static_cast<float>(i / side) + 0.5f) / static_cast<float>(side));
        const Ray ray{p + (frame.x * d.x + frame.y * d.y) * radius - along * (0.5f * radius), along, 0, radius};
        Hit hit;
        if (!surfaces_.accel().intersect(ray, kVisibleAll, hit)) continue;
        const ShadingPoint s = surfaces_.point(hit.instance, hit.triangle, hit.u, hit.v, ray.direction, hit.t);
        const Vec3f normal = s.backfacing ? -s.n : s.n;
        const double q[3] = {double(s.p.x) - p.x, double(s.p.y) - p.y, double(s.p.z) - p.z}, m[3] = {normal.x, normal.y, normal.z};
        fit.add(q, m);
    }
    return fit.curvature(value);
}

}  // namespace alder
