// alSurface: diffuse with backlight, two speculars, transmission and emission in one layered surface that keeps energy.
// alshaders specification, section 6; Langlands, "Physically Based Shader Design in Arnold".
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/surface/al_surface.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/surface/al_surface-inl.h"
#include "nodes/surface/al_surface_params.h"
#include "nodes/surface/al_surface_rules.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {
namespace als = alder::al_surface;

/// Shading globals, in the order of NodeType::globals.
enum AlSurfaceGlobal : int {
    kViewChannel = als::kGlobalsChannel,
    kNormalChannel = kViewChannel + 3,
    kDpduChannel = kNormalChannel + 3,
    kBackfacingChannel = kDpduChannel + 3,
    kDepthChannel,
    kDiffuseDepthChannel,
    kGlossyDepthChannel,
    kTransmissionDepthChannel,
    kPreviousAlphaChannel,
};

/// Channels of what both speculars have.
struct AlSpecularChannels {
    int strength, color, roughness, anisotropy, rotation, ior, reflectivity, edge_tint, depth_scale, normal;
};
inline constexpr AlSpecularChannels kSpecularChannels[2] = {
    {als::channel("specular1Strength"), als::channel("specular1Color"), als::channel("specular1Roughness"),
     als::channel("specular1Anisotropy"), als::channel("specular1Rotation"), als::channel("specular1Ior"),
     als::channel("specular1Reflectivity"), als::channel("specular1EdgeTint"), als::channel("specular1RoughnessDepthScale"),
     als::channel("specular1Normal")},
    {als::channel("specular2Strength"), als::channel("specular2Color"), als::channel("specular2Roughness"),
     als::channel("specular2Anisotropy"), als::channel("specular2Rotation"), als::channel("specular2Ior"),
     als::channel("specular2Reflectivity"), als::channel("specular2EdgeTint"), als::channel("specular2RoughnessDepthScale"),
     als::channel("specular2Normal")},
};

/// What holds for the whole batch: decided once, before the loop over points.
struct AlSurfacePlan {
    struct Specular {
        bool present = false, metallic = false, caustic_paths = false, anisotropic = false, own_normal = false;
        const float* albedo_table = nullptr;
        MicrofacetLayout layout;
    } specular[2];
    int out[als::kLobeCount];  ///< first channel of each lobe, -1 = not wanted
    bool layers = false;       ///< a lobe is wanted that the speculars are part of
    bool roughness_follows_path = false, transmission_caustics = false, own_diffuse_normal = false, own_transmission_normal = false;
    MicrofacetLayout transmission_layout;
    float profile_scale = 1;  ///< of a radius; empirical: mean free paths are radii over 7, and d = mean free path / s(albedo 1)

    template <class R>
    explicit AlSurfacePlan(const OpCall<R>& call) {
        const Statics& s = *call.statics;
        for (int lobe = 0; lobe < als::kLobeCount; ++lobe) {
            const bool listed = lobe < static_cast<int>(s.lobes.size());
            out[lobe] = listed && call.out[s.lobe_offset[lobe]] ? s.lobe_offset[lobe] : -1;
            layers = layers || (out[lobe] >= 0 && lobe != als::kShadow && lobe != als::kInside && lobe != als::kTransparent);
        }
        using als::index;
        set_specular(specular[0], s, als::kSpecular1, index("specular1Strength"), index("specular1Color"),
                     index("specular1FresnelMode"), index("specular1CausticPaths"), index("specular1Distribution"),
                     index("specular1Normal"));
        set_specular(specular[1], s, als::kSpecular2, index("specular2Strength"), index("specular2Color"),
                     index("specular2FresnelMode"), index("specular2CausticPaths"), index("specular2Distribution"),
                     index("specular2Normal"));
        roughness_follows_path = s.e(index("rr")) != 0;
        transmission_caustics = s.e(index("transmissionCausticPaths")) != 0;
        own_diffuse_normal = s.linked[index("diffuseNormal")];
        own_transmission_normal = s.linked[index("transmissionNormal")];
        transmission_layout = MicrofacetLayout(s.lobes[als::kTransmission]);
        if (s.lobes[als::kSss1].order == 0) profile_scale = static_cast<float>(1 / (7 * (1.9 - 1 + 3.5 * 0.2 * 0.2)));
    }

