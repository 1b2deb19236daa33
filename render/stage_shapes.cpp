// Procedural meshes of the preview stages.
#include "render/stage_shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/geometry/mesh_build.h"

namespace alder {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kDegree = kPi / 180;

/// Rows x columns of points as a mesh of quads, corner uv from row and column. `wrap`: the last column joins the first,
/// whose uv is then given once more for the far side of the seam.
struct Grid {
    std::vector<float> u, v;   ///< per column (one more than points if wrapped), per row
    bool wrap = false;
    bool poles = false;        ///< the first and the last row are one point each

    int columns() const { return int(u.size()) - (wrap ? 1 : 0); }
    uint32_t index(int row, int column) const {
        if (poles && row == 0) return 0;
        const int before = poles ? 1 + (row - 1) * columns() : row * columns();
        if (poles && row + 1 == int(v.size())) return uint32_t(before);
        return uint32_t(before + (wrap ? column % columns() : column));
    }

    /// Triangles of the quad with lower corner (row, column), counter-clockwise for columns to the right and rows upwards.
    void emit(Mesh& m) const {
        const int quads_across = int(u.size()) - 1, quads_up = int(v.size()) - 1;
        m.triangles.reserve(size_t(quads_across) * quads_up * 2);
        m.uv.reserve(size_t(quads_across) * quads_up * 6);
        for (int row = 0; row < quads_up; ++row) {
            for (int column = 0; column < quads_across; ++column) {
                const int corner[4][2] = {{row, column}, {row, column + 1}, {row + 1, column + 1}, {row + 1, column}};
                for (const auto& half : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
                    std::array<uint32_t, 3> t;
                    for (int k = 0; k < 3; ++k) t[k] = index(corner[half[k]][0], corner[half[k]][1]);
                    const Vec3f &a = m.positions[t[0]], &b = m.positions[t[1]], &c = m.positions[t[2]];
                    const Vec3f n = cross(b - a, c - a);
                    if (dot(n, n) < 1e-16f) continue;   // the quads at a pole are triangles
                    m.triangles.push_back(t);
                    for (int k = 0; k < 3; ++k) m.uv.push_back({u[corner[half[k]][1]], v[corner[half[k]][0]]});
                }
            }
        }
    }
};

std::shared_ptr<const Mesh> finish(Mesh&& m) {
    fill_derived(m);
    return std::make_shared<const Mesh>(std::move(m));
}

float smooth_step(float t) {
    t = std::clamp(t, 0.0f, 1.0f);
    return t * t * t * (t * (t * 6 - 15) + 10);
}
float smooth_step_slope(float t) { return t <= 0 || t >= 1 ? 0 : 30 * t * t * (t - 1) * (t - 1); }

/// The window: a rectangle with round corners in longitude and latitude.
struct Window {
    float longitude, latitude;        ///< centre
    float half_width, half_height;
    float corner;                     ///< radius of its corners
    float wall;                       ///< width over which the surface sinks
    float depth;

