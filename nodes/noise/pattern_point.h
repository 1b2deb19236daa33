// The point at which an alShaders pattern is evaluated, decided by its parameters `space` and `P`. alshaders specification, 1.5.
#pragma once
#include "graph/lowering.h"

namespace alder {

inline Param pattern_space_param(const char* initial) {
    return param::choice("space", {"world", "object", "Pref", "UV"}, initial)
        .doc("coordinates of the pattern unless P is linked; Pref is the attribute of that name, object space where it is missing");
}
inline Param pattern_point_param() { return param::vector("P", 0, 0, 0).linked_only().doc("point to evaluate at; only a link counts, and replaces space"); }

/// Unlinked P has no effect, space none where P is linked.
inline bool pattern_point_uses(const Statics& s, int param, int space, int p) {
    return param == space ? !s.linked[p] : param == p ? static_cast<bool>(s.linked[p]) : true;
}
/// At the shading point (direction 0), or as far as the next pixel in x (1) or y (2). Pref does not move: its derivative is not known.
inline ValueRef pattern_point(Lowering& l, int space, int p, int direction = 0) {
    const auto seen = [&](Global g) { return direction == 0 ? l.global(g) : l.displaced_global(g, direction, l.constant(Type::Float, 1)); };
    if (l.linked(p)) return direction == 0 ? l.input(p) : l.displaced_input(p, direction, l.constant(Type::Float, 1));
    switch (l.statics().e(space)) {
        case 1: return seen(Global::Po);
        case 2: return l.attribute_or("Pref", Type::Vector, seen(Global::Po));
        case 3: return seen(Global::Uv);
        default: return seen(Global::P);
    }
}
/// Lowers a node whose kernel reads the point in the channels of its parameter P.
/// `fades`: its globals are Dpdx, Dpdy and PixelFootprint, in whose place come, where noise fades, the point at the next pixels and 1.
inline void lower_at_pattern_point(Lowering& l, int space, int p, bool fades = false) {
    const Statics& s = l.statics();
    std::vector<ValueRef> operands;
    for (int i = 0; i < static_cast<int>(s.type->params.size()); ++i) {
        const Type type = s.type->params[i].type;
        if (channels(type) == 0) continue;
        if (i == p) operands.push_back(pattern_point(l, space, p));
        else if (s.type->uses && !s.type->uses(s, i)) operands.push_back(l.constant(type, 0));
        else operands.push_back(l.input(i));
    }
    if (!fades || !l.fades_noise()) return l.result(l.call(operands, 0));
    const ValueRef seen[] = {pattern_point(l, space, p, 1), pattern_point(l, space, p, 2), l.constant(Type::Float, 1)};
    l.result(l.call(operands, seen, 0));
}

}  // namespace alder
