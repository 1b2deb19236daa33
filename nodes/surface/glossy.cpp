// Reflecting BSDFs of Cycles: Glossy (anisotropic; GGX, Beckmann, Ashikhmin–Shirley, Multiscatter GGX) and Metallic (F82 tint
// of Kutz et al. 2021, or a conductor's index and extinction). Multiple scattering: Kulla and Conty 2017.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/surface/glossy.cpp"
#include "hwy/foreach_target.h"

#include "nodes/surface/closure-inl.h"
#include "nodes/surface/cycles_params.h"

#ifndef ALDER_NODES_SURFACE_GLOSSY_LISTS
#define ALDER_NODES_SURFACE_GLOSSY_LISTS
namespace alder {
enum GlossyChannel : int {
    kGlossyColor = 0, kGlossyRoughness = 3, kGlossyAnisotropy = 4, kGlossyRotation = 5, kGlossyNormal = 6, kGlossyTangent = 9,
    kGlossyN = 13, kGlossyNg = 16, kGlossyI = 19
};
enum GlossyParam : int { kGlossyAnisotropyParam = 2, kGlossyRotationParam = 3, kGlossyDistribution = 7 };
enum GlossyDistribution : int { kGlossyBeckmann, kGlossyGgx, kGlossyAshikhminShirley, kGlossyMultiGgx };

enum MetallicChannel : int {
    kMetalBase = 0, kMetalEdge = 3, kMetalIor = 6, kMetalExtinction = 9, kMetalRoughness = 12, kMetalAnisotropy = 13,
    kMetalRotation = 14, kMetalNormal = 15, kMetalTangent = 18, kMetalN = 22, kMetalNg = 25, kMetalI = 28
};
enum MetallicParam : int { kMetalAnisotropyParam = 5, kMetalRotationParam = 6, kMetalDistribution = 10, kMetalFresnel = 11 };
}  // namespace alder
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct GlossyBsdf {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Statics& s = k.statics();
        const LobeOut<F> out(k, 0);
        const MicrofacetLayout at(out.spec);
        const Vec3<F> view = k.v(kGlossyI);
        const Vec3<F> n = reflecting_normal(socket_normal(k.v(kGlossyNormal), k.v(kGlossyN)), k.v(kGlossyNg), view);
        const F alpha = sqr(saturate(k.f(kGlossyRoughness)));
        F ax = alpha, ay = alpha;
        if (out.spec.anisotropic) {
            const F a = clamp(k.f(kGlossyAnisotropy), F(-0.99), F(0.99));
            const Mask<F> stretched = abs(a) > F(1e-4);
            const F narrow = F(1) - abs(a);
            const F thin = select(stretched, alpha * narrow, alpha), wide = select(stretched, min(alpha / narrow, F(1)), alpha);
            ax = select(a < F(0), wide, thin);
            ay = select(a < F(0), thin, wide);
            Vec3<F> t = k.v(kGlossyTangent);
            if (!s.is_zero(kGlossyRotationParam)) t = rotated(t, n, k.f(kGlossyRotation));
            out.tangent(t);
        }
        const Vec3<F> color = max0(k.v(kGlossyColor));
        Vec3<F> weight = allocate(color);
        if (s.e(kGlossyDistribution) == kGlossyMultiGgx)
            weight = weight * MultiScatter<F>(ggx_energy(table_roughness(ax, ay), dot(n, view)), color).factor();
        out.weight(weight);
        out.normal(n);
        emit_widths(out, at, ax, ay);
    }
};
template <class F>
void glossy_bsdf(const Call<F>& c) { c.template each<GlossyBsdf>(); }
ALDER_KERNEL(glossy_bsdf)

struct MetallicBsdf {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Statics& s = k.statics();
        const LobeOut<F> out(k, 0);
        const MicrofacetLayout at(out.spec);
        const Vec3<F> view = k.v(kMetalI), own = socket_normal(k.v(kMetalNormal), k.v(kMetalN));
        const Vec3<F> n = reflecting_normal(own, k.v(kMetalNg), view);
        const F rough = saturate(k.f(kMetalRoughness));
        F ax = sqr(rough), ay = ax;
        if (out.spec.anisotropic) {
            const StretchedWidths<F> widths(rough, saturate(k.f(kMetalAnisotropy)));
            ax = widths.x;
            ay = widths.y;
            Vec3<F> t = k.v(kMetalTangent);
            if (!s.is_zero(kMetalRotationParam)) t = rotated(t, own, k.f(kMetalRotation));
            out.tangent(t);
        }
        Vec3<F> f0, edge, average;
        if (out.spec.fresnel == FresnelMode::F82) {
            f0 = saturate(k.v(kMetalBase));
            edge = f82_b_from_tint(f0, saturate(k.v(kMetalEdge)));
            average = f82_average(f0, edge);
        } else {
            f0 = max0(k.v(kMetalIor));
            edge = max0(k.v(kMetalExtinction));
            average = fresnel_conductor_average(f0, edge);
        }
        Vec3<F> weight(F(1));
        if (s.e(kMetalDistribution) == 2)
            weight = MultiScatter<F>(ggx_energy(table_roughness(ax, ay), dot(n, view)), average).factor();
        out.weight(weight);
        out.normal(n);
        emit_widths(out, at, ax, ay);
        out.param(at.f0, f0);
        out.param(at.edge, edge);
    }
};
template <class F>
void metallic_bsdf(const Call<F>& c) { c.template each<MetallicBsdf>(); }
ALDER_KERNEL(metallic_bsdf)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(glossy_bsdf)
ALDER_KERNEL_EXPORT(metallic_bsdf)

