// LiveRender: a render that never ends.
#include "server/live/live_render.h"

#include <algorithm>

#include <fmt/format.h>

#include "render/prepared_scene.h"
#include "server/log.h"
#include "server/metrics.h"

namespace alder::live {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double kFirstSeconds = 0.012;     // what the first picture after an edit may take
constexpr double kJumpSeconds = 0.08;       // full resolution comes next where it takes no longer
constexpr double kPassSeconds = 0.2;        // of a refinement: others take turns
constexpr double kSleepSeconds = 30;        // without a reader
constexpr double kProgressSeconds = 0.25;
constexpr size_t kEventsMost = 256, kEditsMost = 256;
constexpr int kCoarsest = 8;

double since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }
Clock::duration span(double seconds) { return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds)); }

}  // namespace

void Turns::take(bool urgent) {
    std::unique_lock lock(mutex_);
    const uint64_t ticket = next_++;
    (urgent ? urgent_ : patient_).push_back(ticket);
    freed_.wait(lock, [&] { return !busy_ && (urgent_.empty() ? patient_ : urgent_).front() == ticket; });
    (urgent ? urgent_ : patient_).pop_front();
    busy_ = true;
    if (urgent) hold_.emplace(gate_);
}

void Turns::give() {
    const std::lock_guard lock(mutex_);
    hold_.reset();
    busy_ = false;
    freed_.notify_all();
}

LiveRender::LiveRender(std::string id, LiveSource source, LiveSettings settings, Turns& turns, Metrics& metrics)
    : id_(std::move(id)), turns_(turns), metrics_(metrics), source_(std::move(source)), settings_(std::move(settings)),
      edited_(Clock::now()), last_read_(Clock::now()), last_progress_(Clock::now() - span(10)) {
    say_state();
    thread_ = std::thread([this] { run(); });
}

LiveRender::~LiveRender() {
    close("cancelled");
    thread_.join();
}

void LiveRender::edit(LiveSource source, const std::string& token) {
    const std::lock_guard lock(mutex_);
    source_ = std::move(source);
    ++version_;
    edited_ = Clock::now();
    if (!token.empty() && pending_.size() < kEditsMost) pending_.push_back(token);
    // An edit that interrupts the first picture of the one before would, while a slider moves, let none ever show.
    if (shown_) cancel_ = true;
    dirty_ = true;
    failed_ = false;
    work_.notify_all();
}

void LiveRender::change(const LiveSettings& settings, const std::string& token) {
    LiveSource same;
    {
        const std::lock_guard lock(mutex_);
        settings_ = settings;
        same = source_;
        shown_ = true;   // a picture of another size or with other layers is no step towards this one
    }
    edit(std::move(same), token);
}

bool LiveRender::mix(const Mix& mix, const std::string& token) {
    const std::lock_guard lock(mutex_);
    mix_ = mix;
    if (!token.empty() && pending_.size() < kEditsMost) pending_.push_back(token);
    if (!frame_) return false;
    publish(frame_->film, frame_->divisor, frame_->version);
    return true;
}

void LiveRender::pause(bool paused) {
    const std::lock_guard lock(mutex_);
    paused_ = paused;
    if (paused) cancel_ = true;
    work_.notify_all();
    say_state();
}

void LiveRender::close(const std::string& state) {
    const std::lock_guard lock(mutex_);
    if (!closed_state_.empty()) return;
    closed_state_ = state;
    cancel_ = true;
    say_state();
    push("end", {{"state", state}});
    work_.notify_all();
    news_.notify_all();
}

LiveSettings LiveRender::settings() const {
    const std::lock_guard lock(mutex_);
    return settings_;
}
Mix LiveRender::current_mix() const {
    const std::lock_guard lock(mutex_);
    return mix_;
}
std::shared_ptr<const PreparedScene> LiveRender::scene() const {
    const std::lock_guard lock(mutex_);
    return source_.scene;
}
bool LiveRender::closed() const {
    const std::lock_guard lock(mutex_);
    return !closed_state_.empty();
}
bool LiveRender::has_readers() const {
    const std::lock_guard lock(mutex_);
    return readers_ > 0;
}
nlohmann::json LiveRender::document() const {
    const std::lock_guard lock(mutex_);
    return document_locked();
}
RenderStats LiveRender::stats() const {
    const std::lock_guard lock(mutex_);
    return total_;
}

bool LiveRender::is_awake() const { return readers_ > 0 || since(last_read_) < kSleepSeconds; }

bool LiveRender::has_work() const {
    if (paused_ || failed_ || !is_awake()) return false;
    return dirty_ || !frame_ || divisor_ > 1 || film_done_ < static_cast<uint64_t>(settings_.max_samples);
}

std::string LiveRender::state() const {
    if (!closed_state_.empty()) return closed_state_;
    if (failed_) return "failed";
    return has_work() ? "rendering" : "paused";
}

