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
inline ValueRef pattern_point(Lowering& l, int space, int p) {
    if (l.linked(p)) return l.input(p);
    switch (l.statics().e(space)) {
        case 1: return l.global(Global::Po);
        case 2: return l.attribute_or("Pref", Type::Vector, l.global(Global::Po));
        case 3: return l.global(Global::Uv);
        default: return l.global(Global::P);
    }
}
/// Lowers a node whose kernel reads the point in the channels of its parameter P.
inline void lower_at_pattern_point(Lowering& l, int space, int p) {
    const Statics& s = l.statics();
    std::vector<ValueRef> operands;
    for (int i = 0; i < static_cast<int>(s.type->params.size()); ++i) {
        const Type type = s.type->params[i].type;
        if (channels(type) == 0) continue;
        if (i == p) operands.push_back(pattern_point(l, space, p));
        else if (s.type->uses && !s.type->uses(s, i)) operands.push_back(l.constant(type, 0));
        else operands.push_back(l.input(i));
    }
    l.result(l.call(operands, 0));
}

}  // namespace alder
