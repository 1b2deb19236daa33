// Lobes: the scattering shapes that closure nodes emit and the renderer evaluates.
//
// A closure node's kernel writes, per point, the weight, normal and parameters of a fixed set of lobes; which lobes exist is
// decided at compile time (LobeSpec). The mathematics of each kind is in render/closure/. This header is all that the two
// sides share: the list of kinds, and what each parameter channel of a kind means.
//
// Channels of one lobe, in order: weight r g b; normal x y z; tangent x y z (only where has_tangent()); then params.
// All vectors are world space and unit length, the tangent need not be orthogonal to the normal. `weight` is the colour that
// multiplies the lobe, cosine excluded; energy compensation is part of it. A lobe with zero weight is absent: its other
// channels are not read. Frame: z = normal, x = tangent made orthogonal to it.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace alder {

struct Prepared;  // nodes/schema.h

enum class LobeKind : uint8_t {
    // Not scattering
    Emission,     ///< weight = emitted radiance; no params
    Transparent,  ///< straight through; weight = transmittance; no params
    Holdout,      ///< weight = amount of alpha cut out
    // Diffuse
    Diffuse,      ///< Lambert, or Oren–Nayar of Cycles 4.5 (energy compensated); params: roughness, color r g b in 0..1
                  ///< (enters multiple scattering; weight has the colour too). `smooth` in the spec: no params
    OrenNayar,    ///< alShaders' diffuse: qualitative Oren–Nayar; params: sigma (radians)
    Translucent,  ///< Lambert transmission; no params
    SheenMicrofiber,  ///< linearly transformed cosine about the plane of wo; params: A, B; weight includes the albedo
    SheenAshikhmin,   ///< Ashikhmin's velvet; params: sigma
    ToonDiffuse,      ///< params: size, smooth: half angles in radians
    ToonGlossy,       ///< the same about the mirrored direction
    // Microfacet: params by MicrofacetLayout
    MicrofacetReflection,
    MicrofacetTransmission,  ///< refraction only
    MicrofacetGlass,         ///< reflection and refraction by Fresnel, one lobe
    AshikhminShirley,        ///< anisotropic Phong; widths as a microfacet lobe, no Fresnel
    // Fibres: the tangent runs along the fibre, angles are in radians. Mathematics: render/closure/hair*.h
    HairReflection,    ///< Cycles' Hair BSDF on the side of the normal; params: offset, roughness along, roughness around
    HairTransmission,  ///< the same on the far side
    HairChiang,        ///< all orders of Chiang et al. 2016; params: sigma r g b; variance of R; variance (TT: 1/4 of it, else 4
                       ///< times); logistic scale; tilt; eta; h
    HairOrder,         ///< one order of the same (LobeSpec::order); params: sigma r g b; variance; logistic scale; shift; eta; h
    HairHuang,         ///< Huang et al. 2022; normal: major axis of the section, or zero; params: sigma r g b; roughness; tilt;
                       ///< eta; aspect; h; half the pixel's width in h; weights of R, TT, TRT
    HairKajiya,        ///< Kajiya and Kay's diffuse: sine of the angle to the fibre; no params
    HairGlossy,        ///< alHair's R and TRT; params: shift, width
    HairForward,       ///< alHair's TT; params: shift, width, azimuthal variance
    HairGlint,         ///< alHair's glint; params: shift, width, azimuthal variance, azimuth
    HairDual,          ///< alHair's dual scattering, order 0 local, 1 global; params: colour r g b; forward; back; shift and width of
                       ///< R; azimuthal variances of TT and glint
    // Tables
    Measured,  ///< isotropic table in LobeSpec::prepared (MERL); no params
    // Subsurface: light leaves elsewhere (render/subsurface/). Chosen like any lobe, but 0 where it is evaluated at one point.
    RandomWalk,  ///< params: mean free path r g b (world units); albedo r g b; ior; entry width; anisotropy. LobeSpec::order 1: half of
                 ///< the entries are diffuse (Cycles' skin)
    Profile,     ///< params: scale r g b of a radial profile (world units). LobeSpec::order: 0 Christensen and Burley, 1 cubic
    // Volumes: coefficients per unit length, world units. Mathematics: render/closure/phase.h
    Absorption,           ///< weight = absorption; no params
    PhaseHenyeyGreenstein,  ///< weight of this and the next three = scattering; params: anisotropy
    PhaseRayleigh,          ///< no params
    PhaseDraine,            ///< params: anisotropy, alpha
    PhaseFournierForand,    ///< params: share scattered backwards, index
    Interior,   ///< of a surface that refracts: what lies behind it. weight = extinction; params: scattering r g b, anisotropy
    RayPortal,  ///< goes on elsewhere; params: position x y z, direction x y z
    kCount
};

