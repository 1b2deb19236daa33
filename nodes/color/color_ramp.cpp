// Color Ramp: a number between 0 and 1 to a colour and an alpha along coloured stops (Blender's node).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/color/color_ramp.cpp"
#include "hwy/foreach_target.h"

#include "nodes/color/ramp_table.h"
#include "nodes/kernel-inl.h"
#include "nodes/math/table-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

template <bool interpolate>
struct RampLookup {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const auto& table = static_cast<const RampTable&>(*k.statics().prepared);
        const TablePosition<F> at(k.f(0), kRampSize);
        for (int c = 0; c < 4; ++c)
            if (k.wants(c)) k.set(c, interpolate ? at.linear(table.rgba[c].data()) : gather<F>(table.rgba[c].data(), at.i));
    }
};
template <class F>
void color_ramp(const Call<F>& c) {
    if (static_cast<const RampTable&>(*c.statics().prepared).interpolate) c.template each<RampLookup<true>>();
    else c.template each<RampLookup<false>>();
}
ALDER_KERNEL(color_ramp)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(color_ramp)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeValToRGB";
    n.category = "Converter";
    n.summary = "a colour along a ramp of coloured stops";
    n.help = "The ramp is sampled at 257 places and interpolated linearly between them (CONSTANT: the sample before).";
    n.params.push_back(f("Fac", 0.5).range(0, 1));
    n.params.push_back(ramp("color_ramp").doc("{color_mode, interpolation, hue_interpolation, elements: [{position, color}]}"));
    n.outputs = {{"Color", Type::Color}, {"Alpha", Type::Float}};
    n.kernel = color_ramp_kernel();
    n.cost_ns = 3;
    n.prepare = [](const Statics& s, std::vector<std::string>& errors) -> std::shared_ptr<const Prepared> { return bake_ramp(s.text[1], errors); };
    return n;
}
}  // namespace alder
#endif