  private:
    static void set_specular(Specular& p, const Statics& s, int lobe, int strength, int color, int mode, int caustics, int distribution,
                             int normal) {
        p.present = !s.is_zero(strength) && !s.is_zero(color);
        p.metallic = s.e(mode) != 0;
        p.caustic_paths = s.e(caustics) != 0;
        p.anisotropic = s.lobes[lobe].anisotropic;
        p.own_normal = s.linked[normal];
        p.albedo_table = s.e(distribution) != 0 ? kAlbedoRulesGgx : kAlbedoRulesBeckmann;
        p.layout = MicrofacetLayout(s.lobes[lobe]);
    }
};

/// The viewer, the path and the surface at the current lanes.
template <class F>
struct AlPoint {
    Vec3<F> wo, n, dpdu;
    Mask<F> inside, internal_reflections;
    AlPath<F> path;

    HWY_INLINE explicit AlPoint(const Lanes<F>& k)
        : wo(k.v(kViewChannel)), n(k.v(kNormalChannel)), dpdu(k.v(kDpduChannel)), inside(k.f(kBackfacingChannel) != F(0)),
          internal_reflections(k.f(als::channel("transmissionEnableCaustics")) != F(0)) {
        path.depth = k.f(kDepthChannel);
        path.diffuse_depth = k.f(kDiffuseDepthChannel);
        path.glossy_depth = k.f(kGlossyDepthChannel);
        path.transmission_depth = k.f(kTransmissionDepthChannel);
        path.previous_alpha = select(path.depth > F(0), k.f(kPreviousAlphaChannel), F(0));
    }
};

/// A linked normal, normalised; the shading normal where it has no length.
template <class F>
HWY_INLINE Vec3<F> al_own_normal(const Lanes<F>& k, int channel, Vec3<F> n) {
    const Vec3<F> own = k.v(channel);
    const F length2 = dot(own, own);
    const Mask<F> usable = (length2 > F(1e-30)) & isfinite(length2);
    return select(usable, own * (F(1) / sqrt(select(usable, length2, F(1)))), n);
}

template <class F>
HWY_INLINE Vec3<F> al_tinted(const Lanes<F>& k, int strength, int color) { return k.v(color) * k.f(strength); }

/// Least width by the roughness of the path so far (6.3); 0 = none.
template <class F>
HWY_INLINE F al_width_floor(const Lanes<F>& k, const AlSurfacePlan& plan, const AlPoint<F>& point, int depth_scale) {
    return plan.roughness_follows_path ? max(F(0), point.path.previous_alpha * k.f(depth_scale)) : F(0);
}

/// How the viewer sees a specular lobe, for its albedo.
template <class F>
struct AlAlbedoView {
    const float* table;
    F mu;
    AlWidths<F> width;
    F x, y;  ///< wo in the lobe's frame; read where anisotropic
    Mask<F> mirror;
    bool anisotropic;

    template <class Fresnel>
    HWY_INLINE auto albedo(const Fresnel& fresnel) const {
        const auto rough = anisotropic ? al_albedo_anisotropic(table, mu, width.x, width.y, x, y, fresnel)
                                       : al_albedo(table, AlAlbedoPlace<F>(mu, width.x), fresnel);
        return select(mirror, fresnel(mu), rough);
    }
};

