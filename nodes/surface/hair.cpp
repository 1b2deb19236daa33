// Hair BSDFs of Cycles: Hair (one glossy lobe on either side) and Principled Hair (Chiang et al. 2016, Huang et al. 2022).
// Colour from pigments: d'Eon et al., "An Energy-Conserving Hair Reflectance Model", EGSR 2011; from reflectance: Chiang et al.,
// equation 9; roughness: their equations 7 and 8.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/surface/hair.cpp"
#include "hwy/foreach_target.h"

#include "nodes/surface/closure-inl.h"
#include "nodes/surface/cycles_params.h"

#ifndef ALDER_NODES_SURFACE_HAIR_LISTS
#define ALDER_NODES_SURFACE_HAIR_LISTS
namespace alder {
enum HairChannel : int { kHairColor = 0, kHairOffset = 3, kHairU = 4, kHairV = 5, kHairTangent = 6, kHairN = 10, kHairNg = 13, kHairI = 16,
                         kHairFibre = 19, kHairDpdv = 22, kHairIsStrand = 25 };
enum HairParam : int { kHairTangentParam = 4, kHairComponent = 6 };

enum PrincipledHairChannel : int {
    kPhColor = 0, kPhMelanin = 3, kPhRedness = 4, kPhTint = 5, kPhAbsorption = 8, kPhAspect = 11, kPhRoughness = 12, kPhRadial = 13,
    kPhCoat = 14, kPhIor = 15, kPhOffset = 16, kPhRandomColor = 17, kPhRandomRoughness = 18, kPhRandom = 19, kPhR = 21, kPhTt = 22,
    kPhTrt = 23, kPhN = 24, kPhI = 27, kPhFibre = 30, kPhFibreNormal = 33, kPhIsStrand = 36, kPhH = 37, kPhCoverage = 38
};
enum PrincipledHairParam : int {
    kPhColorParam, kPhMelaninParam, kPhRednessParam, kPhTintParam, kPhAbsorptionParam, kPhAspectParam, kPhRoughnessParam, kPhRadialParam,
    kPhCoatParam, kPhIorParam, kPhOffsetParam, kPhRandomColorParam, kPhRandomRoughnessParam, kPhRandomParam, kPhWeightParam, kPhRParam,
    kPhTtParam, kPhTrtParam, kPhModel, kPhParametrization
};
enum HairParametrization : int { kPhByAbsorption, kPhByMelanin, kPhByColor };
}  // namespace alder
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct HairBsdf {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const LobeOut<F> out(k, 0);
        const Mask<F> strand = k.f(kHairIsStrand) != F(0);
        const Vec3<F> n = k.v(kHairN);
        F offset = -k.f(kHairOffset);
        Vec3<F> t;
        if (k.statics().linked[kHairTangentParam]) {
            t = socket_normal(k.v(kHairTangent), Vec3<F>(F(0), F(0), F(1)));
        } else {
            t = select(strand, k.v(kHairFibre), socket_normal(k.v(kHairDpdv), Vec3<F>(F(0), F(0), F(1))));
            offset = select(strand, offset, F(0));
        }
        out.weight(allocate(k.v(kHairColor)));
        out.normal(select(strand, n, reflecting_normal(n, k.v(kHairNg), k.v(kHairI))));
        out.tangent(t);
        out.param(0, offset);
        out.param(1, clamp(k.f(kHairU), F(0.001), F(1)));
        out.param(2, clamp(k.f(kHairV), F(0.001), F(1)));
    }
};
template <class F>
void hair_bsdf(const Call<F>& c) { c.template each<HairBsdf>(); }
ALDER_KERNEL(hair_bsdf)

