// Random numbers from two integers by 64 rounds of the Tiny Encryption Algorithm, as alShaders draws them. alshaders
// specification, 1.6; Zafar, Olano and Curtis, "GPU Random Numbers via the Tiny Encryption Algorithm", HPG 2010.
#if defined(ALDER_NODES_NOISE_TEA_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_NOISE_TEA_INL_H_
#undef ALDER_NODES_NOISE_TEA_INL_H_
#else
#define ALDER_NODES_NOISE_TEA_INL_H_
#endif

#include "nodes/num/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// In [0, 1), 23 bits.
template <class F>
HWY_INLINE F tea_float(Int<F> v0, Int<F> v1) {
    using I = Int<F>;
    I sum(0);
    for (int round = 0; round < 64; ++round) {
        sum = sum + I(static_cast<int32_t>(0x9e3779b9u));
        v0 = v0 + ((shl<4>(v1) + I(static_cast<int32_t>(0xA341316Cu))) ^ (v1 + sum) ^ (shr<5>(v1) + I(static_cast<int32_t>(0xC8013EA4u))));
        v1 = v1 + ((shl<4>(v0) + I(static_cast<int32_t>(0xAD90777Du))) ^ (v0 + sum) ^ (shr<5>(v0) + I(static_cast<int32_t>(0x7E95761Eu))));
    }
    return bits_to_float<F>(shr<9>(v0) | I(0x3f800000)) - F(1);
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
