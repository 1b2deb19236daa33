// Baking of curve mappings: points with automatic handles, Bezier segments, a table over the clipping range, and its samples.
// Blender 4.5, blenkernel/intern/colortools.cc and curve.cc, for the rules: handles and their lengths, limits of handles, the two
// levels of sampling (32 steps a segment, then 257 equal steps), extension beyond the ends.
#include "nodes/color/curve_table.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <nlohmann/json.hpp>

namespace alder {
namespace {

using nlohmann::json;

constexpr int kSegmentSteps = 32;
constexpr int kTableSteps = 256;
constexpr float kHandleFactor = 2.5614f;  // 1.2807 a side: a quarter circle comes out nearly round
constexpr size_t kMaxPoints = 4096;

struct Point2 {
    float x = 0, y = 0;
};
Point2 operator-(Point2 a, Point2 b) { return {a.x - b.x, a.y - b.y}; }
Point2 along(Point2 p, Point2 d, float s) { return {p.x + d.x * s, p.y + d.y * s}; }
float length(Point2 a) { return std::sqrt(a.x * a.x + a.y * a.y); }

enum class Handle { Auto, AutoClamped, Vector };
struct CurvePoint {
    Point2 at;
    Handle handle = Handle::Auto;
};
struct Knot {
    Point2 before, at, after;
    Handle handle;
};

/// One curve: its table over [min_x, max_x] and how it goes on outside.
struct Curve {
    std::vector<CurvePoint> points;
    float min_x = 0, max_x = 1, inverse_step = 256;
    std::array<Point2, kTableSteps + 1> table{};
    Point2 extend_in, extend_out;
};
struct Mapping {
    bool extrapolate = true;
    float clip_min_x = 0, clip_max_x = 1;
    std::vector<Curve> curves;
};

/// Keeps an automatic, clamped handle's height between its point and the neighbour; level at an extremum.
float clamped_height(float height, float own, float this_side, float other_side) {
    const float here = this_side - own, there = other_side - own;
    if ((here <= 0 && there <= 0) || (here >= 0 && there >= 0)) return own;
    return here <= 0 ? std::max(this_side, height) : std::min(this_side, height);
}

/// The neighbour of an end point that is not there.
Point2 mirrored(Point2 p, Point2 neighbour) { return {2.0f * p.x - neighbour.x, 2.0f * p.y - neighbour.y}; }

void place_handles(Knot& k, const Knot* previous, const Knot* next) {
    const Point2 p0 = previous ? previous->at : mirrored(k.at, next->at);
    const Point2 p1 = next ? next->at : mirrored(k.at, previous->at);
    const Point2 a = k.at - p0, b = p1 - k.at;
    k.before = along(k.at, a, -1.0f / 3.0f);
    k.after = along(k.at, b, 1.0f / 3.0f);
    if (k.handle == Handle::Vector) return;
    k.before = k.after = Point2{};
    float la = length(a), lb = length(b);
    la = la == 0 ? 1 : la;
    lb = lb == 0 ? 1 : lb;
    const Point2 t{b.x / lb + a.x / la, b.y / lb + a.y / la};
    const float l = length(t) * kHandleFactor;
    if (l == 0) return;
    k.before = along(k.at, t, -la / l);
    k.after = along(k.at, t, lb / l);
    if (k.handle == Handle::AutoClamped && previous && next) {
        k.before.y = clamped_height(k.before.y, k.at.y, previous->at.y, next->at.y);
        k.after.y = clamped_height(k.after.y, k.at.y, next->at.y, previous->at.y);
    }
}

/// The outer points' automatic handles point at the neighbour's handle instead of the neighbour; their length stays.
void aim_end(Knot& end, Point2& inner, Point2& outer, Point2 target, bool first) {
    if (end.handle != Handle::Auto) return;
    const float handle_length = length(inner - end.at);
    target.x = first ? std::max(target.x, end.at.x) : std::min(target.x, end.at.x);
    const Point2 d = target - end.at;
    const float l = length(d);
    if (l <= FLT_EPSILON) return;
    inner = along(end.at, d, handle_length / l);
    outer = along(end.at, d, -handle_length / l);
}

/// Handles that overlap along x are shortened alike, so that x does not run back.
void limit_handles(Point2 v1, Point2& v2, Point2& v3, Point2 v4) {
    const Point2 h1 = v1 - v2, h2 = v4 - v3;
    const float span = v4.x - v1.x, reach = std::fabs(h1.x) + std::fabs(h2.x);
    if (reach == 0 || reach <= span) return;
    v2 = along(v1, h1, -span / reach);
    v3 = along(v4, h2, -span / reach);
}

/// One coordinate of a cubic at kSegmentSteps equal parameters, by forward differences in single precision.
void sample_cubic(float q0, float q1, float q2, float q3, float* out, size_t stride) {
    const float n = kSegmentSteps - 1;
    const float d1 = 3.0f * (q1 - q0) / n, d2 = 3.0f * (q0 - 2.0f * q1 + q2) / (n * n), d3 = (q3 - q0 + 3.0f * (q1 - q2)) / (n * n * n);
    float v = q0, s1 = d1 + d2 + d3, s2 = 2 * d2 + 6 * d3;
    const float s3 = 6 * d3;
    for (int i = 0; i < kSegmentSteps; ++i, out += stride) {
        *out = v;
        v += s1;
        s1 += s2;
        s2 += s3;
    }
}

Point2 unit(Point2 d) {
    const float l = length(d);
    return {d.x / l, d.y / l};
}

float extended(const Mapping& m, const Curve& c, float x, Point2 first, Point2 last) {
    if (x <= first.x) {
        if (!m.extrapolate) return first.y;
        if (c.extend_in.x == 0) return first.y + c.extend_in.y * 10000.0f;
        return first.y + c.extend_in.y * (x - first.x) / c.extend_in.x;
    }
    if (!m.extrapolate) return last.y;
    if (c.extend_out.x == 0) return last.y - c.extend_out.y * 10000.0f;
    return last.y + c.extend_out.y * (x - last.x) / c.extend_out.x;
}

void make_table(const Mapping& m, Curve& c) {
    const size_t n = c.points.size();
    c.min_x = m.clip_min_x;
    c.max_x = m.clip_max_x;
    std::vector<Knot> knots;
    for (const CurvePoint& p : c.points) {
        c.min_x = std::min(c.min_x, p.at.x);
        c.max_x = std::max(c.max_x, p.at.x);
        knots.push_back({{}, p.at, {}, p.handle});
    }
    for (size_t i = 0; i < n; ++i) place_handles(knots[i], i > 0 ? &knots[i - 1] : nullptr, i + 1 < n ? &knots[i + 1] : nullptr);
    if (n > 2) {
        aim_end(knots[0], knots[0].after, knots[0].before, knots[1].before, true);
        aim_end(knots[n - 1], knots[n - 1].before, knots[n - 1].after, knots[n - 2].after, false);
    }
    std::vector<Point2> samples((n - 1) * kSegmentSteps);
    for (size_t i = 0; i + 1 < n; ++i) {
        Knot &a = knots[i], &b = knots[i + 1];
        limit_handles(a.at, a.after, b.before, b.at);
        Point2* const out = &samples[i * kSegmentSteps];
        sample_cubic(a.at.x, a.after.x, b.before.x, b.at.x, &out->x, 2);
        sample_cubic(a.at.y, a.after.y, b.before.y, b.at.y, &out->y, 2);
    }
    c.extend_in = unit(knots[0].before - knots[0].at);
    c.extend_out = unit(knots[n - 1].at - knots[n - 1].after);

    const float step = (c.max_x - c.min_x) / kTableSteps;
    c.inverse_step = 1.0f / step;
    size_t p = 0;
    const size_t last = samples.size() - 1;
    for (int i = 0; i <= kTableSteps; ++i) {
        const float x = c.min_x + step * static_cast<float>(i);
        while (x >= samples[p].x && p != last) ++p;
        float y;
        if (p == 0 || (p == last && x >= samples[p].x)) {
            // On an end point its height counts: extending over a rounding error would show at steep ends.
            y = std::fabs(x - samples[p].x) <= 1e-6f ? samples[p].y : extended(m, c, x, samples.front(), samples.back());
        } else {
            const float span = samples[p].x - samples[p - 1].x;
            const float t = span > FLT_EPSILON ? (samples[p].x - x) / span : 0.0f;
            y = t * samples[p - 1].y + (1.0f - t) * samples[p].y;
        }
        c.table[i] = {x, y};
    }
}

float evaluate(const Mapping& m, const Curve& c, float x) {
    const float position = (x - c.min_x) * c.inverse_step;
    if (!(position >= 0) || position > kTableSteps) return extended(m, c, x, c.table.front(), c.table.back());
    const int i = static_cast<int>(position);
    if (i >= kTableSteps) return c.table.back().y;
    const float t = position - static_cast<float>(i);
    return (1.0f - t) * c.table[i].y + t * c.table[i + 1].y;
}

// ---- reading ---------------------------------------------------------------------------------------------------------

bool read_numbers(const json& v, size_t n, float* out) {
    if (!v.is_array() || v.size() < n) return false;
    for (size_t i = 0; i < n; ++i) {
        if (!v[i].is_number()) return false;
        out[i] = v[i].get<float>();
        if (!std::isfinite(out[i])) return false;
    }
    return true;
}

bool read_point(const json& v, CurvePoint& out) {
    if (!v.is_object() || !v.contains("location")) return false;
    float xy[2];
    if (!read_numbers(v["location"], 2, xy)) return false;
    out.at = {xy[0], xy[1]};
    const json handle = v.value("handle_type", json("AUTO"));
    if (handle == "AUTO") out.handle = Handle::Auto;
    else if (handle == "AUTO_CLAMPED") out.handle = Handle::AutoClamped;
    else if (handle == "VECTOR") out.handle = Handle::Vector;
    else return false;
    return true;
}

void read_curve(const json& v, size_t index, Curve& out, std::vector<std::string>& errors) {
    const std::string where = "mapping: curves/" + std::to_string(index);
    const json& points = v.is_object() && v.contains("points") ? v["points"] : v;
    if (!points.is_array() || points.size() < 2 || points.size() > kMaxPoints) {
        errors.push_back(where + ": expected a list of 2 or more points");
        return;
    }
    for (size_t i = 0; i < points.size(); ++i) {
        CurvePoint p;
        if (read_point(points[i], p)) out.points.push_back(p);
        else errors.push_back(where + "/" + std::to_string(i) + ": expected {location [x, y], handle_type AUTO, AUTO_CLAMPED or VECTOR}");
    }
    std::stable_sort(out.points.begin(), out.points.end(), [](const CurvePoint& a, const CurvePoint& b) { return a.at.x < b.at.x; });
}

void read_mapping(const json& v, Mapping& m, size_t wanted, std::vector<std::string>& errors) {
    const auto fault = [&errors](const std::string& text) { errors.push_back("mapping: " + text); };
    if (!v.is_object()) return fault("expected an object with curves");
    const json extend = v.value("extend", json("EXTRAPOLATED"));
    if (extend != "EXTRAPOLATED" && extend != "HORIZONTAL") fault("extend is " + extend.dump() + ", expected EXTRAPOLATED or HORIZONTAL");
    m.extrapolate = extend == "EXTRAPOLATED";
    float clip[4] = {m.clip_min_x, 0, m.clip_max_x, 1};
    if (v.contains("clip") && !read_numbers(v["clip"], 4, clip)) fault("clip: expected [min x, min y, max x, max y]");
    const char* const names[] = {"clip_min_x", "clip_min_y", "clip_max_x", "clip_max_y"};
    for (int i = 0; i < 4; ++i)
        if (v.contains(names[i]) && v[names[i]].is_number()) clip[i] = v[names[i]].get<float>();
    m.clip_min_x = clip[0];
    m.clip_max_x = clip[2];
    if (!v.contains("curves")) return;
    const json& curves = v["curves"];
    if (!curves.is_array() || curves.size() < wanted) return fault("curves: expected " + std::to_string(wanted) + " lists of points");
    m.curves.assign(wanted, {});
    for (size_t i = 0; i < wanted; ++i) read_curve(curves[i], i, m.curves[i], errors);
}

}  // namespace

std::shared_ptr<const CurveTable> bake_curves(const std::string& json_text, CurveKind kind, std::vector<std::string>& errors) {
    const json v = json::parse(json_text.empty() ? "null" : json_text, nullptr, false);
    const size_t wanted = kind == CurveKind::Float ? 1 : kind == CurveKind::Vector ? 3 : 4;
    const float low = kind == CurveKind::Vector ? -1.0f : 0.0f;
    Mapping m;
    m.clip_min_x = low;
    m.curves.assign(wanted, {});
    for (Curve& c : m.curves) c.points = {{{low, low}, Handle::Auto}, {{1, 1}, Handle::Auto}};
    const size_t faults = errors.size();
    if (!v.is_null()) read_mapping(v, m, wanted, errors);
    if (errors.size() != faults) return nullptr;
    for (Curve& c : m.curves) make_table(m, c);

    const auto table = std::make_shared<CurveTable>();
    table->extrapolate = m.extrapolate;
    table->min_x = FLT_MAX;
    table->max_x = -FLT_MAX;
    for (const Curve& c : m.curves) {
        table->min_x = std::min(table->min_x, c.points.front().at.x);
        table->max_x = std::max(table->max_x, c.points.back().at.x);
    }
    const size_t outputs = kind == CurveKind::Float ? 1 : 3;
    table->channels.resize(outputs);
    const float range = table->max_x - table->min_x;
    for (int i = 0; i < kCurveSize; ++i) {
        const float x = table->min_x + static_cast<float>(i) / static_cast<float>(kCurveSize - 1) * range;
        for (size_t c = 0; c < outputs; ++c) {
            const float combined = kind == CurveKind::Rgb ? evaluate(m, m.curves[3], x) : x;
            table->channels[c][i] = evaluate(m, m.curves[c], combined);
        }
    }
    return table;
}

}  // namespace alder