/// x^20
template <class F>
HWY_INLINE F power20(F x) {
    const F x4 = sqr(sqr(x)), x8 = sqr(x4);
    return sqr(x8) * x4;
}
/// Variance of the longitudinal lobe.
template <class F>
HWY_INLINE F hair_variance(F r) { return sqr(F(0.726) * r + F(0.812) * sqr(r) + F(3.7) * power20(r)); }
/// Scale of the azimuthal logistic.
template <class F>
HWY_INLINE F hair_scale(F r) { return F(0.62665706865775012560) * (F(0.265) * r + F(1.194) * sqr(r) + F(5.372) * power20(r) * sqr(r)); }
/// Absorption that gives a mass of hair this colour.
template <class F>
HWY_INLINE Vec3<F> hair_absorption(Vec3<F> color, F radial) {
    const F x = radial;
    const F p = ((((F(0.245) * x + F(5.574)) * x - F(10.73)) * x + F(2.532)) * x - F(0.215)) * x + F(5.969);
    Vec3<F> s;
    for (int c = 0; c < 3; ++c) {
        const F root = log(max(color[c], F(1e-38))) / p;
        s[c] = sqr(root);
    }
    return s;
}

/// What both models share.
template <class F>
struct HairFibre {
    F roughness, radial;
    Vec3<F> sigma;
    HWY_INLINE HairFibre(const Lanes<F>& k, bool chiang) {
        const Statics& s = k.statics();
        const F random = F(2) * (k.f(kPhRandom) - F(0.5));
        const F spread = F(1) + random * k.f(kPhRandomRoughness);
        roughness = k.f(kPhRoughness) * spread;
        radial = chiang ? k.f(kPhRadial) * spread : roughness;
        switch (s.e(kPhParametrization)) {
            case kPhByAbsorption: sigma = k.v(kPhAbsorption); break;
            case kPhByColor: sigma = hair_absorption(k.v(kPhColor), radial); break;
            default: {
                const F amount = k.f(kPhMelanin) * (F(1) + random * saturate(k.f(kPhRandomColor)));
                const F m = -log(max(F(1) - amount, F(1e-4))), red = k.f(kPhRedness);
                const Vec3<F> eumelanin(F(0.506), F(0.841), F(1.653)), pheomelanin(F(0.343), F(0.733), F(1.924));
                sigma = eumelanin * (m * (F(1) - red)) + pheomelanin * (m * red) + hair_absorption(k.v(kPhTint), radial);
            }
        }
        for (int c = 0; c < 3; ++c) sigma[c] = min(sigma[c], F(1e6));
    }
};

struct ChiangHairNode {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const LobeOut<F> out(k, 0);
        const HairFibre<F> hair(k, true);
        const F rough = clamp(hair.roughness, F(0.001), F(1));
        const F first = clamp((F(1) - saturate(k.f(kPhCoat))) * rough, F(0.001), F(1));
        out.weight(Vec3<F>(F(1)));
        out.normal(k.v(kPhN));
        out.tangent(k.v(kPhFibre));
        out.param(0, hair.sigma);
        out.param(3, hair_variance(first));
        out.param(4, hair_variance(rough));
        out.param(5, hair_scale(clamp(hair.radial, F(0.001), F(1))));
        out.param(6, -k.f(kPhOffset));
        out.param(7, k.f(kPhIor));
        out.param(8, clamp(k.f(kPhH), F(-1), F(1)));
    }
};