enum class Distribution : uint8_t { GGX, Beckmann };
enum class FresnelMode : uint8_t {
    None,        ///< F = 1 (in a refraction lobe 0 under total reflection); tint by weight
    Dielectric,  ///< exact unpolarised at eta. A reflection lobe may keep the same eta on both sides (alShaders)
    Principled,  ///< lerp(f0, 1, s), s = sat((Fd - F0d)/(1 - F0d)) with Fd exact at eta; transmitted part × trans
    F82,         ///< f0, edge = b of the F82 form
    Conductor,   ///< f0 = n, edge = k
    TotalReflection,  ///< MicrofacetGlass: F = 1 under total reflection, else 0: all light refracts where it can (alShaders)
};

/// Which light AOV a lobe's contribution goes to (API.md section 10). What a lobe labelled Refraction reflects is Specular.
enum class LobeLabel : uint8_t {
    Diffuse, Specular, Specular2, Backlight, Refraction, Glint, HairTransmission, Local, Global, Sss, SingleScatter, Emission, Transparent, Volume, kCount
};

struct LobeSpec {
    LobeKind kind;
    LobeLabel label = LobeLabel::Diffuse;
    Distribution distribution = Distribution::GGX;
    FresnelMode fresnel = FresnelMode::None;
    bool cycles_normal = false;  ///< Cycles' bump shadowing of diffuse kinds where the normal is not the surface's own
    bool shadow_only = false;    ///< present in shadow-ray programs only (alShaders' shadow opacity)
    bool anisotropic = false;    ///< microfacet reflection, Ashikhmin–Shirley: two widths and a tangent instead of one width
    bool thin_film = false;      ///< Principled Fresnel under a film
    bool smooth = false;         ///< Diffuse: roughness is 0 everywhere, no params
    bool transmits = false;      ///< OrenNayar: leaves on the far side (alShaders' backlight)
    int8_t order = 0;        ///< HairOrder: passes through the fibre (0 R, 1 TT, 2 TRT, 3 all further); HairDual: which part; variant of
                             ///< subsurface kinds
    bool own_normal = false; ///< subsurface kinds: the normal is not the surface's, so that it is evaluated where light leaves, too
    bool cycles_profile = false;  ///< subsurface kinds: Cycles' rules (Lambert after a diffuse scattering; its weights of probes)
    /// Tables the lobe reads: the node's own, set by the graph compiler (Statics::prepared).
    std::shared_ptr<const Prepared> prepared = {};
    /// Indices of node parameters any of which makes the lobe vanish when constant and black/zero.
    std::vector<int> gates = {};

    bool is_microfacet() const { return kind >= LobeKind::MicrofacetReflection && kind <= LobeKind::AshikhminShirley; }
    bool is_hair() const { return kind >= LobeKind::HairReflection && kind <= LobeKind::HairDual; }
    bool is_phase() const { return kind >= LobeKind::PhaseHenyeyGreenstein && kind <= LobeKind::PhaseFournierForand; }
    /// Of a volume's shader, not of a surface's.
    bool is_volume() const {
        return kind == LobeKind::Absorption || is_phase() || (kind == LobeKind::Emission && label == LobeLabel::Volume);
    }
    bool is_subsurface() const { return kind == LobeKind::RandomWalk || kind == LobeKind::Profile; }
    bool has_tangent() const { return is_hair() || (is_microfacet() && anisotropic); }
    int params() const;
    int channels() const { return 6 + (has_tangent() ? 3 : 0) + params(); }
};