nlohmann::json LiveRender::document_locked() const {
    const std::string s = state();
    nlohmann::json reason;
    if (s == "paused") reason = paused_ ? "asked" : !is_awake() ? "no-reader" : "max-samples";
    if (s == "failed") reason = problem_;
    nlohmann::json groups = nlohmann::json::object();
    for (const int g : used_groups(*source_.scene->scene)) {
        nlohmann::json lights = nlohmann::json::array();
        for (const Light& l : source_.scene->scene->lights)
            if (l.light_group == g) lights.push_back(l.name);
        const Vec3f w = mix_.weight[g];
        groups[group_name(g).substr(12)] = {{"lights", std::move(lights)}, {"weight", {w.x, w.y, w.z}}};
    }
    nlohmann::json layers = nlohmann::json::array();
    if (frame_)
        for (const std::string& name : frame_->film->aovs().names()) layers.push_back(name.empty() ? "rgba" : name);
    const std::string at = "/v1/renders/" + id_;
    return {{"id", id_},
            {"mode", "live"},
            {"state", s},
            {"reason", reason},
            {"etag", fmt::format("\"{}\"", version_)},
            {"revision", source_.revision},
            {"resolution", {settings_.width, settings_.height}},
            {"aovs", settings_.aovs},
            {"layers", std::move(layers)},
            {"light_groups", std::move(groups)},
            {"progress",
             {{"samples", frame_ ? frame_->samples() : 0},
              {"max_samples", settings_.max_samples},
              {"divisor", frame_ ? frame_->divisor : 0},
              {"image", frame_ ? frame_->number : 0},
              {"up_to_date", frame_ && frame_->version == version_}}},
            {"readers", readers_},
            {"links",
             {{"events", at + "/events"}, {"preview", at + "/preview.mjpg"}, {"stream", at + "/stream"}, {"tiles", at + "/tiles"},
              {"snapshot", at + "/snapshot.exr"}, {"graph", at + "/graph"}, {"cancel", at + "/cancel"}}}};
}

void LiveRender::say_state() {
    const std::string now = state();
    if (now == said_state_) return;
    said_state_ = now;
    push("state", document_locked());
}

void LiveRender::push(std::string type, nlohmann::json data) {
    // Newer progress and images replace older ones; states and the end stay until there are too many of them.
    if (type == "progress" || type == "image") std::erase_if(events_, [&](const Event& e) { return e.type == type; });
    events_.push_back({++last_event_, std::move(type), std::move(data)});
    if (events_.size() > kEventsMost) {
        first_whole_event_ = events_.front().number + 1;
        events_.pop_front();
    }
    news_.notify_all();
}

Event LiveRender::state_event() const {
    const std::lock_guard lock(mutex_);
    return {last_event_, "state", document_locked()};
}

std::vector<Event> LiveRender::next_events(uint64_t after, double seconds) {
    std::unique_lock lock(mutex_);
    news_.wait_for(lock, span(seconds), [&] { return last_event_ > after || !closed_state_.empty(); });
    std::vector<Event> found;
    if (after + 1 < first_whole_event_) found.push_back({first_whole_event_ - 1, "state", document_locked()});
    for (const Event& e : events_)
        if (e.number > after) found.push_back(e);
    // A picture that this reader has not heard of may have shown an edit before this one took its place.
    for (Event& e : found)
        if (e.type == "image")
            for (const ShownEdit& edit : shown_edits_)
                if (edit.event > after && edit.event <= e.number) e.data["edits"].push_back(edit.token);
    return found;
}

std::shared_ptr<const Frame> LiveRender::next_frame(uint64_t after, double seconds) {
    std::unique_lock lock(mutex_);
    news_.wait_for(lock, span(seconds), [&] { return !closed_state_.empty() || (frame_ && frame_->number > after); });
    return frame_ && frame_->number > after ? frame_ : nullptr;
}

std::vector<std::string> LiveRender::edits_between(uint64_t after, uint64_t until) const {
    const std::lock_guard lock(mutex_);
    std::vector<std::string> found;
    for (const ShownEdit& edit : shown_edits_)
        if (edit.picture > after && edit.picture <= until) found.push_back(edit.token);
    return found;
}

LiveRender::Reader::Reader(std::shared_ptr<LiveRender> render) : render_(std::move(render)) {
    const std::lock_guard lock(render_->mutex_);
    ++render_->readers_;
    render_->work_.notify_all();
}
LiveRender::Reader::~Reader() {
    const std::lock_guard lock(render_->mutex_);
    --render_->readers_;
    render_->last_read_ = Clock::now();
}

