// LiveRender: a render that never ends: it follows edits, shows something at once at a part of the resolution, refines, and
// sleeps when nobody looks.
//
// A thread of its own renders; edits and readers come from others. One lock guards what they share; it is never held while
// rendering, encoding or writing to a client. The newest edit wins: those that come before a picture shows are shown together.
#pragma once
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/jobs/gate.h"
#include "server/live/frame.h"

namespace alder {
class Metrics;
}

namespace alder::live {

/// Passes of several live renders take turns: first pictures before refinements, else who came first.
class Turns {
  public:
    explicit Turns(jobs::Gate* gate = nullptr) : gate_(gate) {}
    void take(bool urgent);
    void give();

  private:
    std::mutex mutex_;
    std::condition_variable freed_;
    uint64_t next_ = 0;
    std::deque<uint64_t> urgent_, patient_;
    bool busy_ = false;
    jobs::Gate* gate_;
    std::optional<jobs::Gate::Hold> hold_;   ///< while the one whose turn it is makes a first picture
};

struct LiveSettings {
    int width = 256, height = 256;
    int max_samples = 1024;
    uint32_t seed = 0;
    std::vector<std::string> aovs;
    int threads = 0;
};

/// What is rendered, and what it is called in answers.
struct LiveSource {
    std::shared_ptr<const PreparedScene> scene;
    std::string revision;
};

struct Event {
    uint64_t number = 0;
    std::string type;   ///< state, progress, image, end
    nlohmann::json data;
};

class LiveRender {
  public:
    LiveRender(std::string id, LiveSource source, LiveSettings settings, Turns& turns, Metrics& metrics);
    ~LiveRender();

    const std::string& id() const { return id_; }
    /// Renders this from now on. The pass under way stops within a stage of a tile, once the edit before it has been shown.
    void edit(LiveSource source, const std::string& token);
    void change(const LiveSettings& settings, const std::string& token);
    /// Shows at once what there is with other weights. False where nothing is there yet: the next picture has them.
    bool mix(const Mix& mix, const std::string& token);
    void pause(bool paused);
    /// Ends it and all its streams; `state` is its last word.
    void close(const std::string& state);

    LiveSettings settings() const;
    Mix current_mix() const;
    std::shared_ptr<const PreparedScene> scene() const;
    bool closed() const;
    bool has_readers() const;
    nlohmann::json document() const;
    RenderStats stats() const;

    /// Someone who looks: while there is one, it does not sleep.
    class Reader {
      public:
        explicit Reader(std::shared_ptr<LiveRender> render);
        ~Reader();
        Reader(const Reader&) = delete;
        Reader& operator=(const Reader&) = delete;

      private:
        std::shared_ptr<LiveRender> render_;
    };
    /// The newest picture later than `after`, or null when none came within `seconds` or the render was closed.
    std::shared_ptr<const Frame> next_frame(uint64_t after, double seconds);
    /// Edits first shown in the pictures after `after`, up to `until`.
    std::vector<std::string> edits_between(uint64_t after, uint64_t until) const;
    /// Events later than `after`, waiting for one at most `seconds`. Where some before them are gone already, a state event
    /// with everything comes first.
    std::vector<Event> next_events(uint64_t after, double seconds);
    /// Everything as it is now, as a state event.
    Event state_event() const;

  private:
    void run();
    void step();
    bool has_work() const;
    bool is_awake() const;
    std::string state() const;
    void publish(std::shared_ptr<const FilmPicture> film, int divisor, uint64_t version);
    void push(std::string type, nlohmann::json data);
    nlohmann::json document_locked() const;
    void say_state();
    int first_divisor() const;
    int next_divisor(int divisor) const;
    double predicted_seconds(int divisor) const;

    const std::string id_;
    Turns& turns_;
    Metrics& metrics_;
    mutable std::mutex mutex_;
    std::condition_variable work_, news_;

    // what is wanted
    LiveSource source_;
    LiveSettings settings_;
    Mix mix_;
    uint64_t version_ = 1;
    bool dirty_ = true, shown_ = false, paused_ = false, failed_ = false;
    std::vector<std::string> pending_;   ///< edits not yet shown
    std::chrono::steady_clock::time_point edited_;
    std::string closed_state_, problem_;
    std::atomic<bool> cancel_{false};

    // who looks
    int readers_ = 0;
    std::chrono::steady_clock::time_point last_read_;

    // what is there
    std::shared_ptr<const Frame> frame_;
    struct ShownEdit {
        uint64_t picture, event;   ///< numbers of those that showed it first
        std::string token;
    };
    std::deque<ShownEdit> shown_edits_;
    std::deque<Event> events_;
    uint64_t last_event_ = 0, first_whole_event_ = 1;   ///< before the latter, events have been dropped
    std::chrono::steady_clock::time_point last_progress_;
    std::string said_state_;
    RenderStats total_;

    // of the rendering thread
    std::unique_ptr<ProgressiveRender> film_;
    LiveSource film_source_;
    LiveSettings film_settings_;
    uint64_t film_version_ = 0, film_done_ = 0;
    int divisor_ = 1;
    double seconds_per_pixel_ = 0;
    std::thread thread_;
};

}  // namespace alder::live