/// Where the parameters of a microfacet lobe lie after weight, normal and tangent; -1 = the lobe has none.
struct MicrofacetLayout {
    int8_t alpha_x = 0, alpha_y = 0;  ///< widths (roughness squared); the same channel where isotropic
    int8_t eta = -1;    ///< relative index seen from wo's side: ior entering, 1/ior leaving
    int8_t f0 = -1;     ///< r g b, meaning by FresnelMode
    int8_t edge = -1;   ///< r g b, meaning by FresnelMode
    int8_t trans = -1;  ///< r g b, tint of the transmitted part (MicrofacetGlass with Principled Fresnel)
    int8_t film = -1;   ///< thickness in nm (0 = none), index of the film seen from wo's side
    int8_t count = 1;

    constexpr MicrofacetLayout() = default;
    constexpr MicrofacetLayout(LobeKind kind, FresnelMode fresnel, bool anisotropic, bool thin_film) {
        if (anisotropic) alpha_y = count++;
        const bool refracts = kind == LobeKind::MicrofacetTransmission || kind == LobeKind::MicrofacetGlass;
        const bool principled = fresnel == FresnelMode::Principled;
        if (refracts || principled || fresnel == FresnelMode::Dielectric) eta = count++;
        if (principled || fresnel == FresnelMode::F82 || fresnel == FresnelMode::Conductor) take(f0, 3);
        if (fresnel == FresnelMode::F82 || fresnel == FresnelMode::Conductor) take(edge, 3);
        if (principled && kind == LobeKind::MicrofacetGlass) take(trans, 3);
        if (principled && thin_film) take(film, 2);
    }
    explicit MicrofacetLayout(const LobeSpec& s) : MicrofacetLayout(s.kind, s.fresnel, s.anisotropic, s.thin_film) {}

  private:
    constexpr void take(int8_t& place, int channels) {
        place = count;
        count = static_cast<int8_t>(count + channels);
    }
};
inline constexpr int kHuangParams = 12;
inline constexpr int kMaxLobeParams = kHuangParams;
static_assert(MicrofacetLayout(LobeKind::MicrofacetGlass, FresnelMode::Principled, true, true).count <= kMaxLobeParams);

inline int LobeSpec::params() const {
    switch (kind) {
        case LobeKind::Diffuse: return smooth ? 0 : 4;
        case LobeKind::OrenNayar:
        case LobeKind::SheenAshikhmin: return 1;
        case LobeKind::SheenMicrofiber:
        case LobeKind::ToonDiffuse:
        case LobeKind::ToonGlossy: return 2;
        case LobeKind::MicrofacetReflection:
        case LobeKind::MicrofacetTransmission:
        case LobeKind::MicrofacetGlass:
        case LobeKind::AshikhminShirley: return MicrofacetLayout(*this).count;
        case LobeKind::RandomWalk: return 9;
        case LobeKind::Profile: return 3;
        case LobeKind::PhaseHenyeyGreenstein: return 1;
        case LobeKind::PhaseDraine:
        case LobeKind::PhaseFournierForand: return 2;
        case LobeKind::Interior: return 4;
        case LobeKind::RayPortal: return 6;
        case LobeKind::HairGlossy: return 2;
        case LobeKind::HairReflection:
        case LobeKind::HairTransmission:
        case LobeKind::HairForward: return 3;
        case LobeKind::HairGlint: return 4;
        case LobeKind::HairOrder: return 8;
        case LobeKind::HairDual:
        case LobeKind::HairChiang: return 9;
        case LobeKind::HairHuang: return kHuangParams;
        default: return 0;
    }
}

}  // namespace alder
