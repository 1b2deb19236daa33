// Kernel<->batch glue: Call<F> is one op execution seen through lane type F; ALDER_KERNEL instantiates a kernel for every
// instruction set, for scalar float and for double. See nodes/README.md for the shape of a node file.
#if defined(ALDER_NODES_KERNEL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_KERNEL_INL_H_
#undef ALDER_NODES_KERNEL_INL_H_
#else
#define ALDER_NODES_KERNEL_INL_H_
#endif

#include "nodes/num/lanes-inl.h"
#include "nodes/num/math-inl.h"
#include "nodes/num/vec-inl.h"
#include "nodes/schema.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// The operands of one op at the current group of lanes. Channel numbers follow OpCall.
template <class F>
struct Lanes {
    using R = Real<F>;
    const OpCall<R>& call;
    size_t i;

    HWY_INLINE const Statics& statics() const { return *call.statics; }
    HWY_INLINE F f(int channel) const {
        const Channel<R>& c = call.in[channel];
        if constexpr (std::is_same_v<F, VF>) return VF(hn::LoadU(TagF(), c.p + i * c.stride));
        else return c.p[i * c.stride];
    }
    HWY_INLINE Vec3<F> v(int channel) const { return {f(channel), f(channel + 1), f(channel + 2)}; }
    HWY_INLINE bool wants(int channel) const { return call.out[channel] != nullptr; }
    HWY_INLINE void set(int channel, F x) const {
        R* const o = call.out[channel];
        if (!o) return;
        if constexpr (std::is_same_v<F, VF>) hn::StoreU(x.v, TagF(), o + i);
        else o[i] = x;
    }
    HWY_INLINE void set(int channel, Vec3<F> x) const {
        set(channel, x.x);
        set(channel + 1, x.y);
        set(channel + 2, x.z);
    }
};

template <class F>
struct Call {
    const OpCall<Real<F>>& call;
    HWY_INLINE const Statics& statics() const { return *call.statics; }
    /// Runs Body::run(Lanes<F>) over all points. Body: struct with `template <class F> static HWY_INLINE void run(Lanes<F>)`.
    template <class Body>
    HWY_INLINE void each() const {
        const size_t w = NumOf<F>::width();
        for (size_t i = 0; i < call.n; i += w) Body::template run<F>(Lanes<F>{call, i});
    }
};

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

// ALDER_KERNEL(name) inside namespace alder::HWY_NAMESPACE, after `template <class F> void name(const Call<F>&)`.
#undef ALDER_KERNEL
#if HWY_ONCE
#define ALDER_KERNEL(name)                                                                       \
    void name##_lanes(const OpCall<float>& c) { name<VF>(Call<VF>{c}); }                         \
    void name##_scalar(const OpCall<float>& c) { name<float>(Call<float>{c}); }                  \
    void name##_f64(const OpCall<double>& c) { name<double>(Call<double>{c}); }
#else
#define ALDER_KERNEL(name) \
    void name##_lanes(const OpCall<float>& c) { name<VF>(Call<VF>{c}); }
#endif
#endif

// ALDER_KERNEL_EXPORT(name) inside `#if HWY_ONCE namespace alder {`; then name##_kernel() gives the Kernel.
#ifndef ALDER_KERNEL_EXPORT
#define ALDER_KERNEL_EXPORT(name)                                                            \
    HWY_EXPORT(name##_lanes);                                                                \
    static Kernel name##_kernel() {                                                          \
        return {[](const OpCall<float>& c) { HWY_DYNAMIC_DISPATCH(name##_lanes)(c); },       \
                HWY_STATIC_DISPATCH(name##_scalar), HWY_STATIC_DISPATCH(name##_f64)};        \
    }
#endif
