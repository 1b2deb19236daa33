// Preview stages: ready-made scenes that show one material well.
//
//   auto stage = make_stage("shaderball", material, 256, diagnostics);
#pragma once
#include <memory>
#include <string_view>
#include <vector>

#include "render/scene.h"

namespace alder {

/// "shaderball", "sphere", "plane", "cloth", "hair" (curves) or "volume" (a block for what fills it). `material` becomes material 0,
/// which the subject wears; null = one that suits the stage. Meshes, floor and light graphs are made once in a process and shared.
/// Light groups: key 1, fill 2, rim 3. An unknown name is an error at "/stage", and null.
std::shared_ptr<const Scene> make_stage(std::string_view name, std::shared_ptr<const Material> material, int size, Diagnostics& d);
/// The same; null without the reasons.
std::shared_ptr<const Scene> make_stage(std::string_view name, std::shared_ptr<const Material> material, int size);
/// Names that make_stage accepts.
std::vector<std::string_view> stage_names();

}  // namespace alder
