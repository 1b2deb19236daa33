// Tables of a mesh made on first use: tangents, a random number per connected part, pointiness.
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "render/geometry/mesh_build.h"
#include "render/geometry/surface.h"
#include "render/sampler.h"
#include "render/sampling.h"

namespace alder {
namespace {

uint32_t find_root(std::vector<uint32_t>& parent, uint32_t x) {
    while (parent[x] != x) x = parent[x] = parent[parent[x]];
    return x;
}

std::vector<float> make_islands(const Mesh& mesh) {
    std::vector<uint32_t> parent(mesh.positions.size());
    std::iota(parent.begin(), parent.end(), 0u);
    for (const auto& t : mesh.triangles)
        for (int k = 1; k < 3; ++k) {
            const uint32_t a = find_root(parent, t[0]), b = find_root(parent, t[k]);
            parent[std::max(a, b)] = std::min(a, b);  // the smallest index is the root: independent of triangle order
        }
    std::vector<float> random(mesh.triangles.size());
    for (size_t i = 0; i < random.size(); ++i) random[i] = unit_float(hash32(find_root(parent, mesh.triangles[i][0]), 0x15a4du));
    return random;
}

/// Cycles' measure: the angle between the normal and the mean direction of the edges, over pi, smoothed once over neighbours.
/// Points at the same place count as one, so that seams do not show.
std::vector<float> make_pointiness(const Mesh& mesh) {
    const size_t n = mesh.positions.size();
    std::vector<uint32_t> same(n);
    std::map<std::array<float, 3>, uint32_t> seen;
    for (uint32_t i = 0; i < n; ++i) {
        const Vec3f p = mesh.positions[i];
        same[i] = seen.emplace(std::array<float, 3>{p.x, p.y, p.z}, i).first->second;
    }
    const std::vector<Vec3f> own = compute_vertex_normals(mesh.positions, mesh.triangles);
    std::vector<Vec3f> normal(n, Vec3f(0.f)), edges(n, Vec3f(0.f));
    for (uint32_t i = 0; i < n; ++i) normal[same[i]] += own[i];
    std::set<std::pair<uint32_t, uint32_t>> pairs;
    for (const auto& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = same[t[k]], b = same[t[(k + 1) % 3]];
            if (a != b) pairs.insert({std::min(a, b), std::max(a, b)});
        }
    std::vector<int> count(n, 0);
    for (const auto& [a, b] : pairs) {
        const Vec3f d = safe_normalize(mesh.positions[b] - mesh.positions[a]);
        edges[a] += d;
        edges[b] -= d;
        ++count[a];
        ++count[b];
    }
    std::vector<float> raw(n, 0.f);
    for (uint32_t i = 0; i < n; ++i) {
        if (same[i] != i || count[i] == 0) continue;
        const float c = dot(safe_normalize(normal[i]), edges[i] * (1.f / count[i]));
        raw[i] = std::acos(std::clamp(c, -1.f, 1.f)) * kInvPi;
    }
    std::vector<float> smooth = raw;
    for (const auto& [a, b] : pairs) {
        smooth[a] += raw[b];
        smooth[b] += raw[a];
    }
    for (uint32_t i = 0; i < n; ++i) smooth[i] /= static_cast<float>(count[i] + 1);
    for (uint32_t i = 0; i < n; ++i) smooth[i] = smooth[same[i]];
    return smooth;
}

}  // namespace

const MeshTables::TangentTable& MeshTables::tangents() const {
    std::call_once(tangents_once_, [this] {
        if (mesh_->tangents.size() == 3 * mesh_->triangles.size()) {
            tangents_.tangents = mesh_->tangents;
            tangents_.signs = mesh_->tangent_signs;
            tangents_.signs.resize(tangents_.tangents.size(), 1.f);
        } else {
            Tangents t = compute_tangents(*mesh_);
            tangents_.tangents = std::move(t.tangents);
            tangents_.signs = std::move(t.signs);
        }
    });
    return tangents_;
}

const ThreadTable& MeshTables::curves() const {
    std::call_once(curves_once_, [this] { curves_ = ThreadTable::make(*mesh_); });
    return curves_;
}

const std::vector<float>& MeshTables::island_random() const {
    std::call_once(islands_once_, [this] { islands_ = make_islands(*mesh_); });
    return islands_;
}

const std::vector<float>& MeshTables::pointiness() const {
    std::call_once(pointiness_once_, [this] { pointiness_ = make_pointiness(*mesh_); });
    return pointiness_;
}

}  // namespace alder
