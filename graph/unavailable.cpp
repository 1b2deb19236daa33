// The one list of what is missing: node types of Blender 4.5 and alShaders that this version knows by name but does not have.
// A node leaves the list by being registered.
#include <algorithm>
#include <iterator>
#include <string_view>

#include "graph/document.h"

namespace alder {
namespace {

constexpr std::string_view kCatalogue[] = {
    // Blender, by bl_idname
    "ShaderNodeAddShader", "ShaderNodeAmbientOcclusion", "ShaderNodeAttribute", "ShaderNodeBackground", "ShaderNodeBevel",
    "ShaderNodeBlackbody", "ShaderNodeBrightContrast", "ShaderNodeBsdfAnisotropic", "ShaderNodeBsdfDiffuse", "ShaderNodeBsdfGlass",
    "ShaderNodeBsdfGlossy", "ShaderNodeBsdfHair", "ShaderNodeBsdfHairPrincipled", "ShaderNodeBsdfMetallic", "ShaderNodeBsdfPrincipled",
    "ShaderNodeBsdfRayPortal", "ShaderNodeBsdfRefraction", "ShaderNodeBsdfSheen", "ShaderNodeBsdfToon", "ShaderNodeBsdfTranslucent",
    "ShaderNodeBsdfTransparent", "ShaderNodeBsdfVelvet", "ShaderNodeBump", "ShaderNodeCameraData", "ShaderNodeClamp",
    "ShaderNodeCombineColor", "ShaderNodeCombineHSV", "ShaderNodeCombineRGB", "ShaderNodeCombineXYZ", "ShaderNodeCustomGroup",
    "ShaderNodeDisplacement", "ShaderNodeEeveeSpecular", "ShaderNodeEmission", "ShaderNodeFloatCurve", "ShaderNodeFresnel",
    "ShaderNodeGamma", "ShaderNodeHairInfo", "ShaderNodeHoldout", "ShaderNodeHueSaturation", "ShaderNodeInvert",
    "ShaderNodeLayerWeight", "ShaderNodeLightFalloff", "ShaderNodeLightPath", "ShaderNodeMapRange", "ShaderNodeMapping",
    "ShaderNodeMath", "ShaderNodeMix", "ShaderNodeMixRGB", "ShaderNodeMixShader", "ShaderNodeNewGeometry", "ShaderNodeNormal",
    "ShaderNodeNormalMap", "ShaderNodeObjectInfo", "ShaderNodeOutputAOV", "ShaderNodeOutputLight", "ShaderNodeOutputLineStyle",
    "ShaderNodeOutputMaterial", "ShaderNodeOutputWorld", "ShaderNodeParticleInfo", "ShaderNodePointInfo", "ShaderNodeRGB",
    "ShaderNodeRGBCurve", "ShaderNodeRGBToBW", "ShaderNodeScript", "ShaderNodeSeparateColor", "ShaderNodeSeparateHSV",
    "ShaderNodeSeparateRGB", "ShaderNodeSeparateXYZ", "ShaderNodeShaderToRGB", "ShaderNodeSqueeze",
    "ShaderNodeSubsurfaceScattering", "ShaderNodeTangent", "ShaderNodeTexBrick", "ShaderNodeTexChecker", "ShaderNodeTexCoord",
    "ShaderNodeTexEnvironment", "ShaderNodeTexGabor", "ShaderNodeTexGradient", "ShaderNodeTexIES", "ShaderNodeTexImage",
    "ShaderNodeTexMagic", "ShaderNodeTexNoise", "ShaderNodeTexPointDensity", "ShaderNodeTexSky",
    "ShaderNodeTexVoronoi", "ShaderNodeTexWave", "ShaderNodeTexWhiteNoise", "ShaderNodeUVAlongStroke", "ShaderNodeUVMap",
    "ShaderNodeValToRGB", "ShaderNodeValue", "ShaderNodeVectorCurve", "ShaderNodeVectorDisplacement", "ShaderNodeVectorMath",
    "ShaderNodeVectorRotate", "ShaderNodeVectorTransform", "ShaderNodeVertexColor", "ShaderNodeVolumeAbsorption",
    "ShaderNodeVolumeCoefficients", "ShaderNodeVolumeInfo", "ShaderNodeVolumePrincipled", "ShaderNodeVolumeScatter",
    "ShaderNodeWavelength", "ShaderNodeWireframe",
    // alShaders
    "alBlackbody", "alCache", "alCel", "alCellNoise", "alColorSpace", "alCombineColor", "alCombineFloat", "alCurvature", "alFlake",
    "alFlowNoise", "alFractal", "alFresnelConductor", "alGaborNoise", "alHair", "alImage", "alInputScalar", "alInputVector",
    "alJitterColor", "alLayer", "alLayerColor", "alLayerFloat", "alMeasured", "alPattern", "alRemapColor", "alRemapFloat",
    "alSurface", "alSwitchColor", "alSwitchFloat", "alTriplanar", "alWriteIds", "cryptomatte_aov", "cryptomatte_filter", "driver_ids",
};

}  // namespace

bool is_known_but_unavailable(const std::string& type) {
    return !find_node(type) && std::find(std::begin(kCatalogue), std::end(kCatalogue), type) != std::end(kCatalogue);
}

std::vector<std::string> unavailable_nodes() {
    std::vector<std::string> list;
    for (auto name : kCatalogue)
        if (!find_node(name)) list.emplace_back(name);
    return list;
}

}  // namespace alder
