// Principled Volume: smoke and fire with a colour, absorption, and the light of a hot body (Blender).
// Scattering = density * colour; absorption = density * (1 - colour) (1 - sqrt(absorption colour)).
// Glow: tint * colour of a black body * sigma/pi (1 + intensity (T^4 - 1)), Stefan and Boltzmann's constant scaled by 1e-6 as in Cycles.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/volume/principled.cpp"
#include "hwy/foreach_target.h"

#include "nodes/color/blackbody-inl.h"
#include "nodes/surface/closure-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Color 0, Density 3, Anisotropy 4, Absorption Color 5, Emission Strength 8, Emission Color 9, Blackbody Intensity 12,
/// Blackbody Tint 13, Temperature 16, Weight 17; attributes: colour 18, density 21, temperature 22.
struct PrincipledVolume {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> none(F(0));
        const Vec3<F> color = k.v(0) * k.v(18);
        const F density = max(max(k.f(3), F(0)) * k.f(21), F(0));
        const LobeOut<F> scattering(k, 0), absorption(k, 1), emission(k, 2);
        scattering.weight(max0(color) * density);
        scattering.normal(none);
        scattering.param(0, k.f(4));
        if (absorption.wanted()) {
            const Vec3<F> kept = k.v(5);
            Vec3<F> a = max0(Vec3<F>(F(1)) - color);
            for (int c = 0; c < 3; ++c) a[c] = a[c] * max(F(1) - safe_sqrt(kept[c]), F(0));
            absorption.weight(a * density);
        }
        absorption.normal(none);
        if (emission.wanted()) {
            Vec3<F> light = k.v(9) * max(k.f(8), F(0));
            const F intensity = k.f(12), t = max(k.f(16) * k.f(22), F(0));
            const F power = F(5.670373e-14 / 3.14159265358979323846) * (F(1) + intensity * (sqr(sqr(t)) - F(1)));
            // Cycles drops what is this faint.
            const Mask<F> glows = (intensity > F(kWeightCutoff)) & (power > F(kWeightCutoff));
            if (any(glows)) light = light + select(glows, k.v(13) * blackbody_rec709(t) * power, none);
            emission.weight(light);
        }
        emission.normal(none);
    }
};
template <class F>
void principled_volume(const Call<F>& c) { c.template each<PrincipledVolume>(); }
ALDER_KERNEL(principled_volume)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "graph/lowering.h"
#include "nodes/surface/cycles_params.h"

namespace alder {
ALDER_KERNEL_EXPORT(principled_volume)

ALDER_NODE {
    using namespace param;
    NodeType n = cycles_bsdf_node("ShaderNodeVolumePrincipled", "principled_volume", "smoke and fire", "Volume");
    n.category = "volume";
    n.help = "Density is per unit length, in world space. Attributes that the geometry does not have are left out.";
    n.params = {
        color("Color", 0.5, 0.5, 0.5).doc("of scattered light"),
        string("Color Attribute").doc("multiplies Color"),
        f("Density", 1).range(0, 1000),
        string("Density Attribute").doc("multiplies Density"),
        f("Anisotropy", 0).range(-1, 1).doc("mean cosine: -1 back, 0 to all sides, 1 straight on"),
        color("Absorption Color", 0, 0, 0).doc("absorption is lowered by its square root"),
        f("Emission Strength", 0).range(0, 1000),
        color("Emission Color", 1, 1, 1),
        f("Blackbody Intensity", 0).range(0, 1).doc("0: no glow; 1: with the fourth power of the temperature"),
        color("Blackbody Tint", 1, 1, 1),
        f("Temperature", 1000).range(0, 6500).doc("kelvin"),
        string("Temperature Attribute").doc("multiplies Temperature"),
        weight_socket(),
    };
    n.kernel = principled_volume_kernel();
    n.cost_ns = 15;
    n.uses = [](const Statics& s, int p) {
        const bool dark = s.is_zero(8);
        return p != 12 && !(dark && (p == 9 || p == 10 || p == 11));
    };
    n.lower = [](Lowering& l, int) {
        std::vector<ValueRef> attributes;
        for (const auto& [param, type] : {std::pair{1, Type::Color}, {3, Type::Float}, {11, Type::Float}}) {
            const ValueRef one = l.constant(type, 1, 1, 1);
            const std::string& name = l.statics().text[param];
            attributes.push_back(name.empty() ? one : l.attribute_or(name, type, one));
        }
        l.emit_lobes(attributes);
    };
    n.lobes = [](const Statics& s) {
        std::vector<LobeSpec> l(3);
        l[0] = {.kind = LobeKind::PhaseHenyeyGreenstein, .label = LobeLabel::Volume, .gates = {0, 2}};
        l[1] = {.kind = LobeKind::Absorption, .label = LobeLabel::Volume, .gates = {2}};
        l[2] = {.kind = LobeKind::Emission, .label = LobeLabel::Volume};
        if (s.is_zero(8)) l[2].gates = {6, 7};
        return l;
    };
    return n;
}
}  // namespace alder
#endif
