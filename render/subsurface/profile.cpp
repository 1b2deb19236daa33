// Subsurface scattering by radial profiles: points of the same object are probed along three axes.
// King et al., "BSSRDF Importance Sampling", SIGGRAPH 2013 talks; profile: Christensen and Burley, "Approximate Reflectance
// Profiles for Efficient Subsurface Scattering", 2015.
#include <algorithm>
#include <cmath>

#include "render/sampling.h"
#include "render/subsurface/subsurface.h"

namespace alder {
namespace {

constexpr float kBurleyReach = 16;                     ///< in units of d
constexpr float kBurleyReached = 0.9963790093708328f;  ///< share of the profile within it
constexpr int kMostHits = 16;

struct Profiles {
    const Lobe<float>& lobe;
    int channels[3], count = 0;  ///< those that are probed
    int narrow = 0;              ///< and those too narrow for it: their light leaves where it entered
    Vec3f is_narrow{0, 0, 0};
    /// position_error: of the entry point.
    Profiles(const Lobe<float>& l, float position_error) : lobe(l) {
        for (int c = 0; c < 3; ++c) {
            if (l.weight[c] == 0 || !(l.p[c] > 0) || !std::isfinite(l.p[c])) continue;
            if (reach(c) > 8 * position_error) {
                channels[count++] = c;
            } else {
                is_narrow[c] = 1;
                ++narrow;
            }
        }
    }
    bool cubic() const { return lobe.spec->order == 1; }
    float reach(int c) const { return cubic() ? lobe.p[c] : kBurleyReach * lobe.p[c]; }
    float sample(int c, float u) const { return cubic() ? sample_cubic_radius(lobe.p[c], u) : sample_burley_radius(lobe.p[c], u); }
    /// 2 pi r R(r)
    float radial(int c, float r) const { return cubic() ? cubic_radial_density(lobe.p[c], r) : burley_radial_density(lobe.p[c], r); }
    Vec3f radial(float r) const {
        Vec3f v(0.f);
        for (int i = 0; i < count; ++i) v[channels[i]] = radial(channels[i], r);
        return v;
    }
    /// Of the radius, with the channel chosen evenly.
    float density(float r) const {
        const Vec3f v = radial(r);
        return (v.x + v.y + v.z) / static_cast<float>(count);
    }
};

struct Found {
    Hit hit;
    Vec3f weight;
};

}  // namespace

float burley_radial_density(float d, float r) {
    if (!(r > 0) || r >= kBurleyReach * d) return 0;
    const float e = std::exp(-r / (3 * d));
    return (e * e * e + e) / (4 * d * kBurleyReached);
}

float sample_burley_radius(float d, float u) {
    // 1 - e^{-r}/4 - 3 e^{-r/3}/4 = u: with x = e^{-r/3}, x^3 + 3x = 4 (1 - u), whose one real root Cardano gives.
    const float q = 2 * (1 - std::min(u, 0.99999994f) * kBurleyReached);
    const float a = std::cbrt(q + std::sqrt(q * q + 1));
    const float x = a - 1 / a;
    return std::min(-3 * std::log(std::clamp(x, 1e-7f, 1.f)), kBurleyReach) * d;
}

float cubic_radial_density(float radius, float r) {
    if (!(r >= 0) || r >= radius) return 0;
    const float x = r / radius, y = 1 - x;
    return 20 * x * y * y * y / radius;
}

float sample_cubic_radius(float radius, float u) {
    // (1-x)^4 (1+4x) = 1 - u, decreasing in x: Newton's steps within a bracket.
    float low = 0, high = 1, x = 0.3f;
    for (int i = 0; i < 24; ++i) {
        const float y = 1 - x, f = y * y * y * y * (1 + 4 * x) - (1 - u);
        (f > 0 ? low : high) = x;
        const float slope = -20 * x * y * y * y;
        const float next = x - f / slope;
        x = next > low && next < high ? next : 0.5f * (low + high);
        if (high - low < 1e-6f || std::abs(f) < 1e-7f) break;
    }
    return x * radius;
}

bool probe_profile(const Surfaces& surfaces, const ShadingPoint& entry, const Lobe<float>& lobe, Vec3f throughput, WalkNumbers& numbers,
                   SubsurfaceExit& exit, uint64_t& rays) {
    const Profiles profiles(lobe, entry.error);
    const int all = profiles.count + profiles.narrow;
    if (all == 0) return false;
    const Sample4& u = numbers.first();
    float u_channel = u.u[0] * static_cast<float>(all);
    if (u_channel < static_cast<float>(profiles.narrow)) {
        exit.hit = {entry.distance, entry.u, entry.v, entry.instance, entry.triangle};
        exit.direction = -entry.wo;
        exit.throughput = throughput * profiles.is_narrow * (static_cast<float>(all) / static_cast<float>(profiles.narrow));
        return is_finite(exit.throughput) && !is_black(exit.throughput);
    }
    if (profiles.count == 0) return false;  // rounding of the choice
    u_channel -= static_cast<float>(profiles.narrow);
    throughput *= static_cast<float>(all) / static_cast<float>(profiles.count);
    // Axis: the normal with probability 1/2, the tangents with 1/4 each.
    const Frame frame = frame_about(entry.ng);
    const Vec3f axes[3] = {frame.z, frame.x, frame.y};
    constexpr float kPick[3] = {0.5f, 0.25f, 0.25f};
    const int axis = u.u[1] < 0.5f ? 0 : u.u[1] < 0.75f ? 1 : 2;
    const float u_angle = axis == 0 ? u.u[1] * 2 : axis == 1 ? (u.u[1] - 0.5f) * 4 : (u.u[1] - 0.75f) * 4;
    const Vec3f along = axes[axis], across1 = axes[(axis + 1) % 3], across2 = axes[(axis + 2) % 3];

    const int pick = std::min(static_cast<int>(u_channel), profiles.count - 1), channel = profiles.channels[pick];
    const float radius = profiles.sample(channel, std::clamp(u_channel - static_cast<float>(pick), 0.f, 0.99999994f));
    const float reach = profiles.reach(channel), height = safe_sqrt(reach * reach - radius * radius);
    const float phi = 2 * kPi * u_angle;
    Ray ray;
    ray.time = entry.time;
    ray.origin = entry.p + along * height + across1 * (radius * std::cos(phi)) + across2 * (radius * std::sin(phi));
    ray.direction = -along;
    ray.t_max = 2 * height;

    const float radius_density = profiles.density(radius);
    Found found[kMostHits];
    int hits = 0;
    float total = 0;
    while (hits < kMostHits) {
        Hit hit;
        ++rays;
        if (!surfaces.accel().intersect_instance(entry.instance, ray, hit)) break;
        ray.t_min = std::nextafter(hit.t, std::numeric_limits<float>::infinity());
        const ShadingPoint q = surfaces.point(hit.instance, hit.triangle, hit.u, hit.v, ray.direction, hit.t, ray.time);
        const Vec3f to = q.p - entry.p;
        const float r = length(to);
        Vec3f weight(0.f);
        if (lobe.spec->cycles_profile) {
            // Cycles: the density of the radius that was chosen stands for all axes, power heuristic over these.
            float own = 0, squares = 0;
            for (int a = 0; a < 3; ++a) {
                const float density = kPick[a] * std::abs(dot(axes[a], q.ng));
                if (a == axis) own = density;
                squares += density * density;
            }
            if (radius_density > 0 && squares > 0) weight = profiles.radial(r) * (own / squares / radius_density);
        } else {
            // Profile over area, against the density over area of all three ways to this point.
            float density = 0;
            for (int a = 0; a < 3; ++a) {
                const float h = dot(to, axes[a]), flat = safe_sqrt(r * r - h * h);
                if (flat > 0) density += kPick[a] * std::abs(dot(axes[a], q.ng)) * profiles.density(flat) / flat;
            }
            if (density > 0 && r > 0) weight = profiles.radial(r) * (1 / (r * density));
        }
        const float w = std::abs(average(weight));
        if (!(w > 0) || !std::isfinite(w)) continue;
        found[hits++] = {hit, weight};
        total += w;
    }
    if (hits == 0) return false;
    float rest = u.u[2] * total;
    int k = 0;
    while (k + 1 < hits && rest >= std::abs(average(found[k].weight))) rest -= std::abs(average(found[k++].weight));
    exit.hit = found[k].hit;
    exit.throughput = throughput * found[k].weight * (total / std::abs(average(found[k].weight)));
    // Seen from the side that the entry was seen from.
    const ShadingPoint q = surfaces.point(exit.hit.instance, exit.hit.triangle, exit.hit.u, exit.hit.v, -along, exit.hit.t, entry.time);
    const Vec3f outward = q.backfacing == entry.backfacing ? q.ng : -q.ng;
    exit.direction = -outward;
    return is_finite(exit.throughput) && !is_black(exit.throughput);
}

}  // namespace alder
