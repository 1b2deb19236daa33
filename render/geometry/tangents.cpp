// Tangents for normal maps, as MikkTSpace gives them for triangle meshes.
// Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008, section 3.4 (welding, groups by orientation, angle weights).
// Corners that agree in position, normal and uv are one vertex; triangles round such a vertex that are joined by edges and
// turn their uv the same way share one tangent: the mean of theirs, projected on the normal's plane, weighted by angle.
#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_map>

#include "render/geometry/mesh_build.h"

namespace alder {
namespace {

struct CornerKey {
    std::array<uint32_t, 8> bits;
    bool operator==(const CornerKey&) const = default;
};
struct CornerHash {
    size_t operator()(const CornerKey& k) const {
        uint64_t h = 0x9e3779b97f4a7c15ull;
        for (uint32_t b : k.bits) h = (h ^ b) * 0xff51afd7ed558ccdull, h ^= h >> 29;
        return size_t(h);
    }
};
uint32_t key_bits(float x) { return std::bit_cast<uint32_t>(x == 0 ? 0.0f : x); }   // -0 welds with 0

/// Uv frame of one triangle.
struct Face {
    Vec3f direction{0, 0, 0};   ///< of increasing u, unit, or zero
    bool preserves = false;     ///< uv turn the same way as the triangle
    bool any = true;            ///< no usable uv: joins whatever group surrounds it
    bool degenerate = false;    ///< two corners are the same point
};

Vec3f unit(Vec3f v) {
    const float l = std::sqrt(dot(v, v));
    return l > 0 && std::isfinite(l) ? v / l : Vec3f(0, 0, 0);
}
Vec3f on_plane(Vec3f v, Vec3f n) { return unit(v - n * dot(n, v)); }

class TangentBuilder {
  public:
    TangentBuilder(const Mesh& mesh, std::span<const std::array<float, 2>> uv) : mesh_(mesh), uv_(uv) {}

    Tangents run() {
        count_ = uint32_t(mesh_.triangles.size());
        weld();
        for (uint32_t f = 0; f < count_; ++f) faces_.push_back(make_face(f));
        connect();
        group_of_.assign(size_t(count_) * 3, -1);
        Tangents out;
        out.tangents.assign(size_t(count_) * 3, Vec3f(1, 0, 0));
        out.signs.assign(size_t(count_) * 3, 1);
        // Triangles with usable uv found the groups; the others have been taken in by then or stay alone.
        for (bool any : {false, true}) {
            for (uint32_t c = 0; c < count_ * 3; ++c) {
                if (faces_[c / 3].any == any && !faces_[c / 3].degenerate && group_of_[c] < 0) grow(c, out);
            }
        }
        settle_degenerate(out);
        return out;
    }

  private:
    void weld() {
        std::unordered_map<CornerKey, uint32_t, CornerHash> seen;
        seen.reserve(size_t(count_) * 2);
        vertex_.resize(size_t(count_) * 3);
        normal_.resize(size_t(count_) * 3);
        for (uint32_t c = 0; c < count_ * 3; ++c) {
            const Vec3f p = position(c), n = normal_[c] = unit(corner_normal(mesh_, c / 3, int(c % 3)));
            const CornerKey key{{key_bits(p.x), key_bits(p.y), key_bits(p.z), key_bits(n.x), key_bits(n.y), key_bits(n.z),
                                 key_bits(uv_[c][0]), key_bits(uv_[c][1])}};
            vertex_[c] = seen.try_emplace(key, uint32_t(seen.size())).first->second;
        }
    }

    Vec3f position(uint32_t corner) const { return mesh_.positions[mesh_.triangles[corner / 3][corner % 3]]; }

    Face make_face(uint32_t f) const {
        Face face;
        const uint32_t c = f * 3;
        const Vec3f d1 = position(c + 1) - position(c), d2 = position(c + 2) - position(c), d3 = d2 - d1;
        face.degenerate = dot(d1, d1) == 0 || dot(d2, d2) == 0 || dot(d3, d3) == 0;
        const float u1 = uv_[c + 1][0] - uv_[c][0], v1 = uv_[c + 1][1] - uv_[c][1];
        const float u2 = uv_[c + 2][0] - uv_[c][0], v2 = uv_[c + 2][1] - uv_[c][1];
        const float area = u1 * v2 - v1 * u2;
        face.preserves = area > 0;
        if (std::isnormal(area)) {
            const Vec3f s = unit(d1 * v2 - d2 * v1), t = unit(d2 * u1 - d1 * u2);
            face.direction = face.preserves ? s : -s;
            face.any = dot(s, s) == 0 || dot(t, t) == 0;
        }
        return face;
    }