ALDER_NODE {
    using namespace param;
    NodeType n = cycles_bsdf_node("ShaderNodeBsdfAnisotropic", "glossy_bsdf", "mirror-like to blurred reflection, optionally stretched");
    n.aliases.push_back("ShaderNodeBsdfGlossy");
    n.params = {
        color("Color", 0.8, 0.8, 0.8),
        f("Roughness", 0.5).range(0, 1),
        f("Anisotropy", 0).range(-1, 1).doc("narrows along the tangent above 0, across it below"),
        f("Rotation", 0).range(0, 1).doc("turns of the tangent"),
        normal_socket(),
        tangent_socket(),
        weight_socket(),
        choice("distribution",
               {{"BECKMANN", "Beckmann", "beckmann"}, {"GGX", "GGX", "ggx"},
                {"ASHIKHMIN_SHIRLEY", "Ashikhmin-Shirley", "ashikhmin_shirley"},
                {"MULTI_GGX", "Multiscatter GGX", "multi_ggx"}}, "MULTI_GGX"),
    };
    n.globals = {Global::N, Global::Ng, Global::I};
    n.kernel = glossy_bsdf_kernel();
    n.uses = [](const Statics& s, int p) {
        if (p == kGlossyRotationParam || p == 5) return !s.is_zero(kGlossyAnisotropyParam);
        return p != 6;
    };
    n.lobes = [](const Statics& s) -> std::vector<LobeSpec> {
        const int d = s.e(kGlossyDistribution);
        return {{.kind = d == kGlossyAshikhminShirley ? LobeKind::AshikhminShirley : LobeKind::MicrofacetReflection,
                 .label = LobeLabel::Specular,
                 .distribution = d == kGlossyBeckmann ? Distribution::Beckmann : Distribution::GGX,
                 .anisotropic = !s.is_zero(kGlossyAnisotropyParam),
                 .gates = {0}}};
    };
    return n;
}

ALDER_NODE {
    using namespace param;
    NodeType n = cycles_bsdf_node("ShaderNodeBsdfMetallic", "metallic_bsdf", "metal, by colours at the centre and the edge or by measured index");
    n.params = {
        color("Base Color", 0.617, 0.577, 0.54).doc("F82 tint: reflectance facing the viewer"),
        color("Edge Tint", 0.695, 0.726, 0.77).doc("F82 tint: at 82 degrees, relative to Schlick's curve"),
        vector("IOR", 2.757, 2.513, 2.231).range(0, 100).doc("physical conductor: index per channel"),
        vector("Extinction", 3.867, 3.404, 3.009).range(0, 100).doc("physical conductor: extinction per channel"),
        f("Roughness", 0.5).range(0, 1),
        f("Anisotropy", 0).range(0, 1),
        f("Rotation", 0).range(0, 1).doc("turns of the tangent"),
        normal_socket(),
        tangent_socket(),
        weight_socket(),
        choice("distribution",
               {{"BECKMANN", "Beckmann", "beckmann"}, {"GGX", "GGX", "ggx"}, {"MULTI_GGX", "Multiscatter GGX", "multi_ggx"}},
               "MULTI_GGX"),
        choice("fresnel_type",
               {{"PHYSICAL_CONDUCTOR", "Physical Conductor", "physical_conductor"}, {"F82", "F82 Tint", "f82"}}, "F82"),
    };
    n.globals = {Global::N, Global::Ng, Global::I};
    n.kernel = metallic_bsdf_kernel();
    n.uses = [](const Statics& s, int p) {
        const bool f82 = s.e(kMetalFresnel) == 1;
        if (p <= 1) return f82;
        if (p <= 3) return !f82;
        if (p == kMetalRotationParam || p == 8) return !s.is_zero(kMetalAnisotropyParam);
        return p != 9;
    };
    n.lobes = [](const Statics& s) -> std::vector<LobeSpec> {
        return {{.kind = LobeKind::MicrofacetReflection,
                 .label = LobeLabel::Specular,
                 .distribution = s.e(kMetalDistribution) == 0 ? Distribution::Beckmann : Distribution::GGX,
                 .fresnel = s.e(kMetalFresnel) == 1 ? FresnelMode::F82 : FresnelMode::Conductor,
                 .anisotropic = !s.is_zero(kMetalAnisotropyParam)}};
    };
    return n;
}
}  // namespace alder
#endif
