// Projects an image along three axes and blends the projections by the normal; each projection repeats the image or scatters it
// over cells. alshaders specification, section 5 (alTriplanar).
#if defined(ALDER_NODES_TEXTURE_TRIPLANAR_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_TEXTURE_TRIPLANAR_INL_H_
#undef ALDER_NODES_TEXTURE_TRIPLANAR_INL_H_
#else
#define ALDER_NODES_TEXTURE_TRIPLANAR_INL_H_
#endif

#include "nodes/noise/cellular-inl.h"
#include "nodes/noise/hash-inl.h"
#include "nodes/num/math-inl.h"
#include "nodes/texture/image_lookup-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Where a projection reads the image, and how far that moves from pixel to pixel.
template <class F>
struct Projected {
    F u, v, dudx, dudy, dvdx, dvdy;
    HWY_INLINE Projected() {}
    HWY_INLINE Projected(F u_, F v_, F dudx_, F dudy_, F dvdx_, F dvdy_) : u(u_), v(v_), dudx(dudx_), dudy(dudy_), dvdx(dvdx_), dvdy(dvdy_) {}
};

/// Parameters by axis, and the point: all times the frequency.
template <class F>
struct Triplanar {
    Vec3<F> p, dpdx, dpdy;
    Vec3<F> scale, offset;      ///< scale: images a unit
    Vec3<F> degrees, jitter;    ///< rotation, and how much of a turn of it is random (cells)
    F cell_softness;
    HWY_INLINE Triplanar() {}
};

/// How much of each axis' projection shows: the normal's components less a threshold that falls from 1/2 to 0, summing to 1.
template <class F>
HWY_INLINE Vec3<F> triplanar_weights(Vec3<F> n, F blend_softness) {
    const F threshold = (F(1) - saturate(blend_softness)) / F(2);
    Vec3<F> w(max(F(0), abs(n.x) - threshold), max(F(0), abs(n.y) - threshold), max(F(0), abs(n.z) - threshold));   // drops NaN
    const F sum = w.x + w.y + w.z;
    const F divisor = select((sum != F(0)) & isfinite(sum), sum, F(1));
    return w / divisor;
}

/// Turned by the angle and mirrored in v, which the original does even at 0 degrees.
template <class F>
HWY_INLINE Projected<F> turned(const Projected<F>& p, F sine, F cosine) {
    return {p.u * cosine + p.v * sine,       p.u * sine - p.v * cosine,       p.dudx * cosine + p.dvdx * sine, p.dudy * cosine + p.dvdy * sine,
            p.dudx * sine - p.dvdx * cosine, p.dudy * sine - p.dvdy * cosine};
}

template <class F>
HWY_INLINE void add_weighted(Rgba<F>& sum, const Rgba<F>& r, F w, Mask<F> seen) {
    sum.rgb = select<F>(seen, sum.rgb + r.rgb * w, sum.rgb);
    sum.a = select(seen, sum.a + r.a * w, sum.a);
}

/// The image again and again. The shifts keep the three projections apart.
template <class F>
HWY_INLINE Rgba<F> triplanar_regular(const Triplanar<F>& t, Vec3<F> weight, const auto& read) {
    constexpr int kAcross[3][2] = {{2, 1}, {0, 2}, {0, 1}};
    constexpr double kShift[3][2] = {{123.94, 87.22}, {74.1, 9.2}, {123.94, 87.22}};
    Rgba<F> sum(Vec3<F>(F(0)), F(0));
    for (int axis = 0; axis < 3; ++axis) {
        const Mask<F> seen = weight[axis] > F(0);
        if (!any(seen)) continue;
        const int a = kAcross[axis][0], b = kAcross[axis][1];
        const F s = t.scale[axis], turn = t.degrees[axis] * F(0.01745329251994329577);
        const Projected<F> flat((t.p[a] + F(kShift[axis][0]) + t.offset[axis]) * s, (t.p[b] + F(kShift[axis][1]) + t.offset[axis]) * s,
                                t.dpdx[a] * s, t.dpdy[a] * s, t.dpdx[b] * s, t.dpdy[b] * s);
        add_weighted(sum, read(turned(flat, sin(turn), cos(turn))), weight[axis], seen);
    }
    return sum;
}

/// a mod 1, in [0, 1).
template <class F>
HWY_INLINE F fraction_of_turn(F a) {
    const F rest = a - trunc(a);
    return select(rest < F(0), rest + F(1), rest);
}

/// One image to a cell of cellular noise, turned at random, three quarters of it to a cell's width. `cells` gives the nearest
/// features of a point, one or three of them.
template <int kCells, class F>
HWY_INLINE Rgba<F> triplanar_cells(const Triplanar<F>& t, Vec3<F> weight, const auto& cells, const auto& read) {
    constexpr int kAcross[3][2] = {{1, 2}, {0, 2}, {1, 0}};
    Rgba<F> sum(Vec3<F>(F(0)), F(0));
    for (int axis = 0; axis < 3; ++axis) {
        const Mask<F> seen = weight[axis] > F(0);
        if (!any(seen)) continue;
        const int a = kAcross[axis][0], b = kAcross[axis][1];
        const F s = t.scale[axis];
        const Cellular<kCells, F> c = cells((t.p[a] + t.offset[axis]) * s, (t.p[b] + t.offset[axis]) * s);
        // Distances of the vectors, not of the search: with several octaves these would differ.
        F share[kCells];
        F total(0);
        const F nearest = length(c.delta[0]);
        for (int i = 0; i < kCells; ++i) {
            share[i] = kCells == 1 ? F(1) : max(F(0), t.cell_softness - (length(c.delta[i]) - nearest));
            total = total + share[i];
        }
        Rgba<F> r(Vec3<F>(F(0)), F(0));
        const F divisor = select(total != F(0), total, F(1));
        for (int i = 0; i < kCells; ++i) {
            const Mask<F> shows = seen & (share[i] > F(0));
            if (!any(shows)) continue;
            const F turn = F(6.28318530717958647693) * fraction_of_turn(t.degrees[axis] / F(360) + (uint_to_unit<F>(c.id[i]) - F(0.5)) * t.jitter[axis]);
            // The vector to the feature shrinks as the point moves on.
            const F k = F(-0.75) * s;
            const Projected<F> flat(c.delta[i].x * F(0.75), c.delta[i].y * F(0.75), t.dpdx[a] * k, t.dpdy[a] * k, t.dpdx[b] * k, t.dpdy[b] * k);
            Projected<F> at = turned(flat, sin(turn), cos(turn));
            at.u = at.u - F(0.5), at.v = at.v - F(0.5);
            add_weighted(r, read(at), share[i] / divisor, shows);
        }
        add_weighted(sum, r, weight[axis], seen);
    }
    return sum;
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
