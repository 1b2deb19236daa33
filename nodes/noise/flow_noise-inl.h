// Simplex noise in three dimensions whose gradients turn, with its derivative. alshaders specification, section 4 (alFlowNoise).
// Ken Perlin and Fabrice Neyret, "Flow Noise", SIGGRAPH 2001 sketches; Stefan Gustavson, "Simplex noise demystified", 2005, and
// his SRDNoise23.
#if defined(ALDER_NODES_NOISE_FLOW_NOISE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_NOISE_FLOW_NOISE_INL_H_
#undef ALDER_NODES_NOISE_FLOW_NOISE_INL_H_
#else
#define ALDER_NODES_NOISE_FLOW_NOISE_INL_H_
#endif

#include "nodes/noise/flow_tables.h"
#include "nodes/num/math-inl.h"
#include "nodes/num/vec-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

template <class F>
struct FlowNoise {
    F value;
    Vec3<F> gradient;
};

/// Place of a lattice coordinate in the permutation. The original wrapped negative ones by 255, which repeats one cell and leaves
/// a seam at 0; `original` does so, for comparison with its numbers.
template <bool original, class F>
HWY_INLINE Int<F> flow_wrap(Int<F> i) {
    using I = Int<F>;
    if constexpr (!original) return i & I(255);
    const I rest = I(0) - ((I(0) - i) & I(255));   // C's remainder, of negative numbers
    return select(i < I(0), select(rest < I(0), rest + I(255), rest), i & I(255));
}

/// Where a corner's gradient is found: the permutation of its column and row, plus x.
template <class F>
HWY_INLINE Int<F> flow_index(Int<F> x, Int<F> y, Int<F> z) {
    const Int<F> row = gather_int<F>(kFlowPermutation, z & Int<F>(255));
    return x + gather_int<F>(kFlowPermutation, (y + row) & Int<F>(255));
}

/// One corner of the simplex: d is the vector from it to the point.
template <class F>
HWY_INLINE void flow_corner(Vec3<F> d, Int<F> index, F sine, F cosine, F& value, Vec3<F>& along, Vec3<F>& across) {
    const F t = F(0.6) - dot(d, d);
    const Mask<F> near = t > F(0);
    if (!any(near)) return;
    const Int<F> h = gather_int<F>(kFlowPermutation, index & Int<F>(255)) & Int<F>(15);
    Vec3<F> g;
    for (int c = 0; c < 3; ++c) g[c] = cosine * gather<F>(kFlowGradient[0][c], h) + sine * gather<F>(kFlowGradient[1][c], h);
    const F t2 = t * t, t4 = t2 * t2, gd = dot(g, d);
    value = value + select(near, t4 * gd, F(0));
    along = select<F>(near, along + d * (t2 * t * gd), along);
    across = select<F>(near, across + g * t4, across);
}

/// The simplex that holds a point: the lattice cell and the vector from its first corner.
template <class F>
struct FlowCell {
    Int<F> cell[3];
    Vec3<F> d;
    HWY_INLINE FlowCell() {}
};
/// The original's floor takes whole numbers that are not positive to the one below.
template <class F>
HWY_INLINE F flow_floor(F s, Mask<F> positive) {
    const F a = floor(s);
    return select((a == s) & !positive, a - F(1), a);
}
/// In the original's order of operations, which costs a few units in the point's last place.
template <class F>
HWY_INLINE FlowCell<F> flow_cell(Vec3<F> p) {
    FlowCell<F> c;
    const F skew = (p.x + p.y + p.z) / F(3);   // divided: the original multiplied by a third in double
    Vec3<F> i(p);
    for (int k = 0; k < 3; ++k) {
        const F s = p[k] + skew;
        i[k] = flow_floor<F>(s, s > F(0));
        c.cell[k] = to_int(i[k]);
    }
    const F t = (i.x + i.y + i.z) / F(6);
    c.d = p - (i - Vec3<F>(t));
    return c;
}
/// The same from whole and fractional parts apart, so that no large numbers are subtracted: as exact as p is at any distance. With
/// p = whole + f and the whole parts' sum 3 q + r, the skewed coordinate of an axis is whole + q + f + (r + fx + fy + fz)/3, and the
/// vector to the corner f - a + (r + a + b + c)/6, where a, b, c are the floors of f + (r + fx + fy + fz)/3.
template <class F>
HWY_INLINE FlowCell<F> flow_cell_far(Vec3<F> p) {
    using I = Int<F>;
    FlowCell<F> c;
    Vec3<F> f(p);
    for (int k = 0; k < 3; ++k) {
        const F whole = floor(p[k]);
        c.cell[k] = to_int(whole);
        f[k] = p[k] - whole;
    }
    const I sum = c.cell[0] + c.cell[1] + c.cell[2];
    const I q = to_int(floor((to_float<F>(sum) + F(0.5)) * F(1.0 / 3)));   // one off does no harm: r takes it up
    const F r = to_float<F>(sum - q * I(3)), skew = (r + (f.x + f.y + f.z)) * F(1.0 / 3);
    F floors(0);
    c.d = f;
    for (int k = 0; k < 3; ++k) {
        const F s = f[k] + skew, a = flow_floor<F>(s, c.cell[k] + q + to_int(floor(s)) > I(0));
        c.cell[k] = c.cell[k] + q + to_int(a);
        floors = floors + a;
        c.d[k] = f[k] - a;
    }
    c.d += Vec3<F>((r + floors) * F(1.0 / 6));
    return c;
}

