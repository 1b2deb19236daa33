// Scenes: revisions by identifier. A revision is immutable and on disk before it is acknowledged; what the renderer made of it
// (meshes, BVH, programs) is kept for the scenes used last and made again when needed.
#pragma once
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "render/render.h"
#include "server/engine.h"

namespace alder {

struct SceneRevision {
    std::string id;
    uint64_t revision = 1;
    std::string etag;                                ///< "\"9\"": of the whole scene
    nlohmann::json source;                           ///< {"container": digest} or {"document": scene document}
    std::map<std::string, nlohmann::json> materials; ///< graphs edited since, by name
    std::vector<std::string> assets;                 ///< every digest it refers to
};

/// What a revision consists of, as it is stored: {"revision", "source", "materials"}.
nlohmann::json to_json(const SceneRevision& scene);
/// Null where it is not one.
std::shared_ptr<SceneRevision> revision_from_json(const std::string& id, const nlohmann::json& json);

/// What the renderer made of one revision.
struct LoadedScene {
    std::shared_ptr<const Scene> scene;
    std::shared_ptr<const PreparedScene> prepared;
    size_t material_index(const std::string& name) const;   ///< scene->materials.size() where there is none
};

class SceneStore {
  public:
    explicit SceneStore(std::string folder);
    const std::string& error() const { return error_; }

    /// Loads and checks everything, then keeps it. Throws scene-invalid or asset-missing.
    std::shared_ptr<const SceneRevision> create(Engine& engine, AssetStore& assets, nlohmann::json source, bool lenient, Diagnostics& d);
    /// Throws not-found.
    std::shared_ptr<const SceneRevision> get(const std::string& id);
    void remove(const std::string& id);
    std::shared_ptr<const LoadedScene> load(Engine& engine, AssetStore& assets, const SceneRevision& scene, Diagnostics& d);

    struct Edit {
        std::shared_ptr<const SceneRevision> scene;
        std::string rebuild;   ///< none, shading, lights, instances, geometry
        nlohmann::json graph;
        std::vector<std::string> changed;   ///< "instances/ball", "cameras/cam"
        std::shared_ptr<const LoadedScene> before, after;
    };
    /// Replaces one graph by what `edit` makes of it. It is called while no other edit of the scene can come between, and
    /// throws where the edit may not go on.
    Edit edit_material(Engine& engine, AssetStore& assets, const std::string& id, const std::string& name, bool lenient,
                       const std::function<nlohmann::json(const nlohmann::json& current)>& edit, Diagnostics& d);
    /// Replaces the document, graphs edited since included, by what `edit` makes of it. What the edit leaves alone is not built
    /// again: meshes with their BVHs, programs, lights, the world.
    Edit edit_document(Engine& engine, AssetStore& assets, const std::string& id, bool lenient,
                       const std::function<nlohmann::json(const nlohmann::json& current, const SceneRevision& scene)>& edit, Diagnostics& d);
    /// The scene with one material replaced, for a preview; nothing is kept of it.
    std::shared_ptr<const PreparedScene> with_graph(Engine& engine, AssetStore& assets, const SceneRevision& scene, const std::string& name,
                                                    std::shared_ptr<const Material> material, Diagnostics& d);
    /// A scene that refers to the digest; empty where none does.
    std::string user_of(const std::string& digest);

  private:
    std::string path(const std::string& id) const;
    void keep(const std::shared_ptr<const SceneRevision>& scene);
    void remember(const SceneRevision& scene, std::shared_ptr<const LoadedScene> loaded);
    std::shared_ptr<std::mutex> edit_mutex(const std::string& id);

    std::string folder_, error_;
    std::mutex mutex_;
    std::map<std::string, std::shared_ptr<const SceneRevision>> known_;
    std::map<std::string, std::weak_ptr<std::mutex>> edits_;
    struct Loaded {
        std::string id, etag;
        std::shared_ptr<const LoadedScene> scene;
    };
    std::list<Loaded> loaded_;   ///< most recent first
    bool all_known_ = false;     ///< every file of the folder has been read
};

}  // namespace alder
