// Cells of random points in one to four dimensions: nearest, second nearest, smoothly nearest point, distance to the border
// between cells, and the radius of the sphere that fits between points. As in Cycles' Voronoi texture.
// Steven Worley, "A Cellular Texture Basis Function", SIGGRAPH 1996; distance to edges: Inigo Quilez, "Voronoi edges", 2012
// (iquilezles.org/articles/voronoilines); smooth minimum over cells: the same, "Smooth voronoi", 2014.
#if defined(ALDER_NODES_NOISE_VORONOI_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_NOISE_VORONOI_INL_H_
#undef ALDER_NODES_NOISE_VORONOI_INL_H_
#else
#define ALDER_NODES_NOISE_VORONOI_INL_H_
#endif

#include "nodes/noise/fractal-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

enum VoronoiMetric { kEuclidean, kManhattan, kChebychev, kMinkowski };
enum VoronoiFeature { kF1, kF2, kSmoothF1, kDistanceToEdge, kSphereRadius };

template <class F>
struct VoronoiParams {
    F scale, detail, roughness, lacunarity, smoothness, exponent, randomness;
    int metric;
    bool normalize;
    bool wants_color, wants_position;
    HWY_INLINE VoronoiParams() {}
};
template <int D, class F>
struct VoronoiResult {
    F distance;
    Vec3<F> color;
    Coord<D, F> position;
    HWY_INLINE VoronoiResult() {}
};

template <int D, class F>
HWY_INLINE Coord<D, F> operator-(Coord<D, F> a, const Coord<D, F>& b) {
    ALDER_UNROLL
    for (int i = 0; i < D; ++i) a.c[i] = a.c[i] - b.c[i];
    return a;
}
template <int D, class F>
HWY_INLINE Coord<D, F> select(Mask<F> m, Coord<D, F> a, const Coord<D, F>& b) {
    ALDER_UNROLL
    for (int i = 0; i < D; ++i) a.c[i] = select(m, a.c[i], b.c[i]);
    return a;
}
template <int D, class F>
HWY_INLINE Coord<D, F> uniform_coord(F v) {
    Coord<D, F> p;
    ALDER_UNROLL
    for (int i = 0; i < D; ++i) p.c[i] = v;
    return p;
}
template <int D, class F>
HWY_INLINE F dot(const Coord<D, F>& a, const Coord<D, F>& b) {
    F s = a.c[0] * b.c[0];
    ALDER_UNROLL
    for (int i = 1; i < D; ++i) s = mad(a.c[i], b.c[i], s);
    return s;
}

/// A number that grows with the distance |d| and is cheaper: its square, or the sum of powers.
template <int D, class F>
HWY_INLINE F metric_rank(const Coord<D, F>& d, const VoronoiParams<F>& q) {
    if constexpr (D == 1) return abs(d.c[0]);
    switch (q.metric) {
        case kEuclidean: return dot(d, d);
        case kManhattan: {
            F s = abs(d.c[0]);
            ALDER_UNROLL
            for (int i = 1; i < D; ++i) s = s + abs(d.c[i]);
            return s;
        }
        case kChebychev: {
            F s = abs(d.c[0]);
            ALDER_UNROLL
            for (int i = 1; i < D; ++i) s = max(s, abs(d.c[i]));
            return s;
        }
        default: {
            F s(0);
            for (int i = 0; i < D; ++i) s = s + pow(abs(d.c[i]), q.exponent);
            return s;
        }
    }
}
template <int D, class F>
HWY_INLINE F distance_of_rank(F rank, const VoronoiParams<F>& q) {
    if constexpr (D == 1) return rank;
    if (q.metric == kEuclidean) return sqrt(rank);
    if (q.metric == kMinkowski) return pow(rank, F(1) / q.exponent);
    return rank;
}
template <int D, class F>
HWY_INLINE F metric_distance(const Coord<D, F>& d, const VoronoiParams<F>& q) {
    return distance_of_rank<D>(metric_rank(d, q), q);
}

