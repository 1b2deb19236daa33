// glTF 2.0 (.glb, .gltf) as a scene document: meshes, nodes, cameras, lights and materials, turned to Z up as Blender does.
//
// Materials become graphs with one Principled BSDF, named as in the file, so that graphs posted under the same name replace
// them. Extensions: KHR_lights_punctual, KHR_texture_transform, KHR_mesh_quantization, EXT_mesh_gpu_instancing and of
// KHR_materials_*: anisotropy, clearcoat, emissive_strength, ior, sheen, specular, transmission, unlit. Other required
// extensions are errors; animation, skins and morph targets are left out with a warning.
#pragma once
#include <span>
#include <string>

#include "render/import/scene_document.h"

namespace alder {

/// A .glb file. External files it names are taken from `folder`, never from outside it.
bool import_glb(std::span<const uint8_t> bytes, const std::string& folder, const SceneLoadOptions& options, SceneSource& source, Diagnostics& d);
/// A parsed .gltf document; `source` comes with readers for the files beside it.
bool import_gltf(const nlohmann::json& gltf, const SceneLoadOptions& options, SceneSource& source, Diagnostics& d);

}  // namespace alder
