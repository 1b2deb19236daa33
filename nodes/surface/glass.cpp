// Refracting BSDFs of Cycles: Glass (reflection and refraction by Fresnel) and Refraction (refraction alone).
// Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007; multiple scattering: Kulla and Conty 2017.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/surface/glass.cpp"
#include "hwy/foreach_target.h"

#include "nodes/surface/closure-inl.h"
#include "nodes/surface/cycles_params.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Index of the far side over the near one.
template <class F>
HWY_INLINE F index_ahead(F ior, F backfacing) {
    ior = max(ior, F(1e-5));
    return select(backfacing != F(0), F(1) / ior, ior);
}

struct GlassBsdf {  // Color 0, Roughness 3, IOR 4, Normal 5, Weight 8; N 9, Ng 12, I 15, Backfacing 18
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const LobeOut<F> out(k, 0);
        const MicrofacetLayout at(out.spec);
        const Vec3<F> view = k.v(15), n = reflecting_normal(socket_normal(k.v(5), k.v(9)), k.v(12), view);
        const F rough = saturate(k.f(3)), eta = index_ahead(k.f(4), k.f(18));
        // The colour tints both parts, so it is the lobe's weight.
        Vec3<F> weight = max0(k.v(0));
        if (k.statics().e(5) == 2)
            weight = weight * MultiScatter<F>(ggx_glass_energy(rough, dot(n, view), eta), weight).factor();
        out.weight(weight);
        out.normal(n);
        out.param(at.alpha_x, sqr(rough));
        out.param(at.eta, eta);
    }
};
template <class F>
void glass_bsdf(const Call<F>& c) { c.template each<GlassBsdf>(); }
ALDER_KERNEL(glass_bsdf)

struct RefractionBsdf {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const LobeOut<F> out(k, 0);
        const MicrofacetLayout at(out.spec);
        out.weight(allocate(k.v(0)));
        out.normal(reflecting_normal(socket_normal(k.v(5), k.v(9)), k.v(12), k.v(15)));
        out.param(at.alpha_x, saturate(sqr(k.f(3))));
        out.param(at.eta, index_ahead(k.f(4), k.f(18)));
    }
};
template <class F>
void refraction_bsdf(const Call<F>& c) { c.template each<RefractionBsdf>(); }
ALDER_KERNEL(refraction_bsdf)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(glass_bsdf)
ALDER_KERNEL_EXPORT(refraction_bsdf)

static NodeType refracting_node(const char* name, const char* alias, const char* summary, double ior, Param distribution) {
    using namespace param;
    NodeType n = cycles_bsdf_node(name, alias, summary);
    n.params = {color("Color", 1, 1, 1), f("Roughness", 0).range(0, 1), f("IOR", ior).range(0, 1000),
                normal_socket(), weight_socket(), std::move(distribution)};
    n.globals = {Global::N, Global::Ng, Global::I, Global::Backfacing};
    n.uses = [](const Statics&, int p) { return p != 4; };
    return n;
}
static const Item kBeckmannItem{"BECKMANN", "Beckmann", "beckmann"}, kGgxItem{"GGX", "GGX", "ggx"},
    kMultiGgxItem{"MULTI_GGX", "Multiscatter GGX", "multi_ggx"};

ALDER_NODE {
    NodeType n = refracting_node("ShaderNodeBsdfGlass", "glass_bsdf", "clear or frosted glass: reflects and refracts by Fresnel", 1.5,
                                 param::choice("distribution", {kBeckmannItem, kGgxItem, kMultiGgxItem}, "MULTI_GGX"));
    n.kernel = glass_bsdf_kernel();
    n.lobes = [](const Statics& s) -> std::vector<LobeSpec> {
        return {{.kind = LobeKind::MicrofacetGlass,
                 .label = LobeLabel::Refraction,
                 .distribution = s.e(5) == 0 ? Distribution::Beckmann : Distribution::GGX,
                 .fresnel = FresnelMode::Dielectric,
                 .gates = {0}}};
    };
    return n;
}

ALDER_NODE {
    NodeType n = refracting_node("ShaderNodeBsdfRefraction", "refraction_bsdf", "refraction without reflection", 1.45,
                                 param::choice("distribution", {kBeckmannItem, kGgxItem}, "BECKMANN"));
    n.kernel = refraction_bsdf_kernel();
    n.lobes = [](const Statics& s) -> std::vector<LobeSpec> {
        return {{.kind = LobeKind::MicrofacetTransmission,
                 .label = LobeLabel::Refraction,
                 .distribution = s.e(5) == 0 ? Distribution::Beckmann : Distribution::GGX,
                 .gates = {0}}};
    };
    return n;
}
}  // namespace alder
#endif
