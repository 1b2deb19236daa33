// Colour models and blend modes as Cycles has them. Colours are linear RGB; hue is 0 ... 1.
// HSV: Smith, "Color gamut transform pairs", SIGGRAPH 1978. HSL: Joblove and Greenberg, "Color spaces for computer graphics",
// SIGGRAPH 1978. Cycles 4.5, util/color.h and svm/color_util.h, for the treatment of greys, negative values and hues outside 0 ... 1.
#if defined(ALDER_NODES_COLOR_COLOR_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_COLOR_COLOR_INL_H_
#undef ALDER_NODES_COLOR_COLOR_INL_H_
#else
#define ALDER_NODES_COLOR_COLOR_INL_H_
#endif

#include "nodes/math/cycles-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

template <class F>
HWY_INLINE Vec3<F> rgb_to_hsv(Vec3<F> c) {
    const F hi = number_max(c.x, number_max(c.y, c.z));
    const F lo = second_min(c.x, second_min(c.y, c.z));
    const F delta = hi - lo;
    const F s = select(hi != F(0), delta / select(hi != F(0), hi, F(1)), F(0));
    const Vec3<F> d = (Vec3<F>(hi) - c) / delta;
    F h = select(c.x == hi, d.z - d.y, select(c.y == hi, F(2) + d.x - d.z, F(4) + d.y - d.x));
    h = h / F(6);
    h = select(h < F(0), h + F(1), h);
    return {select(s != F(0), h, F(0)), s, hi};
}

/// Sextants outside 0 ... 4 take the last branch: a hue outside 0 ... 1 is not wrapped.
template <class F>
HWY_INLINE Vec3<F> hsv_to_rgb(Vec3<F> c) {
    const F h = select(c.x == F(1), F(0), c.x) * F(6), s = c.y, v = c.z;
    const F i = floor(h), f = h - i;
    const F p = v * (F(1) - s), q = v * (F(1) - s * f), t = v * (F(1) - s * (F(1) - f));
    const Mask<F> i0 = i == F(0), i1 = i == F(1), i2 = i == F(2), i3 = i == F(3), i4 = i == F(4);
    const F r = select(i0, v, select(i1, q, select(i2 | i3, p, select(i4, t, v))));
    const F g = select(i0, t, select(i1 | i2, v, select(i3, q, p)));
    const F b = select(i0 | i1, p, select(i2, t, select(i3 | i4, v, q)));
    const Mask<F> grey = s == F(0);
    return {select(grey, v, r), select(grey, v, g), select(grey, v, b)};
}

template <class F>
HWY_INLINE Vec3<F> rgb_to_hsl(Vec3<F> c) {
    const F hi = number_max(c.x, number_max(c.y, c.z));
    const F lo = second_min(c.x, second_min(c.y, c.z));
    const F l = second_min(F(1), (hi + lo) / F(2)), delta = hi - lo;
    const F s = select(l > F(0.5), delta / (F(2) - hi - lo), delta / (hi + lo));
    const F h = select(hi == c.x, (c.y - c.z) / delta + select(c.y < c.z, F(6), F(0)),
                       select(hi == c.y, (c.z - c.x) / delta + F(2), (c.x - c.y) / delta + F(4)));
    const Mask<F> grey = hi == lo;
    return {select(grey, F(0), h / F(6)), select(grey, F(0), s), l};
}

template <class F>
HWY_INLINE Vec3<F> hsl_to_rgb(Vec3<F> c) {
    const F h = c.x * F(6);
    const F r = cycles_saturate(abs(h - F(3)) - F(1)), g = cycles_saturate(F(2) - abs(h - F(2))), b = cycles_saturate(F(2) - abs(h - F(4)));
    const F chroma = (F(1) - abs(F(2) * c.z - F(1))) * c.y;
    return {(r - F(0.5)) * chroma + c.z, (g - F(0.5)) * chroma + c.z, (b - F(0.5)) * chroma + c.z};
}