/// D random numbers in [0, 2^32] of the cell whose coordinates have these float bits; scaled later, with the randomness.
template <int D, class F>
HWY_INLINE Coord<D, F> cell_hash(const Int<F> (&b)[D]) {
    using I = Int<F>;
    const I one(0x3f800000), two(0x40000000);  // 1.0f, 2.0f
    Coord<D, F> h;
    if constexpr (D == 1) {
        h.c[0] = unsigned_to_float<F>(hash_uint(b[0]));
    } else if constexpr (D == 2) {
        h.c[0] = unsigned_to_float<F>(hash_uint2(b[0], b[1]));
        h.c[1] = unsigned_to_float<F>(hash_uint3(b[0], b[1], one));
    } else if constexpr (D == 3) {
        h.c[0] = unsigned_to_float<F>(hash_uint3(b[0], b[1], b[2]));
        h.c[1] = unsigned_to_float<F>(hash_uint4(b[0], b[1], b[2], one));  // the two share the first rounds
        h.c[2] = unsigned_to_float<F>(hash_uint4(b[0], b[1], b[2], two));
    } else {
        h.c[0] = unsigned_to_float<F>(hash_uint4(b[0], b[1], b[2], b[3]));
        h.c[1] = unsigned_to_float<F>(hash_uint4(b[3], b[0], b[1], b[2]));
        h.c[2] = unsigned_to_float<F>(hash_uint4(b[2], b[3], b[0], b[1]));
        h.c[3] = unsigned_to_float<F>(hash_uint4(b[1], b[2], b[3], b[0]));
    }
    return h;
}
/// The colour of a cell, of which `h` is cell_hash.
template <int D, class F>
HWY_INLINE Vec3<F> cell_color(const Int<F> (&b)[D], const Coord<D, F>& h) {
    using I = Int<F>;
    const I one(0x3f800000), two(0x40000000);
    Vec3<F> c;
    c.x = h.c[0];
    if constexpr (D == 1) {
        c.y = unsigned_to_float<F>(hash_uint2(b[0], one));
        c.z = unsigned_to_float<F>(hash_uint2(b[0], two));
    } else if constexpr (D == 2) {
        c.y = h.c[1];
        c.z = unsigned_to_float<F>(hash_uint3(b[0], b[1], two));
    } else if constexpr (D == 3) {
        c.y = h.c[1];
        c.z = h.c[2];
    } else {
        c.y = unsigned_to_float<F>(hash_uint4(b[2], b[0], b[3], b[1]));
        c.z = unsigned_to_float<F>(hash_uint4(b[3], b[2], b[1], b[0]));
    }
    return c * F(0x1p-32f);
}

/// The cell that a point lies in, and the points of the cells around it.
template <int D, class F>
struct CellGrid {
    Coord<D, F> cell, local;  ///< floor of the coordinates, and the rest
    F spread;                 ///< randomness / 2^32
    HWY_INLINE CellGrid(const Coord<D, F>& p, F randomness) : spread(randomness * F(0x1p-32f)) {
        ALDER_UNROLL
        for (int i = 0; i < D; ++i) {
            cell.c[i] = floor(p.c[i]);
            local.c[i] = p.c[i] - cell.c[i];
        }
    }
    HWY_INLINE void bits_at(const Coord<D, F>& offset, Int<F> (&b)[D]) const {
        ALDER_UNROLL
        for (int i = 0; i < D; ++i) b[i] = float_bits(cell.c[i] + offset.c[i]);
    }
    /// The point of the cell at `offset`, relative to this cell's lower corner.
    HWY_INLINE Coord<D, F> point(const Coord<D, F>& offset, const Coord<D, F>& hash) const {
        Coord<D, F> p;
        ALDER_UNROLL
        for (int i = 0; i < D; ++i) p.c[i] = mad(hash.c[i], spread, offset.c[i]);
        return p;
    }
    HWY_INLINE Coord<D, F> point(const Coord<D, F>& offset) const {
        Int<F> b[D];
        bits_at(offset, b);
        return point(offset, cell_hash<D, F>(b));
    }
};

/// Number of the cell at small integer offsets, and back: three bits an axis, so that one integer a lane remembers a cell.
template <int D>
HWY_INLINE int32_t cell_code(const int (&o)[4]) {
    int32_t code = 0;
    ALDER_UNROLL
    for (int i = 0; i < D; ++i) code |= (o[i] + 2) << (3 * i);
    return code;
}
template <int D, class F>
HWY_INLINE Coord<D, F> offset_of_code(Int<F> code) {
    Coord<D, F> o;
    o.c[0] = to_float<F>(code & Int<F>(7)) - F(2);
    if constexpr (D > 1) o.c[1] = to_float<F>(shr<3>(code) & Int<F>(7)) - F(2);
    if constexpr (D > 2) o.c[2] = to_float<F>(shr<6>(code) & Int<F>(7)) - F(2);
    if constexpr (D > 3) o.c[3] = to_float<F>(shr<9>(code) & Int<F>(7)) - F(2);
    return o;
}

