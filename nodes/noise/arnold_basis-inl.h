// Our stand-ins for Arnold's closed gradient noises (alshaders specification, 1.8): perlin4, vnoise3 and vnoise4. Zero at lattice
// points, mean 0, about [-1, 1], smooth; a coordinate that is not finite counts as 0.
#if defined(ALDER_NODES_NOISE_ARNOLD_BASIS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_NOISE_ARNOLD_BASIS_INL_H_
#undef ALDER_NODES_NOISE_ARNOLD_BASIS_INL_H_
#else
#define ALDER_NODES_NOISE_ARNOLD_BASIS_INL_H_
#endif

#include "nodes/noise/perlin-inl.h"
#include "nodes/num/vec-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

template <class F>
HWY_INLINE LatticeAxis<F> lattice_axis(F x) {
    // From 2^23 on floats are whole numbers: the fraction is 0, so is the noise, and the cell number may be anything.
    x = select(isfinite(x), x, F(0));
    const F below = floor(x);
    LatticeAxis<F> a;
    a.cell = to_int(below);
    a.set_fraction(x - below);
    return a;
}

/// perlin() of four dimensions where the last coordinate is a whole number: the half of the corners that counts, the same bits.
template <class F>
HWY_INLINE F perlin_at_whole_w(const LatticeAxis<F> (&a)[4]) {
    const LatticeAxis<F>&x = a[0], &y = a[1], &z = a[2], &w = a[3];
    F row[4];
    for (int j = 0; j < 4; ++j) {
        const Int<F> cy = j & 1 ? y.cell1() : y.cell, cz = j & 2 ? z.cell1() : z.cell;
        const F fy = j & 1 ? y.f1() : y.f, fz = j & 2 ? z.f1() : z.f;
        row[j] = perlin_lerp(gradient4(hash_low6(x.cell, cy, cz, w.cell), x.f, fy, fz, w.f),
                             gradient4(hash_low6(x.cell1(), cy, cz, w.cell), x.f1(), fy, fz, w.f), x.fade);
    }
    return F(0.5f * 0.8344f) * perlin_lerp(perlin_lerp(row[0], row[1], y.fade), perlin_lerp(row[2], row[3], y.fade), z.fade);
}
/// Time is 0, or the same whole frame, in most scenes.
template <class F>
HWY_INLINE F perlin_over_time(const LatticeAxis<F> (&a)[4]) { return all(a[3].f == F(0)) ? perlin_at_whole_w(a) : perlin(a); }

struct ArnoldBasis {
    template <class F>
    HWY_INLINE F perlin4(Vec3<F> p, F t) const {
        const LatticeAxis<F> a[4] = {lattice_axis(p.x), lattice_axis(p.y), lattice_axis(p.z), lattice_axis(t)};
        return perlin_over_time(a);
    }
    // The channels are one noise at places far apart in the lattice: the cells are moved, so that no digit of the fraction is lost.
    template <class F>
    HWY_INLINE Vec3<F> vnoise3(Vec3<F> p) const {
        LatticeAxis<F> a[3] = {lattice_axis(p.x), lattice_axis(p.y), lattice_axis(p.z)};
        Vec3<F> r;
        for (int i = 0; i < 3; ++i) {
            a[0].cell = a[0].cell + Int<F>(0x1f3d5b79);
            r[i] = perlin(a);
        }
        return r;
    }
    template <class F>
    HWY_INLINE Vec3<F> vnoise4(Vec3<F> p, F t) const {
        LatticeAxis<F> a[4] = {lattice_axis(p.x), lattice_axis(p.y), lattice_axis(p.z), lattice_axis(t)};
        Vec3<F> r;
        for (int i = 0; i < 3; ++i) {
            a[0].cell = a[0].cell + Int<F>(0x1f3d5b79);
            r[i] = perlin_over_time(a);
        }
        return r;
    }
};

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