    /// Radius of the surface and its derivatives by longitude and latitude.
    void radius(float lon, float lat, float& r, float& r_lon, float& r_lat) const {
        const float x = lon - longitude, y = lat - latitude;
        const float qx = std::abs(x) - half_width + corner, qy = std::abs(y) - half_height + corner;
        const float ox = std::max(qx, 0.0f), oy = std::max(qy, 0.0f), o = std::sqrt(ox * ox + oy * oy);
        const float distance = o + std::min(std::max(qx, qy), 0.0f) - corner;   // < 0 inside
        float gx = 0, gy = 0;
        if (o > 0) {
            gx = ox / o;
            gy = oy / o;
        } else {
            (qx > qy ? gx : gy) = 1;
        }
        const float t = 0.5f - distance / wall;
        r = 1 - depth * smooth_step(t);
        const float slope = depth * smooth_step_slope(t) / wall;
        r_lon = slope * gx * (x < 0 ? -1.0f : 1.0f);
        r_lat = slope * gy * (y < 0 ? -1.0f : 1.0f);
    }
};

/// Lines from lo to hi at most `coarse` apart, and `fine` within the given intervals.
std::vector<float> lines(float lo, float hi, float coarse, float fine, std::span<const std::array<float, 2>> dense) {
    std::vector<float> out;
    const auto add = [&](float a, float b, float step) {
        const int n = std::max(1, int(std::ceil((b - a) / step)));
        for (int i = 0; i < n; ++i) out.push_back(a + (b - a) * float(i) / float(n));
    };
    float at = lo;
    for (const auto& d : dense) {
        add(at, d[0], coarse);
        add(d[0], d[1], fine);
        at = d[1];
    }
    add(at, hi, coarse);
    out.push_back(hi);
    return out;
}

/// Sphere grid by longitude and latitude lines; `surface(lon, lat, r, r_lon, r_lat)` gives the radius and its slopes.
template <class Surface>
std::shared_ptr<const Mesh> make_globe(const char* name, const std::vector<float>& lon, const std::vector<float>& lat,
                                       const Surface& surface) {
    Mesh m;
    m.name = name;
    Grid grid{{}, {}, true, true};
    for (float x : lon) grid.u.push_back((x - lon.front()) / kPi);
    for (float y : lat) grid.v.push_back((y + kPi / 2) / kPi);
    const int columns = grid.columns();
    std::vector<std::array<float, 2>> turn;
    for (int c = 0; c < columns; ++c) turn.push_back({std::cos(lon[c]), std::sin(lon[c])});
    m.positions.reserve(lat.size() * turn.size());
    m.vertex_normals.reserve(lat.size() * turn.size());
    for (size_t row = 0; row < lat.size(); ++row) {
        const bool pole = row == 0 || row + 1 == lat.size();
        const float cl = pole ? 0 : std::cos(lat[row]), sl = std::sin(lat[row]);
        for (int c = 0; c < (pole ? 1 : columns); ++c) {
            float r = 1, r_lon = 0, r_lat = 0;
            surface(lon[c], lat[row], r, r_lon, r_lat);
            const auto [cx, sx] = turn[c];
            const Vec3f out(cl * cx, cl * sx, sl), north(-sl * cx, -sl * sx, cl), east(-sx, cx, 0);
            m.positions.push_back(out * r);
            // Gradient of |p| - r(longitude, latitude).
            Vec3f n = out - north * (r_lat / r) - east * (cl > 0 ? r_lon / (r * cl) : 0);
            m.vertex_normals.push_back(n / std::sqrt(dot(n, n)));
        }
    }
    grid.emit(m);
    return finish(std::move(m));
}

constexpr float kSeam = -270 * kDegree;   // the seam is at the back: longitudes run from there once round

}  // namespace

std::shared_ptr<const Mesh> make_shader_ball() {
    const Window w{-70 * kDegree, 14 * kDegree, 35 * kDegree, 27 * kDegree, 7 * kDegree, 2.4f * kDegree, 0.11f};
    const auto band = [&](float edge, float inward) {   // lines follow the wall and, inward, the round corners
        const float a = edge - w.wall * 0.6f * inward, b = edge + (w.corner + w.wall) * inward;
        return std::array<float, 2>{std::min(a, b), std::max(a, b)};
    };
    const std::array<std::array<float, 2>, 2> lon_bands = {band(w.longitude - w.half_width, 1), band(w.longitude + w.half_width, -1)};
    const std::array<std::array<float, 2>, 2> lat_bands = {band(w.latitude - w.half_height, 1), band(w.latitude + w.half_height, -1)};
    const std::vector<float> lon = lines(kSeam, kSeam + 2 * kPi, 2.5f * kDegree, 0.35f * kDegree, lon_bands);
    const std::vector<float> lat = lines(-kPi / 2, kPi / 2, 2.5f * kDegree, 0.35f * kDegree, lat_bands);
    return make_globe("shader ball", lon, lat, [&](float x, float y, float& r, float& rx, float& ry) { w.radius(x, y, r, rx, ry); });
}

