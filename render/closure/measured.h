// A measured isotropic reflectance (MERL): value by half and difference angles, sampled by half vectors whose distribution over
// theta_h follows the table, and by the cosine.
#pragma once
#include "nodes/surface/merl.h"
#include "render/closure/bsdf.h"
#include "render/closure/frame.h"

namespace alder::closure {

template <class T>
struct MeasuredLobe {
    const MerlTable& table;
    Frame<T> frame;
    Vec3<T> wo;

    MeasuredLobe(const MerlTable& t, Vec3<T> n, Vec3<T> wo_world) : table(t), frame(frame_around(n)), wo(frame.to_local(wo_world)) {}

    BsdfEval<T> eval(Vec3<T> wi_world) const {
        BsdfEval<T> e;
        const Vec3<T> wi = frame.to_local(wi_world);
        if (!(wo.z > 0 && wi.z > 0)) return e;
        Vec3<T> h = wo + wi;
        const T l = length(h);
        if (!(l > 0)) return e;
        h = h / l;
        const T sin_h = std::sqrt(h.x * h.x + h.y * h.y), theta_h = std::atan2(sin_h, h.z);
        // The light turned into the frame where h is the pole: Rusinkiewicz' difference vector.
        const T cp = sin_h > 0 ? h.x / sin_h : T(1), sp = sin_h > 0 ? h.y / sin_h : T(0);
        const T along = cp * wi.x + sp * wi.y, y = cp * wi.y - sp * wi.x;
        const T x = h.z * along - sin_h * wi.z, z = sin_h * along + h.z * wi.z;
        const float* const v = table.values.data() + size_t{3} * MerlTable::cell(theta_h, std::atan2(std::sqrt(x * x + y * y), z), std::atan2(y, x));
        e.f_cos = Vec3<T>(T(v[0]), T(v[1]), T(v[2])) * wi.z;
        e.pdf = (wi.z / kPi<T> + half_density(theta_h) / (4 * std::max(dot(h, wo), T(1e-20)))) / 2;
        return e;
    }
    /// Half by the cosine, half by the table; invalid below the surface.
    Vec3<T> sample(T u1, T u2, T u3) const {
        if (u3 < T(0.5)) return frame.to_world(sample_cosine(u1, u2));
        const auto it = std::upper_bound(table.below.begin() + 1, table.below.end() - 1, static_cast<double>(u1) * table.below.back());
        const int band = static_cast<int>(it - table.below.begin()) - 1;
        const double share = table.band[band] > 0 ? std::clamp((u1 * table.below.back() - table.below[band]) / table.band[band], 0.0, 1.0) : 0.5;
        const T a = T(std::cos(MerlTable::band_edge(band))), b = T(std::cos(MerlTable::band_edge(band + 1)));
        // sin from 1 - cos: bands near the pole are narrow
        const T rise = T(2 * sqr(std::sin(MerlTable::band_edge(band) / 2))) + T(share) * (a - b);
        const T s = safe_sqrt(rise * (2 - rise)), phi = 2 * kPi<T> * u2;
        const Vec3<T> h(s * std::cos(phi), s * std::sin(phi), 1 - rise);
        return normalize(frame.to_world(h * (2 * dot(h, wo)) - wo));
    }

  private:
    T half_density(T theta_h) const {
        const int k = MerlTable::band_of(theta_h);
        const double a = MerlTable::band_edge(k), b = MerlTable::band_edge(k + 1);
        return static_cast<T>(table.band[k] / table.below.back() / (4 * closure::kPi<double> * std::sin((a + b) / 2) * std::sin((b - a) / 2)));
    }
};

}  // namespace alder::closure
