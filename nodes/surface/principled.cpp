// Principled BSDF of Blender 4.5: sheen over coat over (metal, transmission, dielectric over diffuse), with emission and alpha.
// Layering and energy compensation after Cycles; sheen: Zeltner et al. 2022; metal: F82 of Kutz et al. 2021; multiple
// scattering: Kulla and Conty 2017; thin film: Belcour and Barla 2017.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/surface/principled.cpp"
#include "hwy/foreach_target.h"

#include "nodes/surface/closure-inl.h"
#include "nodes/surface/cycles_params.h"
#include "nodes/surface/subsurface-inl.h"

#ifndef ALDER_NODES_SURFACE_PRINCIPLED_LISTS
#define ALDER_NODES_SURFACE_PRINCIPLED_LISTS
namespace alder::principled {
/// Parameters, in the catalogue's order after the two properties.
enum Parameter : int {
    Distribution_, SubsurfaceMethod, BaseColor, Metallic, Roughness, Ior, Alpha, Normal, Weight, DiffuseRoughness,
    SubsurfaceWeight, SubsurfaceRadius, SubsurfaceScale, SubsurfaceIor, SubsurfaceAnisotropy, SpecularIorLevel, SpecularTint,
    Anisotropic, AnisotropicRotation, Tangent, TransmissionWeight, CoatWeight, CoatRoughness, CoatIor, CoatTint, CoatNormal,
    SheenWeight, SheenRoughness, SheenTint, EmissionColor, EmissionStrength, ThinFilmThickness, ThinFilmIor, kParameters
};
inline constexpr int kChannels[kParameters] = {0, 0, 3, 1, 1, 1, 1, 3, 1, 1, 1, 3, 1, 1, 1, 1, 3,
                                               1, 1, 3, 1, 1, 1, 1, 3, 3, 1, 1, 3, 3, 1, 1, 1};
/// First channel of a parameter; kParameters gives that of the globals.
constexpr int at(int parameter) {
    int c = 0;
    for (int i = 0; i < parameter; ++i) c += kChannels[i];
    return c;
}
/// Channels of the globals.
inline constexpr int kN = at(kParameters), kNg = kN + 3, kI = kN + 6, kBackfacing = kN + 9;
/// Lobes from the top; Transparent last, so that an opaque material lacks it without moving the others.
enum LobeIndex : int { Sheen, Coat, Emission, Metal, Transmission, Dielectric, Diffuse, Subsurface, Shallow, Transparent };
}  // namespace alder::principled
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// 1 - the largest channel of a layer's albedo, ignoring channels that carry no light: one factor for all channels, so that a
/// coloured layer does not tint what lies below.
template <class F>
HWY_INLINE F passed_below(Vec3<F> albedo, Vec3<F> light) {
    F most = F(0);
    for (int i = 0; i < 3; ++i) most = max(most, select(light[i] != F(0), albedo[i], F(0)));
    return saturate(F(1) - most);
}

/// One point's parameters as the layers use them, and the light that is left for the layers below.
template <class F>
struct PrincipledLayers {
    const Lanes<F>& k;
    bool multi_scatter, film;
    Vec3<F> n, ng, view, reflecting_n, coat_n;
    Vec3<F> base, base1, tint, t;
    F rough, ior, alpha_x, alpha_y, metallic, film_thickness, film_ior;
    Mask<F> backfacing;
    Vec3<F> w;  ///< weight left

    HWY_INLINE F f(int parameter) const { return k.f(principled::at(parameter)); }
    HWY_INLINE Vec3<F> v(int parameter) const { return k.v(principled::at(parameter)); }

