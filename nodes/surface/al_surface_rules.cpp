// alSurface's rules: which lobes it emits, which parameters those need, and which settings it refuses because they would
// change the picture and are not there. alshaders specification, sections 6.5, 6.9, 6.12 and 6.13.
#include "nodes/surface/al_surface_rules.h"

#include <algorithm>
#include <array>

#include "nodes/surface/al_surface_params.h"

namespace alder::al_surface {
namespace {

constexpr uint64_t bit(int lobe) { return uint64_t{1} << lobe; }
constexpr uint64_t kSubsurface = bit(kSss1) | bit(kSss2) | bit(kSss3);
constexpr uint64_t kBelowSpecular2 = kSubsurface | bit(kDiffuse) | bit(kBacklight) | bit(kTransmission) | bit(kEmission);
constexpr uint64_t kBelowSpecular1 = kBelowSpecular2 | bit(kSpecular2);
/// Diffuse, backlight and transmission share a budget, so each needs the colours of all.
constexpr uint64_t kBudget = kSubsurface | bit(kDiffuse) | bit(kBacklight) | bit(kTransmission) | bit(kShadow);

/// Items of sssMode.
enum SssMode : int { kSssCubic, kSssDiffusion, kSssDirectional, kSssEmpirical };

bool starts(std::string_view name, std::string_view prefix) { return name.substr(0, prefix.size()) == prefix; }

/// The debug items, after "off".
constexpr int kDebug[] = {
    index("diffuseStrength"),   index("diffuseColor"),      index("diffuseRoughness"),     index("backlightStrength"),
    index("backlightColor"),    index("sssMix"),            index("sssWeight1"),           index("sssRadiusColor"),
    index("sssWeight2"),        index("sssRadiusColor2"),   index("sssWeight3"),           index("sssRadiusColor3"),
    index("specular1Strength"), index("specular1Color"),    index("specular1Roughness"),   index("specular2Strength"),
    index("specular2Color"),    index("specular2Roughness"), index("transmissionStrength"), index("transmissionColor"),
    index("transmissionRoughness"),
};

bool black(const Statics& s, int strength, int color) { return s.is_zero(strength) || s.is_zero(color); }

LobeSpec specular_spec(const Statics& s, LobeLabel label, int distribution, int mode, int anisotropy, int strength, int color) {
    LobeSpec l{LobeKind::MicrofacetReflection, label};
    l.distribution = s.e(distribution) != 0 ? Distribution::GGX : Distribution::Beckmann;
    l.fresnel = s.e(mode) != 0 ? FresnelMode::Conductor : FresnelMode::Dielectric;
    l.anisotropic = !s.is_default(anisotropy);
    l.gates = {strength, color, index("opacity")};
    return l;
}

}  // namespace

int debug_param(int item) { return kDebug[std::clamp(item - 1, 0, static_cast<int>(std::size(kDebug)) - 1)]; }

std::vector<LobeSpec> lobes(const Statics& s) {
    LobeSpec emission{LobeKind::Emission, LobeLabel::Emission};
    if (s.e(index("debug")) != 0) {
        emission.gates = {debug_param(s.e(index("debug")))};
        return {emission};
    }
    const int opacity = index("opacity");
    std::vector<LobeSpec> l(kLobeCount, LobeSpec{LobeKind::Transparent, LobeLabel::Transparent});
    l[kDiffuse] = {LobeKind::OrenNayar, LobeLabel::Diffuse};
    l[kDiffuse].gates = {index("diffuseStrength"), index("diffuseColor"), opacity};
    l[kSpecular1] = specular_spec(s, LobeLabel::Specular, index("specular1Distribution"), index("specular1FresnelMode"),
                                  index("specular1Anisotropy"), index("specular1Strength"), index("specular1Color"));
    l[kSpecular2] = specular_spec(s, LobeLabel::Specular2, index("specular2Distribution"), index("specular2FresnelMode"),
                                  index("specular2Anisotropy"), index("specular2Strength"), index("specular2Color"));
    l[kBacklight] = {LobeKind::OrenNayar, LobeLabel::Backlight};
    l[kBacklight].transmits = true;
    l[kBacklight].gates = {index("backlightStrength"), index("backlightColor"), opacity};
    l[kTransmission] = {LobeKind::MicrofacetGlass, LobeLabel::Refraction};
    l[kTransmission].distribution = Distribution::Beckmann;
    l[kTransmission].fresnel = FresnelMode::TotalReflection;
    l[kTransmission].gates = {index("transmissionStrength"), index("transmissionColor"), opacity};
    emission.gates = {index("emissionStrength"), index("emissionColor"), opacity};
    l[kEmission] = emission;
    const int mode = s.e(index("sssMode"));
    for (const auto& [lobe, weight] : {std::pair{kSss1, index("sssWeight1")}, {kSss2, index("sssWeight2")}, {kSss3, index("sssWeight3")}}) {
        l[lobe] = {LobeKind::Profile, LobeLabel::Sss};
        l[lobe].order = mode == kSssEmpirical ? 0 : 1;
        l[lobe].own_normal = s.linked[index("diffuseNormal")];
        l[lobe].gates = {index("diffuseStrength"), index("diffuseColor"), index("sssMix"), weight, opacity};
    }
    l[kShadow].shadow_only = true;
    l[kShadow].gates = l[kTransmission].gates;
    // A body is clear where its colour is white, nothing scatters and no coefficients are given: then no lobe says so.
    const bool clear = s.is_zero(index("ssSpecifyCoefficients")) && s.is_one(index("ssAttenuationColor"));
    l[kInside] = {LobeKind::Interior, LobeLabel::SingleScatter};
    l[kInside].gates = {index("transmissionStrength"), index("transmissionColor"), opacity, clear ? index("ssInScatteringStrength") : index("ssDensityScale")};
    // A metallic specular 1 casts a full shadow (6.8), so the lobe is left to the kernel, which gives it no weight.
    if (s.is_default(opacity)) l.pop_back();
    return l;
}

bool uses(const Statics& s, int param) {
    const int debug = s.e(index("debug"));
    if (param == index("debug")) return true;
    if (debug != 0) return param == debug_param(debug);
    const std::string_view name = kRows[param].name;
    const bool dark1 = black(s, index("specular1Strength"), index("specular1Color"));
    const bool dark2 = black(s, index("specular2Strength"), index("specular2Color"));
    const bool dark_transmission = black(s, index("transmissionStrength"), index("transmissionColor"));
    const bool round1 = s.is_default(index("specular1Anisotropy")), round2 = s.is_default(index("specular2Anisotropy"));
    // Specular 1 lends these two to transmission and its shadow.
    if (name == "specular1Roughness") return !dark1 || !dark_transmission;
    if (name == "specular1Ior") return !dark1 || !dark_transmission;
    if (name == "specular1Rotation") return !dark1 && !round1;
    if (name == "specular2Rotation") return !dark2 && !round2;
    const bool facts = name.ends_with("Strength") || name.ends_with("Color");
    if (starts(name, "specular1") && !facts) {
        const bool metallic = s.e(index("specular1FresnelMode")) != 0;
        if (name == "specular1Reflectivity" || name == "specular1EdgeTint") return !dark1 && metallic;
        return !dark1 || name == "specular1FresnelMode";
    }
    if (starts(name, "specular2") && !facts) {
        const bool metallic = s.e(index("specular2FresnelMode")) != 0;
        if (name == "specular2Reflectivity" || name == "specular2EdgeTint") return !dark2 && metallic;
        if (name == "specular2Ior") return !dark2 && !metallic;
        return !dark2;
    }
    if (name == "specular1Color") return !s.is_zero(index("specular1Strength"));
    if (name == "specular2Color") return !s.is_zero(index("specular2Strength"));
    if (name == "diffuseColor") return !s.is_zero(index("diffuseStrength"));
    if (name == "backlightColor") return !s.is_zero(index("backlightStrength"));
    if (name == "transmissionColor") return !s.is_zero(index("transmissionStrength"));
    if (name == "emissionColor") return !s.is_zero(index("emissionStrength"));
    if (name == "transmissionEnableCaustics") return !dark1 || !dark2;
    if (starts(name, "transmission") && name != "transmissionStrength") return !dark_transmission;
    if (name == "ssScattering" || name == "ssAbsorption") return !dark_transmission && !s.is_zero(index("ssSpecifyCoefficients"));
    if (starts(name, "ss") && !starts(name, "sss")) return !dark_transmission;
    if (starts(name, "sssWeight") || name == "sssDensityScale") return !s.is_zero(index("sssMix"));
    for (const auto& [radius, color, weight] : {std::array{index("sssRadius"), index("sssRadiusColor"), index("sssWeight1")},
                                                std::array{index("sssRadius2"), index("sssRadiusColor2"), index("sssWeight2")},
                                                std::array{index("sssRadius3"), index("sssRadiusColor3"), index("sssWeight3")}})
        if (param == radius || param == color) return !s.is_zero(index("sssMix")) && !s.is_zero(weight);
    return name == "opacity" || name == "sssMix" || name == "rr" || name == "diffuseRoughness" || name == "diffuseNormal" ||
           name.ends_with("Strength") || (starts(name, "id") && name.size() == 3);
}

void set_only_lobes(NodeType& n) {
    for (size_t p = 0; p < n.params.size(); ++p) {
        const std::string_view name = kRows[p].name;
        uint64_t lobes = 0;
        if (starts(name, "specular1")) lobes = bit(kSpecular1) | kBelowSpecular1;
        if (starts(name, "specular2")) lobes = bit(kSpecular2) | kBelowSpecular2;
        if (name == "specular1Ior") lobes |= bit(kShadow);
        if (name == "transmissionEnableCaustics") lobes = bit(kSpecular1) | kBelowSpecular1;
        else if (starts(name, "transmission")) lobes = bit(kTransmission);
        for (const char* color : {"diffuse", "backlight", "transmission"})
            if (name == std::string(color) + "Strength" || name == std::string(color) + "Color") lobes = kBudget;
        if (name == "diffuseRoughness") lobes = bit(kDiffuse) | bit(kBacklight);
        if (name == "diffuseNormal") lobes = bit(kDiffuse) | bit(kBacklight) | kSubsurface;
        if (name == "sssMix" || starts(name, "sssWeight")) lobes = bit(kDiffuse) | bit(kBacklight) | kSubsurface;
        if (starts(name, "sssRadius") || name == "sssDensityScale") lobes = kSubsurface;
        if (starts(name, "emission")) lobes = bit(kEmission);
        if (starts(name, "ss") && !starts(name, "sss")) lobes = bit(kInside);
        if (name == "opacity") lobes = ~uint64_t{0};
        if (std::find(std::begin(kDebug), std::end(kDebug), static_cast<int>(p)) != std::end(kDebug)) lobes |= bit(0);
        n.params[p].lobes(lobes);
    }
}

namespace {

/// The constants of one instance, by name.
struct Constants {
    const std::vector<const double*>& values;
    std::vector<std::string>& errors;