/// A specular: writes its lobe apart from the weight, and returns what the layers below need.
template <class F>
HWY_INLINE AlCoat<F> al_specular(const Lanes<F>& k, const AlSurfacePlan& plan, const AlPoint<F>& point, int which) {
    const AlSurfacePlan::Specular& p = plan.specular[which];
    const AlSpecularChannels& c = kSpecularChannels[which];
    AlCoat<F> coat;
    if (!p.present) return coat;

    const F alpha = sqr(k.f(c.roughness)), anisotropy = k.f(c.anisotropy), ior = al_ior(k.f(c.ior));
    const Vec3<F> n = p.own_normal ? al_own_normal(k, c.normal, point.n) : point.n;
    const F cos_o = dot(point.wo, n);
    coat.color = al_tinted(k, c.strength, c.color);
    coat.runs = al_specular_runs(point.path, coat.color, alpha, p.caustic_paths, point.internal_reflections);
    const Mask<F> mirror = which == 0 ? alpha == F(0) : Mask<F>(false);
    if (which == 0) coat.runs = coat.runs & ((!mirror) | al_mirror_runs(point.path, dot(point.wo, point.n), ior, point.inside));

    const AlWidths<F> width = al_widths(alpha, anisotropy, al_width_floor(k, plan, point, c.depth_scale));
    AlAlbedoView<F> view{p.albedo_table, min(F(1), max(F(1e-4), cos_o)), width, F(0), F(0), mirror, p.anisotropic};
    Vec3<F> tangent(F(0));
    if (p.anisotropic) {
        const AlFrame<F> frame = al_frame(n, point.dpdu);
        const F turn = select(anisotropy == F(0.5), F(0), k.f(c.rotation) * F(3.14159265358979323846));
        tangent = frame.u * cos(turn) - frame.v * sin(turn);
        view.x = dot(point.wo, tangent);
        view.y = dot(point.wo, cross(n, tangent));
    }
    AlMetalCurve<F> metal{Vec3<F>(F(1)), Vec3<F>(F(0))};
    if (p.metallic) {
        for (int ch = 0; ch < 3; ++ch) {
            const AlMetal<F> m = al_metal(k.f(c.reflectivity + ch), k.f(c.edge_tint + ch));
            metal.n[ch] = m.n;
            metal.k[ch] = m.k;
        }
        coat.albedo = max_component(view.albedo(metal));
    } else {
        coat.albedo = view.albedo(AlDielectricCurve<F>{ior});
    }
    // A normal that faces away reflects nothing to the viewer.
    coat.albedo = select(cos_o > F(0), min(F(1), coat.albedo), F(0));

    const int out = plan.out[which == 0 ? als::kSpecular1 : als::kSpecular2];
    if (out < 0) return coat;
    k.set(out + 3, n);
    if (p.anisotropic) k.set(out + 6, tangent);
    const int params = out + (p.anisotropic ? 9 : 6);
    k.set(params + p.layout.alpha_x, select(mirror, F(0), width.x));
    if (p.anisotropic) k.set(params + p.layout.alpha_y, select(mirror, F(0), width.y));
    if (p.layout.eta >= 0) k.set(params + p.layout.eta, ior);
    if (p.metallic) {
        k.set(params + p.layout.f0, metal.n);
        k.set(params + p.layout.edge, metal.k);
    }
    return coat;
}

/// Normal, width and index of the transmission lobe (6.3, 6.7).
template <class F>
HWY_INLINE void al_transmission(const Lanes<F>& k, const AlSurfacePlan& plan, const AlPoint<F>& point, int out) {
    using als::channel;
    Vec3<F> n = point.n;
    if (plan.own_transmission_normal) {
        n = al_own_normal(k, channel("transmissionNormal"), n);
        n = select(dot(n, point.n) < F(0), -n, n);
    }
    const Mask<F> linked = k.f(channel("transmissionLinkToSpecular1")) != F(0);
    const F roughness = select(linked, k.f(channel("specular1Roughness")), k.f(channel("transmissionRoughness")));
    const F ior = al_ior(select(linked, k.f(channel("specular1Ior")), k.f(channel("transmissionIor"))));
    const F alpha = max(al_width_floor(k, plan, point, channel("transmissionRoughnessDepthScale")), sqr(roughness));
    k.set(out + 3, n);
    k.set(out + 6 + plan.transmission_layout.alpha_x, select(alpha == F(0), F(0), max(al_min_alpha<F>(), alpha)));
    k.set(out + 6 + plan.transmission_layout.eta, select(point.inside, F(1) / ior, ior));
}

