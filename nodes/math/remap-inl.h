// The remap block of alShaders (parameters RMP*): shared by eight nodes. alshaders specification, section 1.4.
#if defined(ALDER_NODES_MATH_REMAP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_MATH_REMAP_INL_H_
#undef ALDER_NODES_MATH_REMAP_INL_H_
#else
#define ALDER_NODES_MATH_REMAP_INL_H_
#endif

#include "nodes/kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Perlin and Hoffert, "Hypertexture", SIGGRAPH 1989: f^(ln b / ln 0.5); 0 for b <= 0.
template <class F>
HWY_INLINE F al_bias(F f, F b) {
    return select(b > F(0), pow(f, log(max(F(1e-30), b)) / F(-0.69314718055994530942)), F(0));
}
template <class F>
HWY_INLINE F al_biasgain(F f, F b, F g) {
    const Mask<F> biased = b != F(0.5), gained = g != F(0.5);
    F r = f;
    if (any(biased)) r = select(biased, al_bias(r, b), r);
    if (any(gained)) {
        const Mask<F> low = r < F(0.5);
        const F x = F(0.5) * al_bias(select(low, F(2) * r, F(2) - F(2) * r), F(1) - g);
        r = select(gained, select(low, x, F(1) - x), r);
    }
    return select(f < F(0), f, r);
}
template <class F>
HWY_INLINE F al_contrast(F x, F c, F pivot) { return select(c == F(1), x, (x - pivot) * c + pivot); }

/// The twelve RMP parameters as channels starting at `c`, in the catalogue's order.
template <class F>
HWY_INLINE F al_remap(const Lanes<F>& k, int c, F x) {
    F f = (x - k.f(c)) / (k.f(c + 1) - k.f(c));
    f = al_contrast(f, k.f(c + 2), k.f(c + 3));
    f = al_biasgain(f, k.f(c + 4), k.f(c + 5));
    f = lerp(k.f(c + 6), k.f(c + 7), f);
    const F lo = k.f(c + 10), hi = k.f(c + 11);
    // Argument order matters: a NaN becomes hi (specification 1.4).
    F g = max(lo, min(hi, f));
    g = select(k.f(c + 9) != F(0), (g - lo) / (hi - lo), g);
    return select(k.f(c + 8) != F(0), g, f);
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
