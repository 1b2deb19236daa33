// What the tests of alShaders patterns share: a case's point, its remap block and its two colours.
#pragma once
#include "nodes/math/remap-inl.h"
#include "tests/nodes/al_table.h"
#include "tests/nodes/node_call.h"

namespace alder::test {

inline float remapped(const nlohmann::json& p, float x) {
    const char* names[12] = {"RMPinputMin", "RMPinputMax", "RMPcontrast", "RMPcontrastPivot", "RMPbias", "RMPgain",
                             "RMPoutputMin", "RMPoutputMax", "RMPclampEnable", "RMPthreshold", "RMPclampMin", "RMPclampMax"};
    float value[12];
    Channel<float> in[12];
    for (int i = 0; i < 12; ++i) value[i] = al_float(p[names[i]]), in[i] = {&value[i], 0};
    const OpCall<float> call{in, nullptr, nullptr, nullptr, 1};
    return HWY_NAMESPACE::al_remap(HWY_NAMESPACE::Lanes<float>{call, 0}, 0, x);
}
/// Where a case's pattern is evaluated, by `space` and `P` (specification, 1.5).
inline Vec3f pattern_point_of(const nlohmann::json& c) {
    const auto& p = c["params"];
    const auto& g = c["globals"];
    if (c.contains("links")) return al_vec(p["P"]);
    if (p["space"] == "world") return al_vec(g["P"]);
    if (p["space"] == "UV") return {al_float(g["u"]), al_float(g["v"]), 0};
    if (p["space"] == "Pref" && c.contains("userData") && c["userData"].contains("Pref")) return al_vec(c["userData"]["Pref"]);
    return al_vec(g["Po"]);
}
/// How far the colour of noise n is from the case's output.
inline double pattern_error(const nlohmann::json& c, float n) {
    const auto& p = c["params"];
    const Vec3f got = HWY_NAMESPACE::lerp(al_vec(p["color1"]), al_vec(p["color2"]), remapped(p, n));
    double worst = 0;
    for (int i = 0; i < 3; ++i) worst = std::max(worst, al_error(got[i], al_number(c["output"][i])));
    return worst;
}

}  // namespace alder::test
