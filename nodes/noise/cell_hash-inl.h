// Random numbers that are constant per integer cell: our stand-ins for Arnold's cell noise (alshaders specification, 1.8).
#if defined(ALDER_NODES_NOISE_CELL_HASH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_NOISE_CELL_HASH_INL_H_
#undef ALDER_NODES_NOISE_CELL_HASH_INL_H_
#else
#define ALDER_NODES_NOISE_CELL_HASH_INL_H_
#endif

#include "nodes/noise/hash-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// The 32 bits as a number in [0, 1): the upper 24 of them, exact in float.
template <class F>
HWY_INLINE F unit_from_bits(Int<F> bits) { return to_float<F>(shr<8>(bits)) * F(0x1p-24); }
/// The cell of a coordinate as bits to hash: of the float, so that cells stay apart at any distance. -0 and 0 are one cell.
template <class F>
HWY_INLINE Int<F> cell_bits(F x) { return float_bits(floor(x) + F(0)); }

/// Arnold's cellnoise2: one number a cell.
template <class F>
HWY_INLINE F cell_noise2(F x, F y) { return unit_from_bits<F>(hash_uint2(cell_bits(x), cell_bits(y))); }
/// Arnold's vcellnoise3: three numbers a cell.
template <class F>
HWY_INLINE Vec3<F> vcell_noise3(Vec3<F> p) {
    const Int<F> x = cell_bits(p.x), y = cell_bits(p.y), z = cell_bits(p.z);
    return {unit_from_bits<F>(hash_uint4(x, y, z, Int<F>(0))), unit_from_bits<F>(hash_uint4(x, y, z, Int<F>(1))),
            unit_from_bits<F>(hash_uint4(x, y, z, Int<F>(2)))};
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
