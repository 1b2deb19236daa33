// Schema of the remap block (RMP*), shared by the alShaders nodes that carry it.
#pragma once
#include "nodes/schema.h"

namespace alder {
/// Appends the twelve RMP parameters in the catalogue's order.
inline void add_remap_params(std::vector<Param>& p) {
    using namespace param;
    p.push_back(f("RMPinputMin", 0).in("Remap").doc("input value that maps to 0"));
    p.push_back(f("RMPinputMax", 1).in("Remap").doc("input value that maps to 1"));
    p.push_back(f("RMPcontrast", 1).in("Remap/Contrast").doc("slope about the pivot"));
    p.push_back(f("RMPcontrastPivot", 0.5).in("Remap/Contrast").doc("value that contrast leaves unchanged"));
    p.push_back(f("RMPbias", 0.5).in("Remap/Bias and gain").doc("below 0.5 darkens, above brightens the middle"));
    p.push_back(f("RMPgain", 0.5).in("Remap/Bias and gain").doc("below 0.5 flattens, above steepens the middle"));
    p.push_back(f("RMPoutputMin", 0).in("Remap").doc("output for 0"));
    p.push_back(f("RMPoutputMax", 1).in("Remap").doc("output for 1"));
    p.push_back(b("RMPclampEnable", true).in("Remap/Clamp").doc("limit the result to clampMin ... clampMax"));
    p.push_back(b("RMPthreshold", false).in("Remap/Clamp").doc("stretch the clamped range to 0 ... 1"));
    p.push_back(f("RMPclampMin", 0).in("Remap/Clamp").doc("lower limit"));
    p.push_back(f("RMPclampMax", 1).in("Remap/Clamp").doc("upper limit"));
}
}  // namespace alder
