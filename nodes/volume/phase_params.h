// What the declarations of volume nodes have in common: phase functions and their parameters.
#pragma once
#include <string_view>
#include <vector>

#include "nodes/schema.h"

namespace alder {

/// Items of `phase`, in this order.
enum class PhaseSetting : int { HenyeyGreenstein, FournierForand, Draine, Rayleigh, Mie };

inline Param phase_choice() {
    return param::choice("phase", {{"HENYEY_GREENSTEIN", "Henyey-Greenstein", "Henyey-Greenstein"},
                                   {"FOURNIER_FORAND", "Fournier-Forand", "Fournier-Forand"},
                                   {"DRAINE", "Draine", "Draine"},
                                   {"RAYLEIGH", "Rayleigh", "Rayleigh"},
                                   {"MIE", "Mie", "Mie"}},
                         "HENYEY_GREENSTEIN")
        .doc("how directions are distributed");
}

/// Sockets of the phase functions, in the order of PhaseChannels.
inline void add_phase_sockets(std::vector<Param>& params) {
    using namespace param;
    params.push_back(f("Anisotropy", 0).range(-1, 1).doc("mean cosine: -1 back, 0 to all sides, 1 straight on"));
    params.push_back(f("IOR", 1.33).range(1, 2).doc("index of the particles"));
    params.push_back(f("Backscatter", 0.1).range(0, 0.5).doc("share that is scattered backwards"));
    params.push_back(f("Alpha", 0.5).range(0, 500).doc("0: Henyey–Greenstein, 1 with anisotropy 0: Rayleigh"));
    params.push_back(f("Diameter", 20).range(0, 50).doc("of water droplets, micrometres"));
}

/// Whether the phase function reads the socket; true for parameters that are not its sockets.
inline bool phase_uses(PhaseSetting phase, std::string_view socket) {
    if (socket == "Anisotropy") return phase == PhaseSetting::HenyeyGreenstein || phase == PhaseSetting::Draine;
    if (socket == "IOR" || socket == "Backscatter") return phase == PhaseSetting::FournierForand;
    if (socket == "Alpha") return phase == PhaseSetting::Draine;
    if (socket == "Diameter") return phase == PhaseSetting::Mie;
    return true;
}

inline std::vector<LobeSpec> phase_lobes(PhaseSetting phase, std::vector<int> gates) {
    const auto lobe = [&](LobeKind kind) { return LobeSpec{.kind = kind, .label = LobeLabel::Volume, .gates = gates}; };
    switch (phase) {
        case PhaseSetting::FournierForand: return {lobe(LobeKind::PhaseFournierForand)};
        case PhaseSetting::Draine: return {lobe(LobeKind::PhaseDraine)};
        case PhaseSetting::Rayleigh: return {lobe(LobeKind::PhaseRayleigh)};
        case PhaseSetting::Mie: return {lobe(LobeKind::PhaseHenyeyGreenstein), lobe(LobeKind::PhaseDraine)};
        case PhaseSetting::HenyeyGreenstein: break;
    }
    return {lobe(LobeKind::PhaseHenyeyGreenstein)};
}

}  // namespace alder
