// Light Path: what kind of ray sees the shading point, how long it is and how many bounces lie before it (Blender's node).
#include "graph/lowering.h"
#include "nodes/schema.h"

namespace alder {

struct LightPathRow {
    const char* output;
    Global global;
};
static constexpr LightPathRow kLightPath[] = {
    {"Is Camera Ray", Global::IsCameraRay},
    {"Is Shadow Ray", Global::IsShadowRay},
    {"Is Diffuse Ray", Global::IsDiffuseRay},
    {"Is Glossy Ray", Global::IsGlossyRay},
    {"Is Singular Ray", Global::IsSingularRay},
    {"Is Reflection Ray", Global::IsReflectionRay},
    {"Is Transmission Ray", Global::IsTransmissionRay},
    {"Is Volume Scatter Ray", Global::IsVolumeRay},
    {"Ray Length", Global::RayLength},
    {"Ray Depth", Global::RayDepth},
    {"Diffuse Depth", Global::DiffuseDepth},
    {"Glossy Depth", Global::GlossyDepth},
    {"Transparent Depth", Global::TransparentDepth},
    {"Transmission Depth", Global::TransmissionDepth}};

ALDER_NODE {
    NodeType n;
    n.name = "ShaderNodeLightPath";
    n.category = "Input";
    n.summary = "what kind of ray sees the shading point, its length and depth";
    n.help = "Kinds are 0 or 1. The background counts as one bounce further.";
    n.aliases = {"light_path"};
    for (const LightPathRow& row : kLightPath) n.outputs.push_back({row.output, Type::Float});
    n.lower = [](Lowering& l, int output) { l.result(l.global(kLightPath[output].global)); };
    return n;
}

}  // namespace alder