    HWY_INLINE explicit PrincipledLayers(const Lanes<F>& lanes) : k(lanes) {
        namespace P = principled;
        const Statics& s = k.statics();
        multi_scatter = s.e(P::Distribution_) == 1;
        film = !s.is_zero(P::ThinFilmThickness);
        const Vec3<F> surface = k.v(P::kN);
        ng = k.v(P::kNg);
        view = k.v(P::kI);
        backfacing = k.f(P::kBackfacing) != F(0);
        n = socket_normal(v(P::Normal), surface);
        coat_n = socket_normal(v(P::CoatNormal), surface);
        reflecting_n = reflecting_normal(n, ng, view);
        base = max0(v(P::BaseColor));
        base1 = min1(base);
        tint = max0(v(P::SpecularTint));
        rough = saturate(f(P::Roughness));
        ior = max(f(P::Ior), F(1e-5));
        metallic = saturate(f(P::Metallic));
        film_thickness = film ? max(f(P::ThinFilmThickness), F(1e-5)) : F(0);
        film_ior = film ? max(f(P::ThinFilmIor), F(1e-5)) : F(1);
        alpha_x = alpha_y = sqr(rough);
        t = Vec3<F>(F(0));
        if (!s.is_zero(P::Anisotropic)) {
            const F a = saturate(f(P::Anisotropic));
            const StretchedWidths<F> widths(rough, a);
            alpha_x = widths.x;
            alpha_y = widths.y;
            t = v(P::Tangent);
            if (!s.is_zero(P::AnisotropicRotation)) t = rotated(t, n, f(P::AnisotropicRotation));
        }
        w = Vec3<F>(saturate(f(P::Alpha)));
    }

    HWY_INLINE void sheen() {
        namespace P = principled;
        const F amount = max(f(P::SheenWeight), F(0));
        if (!any(amount > F(kWeightCutoff))) return LobeOut<F>(k, P::Sheen).weight(Vec3<F>(F(0)));
        const Vec3<F> color = max0(v(P::SheenTint)) * amount;
        const Vec3<F> sheen_n = safe_normalize(lerp(n, coat_n, saturate(f(P::CoatWeight))));
        const SheenFit<F> fit(dot(sheen_n, view), saturate(f(P::SheenRoughness)));
        const F albedo = select(kept(max0(color * w)) & (amount > F(kWeightCutoff)), fit.albedo, F(0));
        const LobeOut<F> out(k, P::Sheen);
        out.weight(color * w * albedo);
        out.normal(sheen_n);
        out.param(0, fit.a);
        out.param(1, fit.b);
        w = w * passed_below(color * albedo, w);
    }

    HWY_INLINE void coat() {
        namespace P = principled;
        const F amount = max(f(P::CoatWeight), F(0));
        const Mask<F> present = amount > F(kWeightCutoff);
        if (!any(present)) return LobeOut<F>(k, P::Coat).weight(Vec3<F>(F(0)));
        const F r = saturate(f(P::CoatRoughness)), eta = max(f(P::CoatIor), F(1));
        const Vec3<F> m = reflecting_normal(coat_n, ng, view);
        const F mu = dot(m, view);
        const MultiScatter<F> multi(ggx_energy(r, mu), Vec3<F>(fresnel_dielectric_average(eta)));
        const Vec3<F> weight = select(present, allocate(w * amount), Vec3<F>(F(0)));
        const LobeOut<F> out(k, P::Coat);
        const MicrofacetLayout at(out.spec);
        out.weight(weight * multi.factor());
        out.normal(m);
        out.param(at.alpha_x, sqr(r));
        out.param(at.eta, eta);

        const F layer = lerp(f0_from_ior(eta), F(1), layer_fresnel_rise(r, mu, eta));
        w = w * select(present & kept(max0(w * amount)), passed_below(multi.darkening * (amount * layer), w), F(1));

        // Beer's law along the refracted direction; the tint is what a perpendicular path leaves.
        const Vec3<F> c = max0(v(P::CoatTint));
        const Mask<F> tinted = present & ((c.x != F(1)) | (c.y != F(1)) | (c.z != F(1)));
        if (!any(tinted)) return;
        const F cos_t = sqrt(max(F(1) - (F(1) - mu * mu) / (eta * eta), F(1e-12)));
        const F depth = F(1) / cos_t;
        const Vec3<F> passed(pow(c.x, depth), pow(c.y, depth), pow(c.z, depth));
        w = select(tinted, w * lerp(Vec3<F>(F(1)), passed, amount), w);
    }

    HWY_INLINE void emission() {
        namespace P = principled;
        LobeOut<F>(k, P::Emission).weight(w * v(P::EmissionColor) * f(P::EmissionStrength));
    }

