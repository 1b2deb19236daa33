// Live renders by identifier, and what routes need to edit them.
#pragma once
#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "server/http/message.h"
#include "server/live/live_render.h"

namespace alder::live {

/// One live render with the document it is edited through.
struct LiveEntry {
    std::shared_ptr<LiveRender> render;
    std::string user;
    std::string scene;      ///< id of the scene it follows; empty where it has a stage
    std::string stage;
    std::mutex edit_mutex;  ///< edits of the graph come one after the other; guards the rest
    nlohmann::json graph;
    bool lenient = false;
    std::atomic<int64_t> used_at{0};   ///< seconds of the steady clock, when a request last named it
};

class LiveStore {
  public:
    /// `gate`: null, or what is held while a first picture is made.
    explicit LiveStore(Metrics& metrics, jobs::Gate* gate = nullptr);

    /// Throws queue-full where there are too many.
    std::shared_ptr<LiveEntry> add(std::shared_ptr<LiveEntry> entry, LiveSource source, const LiveSettings& settings);
    std::shared_ptr<LiveEntry> find(const std::string& id);
    void remove(const std::string& id);
    void scene_changed(const std::string& scene, const LiveSource& source, const std::string& token);
    /// Ends all of them and their streams.
    void stop();
    bool stopping() const { return stopping_; }
    size_t size() const;
    int streams() const { return streams_; }
    /// Of event ids: names this process.
    const std::string& epoch() const { return epoch_; }

    /// Counts a stream while it lives; throws queue-full where there are too many.
    class Stream {
      public:
        explicit Stream(LiveStore& store);
        ~Stream();
        Stream(const Stream&) = delete;
        Stream& operator=(const Stream&) = delete;

      private:
        LiveStore& store_;
    };

  private:
    Metrics& metrics_;
    Turns turns_;
    std::string epoch_;
    mutable std::mutex mutex_;
    std::map<std::string, std::shared_ptr<LiveEntry>> entries_;
    std::atomic<int> streams_{0};
    std::atomic<bool> stopping_{false};
};

/// The Alder-Edit-Id of a request, or nothing; throws malformed-request where it is not 1 to 64 printable characters.
std::string edit_token(const http::Request& request);
/// `current` with the body applied: a JSON Patch (RFC 6902) where the Content-Type says so, else a merge patch (RFC 7396).
nlohmann::json patched(const http::Request& request, nlohmann::json current, const nlohmann::json& body);
/// What two prepared scenes share.
nlohmann::json reused(const PreparedScene& before, const PreparedScene& after);

}  // namespace alder::live
