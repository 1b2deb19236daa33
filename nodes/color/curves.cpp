// RGB Curves, Float Curve and Vector Curves: values through drawn curves (Blender's nodes).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/color/curves.cpp"
#include "hwy/foreach_target.h"

#include "nodes/color/curve_table.h"
#include "nodes/kernel-inl.h"
#include "nodes/math/table-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Factor 0, then the components; each is looked up at its own position and blended with itself.
template <int components, bool extrapolate>
struct CurveLookup {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const auto& curves = static_cast<const CurveTable&>(*k.statics().prepared);
        const F factor = k.f(0), range = F(curves.max_x - curves.min_x);
        for (int c = 0; c < components; ++c) {
            const F input = k.f(1 + c), x = (input - F(curves.min_x)) / range;
            const float* const table = curves.channels[c].data();
            const F value = extrapolate ? lookup_extrapolated(table, kCurveSize, x) : TablePosition<F>(x, kCurveSize).linear(table);
            k.set(c, (F(1) - factor) * input + factor * value);
        }
    }
};
template <class F, int components>
HWY_INLINE void curves_dispatch(const Call<F>& c) {
    if (static_cast<const CurveTable&>(*c.statics().prepared).extrapolate) c.template each<CurveLookup<components, true>>();
    else c.template each<CurveLookup<components, false>>();
}
template <class F>
void curves_three(const Call<F>& c) { curves_dispatch<F, 3>(c); }
template <class F>
void curves_one(const Call<F>& c) { curves_dispatch<F, 1>(c); }
ALDER_KERNEL(curves_three)
ALDER_KERNEL(curves_one)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(curves_three)
ALDER_KERNEL_EXPORT(curves_one)

enum { kFactor, kInput, kMapping };
template <CurveKind kind>
std::shared_ptr<const Prepared> prepare_curves(const Statics& s, std::vector<std::string>& errors) {
    return bake_curves(s.text[kMapping], kind, errors);
}
static NodeType curve_node(const char* name, const char* cycles, const char* factor, Param input, Output output, const char* summary, Kernel kernel) {
    NodeType n;
    n.name = name;
    n.summary = summary;
    n.help = "Curves are sampled at 257 places between their first and last points and interpolated linearly.";
    n.aliases = {cycles};
    n.params.push_back(param::f(factor, 1).range(0, 1));
    n.params.push_back(std::move(input));
    n.params.push_back(param::curve("mapping").doc("{extend, clip, curves: [[{location, handle_type}]]}"));
    n.outputs = {std::move(output)};
    n.kernel = kernel;
    n.cost_ns = 5;
    return n;
}

ALDER_NODE {
    NodeType n = curve_node("ShaderNodeRGBCurve", "rgb_curves", "Fac", param::color("Color", 1, 1, 1), {"Color", Type::Color},
                            "a colour through a combined curve and one for each component", curves_three_kernel());
    n.category = "Color";
    n.prepare = prepare_curves<CurveKind::Rgb>;
    return n;
}
ALDER_NODE {
    NodeType n = curve_node("ShaderNodeVectorCurve", "vector_curves", "Fac", param::vector("Vector", 0, 0, 0).range(-1, 1), {"Vector", Type::Vector},
                            "a vector through one curve for each component", curves_three_kernel());
    n.category = "Vector";
    n.prepare = prepare_curves<CurveKind::Vector>;
    return n;
}
ALDER_NODE {
    NodeType n = curve_node("ShaderNodeFloatCurve", "float_curve", "Factor", param::f("Value", 1), {"Value", Type::Float}, "a number through a curve", curves_one_kernel());
    n.category = "Converter";
    n.prepare = prepare_curves<CurveKind::Float>;
    return n;
}
}  // namespace alder
#endif