/// Calls visitor(offset, code, bits, hash) for the cells within kRadius, x fastest: Cycles' order, which decides ties.
template <int D, int kRadius, class F, class Visitor>
HWY_INLINE void for_each_cell(const CellGrid<D, F>& g, Visitor& visitor) {
    constexpr int rw = D > 3 ? kRadius : 0, rz = D > 2 ? kRadius : 0, ry = D > 1 ? kRadius : 0;
    for (int w = -rw; w <= rw; ++w) {
        for (int z = -rz; z <= rz; ++z) {
            for (int y = -ry; y <= ry; ++y) {
                ALDER_UNROLL
                for (int x = -kRadius; x <= kRadius; ++x) {
                    const int o[4] = {x, y, z, w};
                    Coord<D, F> offset;
                    ALDER_UNROLL
                    for (int i = 0; i < D; ++i) offset.c[i] = F(o[i]);
                    Int<F> b[D];
                    g.bits_at(offset, b);
                    visitor(offset, cell_code<D>(o), b, cell_hash<D, F>(b));
                }
            }
        }
    }
}

template <class F>
HWY_INLINE F far_away() { return F(3.402823466e+38f); }

/// Keeps the rank and the cell of the point nearest to where the grid was entered.
template <int D, class F>
struct NearestPoint {
    const CellGrid<D, F>& grid;
    const VoronoiParams<F>& params;
    F rank = far_away<F>();
    Int<F> code = Int<F>(0);
    HWY_INLINE NearestPoint(const CellGrid<D, F>& g, const VoronoiParams<F>& q) : grid(g), params(q) {}
    HWY_INLINE void operator()(const Coord<D, F>& offset, int32_t c, const Int<F> (&)[D], const Coord<D, F>& hash) {
        const F r = metric_rank(grid.point(offset, hash) - grid.local, params);
        const Mask<F> nearer = r < rank;
        rank = select(nearer, r, rank);
        code = select(nearer, Int<F>(c), code);
    }
};
template <int D, class F>
struct TwoNearestPoints {
    const CellGrid<D, F>& grid;
    const VoronoiParams<F>& params;
    F rank1 = far_away<F>(), rank2 = far_away<F>();
    Int<F> code1 = Int<F>(0), code2 = Int<F>(0);
    HWY_INLINE TwoNearestPoints(const CellGrid<D, F>& g, const VoronoiParams<F>& q) : grid(g), params(q) {}
    HWY_INLINE void operator()(const Coord<D, F>& offset, int32_t c, const Int<F> (&)[D], const Coord<D, F>& hash) {
        const F r = metric_rank(grid.point(offset, hash) - grid.local, params);
        const Mask<F> first = r < rank1, second = r < rank2;
        rank2 = select(first, rank1, select(second, r, rank2));
        code2 = select(first, code1, select(second, Int<F>(c), code2));
        rank1 = select(first, r, rank1);
        code1 = select(first, Int<F>(c), code1);
    }
};

/// Distance, colour and position of the cell found. Where none was (NaN, overflow): Cycles keeps offset and point at zero.
template <int D, class F>
HWY_INLINE VoronoiResult<D, F> result_of_cell(const CellGrid<D, F>& g, const VoronoiParams<F>& q, F rank, Int<F> code, F distance_if_none) {
    VoronoiResult<D, F> r;
    const Mask<F> found = rank < far_away<F>();
    r.distance = select(found, distance_of_rank<D>(rank, q), distance_if_none);
    if (q.wants_color || q.wants_position) {
        const Coord<D, F> zero = uniform_coord<D>(F(0));
        const Coord<D, F> offset = select(found, offset_of_code<D, F>(code), zero);
        Int<F> b[D];
        g.bits_at(offset, b);
        const Coord<D, F> hash = cell_hash<D, F>(b);
        if (q.wants_color) r.color = cell_color<D, F>(b, hash);
        if (q.wants_position) r.position = select(found, g.point(offset, hash), zero) + g.cell;
    }
    return r;
}
template <int D, class F>
HWY_INLINE VoronoiResult<D, F> voronoi_f1(const Coord<D, F>& p, const VoronoiParams<F>& q) {
    const CellGrid<D, F> g(p, q.randomness);
    NearestPoint<D, F> nearest(g, q);
    for_each_cell<D, 1>(g, nearest);
    F none = nearest.rank;
    if (D > 1 && any(!(nearest.rank < far_away<F>()))) none = metric_distance(g.local, q);
    return result_of_cell(g, q, nearest.rank, nearest.code, none);
}
template <int D, class F>
HWY_INLINE VoronoiResult<D, F> voronoi_f2(const Coord<D, F>& p, const VoronoiParams<F>& q) {
    const CellGrid<D, F> g(p, q.randomness);
    TwoNearestPoints<D, F> nearest(g, q);
    for_each_cell<D, 1>(g, nearest);
    return result_of_cell(g, q, nearest.rank2, nearest.code2, far_away<F>());
}

