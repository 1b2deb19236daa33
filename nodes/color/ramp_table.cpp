// Baking of colour ramps: stops, colour models and interpolations as Blender evaluates them.
// Blender 4.5, blenkernel/intern/colorband.cc, for the rules; B-spline and cardinal weights of its key-frame curves.
#include "nodes/color/ramp_table.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace alder {
namespace {

using nlohmann::json;

enum class ColorMode { Rgb, Hsv, Hsl };
enum class RampMode { Ease, Cardinal, Linear, BSpline, Constant };
enum class HueMode { Near, Far, Cw, Ccw };

struct Stop {
    float position;
    std::array<float, 4> color;
};
struct Ramp {
    ColorMode color_mode = ColorMode::Rgb;
    RampMode mode = RampMode::Linear;
    HueMode hue = HueMode::Near;
    std::vector<Stop> stops;
};
constexpr size_t kMaxStops = 1024;  // Blender has 32; more do no harm

float clamp01(float x) { return std::min(std::max(x, 0.0f), 1.0f); }

// Blender's own conversions: another arrangement than Cycles' at shading points.
void rgb_to_hsv(const float c[3], float out[3]) {
    float r = c[0], g = c[1], b = c[2], k = 0;
    if (g < b) {
        std::swap(g, b);
        k = -1;
    }
    float least = b;
    if (r < g) {
        std::swap(r, g);
        k = -2.0f / 6.0f - k;
        least = std::min(g, b);
    }
    const float chroma = r - least;
    out[0] = std::fabs(k + (g - b) / (6.0f * chroma + 1e-20f));
    out[1] = chroma / (r + 1e-20f);
    out[2] = r;
}
void hue_to_weights(float h, float out[3]) {
    out[0] = clamp01(std::fabs(h * 6.0f - 3.0f) - 1.0f);
    out[1] = clamp01(2.0f - std::fabs(h * 6.0f - 2.0f));
    out[2] = clamp01(2.0f - std::fabs(h * 6.0f - 4.0f));
}
void hsv_to_rgb(const float c[3], float out[3]) {
    float w[3];
    hue_to_weights(c[0], w);
    for (int i = 0; i < 3; ++i) out[i] = ((w[i] - 1.0f) * c[1] + 1.0f) * c[2];
}
void rgb_to_hsl(const float c[3], float out[3]) {
    const float hi = std::max({c[0], c[1], c[2]}), lo = std::min({c[0], c[1], c[2]}), d = hi - lo;
    float h = 0, s = 0;
    const float l = std::min(1.0f, (hi + lo) / 2.0f);
    if (d != 0) {
        s = l > 0.5f ? d / (2.0f - hi - lo) : d / (hi + lo);
        h = hi == c[0] ? (c[1] - c[2]) / d + (c[1] < c[2] ? 6.0f : 0.0f) : hi == c[1] ? (c[2] - c[0]) / d + 2.0f : (c[0] - c[1]) / d + 4.0f;
    }
    out[0] = h / 6.0f;
    out[1] = s;
    out[2] = l;
}
void hsl_to_rgb(const float c[3], float out[3]) {
    float w[3];
    hue_to_weights(c[0], w);
    const float chroma = (1.0f - std::fabs(2.0f * c[2] - 1.0f)) * c[1];
    for (int i = 0; i < 3; ++i) out[i] = (w[i] - 0.5f) * chroma + c[2];
}

float wrap_hue(float h) { return h < 1.0f ? h : h - 1.0f; }

/// Weight t on h2. Near and Far choose the shorter and longer way round the circle, Cw falling and Ccw rising hue.
float interpolate_hue(HueMode mode, float t, float h1, float h2) {
    h1 = wrap_hue(h1);
    h2 = wrap_hue(h2);
    const float d = h2 - h1;
    bool raise_first = false, raise_second = false;
    switch (mode) {
        case HueMode::Near:
            raise_first = h1 < h2 && d > 0.5f;
            raise_second = h1 > h2 && d < -0.5f;
            break;
        case HueMode::Far:
            raise_first = h1 == h2 || (h1 < h2 && d < 0.5f);
            raise_second = h1 > h2 && d > -0.5f;
            break;
        case HueMode::Ccw: raise_second = h1 > h2; break;
        case HueMode::Cw: raise_first = h1 < h2; break;
    }
    const float h = (1.0f - t) * (raise_first ? h1 + 1.0f : h1) + t * (raise_second ? h2 + 1.0f : h2);
    return raise_first || raise_second ? wrap_hue(h) : h;
}

std::array<float, 4> curve_weights(RampMode mode, float t) {
    const float t2 = t * t, t3 = t2 * t;
    if (mode == RampMode::Cardinal) {
        constexpr float kTension = 0.71f;
        return {-kTension * t3 + 2.0f * kTension * t2 - kTension * t, (2.0f - kTension) * t3 + (kTension - 3.0f) * t2 + 1.0f,
                (kTension - 2.0f) * t3 + (3.0f - 2.0f * kTension) * t2 + kTension * t, kTension * t3 - kTension * t2};
    }
    return {-0.16666666f * t3 + 0.5f * t2 - 0.5f * t + 0.16666666f, 0.5f * t3 - t2 + 0.66666666f,
            -0.5f * t3 + 0.5f * t2 + 0.5f * t + 0.16666666f, 0.16666666f * t3};
}

/// Between the stop to the right (weight 1 - t) and the one to the left (weight t), as Blender counts.
std::array<float, 4> blend(const Ramp& ramp, const Stop& right, const Stop& left, float t) {
    std::array<float, 4> out;
    const float m = 1.0f - t;
    if (ramp.color_mode == ColorMode::Rgb) {
        for (int i = 0; i < 4; ++i) out[i] = m * right.color[i] + t * left.color[i];
        return out;
    }
    const bool hsv = ramp.color_mode == ColorMode::Hsv;
    float a[3], b[3], c[3];
    (hsv ? rgb_to_hsv : rgb_to_hsl)(right.color.data(), a);
    (hsv ? rgb_to_hsv : rgb_to_hsl)(left.color.data(), b);
    c[0] = interpolate_hue(ramp.hue, t, a[0], b[0]);
    for (int i = 1; i < 3; ++i) c[i] = m * a[i] + t * b[i];
    (hsv ? hsv_to_rgb : hsl_to_rgb)(c, out.data());
    out[3] = m * right.color[3] + t * left.color[3];
    return out;
}

std::array<float, 4> evaluate(const Ramp& ramp, float x) {
    const auto& s = ramp.stops;
    const int n = static_cast<int>(s.size());
    // Outside RGB only linear interpolation exists.
    const RampMode mode = ramp.color_mode == ColorMode::Rgb ? ramp.mode : RampMode::Linear;
    const bool spline = mode == RampMode::Cardinal || mode == RampMode::BSpline;
    if (n == 1 || (!spline && x <= s[0].position)) return s[0].color;
    int a = 0;  // first stop to the right of x
    while (a < n && s[a].position <= x) ++a;
    if (!spline && a == n) return s[n - 1].color;
    if (mode == RampMode::Constant) return s[a - 1].color;
    Stop right = a < n ? s[a] : s[n - 1], left = a > 0 ? s[a - 1] : s[0];
    if (a == n) right.position = 1;
    if (a == 0) left.position = 0;
    float t = left.position != right.position ? (x - right.position) / (left.position - right.position) : a != n ? 0.0f : 1.0f;
    if (spline) {
        const Stop& beyond_right = a >= n - 1 ? right : s[a + 1];
        const Stop& beyond_left = a < 2 ? left : s[a - 2];
        const auto w = curve_weights(mode, clamp01(t));
        std::array<float, 4> out;
        for (int i = 0; i < 4; ++i)
            out[i] = clamp01(w[3] * beyond_left.color[i] + w[2] * left.color[i] + w[1] * right.color[i] + w[0] * beyond_right.color[i]);
        return out;
    }
    if (mode == RampMode::Ease) t = 3.0f * t * t - 2.0f * t * t * t;
    return blend(ramp, right, left, t);
}

/// Index of the text among the names; -1 and a message otherwise.
int choose(const json& ramp, const char* key, std::initializer_list<const char*> names, int otherwise, std::vector<std::string>& errors) {
    const auto it = ramp.find(key);
    if (it == ramp.end()) return otherwise;
    int i = 0;
    std::string list;
    for (const char* name : names) {
        if (*it == name) return i;
        list += (i++ ? ", " : "") + std::string(name);
    }
    errors.push_back("color_ramp: " + std::string(key) + " is " + it->dump() + ", expected one of " + list);
    return otherwise;
}

bool read_stop(const json& v, Stop& out) {
    if (!v.is_object() || !v.contains("position") || !v.contains("color")) return false;
    const json &position = v["position"], &color = v["color"];
    if (!position.is_number() || !color.is_array() || color.size() < 3 || color.size() > 4) return false;
    for (const json& c : color)
        if (!c.is_number()) return false;
    out.position = position.get<float>();
    out.color = {color[0].get<float>(), color[1].get<float>(), color[2].get<float>(), color.size() == 4 ? color[3].get<float>() : 1.0f};
    return std::isfinite(out.position);
}

}  // namespace

