// Vec3<F>: three-component vectors and linear Rec.709 colours over any lane type. Included once per instruction set.
#if defined(ALDER_NODES_NUM_VEC_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_NUM_VEC_INL_H_
#undef ALDER_NODES_NUM_VEC_INL_H_
#else
#define ALDER_NODES_NUM_VEC_INL_H_
#endif

#include "nodes/num/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

template <class F>
struct Vec3 {
    F x, y, z;
    HWY_INLINE Vec3() {}
    HWY_INLINE explicit Vec3(F v) : x(v), y(v), z(v) {}
    HWY_INLINE Vec3(F x_, F y_, F z_) : x(x_), y(y_), z(z_) {}
    HWY_INLINE F operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
    HWY_INLINE F& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
    HWY_INLINE Vec3& operator+=(Vec3 b) { return *this = *this + b; }
    HWY_INLINE Vec3& operator-=(Vec3 b) { return *this = *this - b; }
    HWY_INLINE Vec3& operator*=(Vec3 b) { return *this = *this * b; }
    HWY_INLINE Vec3& operator*=(F s) { return *this = *this * s; }

    friend HWY_INLINE Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend HWY_INLINE Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend HWY_INLINE Vec3 operator*(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
    friend HWY_INLINE Vec3 operator/(Vec3 a, Vec3 b) { return {a.x / b.x, a.y / b.y, a.z / b.z}; }
    friend HWY_INLINE Vec3 operator*(Vec3 a, F s) { return {a.x * s, a.y * s, a.z * s}; }
    friend HWY_INLINE Vec3 operator*(F s, Vec3 a) { return {a.x * s, a.y * s, a.z * s}; }
    friend HWY_INLINE Vec3 operator/(Vec3 a, F s) { return {a.x / s, a.y / s, a.z / s}; }
    friend HWY_INLINE Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
};

template <class F>
HWY_INLINE F dot(Vec3<F> a, Vec3<F> b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
template <class F>
HWY_INLINE Vec3<F> cross(Vec3<F> a, Vec3<F> b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class F>
HWY_INLINE F length(Vec3<F> a) { return sqrt(dot(a, a)); }
/// a/|a|; the zero vector stays zero (Cycles' safe_normalize).
template <class F>
HWY_INLINE Vec3<F> safe_normalize(Vec3<F> a) {
    const F l = length(a);
    const F inv = F(1) / select(l != F(0), l, F(1));
    return {select(l != F(0), a.x * inv, a.x), select(l != F(0), a.y * inv, a.y), select(l != F(0), a.z * inv, a.z)};
}
/// a/|a| without a guard: NaN for the zero vector.
template <class F>
HWY_INLINE Vec3<F> normalize(Vec3<F> a) { return a / length(a); }
template <class F>
HWY_INLINE Vec3<F> select(Mask<F> m, Vec3<F> a, Vec3<F> b) {
    return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}
template <class F>
HWY_INLINE Vec3<F> lerp(Vec3<F> a, Vec3<F> b, F t) { return {lerp(a.x, b.x, t), lerp(a.y, b.y, t), lerp(a.z, b.z, t)}; }
template <class F>
HWY_INLINE F max_component(Vec3<F> a) { return max(max(a.x, a.y), a.z); }
template <class F>
HWY_INLINE F min_component(Vec3<F> a) { return min(min(a.x, a.y), a.z); }
/// Luminance with alShaders' (Arnold's) weights.
template <class F>
HWY_INLINE F luminance_al(Vec3<F> c) { return F(0.212671) * c.x + F(0.715160) * c.y + F(0.072169) * c.z; }
/// Luminance with the weights measured from Cycles (reference README; not the rounded 0.2126/0.7152/0.0722).
template <class F>
HWY_INLINE F luminance_cycles(Vec3<F> c) { return F(0.212674) * c.x + F(0.715152) * c.y + F(0.072175) * c.z; }

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