/// Cycles shades what lies outside an elliptical section as transparent: lobe 1.
struct HuangHairNode {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const LobeOut<F> out(k, 0), clear(k, 1);
        const HairFibre<F> hair(k, false);
        const Vec3<F> t = k.v(kPhFibre), view = k.v(kPhI);
        const Mask<F> strand = k.f(kPhIsStrand) != F(0);
        F aspect = k.f(kPhAspect);
        const Mask<F> ellipse = aspect != F(1);
        // On a curve the major axis is its normal, or any direction across where it has none; else it lies across the view.
        Vec3<F> own = k.v(kPhFibreNormal);
        own = own - t * dot(own, t);
        const Vec3<F> some = select(abs(t.x) < F(0.7), Vec3<F>(F(1), F(0), F(0)), Vec3<F>(F(0), F(1), F(0)));
        const Vec3<F> major = socket_normal(own, socket_normal(cross(t, some), some));
        aspect = select(strand & (aspect > F(1)), F(1) / aspect, aspect);
        const Vec3<F> across = socket_normal(cross(t, view), major);
        const Vec3<F> x = select(strand & ellipse, major, across);
        const Vec3<F> z = cross(x, t);
        const F vx = dot(view, x), vz = dot(view, z);
        const F r2 = F(1) - (F(1) - sqr(aspect)) * sqr(vx) / max(sqr(vx) + sqr(vz), F(1e-20));
        const F h = k.f(kPhH);
        const Mask<F> inside = abs(h) < sqrt(max(r2, F(0)));
        const F r = max(k.f(kPhR), F(0)), tt = max(k.f(kPhTt), F(0)), trt = max(k.f(kPhTrt), F(0));
        const F some_light = select((r > F(0)) | (tt > F(0)) | (trt > F(0)), F(1), F(0));
        out.weight(Vec3<F>(select(inside, some_light, F(0))));
        out.normal(select(strand & ellipse, major, Vec3<F>(F(0))));
        out.tangent(t);
        out.param(0, hair.sigma);
        out.param(3, clamp(hair.roughness, F(0.001), F(1)));
        out.param(4, -k.f(kPhOffset));
        out.param(5, k.f(kPhIor));
        out.param(6, aspect);
        out.param(7, h);
        out.param(8, k.f(kPhCoverage));
        out.param(9, r);
        out.param(10, tt);
        out.param(11, trt);
        clear.weight(Vec3<F>(select(inside, F(0), some_light)));
        clear.normal(k.v(kPhN));
    }
};
template <class F>
void principled_hair_bsdf(const Call<F>& c) {
    if (c.statics().e(kPhModel) == 0) c.template each<ChiangHairNode>();
    else c.template each<HuangHairNode>();
}
ALDER_KERNEL(principled_hair_bsdf)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(hair_bsdf)
ALDER_KERNEL_EXPORT(principled_hair_bsdf)

ALDER_NODE {
    using namespace param;
    NodeType n = cycles_bsdf_node("ShaderNodeBsdfHair", "hair_bsdf", "one highlight of a strand, on the side of the light or through it");
    n.help = "Ou et al. 2012. On a curve the highlight lies about the fibre; on a mesh about the direction of growing V, without Offset.";
    n.params = {
        color("Color", 0.8, 0.8, 0.8),
        f("Offset", 0).range(-1.57079637, 1.57079637).doc("tilt of the highlight along the strand, radians; curves only, or with a linked Tangent"),
        f("RoughnessU", 0.1).range(0, 1).doc("along the strand"),
        f("RoughnessV", 1).range(0, 1).doc("around it"),
        vector("Tangent", 0, 0, 0).doc("direction of the strand, world space; unlinked: the curve's own").linked_only(),
        weight_socket(),
        choice("component", {{"Reflection", "Reflection", "reflection"}, {"Transmission", "Transmission", "transmission"}}, "Reflection"),
    };
    n.globals = {Global::N, Global::Ng, Global::I, Global::FibreTangent, Global::Dpdv, Global::IsStrand};
    n.kernel = hair_bsdf_kernel();
    n.uses = [](const Statics&, int p) { return p != 5; };
    n.uses_global = [](const Statics& s, int g) { return (g != 3 && g != 4) || !s.linked[kHairTangentParam]; };
    n.lobes = [](const Statics& s) -> std::vector<LobeSpec> {
        if (s.e(kHairComponent) == 0) return {{.kind = LobeKind::HairReflection, .label = LobeLabel::Specular, .gates = {0}}};
        return {{.kind = LobeKind::HairTransmission, .label = LobeLabel::HairTransmission, .gates = {0}}};
    };
    return n;
}

