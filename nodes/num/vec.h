// Vec3<T> for scalar code (renderer, scene, tests): the same template as the kernels', in the build's base instruction set.
#pragma once
#include "nodes/num/vec-inl.h"

namespace alder {
template <class T>
using Vec3 = HWY_NAMESPACE::Vec3<T>;
using Vec3f = Vec3<float>;
using Vec3d = Vec3<double>;
}  // namespace alder
