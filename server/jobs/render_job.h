// Rendering one job: its frames one after the other, with checkpoints, until done or asked to stop. Runs in the worker.
#pragma once
#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>

#include <nlohmann/json.hpp>

#include "server/assets.h"
#include "server/engine.h"
#include "server/jobs/files.h"
#include "server/jobs/settings.h"
#include "server/scenes.h"

namespace alder {
class ProgressiveRender;
}

namespace alder::jobs {

/// What lasts from job to job.
struct WorkerContext {
    std::string data;
    AssetStore& assets;
    Engine& engine;
    SceneStore& scenes;
    double checkpoint_seconds = 30;
    double checkpoint_fraction = 0.1;
    std::function<bool(const nlohmann::json&)> send;
};

class RenderJob {
  public:
    RenderJob(WorkerContext& context, const nlohmann::json& order);
    /// Renders; tells what happens by context.send. Throws only std::bad_alloc and what nobody expects.
    void run();
    /// From another thread: stop soon.
    void stop(const std::string& how);
    /// From another thread: write a picture of what there is at the next chance.
    void want_snapshot(int64_t ticket);
    const std::string& id() const { return id_; }

  private:
    struct Stopped {};        ///< run() ends with "stopped"
    struct NoSpace {          ///< ... with "paused", disk-full
        uint64_t bytes;       ///< that did not fit
    };
    struct Failed {
        std::string type, detail;
        nlohmann::json errors = nlohmann::json::array();
    };
    using Clock = std::chrono::steady_clock;

    void prepare();
    void render_frame(int frame);
    void resume(ProgressiveRender& r, int frame);
    void put_away(const ProgressiveRender& r, int frame, bool durable);
    void write_output(ProgressiveRender& r, int frame, bool complete);
    void answer_snapshot(const ProgressiveRender* r);
    void tell(const char* is, nlohmann::json more);
    void tell_progress(double samples, double total, double error, bool now);
    void state(const char* name);
    void log(const char* level, const std::string& text) const;

    WorkerContext& context_;
    std::string id_, snapshot_;
    JobSettings settings_;
    nlohmann::json request_, done_;
    RenderFolder folder_;
    std::shared_ptr<const PreparedScene> prepared_;
    uint32_t scene_seed_ = 0;
    size_t frames_done_ = 0;
    double elapsed_ = 0;                 ///< of the frame, over all attempts, in seconds of rendering
    nlohmann::json timings_ = nlohmann::json::object();
    nlohmann::json stats_;
    Clock::time_point begun_ = Clock::now(), last_checkpoint_, last_progress_;
    double first_image_ = 0, render_seconds_ = 0;

    std::atomic<bool> cancel_{false};
    std::mutex mutex_;
    std::string how_;                    ///< of the stop
    std::vector<int64_t> tickets_;
};

}  // namespace alder::jobs