/// Coefficients of what lies behind the transmission (6.9).
template <class F>
HWY_INLINE void al_inside(const Lanes<F>& k, int out) {
    using als::channel;
    const F density = max(k.f(channel("ssDensityScale")), F(0)), strength = max(k.f(channel("ssInScatteringStrength")), F(0));
    const Mask<F> given = k.f(channel("ssSpecifyCoefficients")) != F(0);
    Vec3<F> color = k.v(channel("ssAttenuationColor"));
    const Mask<F> colored = min(color.x, min(color.y, color.z)) < F(1);
    F extinction[3], scattering[3];
    for (int c = 0; c < 3; ++c) {
        const F kept = select(colored, min(max(color[c], F(0)), F(0.999)), F(1));
        const F least = select(strength > F(0), F(0.01), F(0));
        const F s = select(given, max(k.f(channel("ssScattering") + c), F(0)) * density, kept * strength * density);
        const F a = select(given, max(k.f(channel("ssAbsorption") + c), F(0)) * density, max((F(1) - kept) * density, least));
        scattering[c] = s;
        extinction[c] = s + a;
    }
    k.set(out, Vec3<F>(extinction[0], extinction[1], extinction[2]));
    k.set(out + 3, Vec3<F>(F(0)));
    k.set(out + 6, Vec3<F>(scattering[0], scattering[1], scattering[2]));
    k.set(out + 9, k.f(channel("ssDirection")));
}

/// The three profiles (6.10).
template <class F>
HWY_INLINE void al_subsurface(const Lanes<F>& k, const AlSurfacePlan& plan, const AlPoint<F>& point, Vec3<F> weight, F weights) {
    using als::channel;
    constexpr int kRadius[3] = {channel("sssRadius"), channel("sssRadius2"), channel("sssRadius3")};
    constexpr int kColor[3] = {channel("sssRadiusColor"), channel("sssRadiusColor2"), channel("sssRadiusColor3")};
    constexpr int kWeight[3] = {channel("sssWeight1"), channel("sssWeight2"), channel("sssWeight3")};
    for (int i = 0; i < 3; ++i) {
        const int out = plan.out[als::kSss1 + i];
        if (out < 0) continue;
        const F share = select(weights != F(0), k.f(kWeight[i]) / select(weights != F(0), weights, F(1)), F(0));
        k.set(out, weight * share);
        k.set(out + 3, plan.own_diffuse_normal ? al_own_normal(k, channel("diffuseNormal"), point.n) : point.n);
        const F unit = k.f(kRadius[i]) / k.f(channel("sssDensityScale"));
        for (int ch = 0; ch < 3; ++ch) {
            F radius = unit * k.f(kColor[i] + ch);
            radius = select(radius > F(1e-4), min(radius, F(1e15)), F(1e-4));  // NaN is the least, too
            k.set(out + 6 + ch, radius * F(plan.profile_scale));
        }
    }
}

template <class F>
HWY_INLINE void al_surface_point(const Lanes<F>& k, const AlSurfacePlan& plan) {
    using als::channel;
    const AlPoint<F> point(k);
    AlBase<F> base;
    base.diffuse = al_tinted(k, channel("diffuseStrength"), channel("diffuseColor"));
    base.backlight = al_tinted(k, channel("backlightStrength"), channel("backlightColor"));
    base.transmission = al_tinted(k, channel("transmissionStrength"), channel("transmissionColor"));
    base.emission = al_tinted(k, channel("emissionStrength"), channel("emissionColor"));
    base.opacity = k.v(channel("opacity"));
    const F sss_weights = k.f(channel("sssWeight1")) + k.f(channel("sssWeight2")) + k.f(channel("sssWeight3"));
    base.sss_mix = al_sss_mix(point.path, k.f(channel("sssMix")), sss_weights != F(0));
    al_balance(base);

    AlCoat<F> coat[2];
    if (plan.layers)
        for (int which = 0; which < 2; ++which) coat[which] = al_specular(k, plan, point, which);
    const F straight = plan.specular[0].metallic
                           ? F(1)
                           : fresnel_dielectric(max(F(0), dot(point.wo, point.n)), al_ior(k.f(channel("specular1Ior"))));
    const AlWeights<F> w = al_weights(point.path, base, coat[0], coat[1], plan.transmission_caustics, straight);

    const int* out = plan.out;
    if (out[als::kSpecular1] >= 0) k.set(out[als::kSpecular1], w.specular1);
    if (out[als::kSpecular2] >= 0) k.set(out[als::kSpecular2], w.specular2);
    if (out[als::kDiffuse] >= 0 || out[als::kBacklight] >= 0) {
        const Vec3<F> n = plan.own_diffuse_normal ? al_own_normal(k, channel("diffuseNormal"), point.n) : point.n;
        const F sigma = k.f(channel("diffuseRoughness"));
        for (const int lobe : {als::kDiffuse, als::kBacklight}) {
            if (out[lobe] < 0) continue;
            k.set(out[lobe], lobe == als::kDiffuse ? w.diffuse : w.backlight);
            k.set(out[lobe] + 3, n);
            k.set(out[lobe] + 6, sigma);
        }
    }
    al_subsurface(k, plan, point, w.subsurface, sss_weights);
    if (out[als::kTransmission] >= 0) {
        k.set(out[als::kTransmission], w.transmission);
        al_transmission(k, plan, point, out[als::kTransmission]);
    }
    if (out[als::kInside] >= 0) al_inside(k, out[als::kInside]);
    const Vec3<F> none(F(0));
    for (const int lobe : {als::kEmission, als::kShadow, als::kTransparent}) {
        if (out[lobe] < 0) continue;
        k.set(out[lobe], lobe == als::kEmission ? w.emission : lobe == als::kShadow ? w.shadow : w.transparent);
        k.set(out[lobe] + 3, none);
    }
}

