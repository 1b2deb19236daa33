// Parameters of alSurface, all 197 in the catalogue's order. What a parameter cannot do yet stands in its help text, and
// al_surface_check.cpp refuses the values that would need it.
#pragma once
#include "nodes/surface/al_params.h"

namespace alder::al_surface {
using namespace al;

// clang-format off
inline constexpr std::array kBeforeAovs{
    f("diffuseStrength", 1, "Diffuse", "Strength", "multiplies diffuseColor").range(0, 1),
    color("diffuseColor", 0.5, 0.5, 0.5, "Diffuse", "Color",
        "reflectance of the base; scaled down together with backlight and transmission where the three add up to more than 1"),
    f("diffuseRoughness", 0, "Diffuse", "Roughness", "width of Oren and Nayar's slopes; 0 is Lambert").range(0, 1),
    f("backlightStrength", 0, "Diffuse/Backlight", "Strength", "multiplies backlightColor").range(0, 1),
    color("backlightColor", 0.18, 0.18, 0.18, "Diffuse/Backlight", "Color",
        "diffuse light let through from behind, as by a leaf"),
    f("backlightIndirectStrength", 1, "Diffuse/Backlight", "Indirect strength",
        "only 1 is available while backlight is on: indirect light is not scaled on its own").range(0, 1),
    f("emissionStrength", 0, "Emission", "Strength", "multiplies emissionColor"),
    color("emissionColor", 1, 1, 1, "Emission", "Color", "light emitted below both speculars"),
    f("sssMix", 0, "Diffuse/SSS", "Mix",
        "share of the diffuse colour that scatters below the surface; below 0.01, after a diffuse scattering and after a second glossy one diffuse takes it over").range(0, 1),
    choice("sssMode", "cubic|diffusion|directional|empirical", "cubic", "Diffuse/SSS", "Mode",
        "profile of subsurface scattering: cubic 10(R-r)^3/(pi R^5), empirical Christensen and Burley's; diffusion and directional (dipoles) are not available while it is on"),
    f("sssRadius", 1.5, "Diffuse/SSS", "Distance 1",
        "mean radius of the first profile"),
    f("sssWeight1", 1, "Diffuse/SSS", "Weight 1",
        "weight of the first profile; all three at 0 turn subsurface scattering off").range(0, 1),
    color("sssRadiusColor", 0.439, 0.156, 0.078, "Diffuse/SSS", "Color 1",
        "radius per channel of the first profile"),
    f("sssRadius2", 4, "Diffuse/SSS", "Distance 2",
        "mean radius of the second profile"),
    f("sssWeight2", 0, "Diffuse/SSS", "Weight 2",
        "weight of the second profile").range(0, 1),
    color("sssRadiusColor2", 0.439, 0.08, 0.018, "Diffuse/SSS", "Color 2",
        "radius per channel of the second profile"),
    f("sssRadius3", 0.75, "Diffuse/SSS", "Distance 3",
        "mean radius of the third profile"),
    f("sssWeight3", 0, "Diffuse/SSS", "Weight 3",
        "weight of the third profile").range(0, 1),
    color("sssRadiusColor3", 0.523, 0.637, 0.667, "Diffuse/SSS", "Color 3",
        "radius per channel of the third profile"),
    f("sssDensityScale", 1, "Diffuse/SSS", "Density scale",
        "divides the radii"),
    string("sssTraceSet", "", "Diffuse/SSS", "Trace set", "only empty is available: rays see every object"),
    i("sssExtraSamples", 0, "Diffuse/Advanced", "SSS extra samples",
        "no effect: samples go where they are needed").fixed(),
    f("ssInScatteringStrength", 0, "Transmission/Attenuation", "Scattering",
        "scattering inside a transmissive body, times ssAttenuationColor and ssDensityScale; light scatters there once"),
    color("ssAttenuationColor", 1, 1, 1, "Transmission/Attenuation", "Color",
        "what a transmissive body does not absorb: white is clear; absorption is 1 minus this, times ssDensityScale, per unit length"),
    b("ssSpecifyCoefficients", false, "Transmission/Advanced", "Specify attenuation coeffs.",
        "scattering and absorption of a transmissive body given directly"),
    color("ssScattering", 1, 1, 1, "Transmission/Advanced", "Scattering",
        "scattering coefficient; no effect unless ssSpecifyCoefficients is on"),
    color("ssAbsorption", 1, 1, 1, "Transmission/Advanced", "Absorption",
        "absorption coefficient; no effect unless ssSpecifyCoefficients is on"),
    f("ssDensityScale", 1, "Transmission/Attenuation", "Density scale", "multiplies the coefficients of the inside"),
    f("ssDirection", 0, "Transmission/Attenuation", "Direction",
        "mean cosine of scattering inside: forward (positive) or backward; no effect while nothing scatters there").range(-0.99, 0.99),
    i("diffuseExtraSamples", 0, "Diffuse/Advanced", "Diffuse extra samples",
        "no effect: samples go where they are needed").fixed(),
    f("diffuseIndirectStrength", 1, "Diffuse/Advanced", "Indirect strength",
        "only 1 is available while diffuse is on: indirect light is not scaled on its own").range(0, 1),
    f("diffuseIndirectClamp", 0, "Diffuse/Advanced", "Indirect clamp", "only 0 (no clamp) is available").fixed(),
    vector("diffuseNormal", 0, 0, 0, "Diffuse/Advanced", "Normal",
        "a linked normal replaces the shading normal for diffuse, and turned over for backlight").link_only(),
    f("specular1Strength", 1, "Specular 1", "Strength", "multiplies specular1Color").range(0, 1),
    color("specular1Color", 1, 1, 1, "Specular 1", "Color",
        "tint of the upper reflection; what its Fresnel term leaves goes down to the layers below"),
    f("specular1Roughness", 0.3, "Specular 1", "Roughness", "0 is a mirror; squared before use").range(0, 1),
    f("specular1Anisotropy", 0.5, "Specular 1", "Anisotropy",
        "0.5 is round; towards 0 or 1 the highlight is drawn out along or across the tangent").range(0, 1),
    f("specular1Rotation", 0, "Specular 1", "Rotation",
        "turns the highlight, 1 is half a turn; only where anisotropy is not 0.5").range(0, 1),
    choice("specular1FresnelMode", "dielectric|metallic", "dielectric", "Specular 1/Fresnel", "Mode",
        "reflectance by ior, or by the colours of a metal"),
    f("specular1Ior", 1.4, "Specular 1/Fresnel", "IOR",
        "index of refraction, at least 0.001; also that of transmission where linked, and of shadows"),
    color("specular1Reflectivity", 0.548, 0.549, 0.57, "Specular 1/Fresnel", "Reflectivity",
        "metallic: reflectance seen straight on"),
    color("specular1EdgeTint", 0.579, 0.598, 0.62, "Specular 1/Fresnel", "Edge tint",
        "metallic: tint towards grazing angles"),
    f("specular1RoughnessDepthScale", 1, "Specular 1/Advanced", "Roughness depth scale",
        "with rr: the width seen from a rough bounce is at least that bounce's width times this"),
    i("specular1ExtraSamples", 0, "Specular 1/Advanced", "Extra samples",
        "no effect: samples go where they are needed").fixed(),
    vector("specular1Normal", 0, 0, 0, "Specular 1/Advanced", "Normal",
        "a linked normal replaces the shading normal for this specular").link_only(),
    f("specular1IndirectStrength", 1, "Specular 1/Advanced", "Indirect strength",
        "only 1 is available while this specular is on: indirect light is not scaled on its own").range(0, 1),
    f("specular1IndirectClamp", 0, "Specular 1/Advanced", "Indirect clamp", "only 0 (no clamp) is available").fixed(),
    b("specular1CausticPaths", false, "Specular 1/Advanced", "Caustics",
        "off: this specular is black to rays that came from a diffuse bounce").fixed(),
    b("specular1InternalDirect", true, "Specular 1/Advanced", "Internal direct reflections",
        "direct light on the inside of the surface: only on is available"),
    choice("specular1Distribution", "beckmann|ggx", "beckmann", "Specular 1/Advanced", "Distribution",
        "shape of the highlight: ggx has the longer tail"),
    f("specular2Strength", 0, "Specular 2", "Strength", "multiplies specular1Color").range(0, 1),
    color("specular2Color", 1, 1, 1, "Specular 2", "Color", "tint of the lower reflection; lies under specular 1"),
    f("specular2Roughness", 0.5, "Specular 2", "Roughness", "0 is a mirror; squared before use").range(0, 1),
    f("specular2Anisotropy", 0.5, "Specular 2", "Anisotropy",
        "0.5 is round; towards 0 or 1 the highlight is drawn out along or across the tangent").range(0, 1),
    f("specular2Rotation", 0, "Specular 2", "Rotation",
        "turns the highlight, 1 is half a turn; only where anisotropy is not 0.5").range(0, 1),
    choice("specular2FresnelMode", "dielectric|metallic", "dielectric", "Specular 2/Fresnel", "Mode",
        "reflectance by ior, or by the colours of a metal"),
    f("specular2Ior", 1.4, "Specular 2/Fresnel", "IOR", "index of refraction, at least 0.001"),
    color("specular2Reflectivity", 0.548, 0.549, 0.57, "Specular 2/Fresnel", "Reflectivity",
        "metallic: reflectance seen straight on"),
    color("specular2EdgeTint", 0.579, 0.598, 0.62, "Specular 2/Fresnel", "Edge tint",
        "metallic: tint towards grazing angles"),
    f("specular2RoughnessDepthScale", 1, "Specular 2/Advanced", "Roughness depth scale",
        "with rr: the width seen from a rough bounce is at least that bounce's width times this"),
    i("specular2ExtraSamples", 0, "Specular 2/Advanced", "Extra samples",
        "no effect: samples go where they are needed").fixed(),
    vector("specular2Normal", 0, 0, 0, "Specular 2/Advanced", "Normal",
        "a linked normal replaces the shading normal for this specular").link_only(),
    f("specular2IndirectStrength", 1, "Specular 2/Advanced", "Indirect strength",
        "only 1 is available while this specular is on: indirect light is not scaled on its own").range(0, 1),
    f("specular2IndirectClamp", 0, "Specular 2/Advanced", "Indirect clamp", "only 0 (no clamp) is available").fixed(),
    b("specular2CausticPaths", false, "Specular 2/Advanced", "Caustics",
        "off: this specular is black to rays that came from a diffuse bounce").fixed(),
    b("specular2InternalDirect", true, "Specular 2/Advanced", "Internal direct reflections",
        "direct light on the inside of the surface: only on is available"),
    choice("specular2Distribution", "beckmann|ggx", "beckmann", "Specular 2/Advanced", "Distribution",
        "shape of the highlight: ggx has the longer tail"),
    f("transmissionStrength", 0, "Transmission", "Strength", "multiplies transmissionColor").range(0, 1),
    color("transmissionColor", 1, 1, 1, "Transmission", "Color", "tint of the light that passes the surface"),
    b("transmissionLinkToSpecular1", true, "Transmission", "Link to specular 1",
        "roughness and ior of specular 1 instead of its own"),
    f("transmissionRoughness", 0, "Transmission", "Roughness", "0 is clear; squared before use").range(0, 1),
    f("transmissionIor", 1.4, "Transmission", "IOR", "index of refraction of the inside, at least 0.001"),
    f("transmissionRoughnessDepthScale", 1, "Transmission/Advanced", "Roughness depth scale",
        "with rr: the width seen from a rough bounce is at least that bounce's width times this"),
    b("transmissionEnableCaustics", true, "Transmission/Advanced", "Enable internal reflections",
        "off: both speculars are black to rays that came through a transmissive surface"),
    i("transmissionExtraSamples", 0, "Transmission/Advanced", "Extra samples",
        "no effect: samples go where they are needed").fixed(),
    f("transmissionClamp", 0, "Transmission/Advanced", "Indirect clamp", "only 0 (no clamp) is available").fixed(),
    b("transmissionDoDirect", false, "Transmission/Advanced", "Direct lighting",
        "no effect: lights are found through the surface by the refracted rays").fixed(),
    vector("transmissionNormal", 0, 0, 0, "Transmission/Advanced", "Normal",
        "a linked normal, turned to the viewer's side, replaces the shading normal for transmission").link_only(),
    b("transmissionCausticPaths", false, "Transmission/Advanced", "Caustics",
        "off: transmission is black to rays that came from a diffuse bounce").fixed(),
    color("id1", 0, 0, 0, "IDs", "", "written to the AOV id_1"),
    color("id2", 0, 0, 0, "IDs", "", "written to the AOV id_2"),
    color("id3", 0, 0, 0, "IDs", "", "written to the AOV id_3"),
    color("id4", 0, 0, 0, "IDs", "", "written to the AOV id_4"),
    color("id5", 0, 0, 0, "IDs", "", "written to the AOV id_5"),
    color("id6", 0, 0, 0, "IDs", "", "written to the AOV id_6"),
    color("id7", 0, 0, 0, "IDs", "", "written to the AOV id_7"),
    color("id8", 0, 0, 0, "IDs", "", "written to the AOV id_8"),
    b("aiEnableMatte", false, "", "", "for exporters; no effect").fixed(),
    color("aiMatteColor", 0, 0, 0, "", "", "for exporters; no effect").fixed(),
    f("aiMatteColorA", 0, "", "", "for exporters; no effect").fixed(),
};
inline constexpr std::array kAfterAovs{
    b("standardCompatibleAOVs", false, "AOVs", "Write standard AOVs only",
        "only off is available: every light path has its AOV").fixed(),
    b("transmitAovs", false, "AOVs", "Transmit AOVs",
        "only off is available: AOVs are those of the first surface").fixed(),
    i("rrTransmissionDepth", 1, "Transmission/Advanced", "RR depth",
        "no effect on the converged picture: reflection or transmission is chosen by weight at every depth").fixed(),
    color("opacity", 1, 1, 1, "", "Opacity",
        "what the surface covers; the rest shows what is behind. Limited to 0 ... 1"),
    b("rr", true, "Advanced", "RR",
        "roughness of a bounce is at least that of the bounce before (see the depth scales); termination of paths itself is the renderer's").fixed(),
    string("traceSetAll", "", "Advanced", "Global trace set", "only empty is available: rays see every object"),
    string("traceSetShadows", "", "Advanced", "Shadow trace set", "only empty is available: rays see every object"),
    string("traceSetDiffuse", "", "Diffuse/Advanced", "Diffuse trace set",
        "only empty is available: rays see every object"),
    string("traceSetBacklight", "", "Diffuse/Advanced", "Backlight trace set",
        "only empty is available: rays see every object"),
    string("traceSetSpecular1", "", "Specular 1/Advanced", "Trace set",
        "only empty is available: rays see every object"),
    string("traceSetSpecular2", "", "Specular 2/Advanced", "Trace set",
        "only empty is available: rays see every object"),
    string("traceSetTransmission", "", "Transmission/Advanced", "Trace set",
        "only empty is available: rays see every object"),
    choice("debug",
        "off|diffuse-strength|diffuse-color|diffuse-roughness|backlight-strength|backlight-color|sss-mix|sss-weight-1|sss-color-1|"
        "sss-weight-2|sss-color-2|sss-weight-3|sss-color-3|specular-1-strength|specular-1-color|specular-1-roughness|"
        "specular-2-strength|specular-2-color|specular-2-roughness|transmission-strength|transmission-color|"
        "transmission-roughness",
        "off", "Advanced", "Debug",
        "shows one parameter as emission in place of the surface"),
};
inline constexpr std::array kLast{
    string("crypto_asset_override", "", "AOVs", "Crypto asset override",
        "name for Cryptomatte in place of the object's own; no effect on the picture"),
    string("crypto_object_override", "", "AOVs", "Crypto object override",
        "name for Cryptomatte in place of the object's own; no effect on the picture"),
    string("crypto_material_override", "", "AOVs", "Crypto material override",
        "name for Cryptomatte in place of the material's own; no effect on the picture"),
};
// clang-format on

constexpr auto clamp_params() {
    constexpr size_t count = [] {
        size_t n = 0;
        for (const Aov& a : kAovs) n += !a.clamp_parameter.empty();
        return n;
    }();
    std::array<AlParam, count> rows{};
    size_t at = 0;
    for (const Aov& a : kAovs)
        if (!a.clamp_parameter.empty()) rows[at++] = f(a.clamp_parameter, 0, "AOVs", "Clamp", "only 0 (no clamp) is available").fixed();
    return rows;
}

inline constexpr auto kRows = concat(kBeforeAovs, aov_params(), kAfterAovs, clamp_params(), kLast);
static_assert(kRows.size() == 197);

/// Index of a parameter, and its first channel in OpCall::in.
consteval int index(std::string_view name) { return index_of(kRows, name); }
consteval int channel(std::string_view name) { return channel_of(kRows, name); }
inline constexpr int kGlobalsChannel = channel_count(kRows);

/// The lobes in the order of the kernel's output channels, and of the bits of Param::only_lobes.
enum LobeIndex : int {
    kDiffuse,  ///< with `debug` on: the value shown, as emission, and nothing else
    kSpecular1,
    kSpecular2,
    kBacklight,
    kTransmission,
    kEmission,
    kSss1,         ///< subsurface profiles
    kSss2,
    kSss3,
    kShadow,       ///< what a shadow ray sees through the transmission
    kInside,       ///< the medium behind the transmission
    kTransparent,  ///< last: left out where opacity is at its default
    kLobeCount
};

}  // namespace alder::al_surface
