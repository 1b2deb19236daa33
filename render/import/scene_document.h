// Scene documents: JSON (with buffers beside it or in one .alder container) -> Scene, and back. The layout is described in
// docs/scene-document.md.
//
//   Diagnostics d;
//   auto scene = load_scene("shot.alder", {}, d);      // .alder, .json, .glb, .gltf
//   if (!scene) for (auto& e : d.errors) print(e.line());
#pragma once
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "render/import/arrays.h"
#include "render/scene.h"

namespace alder {

struct SceneLimits {
    uint64_t array_bytes = uint64_t(16) << 30;   ///< of all arrays together, as held in memory
    uint64_t document_bytes = uint64_t(256) << 20;
    size_t instances = 10'000'000, materials = 65536, lights = 1'000'000, meshes = 1'000'000;
};

struct SceneLoadOptions {
    bool lenient = false;               ///< unknown members and parameters are warnings
    std::string pointer_prefix;         ///< prepended to every JSON Pointer
    SceneLimits limits;
    MaterialCache* cache = nullptr;     ///< graphs that did not change are not compiled again
    /// Buffers of a document without a container: assets by digest, files below a root. Not set: load_scene() reads files
    /// beside the document, scene_from_json() has none.
    BufferReader read_buffer;
    /// As MaterialOptions::resolve_image. Not set: load_scene() takes members of the container, else files beside the document.
    std::function<std::string(const nlohmann::json& image, std::string& error)> resolve_image;
    /// A revision to take meshes from where the document says the same about them: a shading edit then shares all geometry.
    const Scene* previous = nullptr;
    const nlohmann::json* previous_document = nullptr;
    /// Graphs by material name that replace what the file says (glTF: posted graphs).
    std::map<std::string, nlohmann::json> material_overrides;
};

/// Null where the document has errors; all of them (up to kMaxDiagnostics) are in `d`.
std::shared_ptr<const Scene> scene_from_json(const nlohmann::json& document, const SceneLoadOptions& options, Diagnostics& d);

/// By the file's extension.
std::shared_ptr<const Scene> load_scene(const std::string& path, const SceneLoadOptions& options, Diagnostics& d);

/// The document inside a file (of a .glb or .gltf: the one it is imported as), for editing and for the daemon.
/// Buffers it names are read through the reader that comes back in `buffers`.
struct SceneSource {
    nlohmann::json document;
    BufferReader read_buffer;
    std::function<std::string(const nlohmann::json& image, std::string& error)> resolve_image;
};
bool open_scene(const std::string& path, const SceneLoadOptions& options, SceneSource& source, Diagnostics& d);

/// Scene -> document. Arrays of more than a few numbers go to `buffer` (offsets in it are written), others stay in the JSON.
nlohmann::json scene_to_json(const Scene& scene, const std::string& buffer_name, std::vector<uint8_t>& buffer);
/// As one .alder container.
bool write_scene(const std::string& path, const Scene& scene, std::string& error);

}  // namespace alder