// ---- blend modes: a is the base, b the layer, t its strength -----------------------------------------------------------
// Modes that treat channels alike are functions of one channel; the last four work in HSV.
#define ALDER_BLEND(Name, ...)                                        \
    struct Blend##Name {                                              \
        template <class F>                                            \
        static HWY_INLINE F one(F a, F b, F t) { __VA_ARGS__; }       \
        template <class F>                                            \
        static HWY_INLINE Vec3<F> mix(Vec3<F> a, Vec3<F> b, F t) {    \
            return {one(a.x, b.x, t), one(a.y, b.y, t), one(a.z, b.z, t)}; \
        }                                                             \
    };
ALDER_BLEND(Mix, return interp(a, b, t))
ALDER_BLEND(Add, return interp(a, a + b, t))
ALDER_BLEND(Multiply, return interp(a, a * b, t))
ALDER_BLEND(Screen, return F(1) - ((F(1) - t) + t * (F(1) - b)) * (F(1) - a))
ALDER_BLEND(Overlay, return select(a < F(0.5), a * ((F(1) - t) + F(2) * t * b),
                                   F(1) - ((F(1) - t) + F(2) * t * (F(1) - b)) * (F(1) - a)))
ALDER_BLEND(Subtract, return interp(a, a - b, t))
ALDER_BLEND(Divide, return select(b != F(0), (F(1) - t) * a + t * a / b, a))
ALDER_BLEND(Difference, return interp(a, abs(a - b), t))
ALDER_BLEND(Exclusion, return second_max(interp(a, a + b - F(2) * a * b, t), F(0)))
ALDER_BLEND(Darken, return interp(a, second_min(a, b), t))
ALDER_BLEND(Lighten, return interp(a, second_max(a, b), t))
ALDER_BLEND(Dodge, const F d = F(1) - t * b; const F r = a / d; return select(a == F(0), a, select((d <= F(0)) | (r > F(1)), F(1), r)))
ALDER_BLEND(Burn, const F d = (F(1) - t) + t * b; const F r = F(1) - (F(1) - a) / d;
            return select((d <= F(0)) | (r < F(0)), F(0), select(r > F(1), F(1), r)))
ALDER_BLEND(SoftLight, return (F(1) - t) * a + t * ((F(1) - a) * b * a + a * (F(1) - (F(1) - b) * (F(1) - a))))
ALDER_BLEND(LinearLight, return a + t * (F(2) * b + F(-1)))
#undef ALDER_BLEND

struct BlendHue {
    template <class F>
    static HWY_INLINE Vec3<F> mix(Vec3<F> a, Vec3<F> b, F t) {
        const Vec3<F> layer = rgb_to_hsv(b), base = rgb_to_hsv(a);
        return select<F>(layer.y != F(0), interp(a, hsv_to_rgb(Vec3<F>(layer.x, base.y, base.z)), t), a);
    }
};
struct BlendSaturation {
    template <class F>
    static HWY_INLINE Vec3<F> mix(Vec3<F> a, Vec3<F> b, F t) {
        const Vec3<F> layer = rgb_to_hsv(b), base = rgb_to_hsv(a);
        return select<F>(base.y != F(0), hsv_to_rgb(Vec3<F>(base.x, (F(1) - t) * base.y + t * layer.y, base.z)), a);
    }
};
struct BlendValue {
    template <class F>
    static HWY_INLINE Vec3<F> mix(Vec3<F> a, Vec3<F> b, F t) {
        const Vec3<F> layer = rgb_to_hsv(b), base = rgb_to_hsv(a);
        return hsv_to_rgb(Vec3<F>(base.x, base.y, (F(1) - t) * base.z + t * layer.z));
    }
};
struct BlendColor {
    template <class F>
    static HWY_INLINE Vec3<F> mix(Vec3<F> a, Vec3<F> b, F t) {
        const Vec3<F> layer = rgb_to_hsv(b), base = rgb_to_hsv(a);
        return select<F>(layer.y != F(0), interp(a, hsv_to_rgb(Vec3<F>(layer.x, layer.y, base.z)), t), a);
    }
};

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
