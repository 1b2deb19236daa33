// Where a scene comes from: a scene document, or a container in the asset store.
#pragma once
#include <memory>

#include <nlohmann/json.hpp>

#include "render/scene.h"
#include "server/assets.h"
#include "server/engine.h"

namespace alder {

/// The scene before an edit: what both documents say the same of is its.
struct SceneBefore {
    const Scene& scene;
    const nlohmann::json& document;
};
/// {"container": digest}, {"document": scene document}, or both: a document that names buffers and images of the container.
/// Null where it cannot be used (every fault is in `d`).
std::shared_ptr<const Scene> load_scene_source(Engine& engine, AssetStore& assets, const nlohmann::json& source, bool lenient, Diagnostics& d, const SceneBefore* before = nullptr);
/// The source's document, that of the container where it has none of its own. Throws scene-invalid.
nlohmann::json document_of_source(Engine& engine, AssetStore& assets, const nlohmann::json& source);

}  // namespace alder