    HWY_INLINE void metal() {
        namespace P = principled;
        const Mask<F> present = metallic > F(kWeightCutoff);
        if (!any(present)) return LobeOut<F>(k, P::Metal).weight(Vec3<F>(F(0)));
        const LobeOut<F> out(k, P::Metal);
        if (out.wanted()) {
            const Vec3<F> b = f82_b_from_tint(base1, min1(tint));
            Vec3<F> weight = select(present, allocate(w * metallic), Vec3<F>(F(0)));
            if (multi_scatter) {
                const SingleScatterAlbedo<F> e = ggx_energy(table_roughness(alpha_x, alpha_y), dot(reflecting_n, view));
                weight = weight * MultiScatter<F>(e, f82_average(base1, b)).factor();
            }
            const MicrofacetLayout at(out.spec);
            out.weight(weight);
            out.normal(reflecting_n);
            out.tangent(t);
            emit_widths(out, at, alpha_x, alpha_y);
            out.param(at.f0, base1);
            out.param(at.edge, b);
        }
        w = select(present, w * (F(1) - metallic), w);
    }

    /// Average of the stretched Fresnel curve, for energy compensation.
    HWY_INLINE Vec3<F> average_fresnel(F eta, Vec3<F> f0) const {
        return lerp(f0, Vec3<F>(F(1)), fresnel_rise(fresnel_dielectric_average(eta), f0_from_ior(eta)));
    }

    HWY_INLINE void transmission() {
        namespace P = principled;
        const F amount = saturate(f(P::TransmissionWeight));
        const Mask<F> present = amount > F(kWeightCutoff);
        if (!any(present)) return LobeOut<F>(k, P::Transmission).weight(Vec3<F>(F(0)));
        const LobeOut<F> out(k, P::Transmission);
        if (out.wanted()) {
            const F eta = select(backfacing, F(1) / ior, ior);
            const Vec3<F> f0 = saturate(tint * f0_from_ior(ior));
            const Vec3<F> through(sqrt(base1.x), sqrt(base1.y), sqrt(base1.z));
            Vec3<F> weight = select(present, allocate(w * amount), Vec3<F>(F(0)));
            if (multi_scatter) {
                const Mask<F> opaque = (through.x == F(0)) & (through.y == F(0)) & (through.z == F(0));
                const Vec3<F> fss = select(opaque, average_fresnel(eta, f0), through);
                weight = weight * MultiScatter<F>(ggx_glass_energy(rough, dot(reflecting_n, view), eta), fss).factor();
            }
            const MicrofacetLayout at(out.spec);
            out.weight(weight);
            out.normal(reflecting_n);
            out.param(at.alpha_x, sqr(rough));
            out.param(at.eta, eta);
            out.param(at.f0, f0);
            out.param(at.trans, through);
            if (at.film >= 0) {
                out.param(at.film, film_thickness);
                out.param(at.film + 1, select(backfacing, film_ior / ior, film_ior));
            }
        }
        w = select(present, w * (F(1) - amount), w);
    }

    HWY_INLINE void dielectric() {
        namespace P = principled;
        const F level = max(f(P::SpecularIorLevel), F(0));
        const Mask<F> as_is = level == F(0.5);
        const F f0_scalar = select(as_is, f0_from_ior(ior), f0_from_ior(ior) * F(2) * level);
        const F scaled = ior_from_f0(f0_scalar);
        const F eta = select(as_is, ior, select(ior < F(1), F(1) / scaled, scaled));
        const Vec3<F> f0 = saturate(tint * f0_scalar);
        const Mask<F> has_film = film_thickness > F(0.1);
        const Vec3<F> allocated = allocate(w);
        const Mask<F> present = kept(max0(w)) & ((eta != F(1)) | has_film);
        const F mu = dot(reflecting_n, view), r = table_roughness(alpha_x, alpha_y);

        Vec3<F> scale(F(1)), darkening(F(1));
        if (multi_scatter) {
            const MultiScatter<F> multi(ggx_energy(r, mu), average_fresnel(eta, f0));
            scale = multi.factor();
            darkening = multi.darkening;
        }
        const LobeOut<F> out(k, P::Dielectric);
        if (out.wanted()) {
            const MicrofacetLayout at(out.spec);
            out.weight(select(present, allocated * scale, Vec3<F>(F(0))));
            out.normal(reflecting_n);
            out.tangent(t);
            emit_widths(out, at, alpha_x, alpha_y);
            out.param(at.eta, eta);
            out.param(at.f0, f0);
            if (at.film >= 0) {
                out.param(at.film, film_thickness);
                out.param(at.film + 1, film_ior);
            }
        }
        Vec3<F> albedo = lerp(f0, Vec3<F>(F(1)), layer_fresnel_rise(r, mu, eta));
        // No table could hold every film: its reflectance at the shading normal stands for the layer.
        if (film && any(has_film)) albedo = select(has_film, fresnel_principled_film(mu, eta, f0, film_thickness, film_ior), albedo);
        w = select(present, w * passed_below(albedo * darkening, w), w);
    }