std::shared_ptr<const RampTable> bake_ramp(const std::string& json_text, std::vector<std::string>& errors) {
    const json v = json::parse(json_text.empty() ? "null" : json_text, nullptr, false);
    Ramp ramp;
    ramp.stops = {{0, {0, 0, 0, 1}}, {1, {1, 1, 1, 1}}};
    const size_t faults = errors.size();
    if (!v.is_null() && !v.is_object()) errors.push_back("color_ramp: expected an object with elements");
    if (v.is_object()) {
        ramp.color_mode = static_cast<ColorMode>(choose(v, "color_mode", {"RGB", "HSV", "HSL"}, 0, errors));
        ramp.mode = static_cast<RampMode>(choose(v, "interpolation", {"EASE", "CARDINAL", "LINEAR", "B_SPLINE", "CONSTANT"}, 2, errors));
        ramp.hue = static_cast<HueMode>(choose(v, "hue_interpolation", {"NEAR", "FAR", "CW", "CCW"}, 0, errors));
        if (v.contains("elements")) {
            const json& elements = v["elements"];
            if (!elements.is_array() || elements.empty() || elements.size() > kMaxStops)
                errors.push_back("color_ramp: elements: expected a list of 1 to " + std::to_string(kMaxStops) + " stops");
            else
                ramp.stops.clear();
            for (size_t i = 0; i < elements.size() && elements.is_array() && elements.size() <= kMaxStops; ++i) {
                Stop s;
                if (read_stop(elements[i], s)) ramp.stops.push_back(s);
                else errors.push_back("color_ramp: elements/" + std::to_string(i) + ": expected {position, color [r, g, b, a]}");
            }
        }
    }
    if (errors.size() != faults) return nullptr;
    std::stable_sort(ramp.stops.begin(), ramp.stops.end(), [](const Stop& a, const Stop& b) { return a.position < b.position; });
    const auto table = std::make_shared<RampTable>();
    table->interpolate = ramp.mode != RampMode::Constant;
    for (int i = 0; i < kRampSize; ++i) {
        const auto c = evaluate(ramp, static_cast<float>(i) / static_cast<float>(kRampSize - 1));
        for (int k = 0; k < 4; ++k) table->rgba[k][i] = c[k];
    }
    return table;
}

}  // namespace alder