ALDER_NODE {
    using namespace param;
    NodeType n = cycles_bsdf_node("ShaderNodeBsdfHairPrincipled", "principled_hair_bsdf", "hair and fur with all its reflections and transmissions");
    n.help = "Chiang et al. 2016: near field, all orders. Huang et al. 2022: rough circular or elliptical fibres, near or far field by the "
             "width of a pixel. On a mesh the fibre runs along growing U. Huang's TT and TRT are estimated at each direction; `alder eval` "
             "integrates them until they have converged.";
    n.params = {
        color("Color", 0.0175129995, 0.00576299988, 0.00205900008).doc("colour of a mass of such hair (Direct Coloring)"),
        f("Melanin", 0.800000012).range(0, 1).doc("amount of pigment: 0 white, 1 black"),
        f("Melanin Redness", 1).range(0, 1).doc("share of the red pigment"),
        color("Tint", 1, 1, 1).doc("dye over the pigments"),
        vector("Absorption Coefficient", 0.245530993, 0.52, 1.36500001).range(0, 1000).doc("per radius"),
        f("Aspect Ratio", 0.850000024).range(0, 1).doc("Huang: minor over major axis of the section"),
        f("Roughness", 0.300000012).range(0, 1),
        f("Radial Roughness", 0.300000012).range(0, 1).doc("Chiang: around the fibre"),
        f("Coat", 0).range(0, 1).doc("Chiang: narrows the first reflection"),
        f("IOR", 1.54999995).range(0, 1000),
        f("Offset", 0.0349065848).range(-1.57079637, 1.57079637).doc("tilt of the scales, radians"),
        f("Random Color", 0).range(0, 1).doc("variation of melanin by Random"),
        f("Random Roughness", 0).range(0, 1).doc("variation of both roughnesses by Random"),
        f("Random", 0).unlinked(Global::FibreRandom).doc("random number of the strand, 0..1; unlinked: its own"),
        weight_socket(),
        f("R lobe", 1).range(0, 1).alias("Reflection").doc("Huang: weight of the first reflection"),
        f("TT lobe", 1).range(0, 1).alias("Transmission").doc("Huang: weight of light that passes through"),
        f("TRT lobe", 1).range(0, 1).alias("Secondary Reflection").doc("Huang: weight of light reflected inside"),
        choice("model", {{"CHIANG", "Chiang", "Chiang"}, {"HUANG", "Huang", "Huang"}}, "CHIANG"),
        choice("parametrization",
               {{"ABSORPTION", "Absorption Coefficient", "Absorption coefficient"}, {"MELANIN", "Melanin Concentration", "Melanin concentration"},
                {"COLOR", "Direct Coloring", "Direct coloring"}}, "COLOR"),
    };
    n.globals = {Global::N, Global::I, Global::FibreTangent, Global::FibreNormal, Global::IsStrand, Global::FibreOffset, Global::FibreCoverage};
    n.kernel = principled_hair_bsdf_kernel();
    n.uses = [](const Statics& s, int p) {
        const bool huang = s.e(kPhModel) == 1;
        const int by = s.e(kPhParametrization);
        switch (p) {
            case kPhColorParam: return by == kPhByColor;
            case kPhMelaninParam:
            case kPhRednessParam:
            case kPhTintParam:
            case kPhRandomColorParam: return by == kPhByMelanin;
            case kPhAbsorptionParam: return by == kPhByAbsorption;
            case kPhRandomParam: return !s.is_zero(kPhRandomRoughnessParam) || (by == kPhByMelanin && !s.is_zero(kPhRandomColorParam));
            case kPhRadialParam:
            case kPhCoatParam: return !huang;
            case kPhAspectParam:
            case kPhRParam:
            case kPhTtParam:
            case kPhTrtParam: return huang;
            default: return p != kPhWeightParam;
        }
    };
    n.uses_global = [](const Statics& s, int g) { return s.e(kPhModel) == 1 || (g != 1 && g != 3 && g != 4 && g != 6); };
    n.lobes = [](const Statics& s) -> std::vector<LobeSpec> {
        if (s.e(kPhModel) == 0) return {{.kind = LobeKind::HairChiang, .label = LobeLabel::Specular}};
        return {{.kind = LobeKind::HairHuang, .label = LobeLabel::Specular}, {.kind = LobeKind::Transparent, .label = LobeLabel::Transparent}};
    };
    return n;
}
}  // namespace alder
#endif