    HWY_INLINE void diffuse() {
        namespace P = principled;
        const Statics& s = k.statics();
        F left = F(1);
        if (!s.is_zero(P::SubsurfaceWeight)) {
            const F amount = saturate(f(P::SubsurfaceWeight));
            const Mask<F> present = amount > F(kWeightCutoff);
            left = F(1) - amount;
            const LobeOut<F> deep(k, P::Subsurface), shallow(k, P::Shallow);
            if (deep.wanted() || shallow.wanted()) {
                const Vec3<F> weight = select(present, allocate(base1 * amount * w), Vec3<F>(F(0)));
                const bool skin = s.e(P::SubsurfaceMethod) == 2;
                emit_subsurface(deep, shallow, weight, reflecting_n, n, v(P::SubsurfaceRadius) * f(P::SubsurfaceScale), base1,
                                skin ? f(P::SubsurfaceIor) : ior, skin ? F(1) : sqr(rough), f(P::SubsurfaceAnisotropy));
            }
        }
        const LobeOut<F> out(k, P::Diffuse);
        if (!out.wanted()) return;
        out.weight(allocate(w * base * left));
        out.normal(n);
        if (out.spec.smooth) return;
        out.param(0, saturate(f(P::DiffuseRoughness)));
        out.param(1, base1);
    }
};

struct Principled {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        namespace P = principled;
        if (k.statics().lobes.size() > P::Transparent) {
            const LobeOut<F> out(k, P::Transparent);
            if (out.wanted()) out.weight(allocate(Vec3<F>(F(1) - saturate(k.f(P::at(P::Alpha))))));
        }
        // From the lowest lobe wanted upwards everything contributes; above it the layers only dim.
        int lowest = -1;
        for (int i = P::Sheen; i <= P::Shallow; ++i)
            if (LobeOut<F>(k, i).wanted()) lowest = i;
        if (lowest < 0) return;
        const Statics& s = k.statics();
        PrincipledLayers<F> layers(k);
        if (!s.is_zero(P::SheenWeight)) layers.sheen();
        if (lowest >= P::Coat && !s.is_zero(P::CoatWeight)) layers.coat();
        if (lowest >= P::Emission) layers.emission();
        if (lowest >= P::Metal) layers.metal();
        if (lowest >= P::Transmission) layers.transmission();
        if (lowest >= P::Dielectric) layers.dielectric();
        if (lowest >= P::Diffuse) layers.diffuse();
    }
};
template <class F>
void principled_bsdf(const Call<F>& c) { c.template each<Principled>(); }
ALDER_KERNEL(principled_bsdf)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(principled_bsdf)

