// Curves and spheres: Catmull-Rom segments, coordinates of hits, tables.
#include "render/geometry/curves.h"

#include <algorithm>
#include <cmath>

#include "render/geometry/motion.h"
#include "render/sampling.h"

namespace alder {

std::vector<CurveSegment> curve_segments(const Mesh& mesh) {
    std::vector<CurveSegment> out;
    out.reserve(mesh.primitive_count());
    for (uint32_t c = 0; c + 1 < mesh.curve_first.size(); ++c)
        for (uint32_t p = mesh.curve_first[c]; p + 1 < mesh.curve_first[c + 1]; ++p) out.push_back({p, c});
    return out;
}

CurveKeys curve_keys(const Mesh& mesh, CurveSegment s, float time) {
    const uint32_t first = mesh.curve_first[s.curve], last = mesh.curve_first[s.curve + 1] - 1;
    const uint32_t points[4] = {std::max(s.point, first + 1) - 1, s.point, s.point + 1, std::min(s.point + 2, last)};
    CurveKeys keys;
    for (int k = 0; k < 4; ++k) {
        keys.p[k] = position_at(mesh, points[k], time);
        keys.radius[k] = radius_at(mesh, points[k], time);
    }
    return keys;
}

CurvePoint curve_point(const CurveKeys& k, CurveForm form, float u) {
    if (form == CurveForm::Linear)
        return {k.p[1] * (1 - u) + k.p[2] * u, k.p[2] - k.p[1], k.radius[1] * (1 - u) + k.radius[2] * u};
    // Catmull and Rom, "A Class of Local Interpolating Splines", 1974: tangents are half the chord between the neighbours.
    const float u2 = u * u, u3 = u2 * u;
    const float b[4] = {0.5f * (-u3 + 2 * u2 - u), 0.5f * (3 * u3 - 5 * u2 + 2), 0.5f * (-3 * u3 + 4 * u2 + u), 0.5f * (u3 - u2)};
    const float d[4] = {0.5f * (-3 * u2 + 4 * u - 1), 0.5f * (9 * u2 - 10 * u), 0.5f * (-9 * u2 + 8 * u + 1), 0.5f * (3 * u2 - 2 * u)};
    CurvePoint out{Vec3f(0.f), Vec3f(0.f), 0};
    for (int i = 0; i < 4; ++i) {
        out.center += k.p[i] * b[i];
        out.tangent += k.p[i] * d[i];
        out.radius += k.radius[i] * b[i];
    }
    return out;
}

Vec3f around_curve(Vec3f tangent, float angle) {
    const Vec3f t = safe_normalize(tangent);
    const Frame f = frame_about(is_black(t) || !is_finite(t) ? Vec3f(0, 0, 1) : t);
    return f.x * std::cos(angle) + f.y * std::sin(angle);
}

float angle_around_curve(Vec3f tangent, Vec3f direction) {
    const Vec3f t = safe_normalize(tangent);
    const Frame f = frame_about(is_black(t) || !is_finite(t) ? Vec3f(0, 0, 1) : t);
    const float angle = std::atan2(dot(direction, f.y), dot(direction, f.x));
    return std::isfinite(angle) ? angle : 0.f;
}

void encode_direction(Vec3f d, float& u, float& v) {
    const float sum = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
    if (!(sum > 0) || !std::isfinite(sum)) {
        u = v = 0;
        return;
    }
    u = d.x / sum;
    v = d.y / sum;
    if (d.z < 0) {
        const float x = (1 - std::abs(v)) * std::copysign(1.f, u), y = (1 - std::abs(u)) * std::copysign(1.f, v);
        u = x;
        v = y;
    }
}

Vec3f decode_direction(float u, float v) {
    const float z = 1 - std::abs(u) - std::abs(v);
    if (z >= 0) return safe_normalize(Vec3f(u, v, z));
    return safe_normalize(Vec3f((1 - std::abs(v)) * std::copysign(1.f, u), (1 - std::abs(u)) * std::copysign(1.f, v), z));
}

ThreadTable ThreadTable::make(const Mesh& mesh) {
    ThreadTable t;
    t.segments = curve_segments(mesh);
    t.intercepts.assign(mesh.positions.size(), 0.f);
    for (size_t c = 0; c + 1 < mesh.curve_first.size(); ++c) {
        const uint32_t first = mesh.curve_first[c], end = mesh.curve_first[c + 1];
        float sum = 0;
        for (uint32_t p = first + 1; p < end; ++p) t.intercepts[p] = sum += length(mesh.positions[p] - mesh.positions[p - 1]);
        if (sum > 0)
            for (uint32_t p = first + 1; p < end; ++p) t.intercepts[p] /= sum;
        t.lengths.push_back(sum);
    }
    return t;
}

float element_random(uint32_t index) {
    // Jenkins, lookup3.c, 2006: final() over two words, the second of them 0.
    const auto turned = [](uint32_t x, int k) { return (x << k) | (x >> (32 - k)); };
    uint32_t a = 0xdeadbeefu + (2u << 2) + 13u, b = a, c = a;
    a += index;
    c = (c ^ b) - turned(b, 14);
    a = (a ^ c) - turned(c, 11);
    b = (b ^ a) - turned(a, 25);
    c = (c ^ b) - turned(b, 16);
    a = (a ^ c) - turned(c, 4);
    b = (b ^ a) - turned(a, 14);
    c = (c ^ b) - turned(b, 24);
    return static_cast<float>(c) * (1.f / 4294967295.f);
}

}  // namespace alder
