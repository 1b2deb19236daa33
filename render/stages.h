// Preview stages: ready-made scenes that show one material well.
//
//   auto stage = make_stage("shaderball", material, 256, diagnostics);
#pragma once
#include <memory>
#include <string_view>
#include <vector>

#include "render/scene.h"

namespace alder {

/// "shaderball", "sphere" or "plane". `material` becomes material 0, which the subject wears; null = a grey Principled one.
/// Meshes, floor and light graphs are made once in a process and shared by all stages. Light groups: key 1, fill 2, rim 3.
/// "cloth", "hair" and "volume" are not available yet: an error that says so, and null. Pointer: "/stage".
std::shared_ptr<const Scene> make_stage(std::string_view name, std::shared_ptr<const Material> material, int size, Diagnostics& d);
/// The same; null without the reasons.
std::shared_ptr<const Scene> make_stage(std::string_view name, std::shared_ptr<const Material> material, int size);
/// Names that make_stage accepts.
std::vector<std::string_view> stage_names();

}  // namespace alder
