// Kernels the compiler itself inserts (builtin_ops.h).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "graph/builtin_ops.cpp"
#include "hwy/foreach_target.h"

#include "graph/builtin_ops.h"
#include "nodes/kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

#define ALDER_BUILTIN(name, ...)                                               \
    struct Body_##name {                                                       \
        template <class F>                                                     \
        static HWY_INLINE void run(Lanes<F> k) { k.set(0, (__VA_ARGS__)); }    \
    };                                                                         \
    template <class F>                                                         \
    void builtin_##name(const Call<F>& c) { c.template each<Body_##name>(); }  \
    ALDER_KERNEL(builtin_##name)

ALDER_BUILTIN(luminance_cycles, luminance_cycles(k.v(0)))
ALDER_BUILTIN(mean, (k.f(0) + k.f(1) + k.f(2)) * F(1.0 / 3.0))
ALDER_BUILTIN(to_int, trunc(k.f(0)))
ALDER_BUILTIN(to_bool, select(k.f(0) != F(0), F(1), F(0)))
ALDER_BUILTIN(multiply, k.f(0) * k.f(1))
ALDER_BUILTIN(add, k.f(0) + k.f(1))
ALDER_BUILTIN(mad, k.f(0) * k.f(1) + k.f(2))
ALDER_BUILTIN(select, select(k.f(0) != F(0), k.f(1), k.f(2)))
ALDER_BUILTIN(guard_nonzero, select(k.f(0) == F(0), F(0), F(1)))
ALDER_BUILTIN(guard_positive, select(k.f(0) > F(0), F(1), F(0)))
ALDER_BUILTIN(guard_below_one, select(k.f(0) < F(1), F(1), F(0)))

struct Body_guard_switch {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F m = k.f(0);
        F i = floor(m);
        i = select(m - i >= k.f(1), i + F(1), i);
        i = select(isnan(i), F(0), clamp(i, F(0), F(7)));
        k.set(0, select(i == k.f(2), F(1), F(0)));
    }
};
template <class F>
void builtin_guard_switch(const Call<F>& c) { c.template each<Body_guard_switch>(); }
ALDER_KERNEL(builtin_guard_switch)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
#define ALDER_BUILTIN_EXPORT(name)      \
    ALDER_KERNEL_EXPORT(builtin_##name) \
    namespace builtin {                 \
    Kernel name() { return builtin_##name##_kernel(); } \
    }
ALDER_BUILTIN_EXPORT(luminance_cycles)
ALDER_BUILTIN_EXPORT(mean)
ALDER_BUILTIN_EXPORT(to_int)
ALDER_BUILTIN_EXPORT(to_bool)
ALDER_BUILTIN_EXPORT(multiply)
ALDER_BUILTIN_EXPORT(add)
ALDER_BUILTIN_EXPORT(mad)
ALDER_BUILTIN_EXPORT(select)
ALDER_BUILTIN_EXPORT(guard_nonzero)
ALDER_BUILTIN_EXPORT(guard_positive)
ALDER_BUILTIN_EXPORT(guard_below_one)
ALDER_BUILTIN_EXPORT(guard_switch)
}  // namespace alder
#endif