std::shared_ptr<const Mesh> make_sphere() {
    const std::vector<float> lon = lines(kSeam, kSeam + 2 * kPi, 2 * kDegree, 1, {});
    const std::vector<float> lat = lines(-kPi / 2, kPi / 2, 2 * kDegree, 1, {});
    return make_globe("sphere", lon, lat, [](float, float, float& r, float& rx, float& ry) { r = 1, rx = ry = 0; });
}

std::shared_ptr<const Mesh> make_plate() {
    Mesh m;
    m.name = "plate";
    const Grid grid{{0, 1}, {0, 1}, false};
    m.positions = {{-1, 0, -1}, {1, 0, -1}, {-1, 0, 1}, {1, 0, 1}};
    grid.emit(m);
    return finish(std::move(m));
}

std::shared_ptr<const Mesh> make_block() {
    Mesh m;
    m.name = "block";
    constexpr float h = 0.75f;
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.f, 1.f}) {
            const uint32_t first = uint32_t(m.positions.size());
            for (const auto& [a, b] : {std::array{-1.f, -1.f}, {1.f, -1.f}, {1.f, 1.f}, {-1.f, 1.f}}) {
                Vec3f p;
                p[axis] = side * h;
                p[(axis + 1) % 3] = a * side * h;   // turned round on the other side: faces look outwards
                p[(axis + 2) % 3] = b * h;
                m.positions.push_back(p);
            }
            m.triangles.push_back({first, first + 1, first + 2});
            m.triangles.push_back({first, first + 2, first + 3});
            for (const auto& uv : {std::array{0.f, 0.f}, {1.f, 0.f}, {1.f, 1.f}, {0.f, 0.f}, {1.f, 1.f}, {0.f, 1.f}}) m.uv.push_back(uv);
        }
    m.smooth.assign(m.triangles.size(), 0);
    return finish(std::move(m));
}

std::shared_ptr<const Mesh> make_drape() {
    constexpr int kLines = 161;
    constexpr float kHalf = 1.6f, kRadius = 0.62f, kEdge = 78 * kDegree, kFolds = 11;
    Mesh m;
    m.name = "drape";
    Grid grid{{}, {}, false};
    for (int i = 0; i < kLines; ++i) {
        grid.u.push_back(float(i) / (kLines - 1));
        grid.v.push_back(float(i) / (kLines - 1));
    }
    for (const float v : grid.v)
        for (const float u : grid.u) {
            const float x = (2 * u - 1) * kHalf, y = (2 * v - 1) * kHalf, s = std::hypot(x, y), turn = std::atan2(y, x);
            const float on_ball = std::min(s, kEdge * kRadius), angle = on_ball / kRadius, hangs = s - on_ball;
            // Below the ball the sheet has more cloth than way round: it goes into folds that grow downwards.
            const float fold = 0.10f * smooth_step(hangs / 0.8f) * std::cos(kFolds * turn + 0.6f * std::sin(2 * turn + 1));
            const float r = kRadius * std::sin(angle) + hangs * (0.13f + 0.03f * std::sin(3 * turn)) + fold;
            const float z = kRadius * std::cos(angle) - 0.95f * hangs;
            m.positions.push_back({r * std::cos(turn), r * std::sin(turn), z});
        }
    grid.emit(m);
    return finish(std::move(m));
}

std::shared_ptr<const Mesh> make_hair_swatch() {
    constexpr int kThreads = 5000, kPoints = 18;
    constexpr float kBar = 0.42f, kHalfWidth = 0.85f, kThick = 0.05f;
    Mesh m;
    m.name = "swatch";
    m.shape = Shape::Curves;
    uint32_t state = 1;
    const auto random = [&state] {   // numerical recipes' generator: the same threads everywhere
        state = state * 1664525u + 1013904223u;
        return float(state >> 8) * 0x1p-24f;
    };
    for (int i = 0; i < kThreads; ++i) {
        m.curve_first.push_back(uint32_t(m.positions.size()));
        const float root = (2 * random() - 1) * kHalfWidth, lift = kThick * random(), front = 1.15f + 0.25f * random(), back = 0.25f + 0.2f * random();
        const float wave = 0.012f + 0.02f * random(), phase = 2 * kPi * random(), drift = 0.10f * (random() - 0.5f), width = 0.0035f + 0.0015f * random();
        const float r = kBar + lift, half_turn = kPi * r, whole = back + half_turn + front;
        for (int k = 0; k < kPoints; ++k) {
            const float t = float(k) / (kPoints - 1), s = t * whole - back;   // along the thread: up behind, over the bar, down in front
            Vec3f p;
            if (s < 0) p = {0, r, s};
            else if (s < half_turn) p = {0, r * std::cos(s / r), r * std::sin(s / r)};
            else p = {0, -r, -(s - half_turn)};
            const float down = std::max(0.f, s - half_turn);
            p.x = root + drift * t + wave * std::sin(7 * s + phase);
            p.y -= 0.5f * wave * std::cos(5 * s + phase) + 0.06f * down * down * lift / kThick;
            m.positions.push_back(p);
            m.radii.push_back(width * (t > 0.9f ? 1 - 6 * (t - 0.9f) : 1));
        }
    }
    m.curve_first.push_back(uint32_t(m.positions.size()));
    return finish(std::move(m));
}

