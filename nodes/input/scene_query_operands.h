// Operands with which kernels that cast rays end: nodes/input/scene_query-inl.h reads them.
#pragma once
#include <vector>

#include "graph/lowering.h"
#include "nodes/input/scene_query.h"

namespace alder {

inline void add_scene_operands(Lowering& l, std::vector<ValueRef>& operands) {
    for (Global g : {Global::P, Global::Ng, Global::N, Global::I}) operands.push_back(l.global(g));
    operands.push_back(l.attribute(kSceneInstance, Type::Float));
    operands.push_back(l.attribute(kScenePositionError, Type::Float));
    operands.push_back(l.global(Global::Backfacing));
}

}  // namespace alder
