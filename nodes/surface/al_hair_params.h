// Parameters of alHair, all 90 in the catalogue's order, and one of ours.
#pragma once
#include "nodes/surface/al_params.h"

namespace alder::al_hair {
using namespace al;

constexpr AlParam aov(Text name, Text label) {
    return string(name, name.substr(4), label.empty() ? "" : "AOVs", label,
                  "name of the AOV; no effect on the picture, whose layers keep the default names");
}

// clang-format off
inline constexpr std::array kRows{
    color("dyeColor", 1, 1, 1, "Fibre properties", "Dye color", "multiplies the colour that melanin gives; 0 to 1"),
    f("melanin", 0.15, "Fibre properties", "Melanin", "amount of pigment: 0 white, 0.15 blond, 1 black").range(0, 1),
    f("specularShift", 4, "Fibre properties", "Highlight shift", "tilt of the first highlight towards the root, degrees").fixed(),
    f("specularWidth", 3, "Fibre properties", "Highlight width", "width of the first highlight along the fibre, degrees; the others follow from it").fixed(),
    i("extraSamplesDiffuse", 0, "Advanced", "Diffuse extra samples", "no effect: samples go where they are needed").fixed(),
    i("extraSamplesGlossy", 0, "Advanced", "Glossy extra samples", "no effect: samples go where they are needed").fixed(),
    f("diffuseStrength", 1, "Diffuse", "Strength", "multiplies diffuseColor").range(0, 1),
    color("diffuseColor", 1, 1, 1, "Diffuse", "Tint", "tint of the diffuse or multiply scattered light"),
    choice("diffuseScatteringMode", "kajiya-kay|dual-scattering", "dual-scattering", "Diffuse", "Scattering mode", "kajiya-kay: diffuse strands; dual-scattering: light that other fibres scatter back"),
    f("specular1Strength", 1, "Specular 1", "Strength", "multiplies specular1Color").range(0, 1),
    color("specular1Color", 1, 1, 1, "Specular 1", "Tint", "tint of the first highlight, which has the colour of the light"),
    f("specular2Strength", 1, "Specular 2", "Strength", "multiplies specular2Color").range(0, 1),
    color("specular2Color", 1, 1, 1, "Specular 2", "Tint", "tint of the second highlight, which has the colour of the hair"),
    f("glintStrength", 2.5, "Specular 2", "Glint strength", "brightness of the glints within the second highlight"),
    f("glintRolloff", 5, "Fibre properties/Advanced", "Glint rolloff", "size of the glints around the fibre: square root of degrees, as in the original").fixed(),
    f("transmissionStrength", 1, "Transmission", "Strength", "multiplies transmissionColor").range(0, 1),
    color("transmissionColor", 1, 1, 1, "Transmission", "Tint", "tint of light that passes through"),
    f("transmissionRolloff", 10, "Fibre properties/Advanced", "Transmission rolloff", "spread of transmitted light around the fibre: square root of degrees, as in the original; energy-conserving: degrees").fixed(),
    color("opacity", 1, 1, 1, "Fibre properties", "Opacity", "multiplies every lobe; what is left passes straight through"),
    i("dualDepth", 0, "Advanced", "Brute force bounces", "no effect: dual scattering is the same at every bounce").fixed(),
    f("diffuseForward", 0.7, "Diffuse", "Forward scattering", "dual-scattering: weight of light that came through other fibres").range(0, 1),
    f("diffuseBack", 0.7, "Diffuse", "Back scattering", "dual-scattering: weight of light that other fibres send back").range(0, 1),
    f("specular1WidthScale", 1, "Specular 1", "Width scale", "multiplies the width of the first highlight"),
    f("specular2WidthScale", 1, "Specular 2", "Width scale", "multiplies the width of the second highlight and the glints"),
    f("transmissionWidthScale", 1, "Transmission", "Width scale", "multiplies the width of the transmitted lobe"),
    f("specular1Shift", 0, "Specular 1", "Shift offset", "added to the shift of the first highlight, degrees"),
    f("specular2Shift", 0, "Specular 2", "Shift offset", "added to the shift of the second highlight and the glints, degrees"),
    f("transmissionShift", 0, "Transmission", "Shift offset", "added to the shift of the transmitted lobe, degrees"),
    f("diffuseIndirectStrength", 0, "Advanced", "Diffuse indirect strength", "no effect: indirect light is scattered as direct light is"),
    f("glossyIndirectStrength", 0, "Advanced", "Glossy indirect strength", "no effect: indirect light is scattered as direct light is"),
    f("randomTangent", 0, "Fibre properties/Randomize", "Tangent", "variation of the direction of the fibre, per strand"),
    f("randomHue", 0, "Fibre properties/Randomize", "Dye hue", "variation of the hue of the dye, per strand"),
    f("randomSaturation", 0, "Fibre properties/Randomize", "Dye saturation", "variation of the saturation of the dye, per strand"),
    f("randomMelanin", 0.08, "Fibre properties/Randomize", "Melanin", "variation of melanin, per strand"),
    string("uparam", "uparamcoord", "Advanced", "U param", "no effect: parameters are evaluated at the UV of the curve"),
    string("vparam", "vparamcoord", "Advanced", "V param", "no effect: parameters are evaluated at the UV of the curve"),
    color("id1", 0, 0, 0, "IDs", "", "written to the AOV id_1 of camera rays"),
    color("id2", 0, 0, 0, "IDs", "", "written to the AOV id_2 of camera rays"),
    color("id3", 0, 0, 0, "IDs", "", "written to the AOV id_3 of camera rays"),
    color("id4", 0, 0, 0, "IDs", "", "written to the AOV id_4 of camera rays"),
    color("id5", 0, 0, 0, "IDs", "", "written to the AOV id_5 of camera rays"),
    color("id6", 0, 0, 0, "IDs", "", "written to the AOV id_6 of camera rays"),
    color("id7", 0, 0, 0, "IDs", "", "written to the AOV id_7 of camera rays"),
    color("id8", 0, 0, 0, "IDs", "", "written to the AOV id_8 of camera rays"),
    aov("aov_diffuse_color", "Diffuse color"),
    aov("aov_direct_diffuse", "Direct diffuse"),
    aov("aov_indirect_diffuse", "Indirect diffuse"),
    aov("aov_direct_local", "Direct local"),
    aov("aov_indirect_local", "Indirect local"),
    aov("aov_direct_global", "Direct global"),
    aov("aov_indirect_global", "Indirect global"),
    aov("aov_direct_specular", "Direct specular"),
    aov("aov_indirect_specular", "Indirect specular"),
    aov("aov_direct_specular_2", ""),
    aov("aov_indirect_specular_2", ""),
    aov("aov_direct_glint", ""),
    aov("aov_indirect_glint", ""),
    aov("aov_direct_transmission", ""),
    aov("aov_indirect_transmission", ""),
    aov("aov_depth", ""),
    aov("aov_light_group_1", "Light group [1]"),
    aov("aov_light_group_2", "Light group [2]"),
    aov("aov_light_group_3", "Light group [3]"),
    aov("aov_light_group_4", "Light group [4]"),
    aov("aov_light_group_5", "Light group [5]"),
    aov("aov_light_group_6", "Light group [6]"),
    aov("aov_light_group_7", "Light group [7]"),
    aov("aov_light_group_8", "Light group [8]"),
    aov("aov_light_group_9", "Light group [9]"),
    aov("aov_light_group_10", "Light group [10]"),
    aov("aov_light_group_11", "Light group [11]"),
    aov("aov_light_group_12", "Light group [12]"),
    aov("aov_light_group_13", "Light group [13]"),
    aov("aov_light_group_14", "Light group [14]"),
    aov("aov_light_group_15", "Light group [15]"),
    aov("aov_light_group_16", "Light group [16]"),
    aov("aov_id_1", "ID [1]"),
    aov("aov_id_2", "ID [2]"),
    aov("aov_id_3", "ID [3]"),
    aov("aov_id_4", "ID [4]"),
    aov("aov_id_5", "ID [5]"),
    aov("aov_id_6", "ID [6]"),
    aov("aov_id_7", "ID [7]"),
    aov("aov_id_8", "ID [8]"),
    string("crypto_asset_override", "", "AOVs", "Crypto asset override", "no effect: ids of objects are not written by materials"),
    string("crypto_object_override", "", "AOVs", "Crypto object override", "no effect: ids of objects are not written by materials"),
    string("crypto_material_override", "", "AOVs", "Crypto material override", "no effect: ids of objects are not written by materials"),
    aov("aov_crypto_asset", "Crypto Asset"),
    aov("aov_crypto_object", "Crypto Object"),
    aov("aov_crypto_material", "Crypto Material"),
    choice("fibreModel", "marschner|energy-conserving", "marschner", "Fibre properties", "Fibre model",
        "marschner: the lobes of Ou et al. 2012, as alShaders has them; energy-conserving: those of d'Eon, Marschner and Hanika 2011 with the near "
        "field of Chiang et al. 2016: what is not absorbed is scattered, and there is no diffuse part. Not in the original"),
};
// clang-format on
static_assert(kRows.size() == 91);

constexpr int index(std::string_view name) {
    for (size_t k = 0; k < kRows.size(); ++k)
        if (kRows[k].name == name) return static_cast<int>(k);
    return -1;
}
consteval int channel(std::string_view name) { return channel_of(kRows, name); }
inline constexpr int kGlobalsAt = channel_count(kRows);

}  // namespace alder::al_hair
