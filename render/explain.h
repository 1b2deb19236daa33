// Explain: what each node of a material makes of one pixel: inputs, outputs, the closures that came of it, and which nodes are
// never run and why.
#pragma once
#include <nlohmann/json.hpp>

namespace alder {

class PreparedScene;

/// Of the surface first hit by the ray through the middle of the pixel, as the camera sees it at this resolution:
/// {"hit", "object", "material", "primitive", "P", "N", "uv"?, "distance", "nodes": {NAME: {"type", "inputs", "outputs"}},
///  "closures": [{"node", "closure", "weight"}], "skipped": [TEXT]}; {"hit": false} where it meets nothing.
nlohmann::json explain_pixel(const PreparedScene& scene, int width, int height, int x, int y);

}  // namespace alder
