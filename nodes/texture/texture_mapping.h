// The placement built into Blender's texture nodes (`texture_mapping`): move, turn, scale and swap axes of Vector before the
// texture reads it. Parsed once at compile time into a 3x4 matrix.
#pragma once
#include <string>
#include <vector>

#include "nodes/schema.h"

namespace alder {

struct TextureMapping {
    bool active = false;     ///< false: the identity, nothing to do
    bool normalize = false;  ///< vector type NORMAL: to unit length after the matrix
    float matrix[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
};

/// What every texture node prepares at least; nodes with images derive from it.
struct PreparedTexture : Prepared {
    TextureMapping mapping;
};

/// Reads the structure (JSON text; null is the identity). Faults are appended to `errors`.
TextureMapping parse_texture_mapping(const std::string& json, std::vector<std::string>& errors);

/// The parameter, for every texture node's schema.
Param texture_mapping_param();
/// Blender's colour mapping of texture nodes, which Cycles does not read: accepted.
Param color_mapping_param();

/// NodeType::prepare of nodes that need nothing but the mapping: null where it is the identity.
std::shared_ptr<const Prepared> prepare_texture_mapping(const Statics& statics, std::vector<std::string>& errors);

}  // namespace alder