/// Blends the cells by a smooth minimum of their distances, in Cycles' order, on which the result depends.
template <int D, class F>
struct SmoothNearest {
    const CellGrid<D, F>& grid;
    const VoronoiParams<F>& params;
    F half_inverse, correction_divisor;
    VoronoiResult<D, F> sum;
    bool first = true;
    HWY_INLINE SmoothNearest(const CellGrid<D, F>& g, const VoronoiParams<F>& q) : grid(g), params(q) {
        half_inverse = F(0.5) / q.smoothness;
        correction_divisor = F(1) / (F(1) + F(3) * q.smoothness);
        sum.distance = F(0);
        sum.color = Vec3<F>(F(0));
        sum.position = uniform_coord<D>(F(0));
    }
    HWY_INLINE void operator()(const Coord<D, F>& offset, int32_t, const Int<F> (&b)[D], const Coord<D, F>& hash) {
        const Coord<D, F> point = grid.point(offset, hash);
        const F distance = metric_distance(point - grid.local, params);
        const F t = mad(sum.distance - distance, half_inverse, F(0.5));
        // smoothstep: 0 below 0, 1 from 1 on, NaN stays.
        F h = (F(3) - F(2) * t) * (t * t);
        h = select(t < F(0), F(0), select(t >= F(1), F(1), h));
        if (first) h = F(1);
        first = false;
        F correction = params.smoothness * h * (F(1) - h);
        sum.distance = mad(h, distance - sum.distance, sum.distance) - correction;
        correction = correction * correction_divisor;
        if (params.wants_color) {
            const Vec3<F> color = cell_color<D, F>(b, hash);
            for (int i = 0; i < 3; ++i) sum.color[i] = mad(h, color[i] - sum.color[i], sum.color[i]) - correction;
        }
        if (params.wants_position) {
            ALDER_UNROLL
            for (int i = 0; i < D; ++i) {
                sum.position.c[i] = mad(h, point.c[i] - sum.position.c[i], sum.position.c[i]) - correction;
            }
        }
    }
};
template <int D, class F>
HWY_INLINE VoronoiResult<D, F> voronoi_smooth_f1(const Coord<D, F>& p, const VoronoiParams<F>& q) {
    const CellGrid<D, F> g(p, q.randomness);
    SmoothNearest<D, F> smooth(g, q);
    for_each_cell<D, 2>(g, smooth);
    smooth.sum.position = smooth.sum.position + g.cell;
    return smooth.sum;
}