std::shared_ptr<const Mesh> make_turned(const char* name, std::span<const OutlinePoint> outline, int segments) {
    // Each rounded corner becomes an arc of a quadratic Bezier curve between points on its two sides.
    constexpr int kArc = 8;
    std::vector<std::array<float, 2>> line;
    for (size_t i = 0; i < outline.size(); ++i) {
        const OutlinePoint& p = outline[i];
        if (i == 0 || i + 1 == outline.size() || p.rounding <= 0) {
            line.push_back({p.r, p.z});
            continue;
        }
        const auto towards = [&](const OutlinePoint& q) {
            const float l = std::hypot(q.r - p.r, q.z - p.z), s = std::min(p.rounding, l / 2) / std::max(l, 1e-6f);
            return std::array<float, 2>{p.r + (q.r - p.r) * s, p.z + (q.z - p.z) * s};
        };
        const auto a = towards(outline[i - 1]), b = towards(outline[i + 1]);
        for (int k = 0; k <= kArc; ++k) {
            const float t = float(k) / kArc, wa = (1 - t) * (1 - t), wp = 2 * t * (1 - t), wb = t * t;
            line.push_back({wa * a[0] + wp * p.r + wb * b[0], wa * a[1] + wp * p.z + wb * b[1]});
        }
    }
    Mesh m;
    m.name = name;
    Grid grid{{}, {}, true};
    for (int c = 0; c <= segments; ++c) grid.u.push_back(float(c) / float(segments));
    float along = 0;
    for (size_t i = 0; i < line.size(); ++i) {
        if (i > 0) along += std::hypot(line[i][0] - line[i - 1][0], line[i][1] - line[i - 1][1]);
        grid.v.push_back(along);
        for (int c = 0; c < segments; ++c) {
            const float angle = 2 * kPi * float(c) / float(segments);
            m.positions.push_back(Vec3f(line[i][0] * std::cos(angle), line[i][0] * std::sin(angle), line[i][1]));
        }
    }
    for (float& v : grid.v) v /= std::max(along, 1e-6f);
    grid.emit(m);
    return finish(std::move(m));
}

std::shared_ptr<const Mesh> make_cyclorama(float half_width, float front, float back, float radius, float top) {
    Mesh m;
    m.name = "studio";
    std::vector<std::array<float, 3>> profile;   // y, z, length so far
    profile.push_back({front, 0, 0});
    constexpr int kArc = 32;
    const float flat = back - radius - front;
    for (int k = 0; k <= kArc; ++k) {
        const float a = kPi / 2 * float(k) / kArc;
        profile.push_back({back - radius + radius * std::sin(a), radius - radius * std::cos(a), flat + radius * a});
    }
    profile.push_back({back, top, flat + radius * kPi / 2 + top - radius});
    Grid grid{{-half_width, half_width}, {}, false};
    for (const auto& [y, z, along] : profile) {
        grid.v.push_back(along + front);   // metres, 0 where y = 0
        for (float x : grid.u) m.positions.push_back(Vec3f(x, y, z));
    }
    grid.emit(m);
    return finish(std::move(m));
}

}  // namespace alder