    /// neighbour_[c]: the triangle beyond the edge from corner c to the next one, or -1. One partner an edge.
    void connect() {
        neighbour_.assign(size_t(count_) * 3, -1);
        std::unordered_map<uint64_t, uint32_t> open;
        open.reserve(size_t(count_) * 2);
        for (uint32_t c = 0; c < count_ * 3; ++c) {
            if (faces_[c / 3].degenerate) continue;
            const uint32_t a = vertex_[c], b = vertex_[c - c % 3 + (c + 1) % 3];
            const auto twin = open.find(uint64_t(b) << 32 | a);
            if (twin != open.end()) {
                neighbour_[c] = int32_t(twin->second / 3);
                neighbour_[twin->second] = int32_t(c / 3);
                open.erase(twin);
            } else {
                open.try_emplace(uint64_t(a) << 32 | b, c);
            }
        }
    }

    /// Collects the group of corner `start` round its vertex and gives all its corners their common tangent.
    void grow(uint32_t start, Tangents& out) {
        const uint32_t vertex = vertex_[start];
        const int group = group_count_++;
        const bool preserves = faces_[start / 3].preserves;
        group_of_[start] = group;
        members_.assign(1, start);
        for (size_t i = 0; i < members_.size(); ++i) {
            const uint32_t c = members_[i], f = c / 3;
            for (const int32_t next : {neighbour_[c], neighbour_[f * 3 + (c + 2) % 3]}) {
                if (next < 0) continue;
                Face& face = faces_[next];
                for (uint32_t k = uint32_t(next) * 3; k < uint32_t(next) * 3 + 3; ++k) {
                    if (vertex_[k] != vertex || group_of_[k] >= 0) continue;
                    if (face.any && face_is_free(uint32_t(next))) face.preserves = preserves;
                    if (face.preserves != preserves) continue;
                    group_of_[k] = group;
                    members_.push_back(k);
                }
            }
        }
        Vec3f sum(0, 0, 0);
        for (const uint32_t c : members_) {
            if (faces_[c / 3].any) continue;
            const Vec3f n = normal_[c], p = position(c);
            const uint32_t first = c - c % 3;
            const Vec3f a = on_plane(position(first + (c + 1) % 3) - p, n), b = on_plane(position(first + (c + 2) % 3) - p, n);
            sum += on_plane(faces_[c / 3].direction, n) * std::acos(std::clamp(dot(a, b), -1.0f, 1.0f));
        }
        sum = unit(sum);
        if (dot(sum, sum) == 0) sum = Vec3f(1, 0, 0);
        for (const uint32_t c : members_) {
            out.tangents[c] = sum;
            out.signs[c] = preserves ? 1.0f : -1.0f;
        }
    }

    bool face_is_free(uint32_t f) const { return group_of_[f * 3] < 0 && group_of_[f * 3 + 1] < 0 && group_of_[f * 3 + 2] < 0; }

    /// A triangle without an area takes the tangents of its vertices from whichever good triangle has them.
    void settle_degenerate(Tangents& out) const {
        std::unordered_map<uint32_t, uint32_t> good;
        for (uint32_t c = 0; c < count_ * 3; ++c) {
            if (!faces_[c / 3].degenerate) good.try_emplace(vertex_[c], c);
        }
        for (uint32_t c = 0; c < count_ * 3; ++c) {
            const auto g = faces_[c / 3].degenerate ? good.find(vertex_[c]) : good.end();
            if (g == good.end()) continue;
            out.tangents[c] = out.tangents[g->second];
            out.signs[c] = out.signs[g->second];
        }
    }

    const Mesh& mesh_;
    std::span<const std::array<float, 2>> uv_;
    uint32_t count_ = 0;
    int group_count_ = 0;
    std::vector<uint32_t> vertex_, members_;
    std::vector<Vec3f> normal_;
    std::vector<Face> faces_;
    std::vector<int32_t> neighbour_, group_of_;
};

}  // namespace

Tangents compute_tangents(const Mesh& mesh, std::span<const std::array<float, 2>> uv) {
    if (uv.size() != mesh.triangles.size() * 3 || uv.empty()) return {};
    return TangentBuilder(mesh, uv).run();
}

Tangents compute_tangents(const Mesh& mesh) { return compute_tangents(mesh, mesh.uv); }

}  // namespace alder