    bool linked(int p) const { return values[p] == nullptr; }
    double number(int p) const { return values[p] ? values[p][0] : 0; }
    bool is(int p, double v) const {
        if (linked(p)) return false;
        const int count = channels(kRows[p].type);
        return std::all_of(values[p], values[p] + count, [v](double x) { return x == v; });
    }
    bool dark(int strength, int color) const { return is(strength, 0) || is(color, 0); }
    /// `expected` is what would have been right, and why.
    void refuse(int p, const std::string& expected) const { errors.push_back(std::string(kRows[p].name) + ": " + expected); }
    void only(int p, double v, const char* expected) const {
        if (!is(p, v)) refuse(p, expected);
    }
};

constexpr char kNoScale[] = "1: indirect light is not scaled on its own";
constexpr char kNoClamp[] = "0: clamping is not available";

void check_subsurface(const Statics& s, const Constants& c) {
    const bool weights = !(c.is(index("sssWeight1"), 0) && c.is(index("sssWeight2"), 0) && c.is(index("sssWeight3"), 0));
    const int mix = index("sssMix"), mode = s.e(index("sssMode"));
    const bool on = weights && (c.linked(mix) || c.number(mix) >= 0.01);
    if (on && mode != kSssCubic && mode != kSssEmpirical)
        c.refuse(index("sssMode"), "cubic or empirical: the dipoles of diffusion and directional are not available");
}

void check_specular(const Constants& c, int strength, int clamp, int internal) {
    c.only(strength, 1, kNoScale);
    c.only(clamp, 0, kNoClamp);
    if (c.linked(internal) || c.is(internal, 0)) c.refuse(internal, "true: direct light inside cannot be switched off on its own");
}

}  // namespace

void check(const Statics& s, const std::vector<const double*>& constant, std::vector<std::string>& errors) {
    const Constants c{constant, errors};
    if (s.e(index("debug")) != 0) return;
    if (!c.dark(index("diffuseStrength"), index("diffuseColor"))) {
        check_subsurface(s, c);
        c.only(index("diffuseIndirectStrength"), 1, kNoScale);
        c.only(index("diffuseIndirectClamp"), 0, kNoClamp);
    }
    if (!c.dark(index("backlightStrength"), index("backlightColor"))) c.only(index("backlightIndirectStrength"), 1, kNoScale);
    if (!c.dark(index("specular1Strength"), index("specular1Color")))
        check_specular(c, index("specular1IndirectStrength"), index("specular1IndirectClamp"), index("specular1InternalDirect"));
    if (!c.dark(index("specular2Strength"), index("specular2Color")))
        check_specular(c, index("specular2IndirectStrength"), index("specular2IndirectClamp"), index("specular2InternalDirect"));
    if (!c.dark(index("transmissionStrength"), index("transmissionColor"))) {
        c.only(index("transmissionClamp"), 0, kNoClamp);
    }
    for (size_t p = 0; p < kRows.size(); ++p) {
        const std::string_view name = kRows[p].name;
        if (starts(name, "aov_") && name.ends_with("_clamp")) c.only(static_cast<int>(p), 0, kNoClamp);
        const bool trace_set = starts(name, "traceSet") || name == "sssTraceSet";
        if (trace_set && !s.text[p].empty()) c.refuse(static_cast<int>(p), "an empty string: trace sets are not available, rays see every object");
    }
    c.only(index("standardCompatibleAOVs"), 0, "false: every light path has its AOV");
    c.only(index("transmitAovs"), 0, "false: AOVs are those of the first surface");
}

}  // namespace alder::al_surface
