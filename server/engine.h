// Engine: the daemon's view of the renderer. Finds compiled materials and prepared stages again, and decides which files a
// document may name.
#pragma once
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "graph/material.h"
#include "render/render.h"
#include "server/assets.h"

namespace alder {

class Engine {
  public:
    Engine(AssetStore& assets, std::vector<std::string> asset_roots, int threads);

    /// Compiles a graph, or finds it. `prefix` leads the pointers of faults. Throws graph-invalid, or asset-missing with all
    /// of them; warnings are left in `d`. `strict`: files that are missing or broken are errors.
    std::shared_ptr<const Material> material(const nlohmann::json& graph, const std::string& prefix, bool lenient, Diagnostics& d, bool strict = false);
    /// A preview stage wearing the material: geometry and BVH are built once a stage, a warm call costs no more than lights
    /// and programs of the material. Throws graph-invalid or settings-invalid.
    std::shared_ptr<const PreparedScene> stage(const std::string& name, std::shared_ptr<const Material> material, Diagnostics& d);
    /// Builds what the first preview needs.
    void warm_up();
    const EvalContext& context() const { return context_; }
    MaterialCache& materials() { return materials_; }
    int threads() const { return threads_; }

    /// What a graph's image value may be read from: an asset, or a file below an asset root. Empty and a reason where it may
    /// not; digests that are not in the store are added to `missing`.
    std::string resolve(const nlohmann::json& image, std::string& error, std::vector<std::string>* missing) const;
    /// A relative name below one of the asset roots, with no symbolic link on the way; empty where there is none.
    std::string resolve_file(const std::string& name, std::string& error) const;
    bool serves_files() const { return !asset_roots_.empty(); }

  private:
    std::shared_ptr<const PreparedScene> base_stage(const std::string& name, Diagnostics& d);

    AssetStore& assets_;
    std::vector<std::string> asset_roots_;
    int threads_;
    EvalContext context_;
    MaterialCache materials_;
    struct BaseStage {
        std::mutex building;   ///< who comes second waits instead of building again
        std::shared_ptr<const PreparedScene> scene;
    };
    std::mutex stages_mutex_;
    std::map<std::string, std::shared_ptr<BaseStage>> stages_;
    struct Dressed {
        std::string stage;
        std::shared_ptr<const Material> material;
        std::shared_ptr<const PreparedScene> scene;
    };
    std::list<Dressed> dressed_;   ///< most recent first
};

/// Throws asset-missing with the digests listed.
[[noreturn]] void throw_missing(const std::vector<std::string>& missing);

}  // namespace alder
