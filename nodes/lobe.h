// Lobes: the scattering shapes that closure nodes emit and the renderer evaluates.
//
// A closure node's kernel writes, per point, the weight, normal and parameters of a fixed set of lobes; which lobes exist is
// decided at compile time (LobeSpec). The mathematics of each kind is in render/closure/. This header is all that the two
// sides share: the list of kinds, and what each parameter channel of a kind means.
//
// Channels of one lobe, in order: weight r g b; normal x y z; tangent x y z (only kinds with has_tangent); then params.
// All vectors are world space. `weight` is the colour that multiplies the lobe, cosine excluded. A lobe with zero weight is
// not evaluated. Frame: z = normal, x = tangent made orthogonal to it.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace alder {

enum class LobeKind : uint8_t {
    // Not scattering
    Emission,     ///< weight = emitted radiance; no params
    Transparent,  ///< straight through; weight = transmittance; no params
    Holdout,      ///< weight = amount of alpha cut out
    // Diffuse
    Diffuse,     ///< params: roughness (Oren–Nayar of Cycles 4.5, energy compensated), color r g b (enters multiple scattering)
    OrenNayar,   ///< alShaders' diffuse: qualitative Oren–Nayar; params: sigma
    Translucent, ///< Lambert transmission (also alShaders' backlight); params: roughness
    // Microfacet. params: alpha_x, alpha_y, eta, then f0 r g b, f90-or-edge r g b, scale r g b; see MicrofacetParam
    MicrofacetReflection,
    MicrofacetTransmission,  ///< refraction only
    MicrofacetGlass,         ///< reflection and refraction by Fresnel, one lobe
    AshikhminShirley,        ///< params as Microfacet
    SheenMicrofiber,         ///< params: ltc_a, ltc_b, albedo
    kCount
};

/// Parameter channels of the microfacet kinds, after weight, normal and tangent.
enum MicrofacetParam : int {
    kAlphaX,
    kAlphaY,
    kEta,        ///< relative index seen from wo's side: ior entering, 1/ior leaving
    kF0R, kF0G, kF0B,        ///< meaning by FresnelMode
    kEdgeR, kEdgeG, kEdgeB,  ///< meaning by FresnelMode
    kTransR, kTransG, kTransB,  ///< tint of the transmitted part (MicrofacetGlass)
    kScaleR, kScaleG, kScaleB,  ///< energy compensation per channel; 1 where there is none
    kFilmThickness, kFilmIor,   ///< thin film, nm; 0 = none
    kMicrofacetParams
};

enum class Distribution : uint8_t { GGX, Beckmann };
enum class FresnelMode : uint8_t {
    None,          ///< F = 1 for every channel (or 0 under total reflection in a pure refraction lobe)
    Dielectric,    ///< exact unpolarised at eta; tinted: reflected x f0, transmitted x trans
    Principled,    ///< lerp(f0, 1, s), s = sat((Fd - F0d)/(1 - F0d)) with Fd exact at eta
    F82,           ///< f0, edge = b of the F82 form
    Conductor,     ///< f0 = n, edge = k
    AlDielectric,  ///< alShaders: the dielectric curve, the same eta on both sides, no refraction
};

/// Which light AOV a lobe's contribution goes to (API.md section 10).
enum class LobeLabel : uint8_t { Diffuse, Specular, Specular2, Backlight, Refraction, Sss, SingleScatter, Emission, Transparent, kCount };

struct LobeSpec {
    LobeKind kind;
    LobeLabel label = LobeLabel::Diffuse;
    Distribution distribution = Distribution::GGX;
    FresnelMode fresnel = FresnelMode::None;
    bool cycles_normal = false;   ///< apply Cycles' corrected normal and bump shadowing (formulas of the closure reference)
    bool shadow_only = false;     ///< present in shadow-ray programs only (alShaders' shadow opacity)
    /// Indices of node parameters any of which makes the lobe vanish when constant and black/zero.
    std::vector<int> gates = {};

    bool has_tangent() const {
        return kind == LobeKind::MicrofacetReflection || kind == LobeKind::MicrofacetTransmission ||
               kind == LobeKind::MicrofacetGlass || kind == LobeKind::AshikhminShirley;
    }
    int params() const {
        switch (kind) {
            case LobeKind::Diffuse: return 4;
            case LobeKind::OrenNayar: return 1;
            case LobeKind::Translucent: return 1;
            case LobeKind::MicrofacetReflection:
            case LobeKind::MicrofacetTransmission:
            case LobeKind::MicrofacetGlass:
            case LobeKind::AshikhminShirley: return kMicrofacetParams;
            case LobeKind::SheenMicrofiber: return 3;
            default: return 0;
        }
    }
    int channels() const { return 6 + (has_tangent() ? 3 : 0) + params(); }
};

}  // namespace alder
