// The tangent that Cycles uses where none is given: around the object's Z axis, from generated coordinates.
#pragma once
#include "graph/lowering.h"

namespace alder {

/// World space, orthogonal to N; NaN at the poles and on the world.
ValueRef radial_tangent(Lowering& lowering);

}  // namespace alder
