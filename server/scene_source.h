// Where a scene comes from: a scene document, or a container in the asset store.
#pragma once
#include <memory>

#include <nlohmann/json.hpp>

#include "render/scene.h"
#include "server/assets.h"
#include "server/engine.h"

namespace alder {

/// {"container": digest} or {"document": scene document}. Null where it cannot be used (every fault is in `d`).
std::shared_ptr<const Scene> load_scene_source(Engine& engine, AssetStore& assets, const nlohmann::json& source, bool lenient, Diagnostics& d);

}  // namespace alder