/// Remembers where the cells' points are, and which is nearest.
template <int D, class F>
struct PointsAround {
    static constexpr int kCells = D == 1 ? 3 : D == 2 ? 9 : D == 3 ? 27 : 81;
    const CellGrid<D, F>& grid;
    F rank = far_away<F>();
    Coord<D, F> nearest = uniform_coord<D>(F(0));
    int count = 0;
    Coord<D, F> to_point[kCells];
    HWY_INLINE explicit PointsAround(const CellGrid<D, F>& g) : grid(g) {}
    HWY_INLINE void operator()(const Coord<D, F>& offset, int32_t, const Int<F> (&)[D], const Coord<D, F>& hash) {
        const Coord<D, F> v = grid.point(offset, hash) - grid.local;
        const F r = dot(v, v);
        const Mask<F> nearer = r < rank;
        rank = select(nearer, r, rank);
        nearest = select(nearer, v, nearest);
        to_point[count++] = v;
    }
};
template <int D, class F>
HWY_INLINE F voronoi_distance_to_edge(const Coord<D, F>& p, const VoronoiParams<F>& q) {
    const CellGrid<D, F> g(p, q.randomness);
    if constexpr (D == 1) {
        // The middle cell is hashed as it is: floor(-0) is -0, which another hash belongs to.
        const Int<F> here[1] = {float_bits(g.cell.c[0])};
        const F middle = cell_hash<1, F>(here).c[0] * g.spread;
        Coord<1, F> o;
        o.c[0] = F(-1);
        const F left = g.point(o).c[0];
        o.c[0] = F(1);
        const F right = g.point(o).c[0];
        return min(abs((middle + left) * F(0.5) - g.local.c[0]), abs((middle + right) * F(0.5) - g.local.c[0]));
    }
    PointsAround<D, F> around(g);
    for_each_cell<D, 1>(g, around);
    F distance = far_away<F>();
    for (int i = 0; i < PointsAround<D, F>::kCells; ++i) {
        // The border is the plane half way between two points.
        const Coord<D, F> across = around.to_point[i] - around.nearest;
        const F length_squared = dot(across, across);
        const Mask<F> other = length_squared > F(0.0001f);
        const F inverse = reciprocal_sqrt_estimate(select(other, length_squared, F(1)));
        const F d = F(0.5) * dot(around.nearest + around.to_point[i], across) * inverse;
        distance = select(other & (d < distance), d, distance);
    }
    return distance;
}

/// The nearest other point to a point of a cell.
template <int D, class F>
HWY_INLINE F voronoi_sphere_radius(const Coord<D, F>& p, const VoronoiParams<F>& q) {
    VoronoiParams<F> euclidean = q;
    euclidean.metric = kEuclidean;
    const CellGrid<D, F> g(p, q.randomness);
    NearestPoint<D, F> nearest(g, euclidean);
    for_each_cell<D, 1>(g, nearest);
    const Mask<F> found = nearest.rank < far_away<F>();
    const Coord<D, F> zero = uniform_coord<D>(F(0));
    const Coord<D, F> offset = select(found, offset_of_code<D, F>(nearest.code), zero);
    const Coord<D, F> point = select(found, g.point(offset), zero);
    F rank = far_away<F>();
    constexpr int rw = D > 3, rz = D > 2, ry = D > 1;
    for (int w = -rw; w <= rw; ++w) {
        for (int z = -rz; z <= rz; ++z) {
            for (int y = -ry; y <= ry; ++y) {
                for (int x = -1; x <= 1; ++x) {
                    if (x == 0 && y == 0 && z == 0 && w == 0) continue;
                    const int o[4] = {x, y, z, w};
                    Coord<D, F> neighbour = offset;
                    ALDER_UNROLL
                    for (int i = 0; i < D; ++i) neighbour.c[i] = neighbour.c[i] + F(o[i]);
                    rank = min(rank, metric_rank(point - g.point(neighbour), euclidean));
                }
            }
        }
    }
    // None found: Cycles measures to the zero point.
    const F distance = select(rank < far_away<F>(), distance_of_rank<D>(rank, euclidean), metric_distance(point, euclidean));
    return distance * F(0.5);
}

/// Octaves of a Voronoi texture: like fBM, except that positions and edge distances are blended.
template <class F>
struct VoronoiOctaves {
    F detail, remainder;
    Mask<F> single;  ///< lanes that have one octave, taken as it is
    HWY_INLINE explicit VoronoiOctaves(const VoronoiParams<F>& q) {
        detail = q.detail;
        remainder = detail - floor(detail);
        single = (detail == F(0)) | (q.roughness == F(0));
    }
    HWY_INLINE Mask<F> full(int i) const { return (F(i) <= detail) & (!single); }
    HWY_INLINE Mask<F> partial(int i) const { return (F(i) > detail) & (F(i) == ceil(detail)) & (!single); }
};
template <class F>
HWY_INLINE F voronoi_lerp(F a, F b, F t) { return mad(t, b - a, a); }