/// With the lock held.
void LiveRender::publish(std::shared_ptr<const FilmPicture> film, int divisor, uint64_t version) {
    auto frame = std::make_shared<Frame>();
    frame->film = std::move(film);
    frame->mix = mix_;
    frame->divisor = divisor;
    frame->width = film_settings_.width;
    frame->height = film_settings_.height;
    frame->number = frame_ ? frame_->number + 1 : 1;
    frame->version = version;
    frame->revision = film_source_.revision;
    // A re-mix shows at once; edits of the scene only when a picture of it is there.
    if (version == version_ || !dirty_) {
        for (std::string& token : pending_) shown_edits_.push_back({frame->number, last_event_ + 1, std::move(token)});
        while (shown_edits_.size() > kEditsMost) shown_edits_.pop_front();
        if (version == version_ && !shown_) metrics_.observe("alder_edit_to_image_seconds", {}, since(edited_));
        pending_.clear();
        shown_ = true;
    }
    frame_ = std::move(frame);
    push("image", {{"samples", frame_->samples()}, {"divisor", divisor}, {"number", frame_->number}, {"url", "/v1/renders/" + id_ + "/snapshot.exr"},
                   {"etag", fmt::format("\"{}\"", frame_->number)}, {"scene_revision", frame_->revision}, {"edits", nlohmann::json::array()}});   // filled in for each reader
}

double LiveRender::predicted_seconds(int divisor) const {
    return 0.001 + seconds_per_pixel_ * film_settings_.width * film_settings_.height / (divisor * divisor);
}
int LiveRender::first_divisor() const {
    if (seconds_per_pixel_ <= 0) return kCoarsest;
    for (int d = 1; d < kCoarsest; d *= 2)
        if (predicted_seconds(d) <= kFirstSeconds) return d;
    return kCoarsest;
}
int LiveRender::next_divisor(int divisor) const { return predicted_seconds(1) <= kJumpSeconds ? 1 : divisor / 2; }

void LiveRender::run() {
    std::unique_lock lock(mutex_);
    for (;;) {
        say_state();
        work_.wait(lock, [&] { return !closed_state_.empty() || has_work(); });
        if (!closed_state_.empty()) break;
        say_state();
        if (dirty_) {
            dirty_ = shown_ = false;
            film_version_ = version_;
            film_source_ = source_;
            film_settings_ = settings_;
            film_done_ = 0;
            divisor_ = first_divisor();
            auto old = std::move(film_);
            lock.unlock();
            old.reset();
            lock.lock();
            if (dirty_) continue;
        }
        cancel_ = false;
        lock.unlock();
        std::string problem;
        try {
            step();
        } catch (const std::exception& e) {
            problem = e.what();
        }
        lock.lock();
        if (!problem.empty()) {
            log_event("error", "live render failed", {{"render", id_}, {"what", problem}});
            failed_ = true;
            problem_ = "internal";
            film_.reset();
        }
    }
    film_.reset();
}

/// One pass, and its picture. Without the lock.
void LiveRender::step() {
    if (!film_) {
        RenderRequest r;
        r.width = std::max(1, film_settings_.width / divisor_);
        r.height = std::max(1, film_settings_.height / divisor_);
        r.samples = film_settings_.max_samples;
        r.seed = film_settings_.seed;
        r.threads = film_settings_.threads;
        r.aovs = film_settings_.aovs;
        for (const int g : used_groups(*film_source_.scene->scene)) r.aovs.push_back(group_name(g));
        r.cancel = &cancel_;
        film_ = std::make_unique<ProgressiveRender>(film_source_.scene, r);
    }
    const uint64_t done = film_->samples();
    uint64_t count = 1;
    if (divisor_ == 1 && done > 0) {
        const double second = std::max(predicted_seconds(1), 1e-6);
        count = std::clamp<uint64_t>(static_cast<uint64_t>(kPassSeconds / second), 1, done);
        count = std::min(count, static_cast<uint64_t>(film_settings_.max_samples) - done);
        count = film_->next_pass(count);
    }
    turns_.take(done == 0);
    const auto start = Clock::now();
    bool whole = false;
    try {
        whole = film_->advance(count);
    } catch (...) {
        turns_.give();
        throw;
    }
    turns_.give();
    if (!whole) return;
    const double per_pixel = std::max(since(start) - 0.001, 1e-6) / (static_cast<double>(count) * film_settings_.width * film_settings_.height / (divisor_ * divisor_));
    seconds_per_pixel_ = seconds_per_pixel_ > 0 ? 0.7 * seconds_per_pixel_ + 0.3 * per_pixel : per_pixel;
    auto picture = film_->picture();
    const RenderStats stats = film_->stats();
    const std::lock_guard lock(mutex_);
    total_ = stats;
    total_.samples = static_cast<int>(film_->samples());
    metrics_.count("alder_live_passes");
    film_done_ = divisor_ == 1 ? film_->samples() : 0;
    publish(std::move(picture), divisor_, film_version_);
    if (since(last_progress_) >= kProgressSeconds) {
        last_progress_ = Clock::now();
        push("progress", {{"samples", film_->samples()}, {"max_samples", film_settings_.max_samples}, {"divisor", divisor_},
                          {"fraction", divisor_ == 1 ? static_cast<double>(film_done_) / film_settings_.max_samples : 0.0}});
    }
    if (divisor_ > 1) {
        divisor_ = next_divisor(divisor_);
        film_.reset();
    }
}

}  // namespace alder::live