/// The noise and its gradient at p, the gradients turned by the angle of that sine and cosine. Coordinates that are not finite
/// count as 0, those beyond 5e8 as that.
template <bool original, class F>
HWY_INLINE FlowNoise<F> flow_noise(Vec3<F> p, F sine, F cosine) {
    using I = Int<F>;
    for (int k = 0; k < 3; ++k) p[k] = clamp(select(isfinite(p[k]), p[k], F(0)), F(-5e8), F(5e8));
    FlowCell<F> simplex = flow_cell(p);
    // Up to 2^14 the original's numbers to the last digits that tests see; beyond, where its roundings begin to show, exact ones.
    const Mask<F> far = max(max(abs(p.x), abs(p.y)), abs(p.z)) > F(16384);
    if (any(far)) {
        const FlowCell<F> exact = flow_cell_far(p);
        simplex.d = select<F>(far, exact.d, simplex.d);
        for (int k = 0; k < 3; ++k) simplex.cell[k] = select(far, exact.cell[k], simplex.cell[k]);
    }
    const Vec3<F> d = simplex.d;

    // Which of the six tetrahedra: the first step goes along the largest coordinate, the second leaves out the smallest.
    const Mask<F> xy = d.x >= d.y, yz = d.y >= d.z, xz = d.x >= d.z;
    const Mask<F> x1 = xy & (yz | xz), z1 = (xy & !(yz | xz)) | ((!xy) & (d.y < d.z)), y1 = (!xy) & !(d.y < d.z);
    const Mask<F> x2 = xy | ((!(d.y < d.z)) & !(d.x < d.z)), y2 = (xy & yz) | !xy, z2 = (xy & !yz) | ((!xy) & ((d.y < d.z) | (d.x < d.z)));

    I i[3], m1[3], m2[3];
    const I zero(0), one(1);
    const Mask<F> step1[3] = {x1, y1, z1}, step2[3] = {x2, y2, z2};
    Vec3<F> d1(d), d2(d);
    for (int c = 0; c < 3; ++c) {
        i[c] = flow_wrap<original, F>(simplex.cell[c]);
        m1[c] = select(step1[c], one, zero);
        m2[c] = select(step2[c], one, zero);
        d1[c] = d1[c] - select(step1[c], F(1), F(0)) + F(1.0 / 6);
        d2[c] = d2[c] - select(step2[c], F(1), F(0)) + F(1.0 / 3);
    }
    const Vec3<F> d3 = d - Vec3<F>(F(1)) + Vec3<F>(F(0.5));
    F value(0);
    Vec3<F> along(F(0)), across(F(0));
    flow_corner(d, flow_index<F>(i[0], i[1], i[2]), sine, cosine, value, along, across);
    flow_corner(d1, flow_index<F>(i[0] + m1[0], i[1] + m1[1], i[2] + m1[2]), sine, cosine, value, along, across);
    flow_corner(d2, flow_index<F>(i[0] + m2[0], i[1] + m2[1], i[2] + m2[2]), sine, cosine, value, along, across);
    flow_corner(d3, flow_index<F>(i[0] + one, i[1] + one, i[2] + one), sine, cosine, value, along, across);
    return {F(28) * value, F(28) * (across - F(8) * along)};
}

template <class F>
struct FlowNoiseParams {
    F lacunarity, gain, angle, advection;
    int octaves;
    bool turbulent;
};
/// The octaves of alFlowNoise: each is carried along by the gradients of those before it.
template <bool original, class F>
HWY_INLINE F flow_noise_sum(Vec3<F> p, const FlowNoiseParams<F>& f) {
    const F sine = sin(f.angle), cosine = cos(f.angle);
    F sum(0), amplitude(1);
    Vec3<F> advect(F(0));
    for (int octave = 0; octave < f.octaves; ++octave) {
        const FlowNoise<F> n = flow_noise<original>(p + advect, sine, cosine);
        sum = sum + (f.turbulent ? abs(n.value) : n.value) * amplitude;
        advect -= n.gradient * (f.advection * amplitude);
        p *= f.lacunarity;
        amplitude *= f.gain;
    }
    return sum;
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