static std::vector<LobeSpec> principled_lobes(const Statics& s) {
    namespace P = principled;
    std::vector<LobeSpec> lobes(P::Transparent);
    for (LobeSpec& l : lobes) {
        l.cycles_normal = true;
        l.label = LobeLabel::Specular;
        l.gates = {P::Alpha};
    }
    const bool anisotropic = !s.is_zero(P::Anisotropic), film = !s.is_zero(P::ThinFilmThickness);
    lobes[P::Sheen].kind = LobeKind::SheenMicrofiber;
    lobes[P::Sheen].label = LobeLabel::Diffuse;
    lobes[P::Sheen].gates = {P::Alpha, P::SheenWeight, P::SheenTint};
    lobes[P::Coat].kind = LobeKind::MicrofacetReflection;
    lobes[P::Coat].fresnel = FresnelMode::Dielectric;
    lobes[P::Coat].gates = {P::Alpha, P::CoatWeight};
    lobes[P::Emission].kind = LobeKind::Emission;
    lobes[P::Emission].label = LobeLabel::Emission;
    lobes[P::Emission].gates = {P::Alpha, P::EmissionColor, P::EmissionStrength};
    lobes[P::Metal].kind = LobeKind::MicrofacetReflection;
    lobes[P::Metal].fresnel = FresnelMode::F82;
    lobes[P::Metal].anisotropic = anisotropic;
    lobes[P::Metal].gates = {P::Alpha, P::Metallic};
    lobes[P::Transmission].kind = LobeKind::MicrofacetGlass;
    lobes[P::Transmission].label = LobeLabel::Refraction;
    lobes[P::Transmission].fresnel = FresnelMode::Principled;
    lobes[P::Transmission].thin_film = film;
    lobes[P::Transmission].gates = {P::Alpha, P::TransmissionWeight};
    lobes[P::Dielectric].kind = LobeKind::MicrofacetReflection;
    lobes[P::Dielectric].fresnel = FresnelMode::Principled;
    lobes[P::Dielectric].anisotropic = anisotropic;
    lobes[P::Dielectric].thin_film = film;
    if (!film) lobes[P::Dielectric].gates.push_back(P::SpecularIorLevel);
    lobes[P::Diffuse].kind = LobeKind::Diffuse;
    lobes[P::Diffuse].label = LobeLabel::Diffuse;
    lobes[P::Diffuse].smooth = s.is_zero(P::DiffuseRoughness);
    lobes[P::Diffuse].gates = {P::Alpha, P::BaseColor};
    set_subsurface_specs(lobes[P::Subsurface], lobes[P::Shallow], s.e(P::SubsurfaceMethod), s.linked[P::Normal]);
    lobes[P::Subsurface].gates = lobes[P::Shallow].gates = {P::Alpha, P::BaseColor, P::SubsurfaceWeight};
    if (s.is_one(P::SubsurfaceWeight)) lobes[P::Diffuse].gates.push_back(P::Weight);
    // Full metal or full transmission leaves nothing to the layers below: gated by a parameter that is 0 in practice.
    const int below = s.is_one(P::Metallic) ? P::Transmission : s.is_one(P::TransmissionWeight) ? P::Dielectric : P::Transparent;
    for (int i = below; i < P::Transparent; ++i) lobes[i].gates.push_back(P::Weight);
    if (!s.is_default(P::Alpha))
        lobes.push_back({.kind = LobeKind::Transparent, .label = LobeLabel::Transparent});
    return lobes;
}

static bool principled_uses(const Statics& s, int p) {
    namespace P = principled;
    switch (p) {
        case P::Weight: return false;
        case P::SubsurfaceRadius:
        case P::SubsurfaceScale: return !s.is_zero(P::SubsurfaceWeight);
        case P::SubsurfaceIor: return !s.is_zero(P::SubsurfaceWeight) && s.e(P::SubsurfaceMethod) == 2;
        case P::SubsurfaceAnisotropy: return !s.is_zero(P::SubsurfaceWeight) && s.e(P::SubsurfaceMethod) != 0;
        case P::Tangent:
        case P::AnisotropicRotation: return !s.is_zero(P::Anisotropic);
        case P::CoatRoughness:
        case P::CoatIor:
        case P::CoatTint:
        case P::CoatNormal: return !s.is_zero(P::CoatWeight);
        case P::SheenRoughness:
        case P::SheenTint: return !s.is_zero(P::SheenWeight);
        case P::EmissionColor: return !s.is_zero(P::EmissionStrength);
        case P::ThinFilmIor: return !s.is_zero(P::ThinFilmThickness);
        default: return true;
    }
}

