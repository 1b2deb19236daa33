// Map Range: takes a number or vector from one range to another, linearly, in steps, or with smooth ends (Blender's node).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/math/map_range.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/math/cycles-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

enum MapRangeParam { kInterpolation = 12, kDataType, kClamp };
enum class Mapping { Linear, Stepped, Smooth, Smoother };

template <class F>
HWY_INLINE F smootherstep_unit(F t) { return t * t * t * (t * (t * F(6) - F(15)) + F(10)); }
template <class F>
HWY_INLINE F stepped(F t, F steps) {
    return select(steps > F(0), floor(t * (steps + F(1))) / steps, F(0));
}
/// Clamps to the target range, whichever way round it is.
template <class F>
HWY_INLINE F clamp_range(F x, F lo, F hi) {
    return select(lo > hi, cycles_clamp(x, hi, lo), cycles_clamp(x, lo, hi));
}

/// One number. Smooth Step runs between the ordered bounds and is mirrored where they are reversed. Equal bounds give 0.
template <Mapping mapping, bool clamped>
struct MapRangeFloat {
    template <class F>
    static HWY_INLINE F smooth(F lo, F hi, F x) {
        if constexpr (mapping == Mapping::Smoother) return smootherstep_unit(cycles_clamp(safe_divide(x - lo, hi - lo), F(0), F(1)));
        const F t = (x - lo) / (hi - lo);
        return select(x < lo, F(0), select(x >= hi, F(1), (F(3) - F(2) * t) * (t * t)));
    }
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F value = k.f(0), from_min = k.f(1), from_max = k.f(2), to_min = k.f(3), to_max = k.f(4);
        F t = (value - from_min) / (from_max - from_min);
        if constexpr (mapping == Mapping::Stepped) t = stepped(t, k.f(5));
        if constexpr (mapping == Mapping::Smooth || mapping == Mapping::Smoother) {
            const Mask<F> reversed = from_min > from_max;
            t = smooth(select(reversed, from_max, from_min), select(reversed, from_min, from_max), value);
            t = select(reversed, F(1) - t, t);
        }
        F result = select(from_max != from_min, to_min + t * (to_max - to_min), F(0));
        if constexpr (clamped) result = clamp_range(result, to_min, to_max);
        k.set(0, result);
        k.set(1, Vec3<F>(F(0)));
    }
};

/// The vector form, component by component: zero divisors give 0, and Smooth Step needs no mirroring.
template <Mapping mapping, bool clamped>
struct MapRangeVector {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        for (int i = 0; i < 3; ++i) {
            const F value = k.f(6 + i), from_min = k.f(9 + i), from_max = k.f(12 + i), to_min = k.f(15 + i), to_max = k.f(18 + i);
            F t = safe_divide(value - from_min, from_max - from_min);
            if constexpr (mapping == Mapping::Stepped) t = stepped(t, k.f(21 + i));
            if constexpr (mapping == Mapping::Smooth || mapping == Mapping::Smoother) {
                t = cycles_saturate(t);
                t = mapping == Mapping::Smooth ? (F(3) - F(2) * t) * (t * t) : smootherstep_unit(t);
            }
            F result = to_min + t * (to_max - to_min);
            // Smooth vectors are within the range already, and Cycles does not clamp them.
            if constexpr (clamped && (mapping == Mapping::Linear || mapping == Mapping::Stepped)) result = clamp_range(result, to_min, to_max);
            k.set(1 + i, result);
        }
        k.set(0, F(0));
    }
};

template <class F, template <Mapping, bool> class Body>
HWY_INLINE void map_range_dispatch(const Call<F>& c) {
    const bool clamped = c.statics().e(kClamp) != 0;
    switch (c.statics().e(kInterpolation)) {
        case 0: return clamped ? c.template each<Body<Mapping::Linear, true>>() : c.template each<Body<Mapping::Linear, false>>();
        case 1: return clamped ? c.template each<Body<Mapping::Stepped, true>>() : c.template each<Body<Mapping::Stepped, false>>();
        case 2: return clamped ? c.template each<Body<Mapping::Smooth, true>>() : c.template each<Body<Mapping::Smooth, false>>();
        default: return clamped ? c.template each<Body<Mapping::Smoother, true>>() : c.template each<Body<Mapping::Smoother, false>>();
    }
}
template <class F>
void map_range(const Call<F>& c) {
    if (c.statics().e(kDataType) == 0) map_range_dispatch<F, MapRangeFloat>(c);
    else map_range_dispatch<F, MapRangeVector>(c);
}
ALDER_KERNEL(map_range)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(map_range)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeMapRange";
    n.category = "Converter";
    n.summary = "takes a number or a vector from one range to another";
    n.help = "Equal From bounds give 0 (numbers, before the clamp) or the To minimum (vectors).";
    n.aliases = {"map_range"};
    n.params.push_back(f("Value", 1).range(-10000, 10000));
    n.params.push_back(f("From Min", 0).range(-10000, 10000));
    n.params.push_back(f("From Max", 1).range(-10000, 10000));
    n.params.push_back(f("To Min", 0).range(-10000, 10000));
    n.params.push_back(f("To Max", 1).range(-10000, 10000));
    n.params.push_back(f("Steps", 4).range(-10000, 10000));
    n.params.push_back(vector("Vector", 0, 0, 0));
    n.params.push_back(vector("From_Min_FLOAT3", 0, 0, 0));
    n.params.push_back(vector("From_Max_FLOAT3", 1, 1, 1));
    n.params.push_back(vector("To_Min_FLOAT3", 0, 0, 0));
    n.params.push_back(vector("To_Max_FLOAT3", 1, 1, 1));
    n.params.push_back(vector("Steps_FLOAT3", 4, 4, 4));
    n.params.push_back(choice("interpolation_type",
                              std::vector<Item>{{"LINEAR", "Linear", "linear"}, {"STEPPED", "Stepped Linear", "stepped"},
                                                {"SMOOTHSTEP", "Smooth Step", "smoothstep"}, {"SMOOTHERSTEP", "Smoother Step", "smootherstep"}},
                              "LINEAR").alias("range_type"));
    n.params.push_back(choice("data_type", std::vector<Item>{{"FLOAT", "Float", ""}, {"FLOAT_VECTOR", "Vector", ""}}, "FLOAT"));
    n.params.push_back(b("clamp", true).no_link().alias("use_clamp").doc("limit the result to the To range"));
    n.outputs = {{"Result", Type::Float}, {"Vector", Type::Vector}};
    n.kernel = map_range_kernel();
    n.cost_ns = 3;
    n.uses = [](const Statics& s, int param) {
        if (param > 11) return true;
        const bool vector_socket = param >= 6, steps = param % 6 == 5;
        return vector_socket == (s.e(13) == 1) && (!steps || s.e(12) == 1);
    };
    return n;
}
}  // namespace alder
#endif
