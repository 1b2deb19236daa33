// Service: what the routes share. Owns the stores, the caches and the lanes on which the engine works.
#pragma once
#include <atomic>
#include <functional>
#include <string>

#include <nlohmann/json.hpp>

#include "server/access.h"
#include "server/assets.h"
#include "server/engine.h"
#include "server/errors.h"
#include "server/http/message.h"
#include "server/jobs/queue.h"
#include "server/lane.h"
#include "server/live/live_store.h"
#include "server/metrics.h"
#include "server/options.h"
#include "server/result_cache.h"
#include "server/scenes.h"

namespace alder {

class Service {
  public:
    explicit Service(const ServiceOptions& options);
    ~Service();

    /// Answers one request: access, route, work, errors, metrics, log. Never throws.
    http::Response handle(http::Request& request);

    /// The body as JSON, or a Problem. A scene document may be longer than other bodies.
    nlohmann::json read_json(http::Request& request, bool is_scene = false);
    /// Runs `work` on a lane and waits for it, at most `seconds` where that is > 0; cancels it when the client leaves, the
    /// time is over, or the daemon stops. Problems and exceptions thrown by `work` come out here.
    void run(Lane& lane, http::Request& request, double seconds, const std::function<void(const std::atomic<bool>& cancel)>& work);

    /// Adds a finished render to the counters.
    void count_render(const RenderStats& stats);

    ServiceOptions options;
    Access access;
    AssetStore assets;
    Metrics metrics;
    Engine engine;
    SceneStore scenes;
    ResultCache results;
    jobs::JobQueue renders;
    Lane compile_lane, preview_lane;
    live::LiveStore live;
    std::atomic<bool> draining{false};

  private:
    http::Response route(http::Request& request);
    void watch_textures();
    std::atomic<size_t> buffered_bytes_{0};   ///< of bodies being read, over all connections
};

/// A JSON answer, one line.
http::Response json_response(int status, const nlohmann::json& value);
/// An answer that never changes while the process lives, with a tag.
http::Response constant_json(http::Request& request, const nlohmann::json& value);

}  // namespace alder
