// Elementary functions over lanes. Scalars and double use libm; lanes use libm per lane until a polynomial of ours serves.
#if defined(ALDER_NODES_NUM_MATH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_NUM_MATH_INL_H_
#undef ALDER_NODES_NUM_MATH_INL_H_
#else
#define ALDER_NODES_NUM_MATH_INL_H_
#endif

#include "nodes/num/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

#define ALDER_LIBM1(name) \
    template <class F> HWY_INLINE F name(F x) { return map_lanes(x, [](auto a) { return std::name(a); }); }
ALDER_LIBM1(exp) ALDER_LIBM1(exp2) ALDER_LIBM1(log) ALDER_LIBM1(log2) ALDER_LIBM1(log10) ALDER_LIBM1(sin) ALDER_LIBM1(cos)
ALDER_LIBM1(tan) ALDER_LIBM1(asin) ALDER_LIBM1(acos) ALDER_LIBM1(atan) ALDER_LIBM1(sinh) ALDER_LIBM1(cosh) ALDER_LIBM1(tanh)
ALDER_LIBM1(cbrt)
#undef ALDER_LIBM1
template <class F> HWY_INLINE F pow(F x, F y) { return map_lanes(x, y, [](auto a, auto b) { return std::pow(a, b); }); }
template <class F> HWY_INLINE F atan2(F y, F x) { return map_lanes(y, x, [](auto a, auto b) { return std::atan2(a, b); }); }
template <class F> HWY_INLINE F fmod(F x, F y) { return map_lanes(x, y, [](auto a, auto b) { return std::fmod(a, b); }); }

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