/// `debug`: one parameter as it was given, as emission (6.13).
template <class F>
void al_surface_debug(const Call<F>& c) {
    const Statics& s = c.statics();
    const int param = als::debug_param(s.e(als::index("debug")));
    const int first = s.type->channel_of(param), step = s.type->params[param].type == Type::Color ? 1 : 0;
    const int out = s.lobe_offset[0];
    for (size_t i = 0; i < c.call.n; i += NumOf<F>::width()) {
        const Lanes<F> k{c.call, i};
        for (int ch = 0; ch < 3; ++ch) {
            k.set(out + ch, k.f(first + ch * step));
            k.set(out + 3 + ch, F(0));
        }
    }
}

template <class F>
void al_surface(const Call<F>& c) {
    if (c.statics().e(als::index("debug")) != 0) return al_surface_debug(c);
    const AlSurfacePlan plan(c.call);
    for (size_t i = 0; i < c.call.n; i += NumOf<F>::width()) al_surface_point(Lanes<F>{c.call, i}, plan);
}
ALDER_KERNEL(al_surface)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(al_surface)

ALDER_NODE {
    NodeType n;
    n.name = "alSurface";
    n.system = System::AlShaders;
    n.category = "surface";
    n.summary = "layered surface shader";
    n.help = "Two speculars over diffuse, backlight and transmission, emission below the speculars. Roughness is squared. Diffuse, "
             "backlight and transmission share one budget: where they add up to more than 1 they are scaled down together. Each "
             "specular passes down what its directional albedo leaves. Bodies behind the transmission absorb, and scatter light once, by "
             "the ss parameters. Dipoles for subsurface scattering and separate controls of indirect light are refused where they would "
             "change the picture. Opacity multiplies every lobe, as Arnold's renderer composites the original's colour by it.";
    for (const AlParam& row : al_surface::kRows) n.params.push_back(al::make_param(row));
    al_surface::set_only_lobes(n);
    n.outputs = {{"out", Type::Closure}};
    n.globals = {Global::I, Global::N, Global::Dpdu, Global::Backfacing, Global::RayDepth, Global::DiffuseDepth, Global::GlossyDepth,
                 Global::TransmissionDepth, Global::PreviousAlpha};
    n.kernel = al_surface_kernel();
    n.cost_ns = 150;
    n.uses = al_surface::uses;
    n.lobes = al_surface::lobes;
    n.check = al_surface::check;
    for (int id = 1; id <= 8; ++id) {
        const std::string digit = std::to_string(id);
        n.closure_aovs.push_back({"id_" + digit, n.param_index("id" + digit)});
    }
    return n;
}
}  // namespace alder
#endif