ALDER_NODE {
    using namespace param;
    namespace P = principled;
    const auto bits = [](auto... lobe) { return ((uint64_t{1} << lobe) | ...); };
    const uint64_t below_sheen = bits(P::Coat, P::Emission, P::Metal, P::Transmission, P::Dielectric, P::Diffuse, P::Subsurface, P::Shallow);
    const uint64_t below_coat = bits(P::Emission, P::Metal, P::Transmission, P::Dielectric, P::Diffuse, P::Subsurface, P::Shallow);
    const uint64_t base = bits(P::Metal, P::Transmission, P::Dielectric, P::Diffuse, P::Subsurface, P::Shallow);
    const uint64_t dielectrics = bits(P::Transmission, P::Dielectric, P::Diffuse, P::Subsurface, P::Shallow);
    const uint64_t subsurface = bits(P::Subsurface, P::Shallow);
    NodeType n;
    n.name = "ShaderNodeBsdfPrincipled";
    n.system = System::Cycles;
    n.category = "surface";
    n.summary = "general surface: metal, glass, dielectric over diffuse, with coat, sheen, emission and alpha";
    n.help = "Blender 4.5's Principled BSDF. Layers from the top: sheen, coat, emission, metal, transmission, dielectric, "
             "diffuse and subsurface; each passes down what its largest albedo channel leaves. Subsurface light walks at random inside the "
             "object the surface belongs to, or follows Christensen and Burley's profile.";
    n.aliases = {"principled_bsdf"};
    n.params = {
        choice("distribution", {{"GGX", "GGX", "ggx"}, {"MULTI_GGX", "Multiscatter GGX", "multi_ggx"}}, "MULTI_GGX")
            .doc("whether light that scatters several times between microfacets is put back"),
        choice("subsurface_method",
               {{"BURLEY", "Christensen-Burley", "burley"}, {"RANDOM_WALK", "Random Walk", "random_walk"},
                {"RANDOM_WALK_SKIN", "Random Walk (Skin)", "random_walk_skin"}}, "RANDOM_WALK")
            .doc("profile, or walk inside the object; Skin enters diffusely in half of the cases and adapts the radius to the colour"),
        color("Base Color", 0.8, 0.8, 0.8).lobes(bits(P::Metal, P::Transmission, P::Diffuse) | subsurface),
        f("Metallic", 0).range(0, 1).lobes(base),
        f("Roughness", 0.5).range(0, 1).lobes(base),
        f("IOR", 1.5).range(1, 1000).lobes(dielectrics),
        f("Alpha", 1).range(0, 1),
        normal_socket().lobes(bits(P::Sheen) | base | below_coat | below_sheen),
        weight_socket(),
        f("Diffuse Roughness", 0).range(0, 1).lobes(bits(P::Diffuse)),
        f("Subsurface Weight", 0).range(0, 1).lobes(bits(P::Diffuse) | subsurface).doc("share of the diffuse layer that is subsurface"),
        vector("Subsurface Radius", 1, 0.2, 0.1).range(0, 100).lobes(subsurface).doc("how far light spreads, per channel; times the scale"),
        f("Subsurface Scale", 0.05).range(0, 10).lobes(subsurface).doc("length of one unit of radius"),
        f("Subsurface IOR", 1.4).range(1.01, 3.8).lobes(subsurface).doc("of the inside, for Skin; otherwise IOR counts"),
        f("Subsurface Anisotropy", 0).range(0, 1).lobes(subsurface).doc("of scattering inside, up to 0.9; not for the profile"),
        f("Specular IOR Level", 0.5).range(0, 1).lobes(bits(P::Dielectric, P::Diffuse))
            .doc("scales the reflectance at normal incidence; 0.5 is that of the IOR"),
        color("Specular Tint", 1, 1, 1).lobes(base).doc("reflectance at normal incidence; metals: at grazing angles"),
        f("Anisotropic", 0).range(0, 1).lobes(base),
        f("Anisotropic Rotation", 0).range(0, 1).lobes(bits(P::Metal, P::Dielectric)).doc("turns of the tangent"),
        tangent_socket().lobes(bits(P::Metal, P::Dielectric)),
        f("Transmission Weight", 0).range(0, 1).lobes(dielectrics),
        f("Coat Weight", 0).range(0, 1).lobes(bits(P::Sheen) | below_sheen),
        f("Coat Roughness", 0.03).range(0, 1).lobes(below_sheen),
        f("Coat IOR", 1.5).range(1, 4).lobes(below_sheen),
        color("Coat Tint", 1, 1, 1).lobes(below_coat).doc("what light keeps on its way through the coat and back"),
        normal_socket("Coat Normal").lobes(bits(P::Sheen) | below_sheen),
        f("Sheen Weight", 0).range(0, 1).lobes(bits(P::Sheen) | below_sheen),
        f("Sheen Roughness", 0.5).range(0, 1).lobes(bits(P::Sheen) | below_sheen),
        color("Sheen Tint", 1, 1, 1).lobes(bits(P::Sheen) | below_sheen),
        color("Emission Color", 1, 1, 1).lobes(bits(P::Emission)),
        f("Emission Strength", 0).range(0, 1e6).lobes(bits(P::Emission)),
        f("Thin Film Thickness", 0).range(0, 1e5).lobes(dielectrics).doc("nanometres"),
        f("Thin Film IOR", 1.33).range(1, 1000).lobes(dielectrics),
    };
    n.outputs = {{"BSDF", Type::Closure}};
    n.globals = {Global::N, Global::Ng, Global::I, Global::Backfacing};
    n.kernel = principled_bsdf_kernel();
    n.cost_ns = 60;
    n.uses = principled_uses;
    n.lobes = principled_lobes;
    return n;
}
}  // namespace alder
#endif
