// Motion keys: a matrix as rotation and stretch, and what lies between two of them.
#include "render/geometry/motion.h"

#include <algorithm>
#include <cmath>

namespace alder {
namespace {

Vec3d column_of(const Transform& t, int c) { return {t.m[c], t.m[4 + c], t.m[8 + c]}; }
double size(Vec3d v) { return std::sqrt(dot(v, v)); }
Vec3d divided(Vec3d v, double s) { return s != 0 ? v / s : Vec3d(0, 0, 0); }

/// Unit quaternion of a rotation by its columns: the largest of the four components first, so that nothing cancels.
std::array<float, 4> quaternion(Vec3d x, Vec3d y, Vec3d z) {
    const double trace = x.x + y.y + z.z;
    double w, i, j, k;
    if (trace > 0) {
        w = 1 + trace;
        i = y.z - z.y;
        j = z.x - x.z;
        k = x.y - y.x;
    } else if (x.x >= y.y && x.x >= z.z) {
        w = y.z - z.y;
        i = 1 + x.x - y.y - z.z;
        j = x.y + y.x;
        k = z.x + x.z;
    } else if (y.y >= z.z) {
        w = z.x - x.z;
        i = x.y + y.x;
        j = 1 + y.y - x.x - z.z;
        k = y.z + z.y;
    } else {
        w = x.y - y.x;
        i = z.x + x.z;
        j = y.z + z.y;
        k = 1 + z.z - x.x - y.y;
    }
    const double l = std::sqrt(w * w + i * i + j * j + k * k);
    if (!(l > 0) || !std::isfinite(l)) return {1, 0, 0, 0};
    return {float(w / l), float(i / l), float(j / l), float(k / l)};
}

/// The columns made orthogonal one after the other (Gram and Schmidt); what is taken off is the stretch.
MotionKey key_of(const Transform& t) {
    MotionKey key;
    key.translation = {t.m[3], t.m[7], t.m[11]};
    Vec3d x = column_of(t, 0), y = column_of(t, 1), z = column_of(t, 2);
    Vec3d scale, skew;
    scale.x = size(x);
    x = divided(x, scale.x);
    skew.x = dot(x, y);
    y -= x * skew.x;
    scale.y = size(y);
    y = divided(y, scale.y);
    skew.y = dot(x, z);
    z -= x * skew.y;
    skew.z = dot(y, z);
    z -= y * skew.z;
    scale.z = size(z);
    z = divided(z, scale.z);
    if (dot(cross(x, y), z) < 0) {  // a mirror is no rotation: the stretch takes it
        x = -x;
        y = -y;
        z = -z;
        scale = -scale;
        skew = -skew;
    }
    key.rotation = quaternion(x, y, z);
    key.scale = {float(scale.x), float(scale.y), float(scale.z)};
    key.skew = {float(skew.x), float(skew.y), float(skew.z)};
    return key;
}

using Quaternion = std::array<float, 4>;
float dot4(const Quaternion& a, const Quaternion& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]; }
Quaternion mixed(const Quaternion& a, float wa, const Quaternion& b, float wb) {
    Quaternion q;
    for (int i = 0; i < 4; ++i) q[i] = a[i] * wa + b[i] * wb;
    return q;
}
Quaternion normalized(Quaternion q) {
    const float l = std::sqrt(dot4(q, q));
    if (!(l > 0)) return {1, 0, 0, 0};
    for (float& x : q) x /= l;
    return q;
}
/// Shoemake, "Animating Rotation with Quaternion Curves", SIGGRAPH 1985. Close ones along the chord: the arc's sine vanishes.
Quaternion slerp(const Quaternion& a, const Quaternion& b, float t) {
    const float cosine = std::min(dot4(a, b), 1.f);
    if (cosine > 0.9995f) return normalized(mixed(a, 1 - t, b, t));
    const float angle = t * std::acos(std::max(cosine, -1.f));
    return mixed(a, std::cos(angle), normalized(mixed(b, 1, a, -cosine)), std::sin(angle));
}

}  // namespace

std::vector<MotionKey> motion_keys(std::span<const Transform> transforms) {
    std::vector<MotionKey> keys;
    for (const Transform& t : transforms) keys.push_back(key_of(t));
    const auto is_flat = [](const MotionKey& k) { return k.scale.x == 0 || k.scale.y == 0 || k.scale.z == 0; };
    for (size_t i = 0; i < keys.size(); ++i) {
        // Without extent there is no rotation either: that of a neighbour, so that the object does not spin as it vanishes.
        if (is_flat(keys[i])) {
            if (i > 0) keys[i].rotation = keys[i - 1].rotation;
            else if (keys.size() > 1) keys[i].rotation = keys[i + 1].rotation;
        }
        if (i > 0 && dot4(keys[i - 1].rotation, keys[i].rotation) < 0)
            for (float& x : keys[i].rotation) x = -x;
    }
    return keys;
}

Transform transform_of(const MotionKey& key) {
    const auto [w, x, y, z] = key.rotation;
    const float r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                           {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                           {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    Transform t;
    for (int row = 0; row < 3; ++row) {
        t.m[row * 4] = r[row][0] * key.scale.x;
        t.m[row * 4 + 1] = r[row][0] * key.skew.x + r[row][1] * key.scale.y;
        t.m[row * 4 + 2] = r[row][0] * key.skew.y + r[row][1] * key.skew.z + r[row][2] * key.scale.z;
        t.m[row * 4 + 3] = key.translation[row];
    }
    return t;
}

MotionSpan motion_span(size_t steps, float time) {
    if (steps < 2 || !(time > 0)) return {0, 0};
    const size_t last = steps - 1;
    if (time >= 1) return {last - 1, 1};
    const float at = time * static_cast<float>(last);
    const size_t step = std::min(static_cast<size_t>(at), last - 1);
    return {step, at - static_cast<float>(step)};
}

Transform transform_at(std::span<const MotionKey> keys, float time) {
    if (keys.size() == 1) return transform_of(keys[0]);
    const auto [step, t] = motion_span(keys.size(), time);
    const MotionKey &a = keys[step], &b = keys[step + 1];
    MotionKey k;
    k.rotation = slerp(a.rotation, b.rotation, t);
    k.scale = a.scale * (1 - t) + b.scale * t;
    k.skew = a.skew * (1 - t) + b.skew * t;
    k.translation = a.translation * (1 - t) + b.translation * t;
    return transform_of(k);
}

Vec3f position_at(const Mesh& mesh, uint32_t point, float time) {
    if (!mesh.moves()) return mesh.positions[point];
    const auto [step, t] = motion_span(static_cast<size_t>(mesh.motion_steps), time);
    const Vec3f* const p = mesh.motion_positions.data() + step * mesh.positions.size() + point;
    return p[0] * (1 - t) + p[mesh.positions.size()] * t;
}

float radius_at(const Mesh& mesh, uint32_t point, float time) {
    if (!mesh.moves() || mesh.motion_radii.empty()) return mesh.radii[point];
    const auto [step, t] = motion_span(static_cast<size_t>(mesh.motion_steps), time);
    const float* const r = mesh.motion_radii.data() + step * mesh.positions.size() + point;
    return r[0] * (1 - t) + r[mesh.positions.size()] * t;
}

}  // namespace alder
