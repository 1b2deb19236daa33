// Upgrade of graph documents with nodes, sockets and settings of older Blender versions to those of Blender 4.5.
#pragma once
#include <nlohmann/json.hpp>
#include <optional>

namespace alder {

/// The document with what is old replaced, as Blender's own file versioning does it; nothing where there is nothing old. Faulty
/// documents pass through: validation comes after.
///
/// A document says by "blender_version": [3, 6] (or "3.6") that all of it is of that version; without it, what is old is known by
/// its names, so that settings whose meaning changed under the same name are taken as Blender 4.5's.
std::optional<nlohmann::json> upgraded_document(const nlohmann::json& document);

/// The steps, each in a file of its own.
namespace upgrade {
class Tree;
void musgrave(Tree& tree, const std::string& name);    ///< to Noise and Math nodes (4.1)
void principled(Tree& tree, const std::string& name);  ///< sockets of 3.x (4.0)
}  // namespace upgrade

}  // namespace alder
