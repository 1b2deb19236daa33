// Random lobes of every kind, and integration over the sphere, for the closure tests.
#pragma once
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "render/closure/bsdf.h"
#include "render/closure/frame.h"

namespace alder::testing {

using closure::kPi;

struct LobeCase {
    std::string name;
    LobeSpec spec;
};

/// Every kind that scatters with a density, in all its variants.
inline std::vector<LobeCase> scattering_cases() {
    std::vector<LobeCase> cases;
    const auto add = [&](const char* name, LobeKind kind, auto... changes) {
        LobeCase c{name, LobeSpec{.kind = kind}};
        (changes(c.spec), ...);
        cases.push_back(c);
    };
    const auto smooth = [](LobeSpec& s) { s.smooth = true; };
    const auto bump = [](LobeSpec& s) { s.cycles_normal = true; };
    const auto back = [](LobeSpec& s) { s.transmits = true; };
    const auto aniso = [](LobeSpec& s) { s.anisotropic = true; };
    const auto beckmann = [](LobeSpec& s) { s.distribution = Distribution::Beckmann; };
    const auto film = [](LobeSpec& s) { s.thin_film = true; };
    const auto fresnel = [](FresnelMode m) { return [m](LobeSpec& s) { s.fresnel = m; }; };
    add("lambert", LobeKind::Diffuse, smooth);
    add("oren_nayar_cycles", LobeKind::Diffuse, bump);
    add("oren_nayar_al", LobeKind::OrenNayar);
    add("backlight_al", LobeKind::OrenNayar, back);
    add("translucent", LobeKind::Translucent, bump);
    add("sheen_microfiber", LobeKind::SheenMicrofiber);
    add("sheen_ashikhmin", LobeKind::SheenAshikhmin);
    add("toon_diffuse", LobeKind::ToonDiffuse);
    add("toon_glossy", LobeKind::ToonGlossy);
    add("ashikhmin_shirley", LobeKind::AshikhminShirley);
    add("ashikhmin_shirley_aniso", LobeKind::AshikhminShirley, aniso);
    add("ggx", LobeKind::MicrofacetReflection);
    add("ggx_aniso", LobeKind::MicrofacetReflection, aniso, fresnel(FresnelMode::Principled));
    add("ggx_film", LobeKind::MicrofacetReflection, film, fresnel(FresnelMode::Principled));
    add("ggx_f82", LobeKind::MicrofacetReflection, fresnel(FresnelMode::F82));
    add("ggx_conductor", LobeKind::MicrofacetReflection, fresnel(FresnelMode::Conductor));
    add("ggx_dielectric", LobeKind::MicrofacetReflection, fresnel(FresnelMode::Dielectric));
    add("beckmann", LobeKind::MicrofacetReflection, beckmann);
    add("beckmann_aniso", LobeKind::MicrofacetReflection, beckmann, aniso);
    add("ggx_refraction", LobeKind::MicrofacetTransmission);
    add("beckmann_refraction", LobeKind::MicrofacetTransmission, beckmann);
    add("ggx_glass", LobeKind::MicrofacetGlass, fresnel(FresnelMode::Dielectric));
    add("ggx_glass_principled", LobeKind::MicrofacetGlass, fresnel(FresnelMode::Principled));
    add("ggx_glass_film", LobeKind::MicrofacetGlass, fresnel(FresnelMode::Principled), film);
    add("ggx_glass_total", LobeKind::MicrofacetGlass, fresnel(FresnelMode::TotalReflection));
    add("beckmann_glass", LobeKind::MicrofacetGlass, beckmann, fresnel(FresnelMode::Dielectric));
    return cases;
}

class Random {
  public:
    explicit Random(uint64_t seed) : engine_(seed) {}
    double operator()(double lo = 0, double hi = 1) { return lo + (hi - lo) * (engine_() >> 11) * 0x1p-53; }
    Vec3d direction() {
        const double z = (*this)(-1, 1), phi = (*this)(0, 2 * kPi<double>), r = std::sqrt(1 - z * z);
        return {r * std::cos(phi), r * std::sin(phi), z};
    }

  private:
    std::mt19937_64 engine_;
};

/// A lobe with random parameters in its kind's range; widths (alpha) between alpha_min and 1.
template <class T>
Lobe<T> random_lobe(const LobeSpec& spec, Random& random, double alpha_min = 0.05) {
    Lobe<T> l;
    l.spec = &spec;
    l.weight = Vec3<T>(T(1));
    const auto set = [&](int i, double x) { l.p[i] = static_cast<T>(x); };
    switch (spec.kind) {
        case LobeKind::Diffuse:
            for (int i = 0; i < 4; ++i) set(i, random());
            break;
        case LobeKind::SheenMicrofiber:
            set(0, random(0.1, 1.2));
            set(1, random(-0.5, 0.5));
            break;
        case LobeKind::OrenNayar:
        case LobeKind::SheenAshikhmin: set(0, random(0.05, 1)); break;
        case LobeKind::ToonDiffuse:
        case LobeKind::ToonGlossy:
            set(0, random(0.1, 1.5));
            set(1, random(0, 1.5));
            break;
        default: break;
    }
    if (!spec.is_microfacet()) return l;
    const MicrofacetLayout at(spec);
    set(at.alpha_x, alpha_min * std::pow(1 / alpha_min, random()));
    if (at.alpha_y != at.alpha_x) set(at.alpha_y, alpha_min * std::pow(1 / alpha_min, random()));
    if (at.eta >= 0) set(at.eta, random() < 0.5 ? random(1.05, 2.5) : 1 / random(1.05, 2.5));
    for (int i = 0; i < 3; ++i) {
        const bool conductor = spec.fresnel == FresnelMode::Conductor;
        if (at.f0 >= 0) set(at.f0 + i, conductor ? random(0.2, 3) : random());
        if (at.edge >= 0) set(at.edge + i, random(0, conductor ? 4 : 3));
        if (at.trans >= 0) set(at.trans + i, random());
    }
    if (at.film >= 0) {
        set(at.film, random(0, 800));
        set(at.film + 1, random(1, 2));
        // A film's reflectance is scaled by f0 over that of the bare surface: above 1 only for tints above 1.
        for (int i = 0; i < 3; ++i) set(at.f0 + i, random() * closure::sqr((l.p[at.eta] - 1) / (l.p[at.eta] + 1)));
    }
    return l;
}

template <class T>
Vec3<T> cast(Vec3d v) { return {static_cast<T>(v.x), static_cast<T>(v.y), static_cast<T>(v.z)}; }

/// wo at the given angle from +z.
inline Vec3d tilted(double theta, double phi) {
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

}  // namespace alder::testing
