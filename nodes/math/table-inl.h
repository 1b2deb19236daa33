// Lookup in a table sampled at equal steps over 0 ... 1, linear between samples, as Cycles looks up ramps and curves.
#if defined(ALDER_NODES_MATH_TABLE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_MATH_TABLE_INL_H_
#undef ALDER_NODES_MATH_TABLE_INL_H_
#else
#define ALDER_NODES_MATH_TABLE_INL_H_
#endif

#include "nodes/math/cycles-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Where a position falls in a table: sample i and fraction t towards the next. NaN falls on sample 0.
template <class F>
struct TablePosition {
    Int<F> i, next;
    F t;
    HWY_INLINE TablePosition(F x, int size) {
        const F scaled = cycles_saturate(x) * F(size - 1);
        i = min(max(to_int(scaled), Int<F>(0)), Int<F>(size - 1));
        next = min(i + Int<F>(1), Int<F>(size - 1));
        t = scaled - to_float<F>(i);
    }
    /// Linear between the two samples.
    HWY_INLINE F linear(const float* table) const {
        const F a = gather<F>(table, i), b = gather<F>(table, next);
        return select(t > F(0), (F(1) - t) * a + t * b, a);
    }
};

/// Linear lookup that goes on beyond 0 and 1 with the slope of the first and last step.
template <class F>
HWY_INLINE F lookup_extrapolated(const float* table, int size, F x) {
    const F inside = TablePosition<F>(x, size).linear(table);
    const F first = F(table[0]), last = F(table[size - 1]);
    const F below = first + (first - F(table[1])) * (-x) * F(size - 1);
    const F above = last + (last - F(table[size - 2])) * (x - F(1)) * F(size - 1);
    return select(x < F(0), below, select(x > F(1), above, inside));
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