template <VoronoiFeature kFeature, int D, class F>
HWY_INLINE VoronoiResult<D, F> voronoi_octave(const Coord<D, F>& p, const VoronoiParams<F>& q) {
    if constexpr (kFeature == kF2) return voronoi_f2(p, q);
    if constexpr (kFeature == kF1) return voronoi_f1(p, q);
    const Mask<F> sharp = q.smoothness == F(0);
    if (all(sharp)) return voronoi_f1(p, q);
    VoronoiResult<D, F> r = voronoi_smooth_f1(p, q);
    if (any(sharp)) {
        const VoronoiResult<D, F> f1 = voronoi_f1(p, q);
        r.distance = select(sharp, f1.distance, r.distance);
        if (q.wants_color) r.color = select<F>(sharp, f1.color, r.color);
        if (q.wants_position) r.position = select(sharp, f1.position, r.position);
    }
    return r;
}

template <VoronoiFeature kFeature, int D, class F>
HWY_INLINE VoronoiResult<D, F> fractal_voronoi(const Coord<D, F>& p, const VoronoiParams<F>& q) {
    const VoronoiOctaves<F> octaves(q);
    VoronoiResult<D, F> sum;
    sum.distance = F(0);
    sum.color = Vec3<F>(F(0));
    sum.position = uniform_coord<D>(F(0));
    F amplitude(1), most(0), scale(1);
    for (int i = 0;; ++i) {
        const Mask<F> full = octaves.full(i), partial = octaves.partial(i);
        if (i > 0 && !any(full | partial)) break;
        const VoronoiResult<D, F> octave = voronoi_octave<kFeature>(p * scale, q);
        if (i == 0 && all(octaves.single)) {
            sum = octave;
            most = F(1);
            break;
        }
        // A partial octave is blended in by the remainder of the detail.
        const F blend = select(full, F(1), octaves.remainder);
        const Mask<F> used = full | partial;
        const Mask<F> taken = i == 0 ? octaves.single : Mask<F>(false);
        most = select(taken, F(1), select(used, mad(blend, amplitude, most), most));
        const F weight = blend * amplitude;
        sum.distance = select(taken, octave.distance, select(used, mad(octave.distance, weight, sum.distance), sum.distance));
        if (q.wants_color) {
            sum.color = select<F>(taken, octave.color, select<F>(used, sum.color + octave.color * weight, sum.color));
        }
        if (q.wants_position) {
            ALDER_UNROLL
            for (int a = 0; a < D; ++a) {
                const F here = sum.position.c[a];
                const F moved = voronoi_lerp(here, octave.position.c[a] / scale, amplitude);
                sum.position.c[a] = select(taken, octave.position.c[a], select(full, moved, select(partial, voronoi_lerp(here, moved, blend), here)));
            }
        }
        amplitude = amplitude * q.roughness;
        scale = scale * q.lacunarity;
    }
    if (q.normalize) {
        const F reach = F(0.5) + F(0.5) * q.randomness;
        const F farthest = metric_distance(uniform_coord<D>(reach), q) * F(kFeature == kF2 ? 2 : 1);
        sum.distance = sum.distance / (most * farthest);
        if (q.wants_color) sum.color = sum.color / most;
    }
    if (q.wants_position) {
        ALDER_UNROLL
        for (int a = 0; a < D; ++a) sum.position.c[a] = safe_divide(sum.position.c[a], q.scale);
    }
    return sum;
}

template <int D, class F>
HWY_INLINE F fractal_voronoi_distance_to_edge(const Coord<D, F>& p, const VoronoiParams<F>& q) {
    const VoronoiOctaves<F> octaves(q);
    const F farthest = F(0.5) + F(0.5) * q.randomness;
    F distance(8), most = farthest, amplitude(1), scale(1);
    for (int i = 0;; ++i) {
        const Mask<F> full = octaves.full(i), partial = octaves.partial(i);
        if (i > 0 && !any(full | partial)) break;
        const F octave = voronoi_distance_to_edge(p * scale, q);
        if (i == 0 && all(octaves.single)) {
            distance = octave;
            break;
        }
        const F nearer = voronoi_lerp(distance, min(octave / scale, distance), amplitude);
        const F more = voronoi_lerp(most, farthest / scale, amplitude);
        const F partly = voronoi_lerp(distance, min(nearer, distance), octaves.remainder);
        if (i == 0) distance = select(octaves.single, octave, distance);
        distance = select(full, nearer, select(partial, partly, distance));
        most = select(full, more, select(partial, voronoi_lerp(most, more, octaves.remainder), most));
        amplitude = amplitude * q.roughness;
        scale = scale * q.lacunarity;
    }
    return q.normalize ? distance / most : distance;
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
