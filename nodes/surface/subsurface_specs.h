// Lobes of Cycles' subsurface methods.
#pragma once
#include "nodes/schema.h"

namespace alder {

/// `method` as in the enum: 0 Christensen–Burley, 1 random walk, 2 random walk (skin).
inline void set_subsurface_specs(LobeSpec& deep, LobeSpec& shallow, int method, bool own_normal) {
    deep.kind = method == 0 ? LobeKind::Profile : LobeKind::RandomWalk;
    deep.order = method == 2 ? 1 : 0;
    deep.cycles_profile = true;
    deep.own_normal = own_normal;
    deep.label = LobeLabel::Sss;
    deep.cycles_normal = false;
    shallow.kind = LobeKind::Diffuse;
    shallow.smooth = true;
    shallow.label = LobeLabel::Sss;
    shallow.cycles_normal = true;
}

}  // namespace alder
