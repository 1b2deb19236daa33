// The queue's thread: gives jobs to the worker, takes what it says, survives its end, cleans up.
#include <poll.h>
#include <sys/resource.h>
#include <sys/sysinfo.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>

#include <fmt/format.h>

#include "server/assets.h"
#include "server/errors.h"
#include "server/jobs/files.h"
#include "server/jobs/queue.h"
#include "server/log.h"
#include "server/metrics.h"
#include "server/options.h"

namespace alder::jobs {
namespace {

constexpr int kCrashesMost = 3;
constexpr double kStopSeconds = 10;        // for a worker to stop by itself
constexpr double kCleanSeconds = 60;
constexpr double kSpaceSeconds = 2;        // between looks whether a full disk has room again
constexpr double kAnswersSeconds = 86400;  // idempotency keys are kept for a day
constexpr size_t kCrashLinesMost = 80;

double monotonic() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

uint64_t physical_bytes() {
    struct sysinfo info {};
    return sysinfo(&info) == 0 ? static_cast<uint64_t>(info.totalram) * info.mem_unit : 0;
}

}  // namespace

void JobQueue::run() {
    pthread_setname_np(pthread_self(), "jobs");
    std::unique_lock lock(mutex_);
    while (!stopping_) {
        const double now = monotonic();
        settle();
        if (warm_wanted_ && !worker_.alive() && now >= worker_retry_at_) {
            warm_wanted_ = false;
            if (const std::string error = start_worker(); !error.empty()) log_event("error", "no worker", {{"why", error}});
        }
        if (!active_ && look_for_work_ && !draining_ && now >= worker_retry_at_) dispatch(lock);
        send_stops();
        if (space_wanted_ && now >= space_at_) look_after_space();
        if (now >= clean_at_) clean_up(now);

        pollfd p[3] = {{wake_fd_, POLLIN, 0}, {worker_.channel_fd(), POLLIN, 0}, {worker_.error_fd(), POLLIN, 0}};
        lock.unlock();
        const bool soon = active_ && (active_->finished || !active_->stop.empty());
        ::poll(p, 3, soon ? 100 : look_for_work_ ? 200 : 1000);
        lock.lock();
        uint64_t count = 0;
        (void)!::read(wake_fd_, &count, sizeof count);
        const auto take_line = [&](const std::string& line) {
            if (!line.empty() && line[0] == '{') {   // a line of its log: passed on as it is
                (void)!::write(2, (line + "\n").data(), line.size() + 1);
                return;
            }
            if (crash_lines_.size() < kCrashLinesMost) crash_lines_.push_back(line);
        };
        worker_.read_errors(take_line);
        if (worker_.alive()) {
            nlohmann::json message;
            Channel::Got got;
            while ((got = worker_.receive(message)) == Channel::Got::Message) take(message);
            if (got == Channel::Got::End && worker_.alive()) {
                worker_.read_errors(take_line);
                worker_ended();
            }
        }
    }
}

uint64_t JobQueue::memory_cap() const {
    return options_.worker_memory_mib > 0 ? static_cast<uint64_t>(options_.worker_memory_mib) << 20 : physical_bytes() / 5 * 4;
}

std::string JobQueue::start_worker() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    const uint64_t enforced = 0;   // shadow memory would count, too
#else
    const uint64_t enforced = memory_cap();
#endif
    const std::string program = options_.worker_program.empty() ? WorkerHandle::default_program() : options_.worker_program;
    const std::string error = worker_.start(program, {{"do", "setup"},
                                                      {"data", options_.data},
                                                      {"asset_roots", options_.asset_roots},
                                                      {"threads", options_.threads},
                                                      {"texture_mib", options_.texture_mib},
                                                      {"color_configuration", options_.color_configuration},
                                                      {"memory_bytes", enforced},
                                                      {"checkpoint_seconds", options_.checkpoint_seconds},
                                                      {"checkpoint_fraction", options_.checkpoint_fraction},
                                                      {"log_level", options_.log_level},
                                                      {"gate", gate_.descriptor() >= 0},
                                                      {"priority", 19}}, gate_.descriptor());
    worker_pid_ = worker_.pid();
    if (!error.empty()) {
        ++worker_failures_;
        worker_retry_at_ = monotonic() + 2;
    } else {
        metrics_.count("alder_worker_starts");
    }
    return error;
}

/// Highest priority first; among those the user served longest ago; of that user the oldest.
void JobQueue::dispatch(std::unique_lock<std::mutex>&) {
    try {
        const auto candidates = store_.next_by_user();
        if (candidates.empty()) {
            look_for_work_ = false;
            return;
        }
        const auto next = std::min_element(candidates.begin(), candidates.end(), [&](const auto& a, const auto& b) {
            const auto turn = [&](const std::string& user) {
                const auto it = turns_.find(user);
                return it == turns_.end() ? uint64_t{0} : it->second;
            };
            return std::pair(turn(a.first), a.second) < std::pair(turn(b.first), b.second);
        });
        auto job = store_.get(next->second);
        if (!job) return;
        if (!worker_.alive()) {
            if (const std::string error = start_worker(); !error.empty()) {
                log_event("error", "no worker", {{"why", error}});
                return;
            }
        }
        turns_[next->first] = ++turn_;
        job->state = State::Preparing;
        ++job->attempt;
        const double now = wall_seconds();
        if (job->started == 0) {
            job->started = now;
            job->timings["queued"] = std::max(0.0, now - job->created);
            metrics_.observe("alder_queue_seconds", {}, std::max(0.0, now - job->created));
        }
        store_.update(*job);
        nlohmann::json done = nlohmann::json::array();
        for (const Output& o : job->outputs) done.push_back(o.frame);
        crash_lines_.clear();
        active_.emplace(Active{std::move(*job)});
        active_->begun = monotonic();
        worker_.send({{"do", "render"}, {"id", active_->job.id}, {"snapshot", active_->job.snapshot}, {"request", active_->job.request}, {"done", std::move(done)}});
        changed();
    } catch (const DatabaseError& e) {
        log_event("error", "job store", {{"what", e.what()}});
        worker_retry_at_ = monotonic() + 1;
    }
}

void JobQueue::send_stops() {
    if (!active_ || active_->finished) return;
    Active& a = *active_;
    if (a.stop.empty() && options_.max_render_seconds > 0 && monotonic() - a.begun > options_.max_render_seconds) a.stop = "deadline";
    if (a.stop.empty() && look_for_work_) {
        // A render of higher priority does not wait for this one: what is there is put away and goes on later.
        look_for_work_ = false;
        try {
            const auto waiting = store_.next_by_user();
            if (!waiting.empty()) {
                const auto other = store_.get(waiting.front().second);
                if (other && other->priority > a.job.priority) a.stop = "yield";
            }
        } catch (const DatabaseError&) {
        }
    }
    if (a.stop.empty()) return;
    if (!a.stop_sent) {
        a.stop_sent = true;
        a.stop_at = monotonic();
        worker_.send({{"do", "stop"}, {"id", a.job.id}, {"how", a.stop}});
    } else if (monotonic() - a.stop_at > kStopSeconds) {
        log_event("error", "worker does not stop", {{"render", a.job.id}, {"pid", worker_.pid()}});
        worker_.kill();
        worker_ended();
    }
}

void JobQueue::take(const nlohmann::json& m) {
    const std::string is = m.value("is", "");
    if (is == "ready") {
        worker_failures_ = 0;
        return;
    }
    if (is == "snapshot") {
        if (const auto it = snapshots_.find(m.value("ticket", int64_t{0})); it != snapshots_.end()) it->second = Snapshot{m.value("file", ""), m.value("samples", uint64_t{0})};
        changed();
        return;
    }
    if (!active_ || active_->finished || m.value("id", "") != active_->job.id) return;
    active_->acknowledged = true;
    Job& job = active_->job;
    job.live_tag = fmt::format(".{}.{}", epoch_, ++active_->changes);
    const auto merge_timings = [&] {
        if (const auto it = m.find("timings"); it != m.end()) job.timings.update(*it);
    };
    try {
        if (is == "state") {
            state_from_name(m.value("state", ""), job.state);
            merge_timings();
            if (const auto it = m.find("warnings"); it != m.end()) job.warnings = *it;
        } else if (is == "progress") {
            job.progress = m.at("progress");
        } else if (is == "checkpoint") {
            metrics_.observe("alder_checkpoint_seconds", {}, m.value("seconds", 0.0));
            job.crashes = 0;
            store_.update(job);
        } else if (is == "output") {
            Output o{m.at("file"), m.at("frame"), m.at("bytes"), m.at("digest"), m.at("layers").get<std::vector<std::string>>(), m.at("complete")};
            store_.add_output(job.id, o);
            std::erase_if(job.outputs, [&](const Output& other) { return other.file == o.file; });
            job.outputs.push_back(std::move(o));
            job.progress["samples"] = m.at("samples");
            job.progress["estimated_error"] = m.at("estimated_error");
            job.crashes = 0;
        } else if (is == "done") {
            merge_timings();
            job.stats = m.at("stats");
            count(job);
            job.progress["fraction"] = 1;
            job.progress["eta"] = 0;
            job.progress["frames_done"] = job.outputs.size();
            finish(State::Succeeded);
        } else if (is == "stopped") {
            const std::string how = m.value("how", "");
            if (how == "cancel") finish(State::Cancelled);
            else if (how == "pause") finish(State::Paused);
            else if (how == "deadline") {
                job.problem = {{"type", "/problems/deadline"}, {"detail", fmt::format("renders may take {:g} s here", options_.max_render_seconds)}};
                finish(State::Failed);
            } else finish(State::Queued);
        } else if (is == "paused") {
            space_wanted_ = true;
            space_at_ = monotonic() + kSpaceSeconds;
            job.progress["needed_bytes"] = m.value("bytes", uint64_t{0});
            finish(State::Paused, m.value("reason", "disk-full"));
        } else if (is == "failed") {
            job.problem = {{"type", "/problems/" + m.value("type", "internal")}, {"detail", m.value("detail", "")}};
            if (!m.value("errors", nlohmann::json::array()).empty()) job.problem["errors"] = m["errors"];
            finish(State::Failed);
            if (m.value("type", "") == "out-of-memory") {   // it ends itself: the next render gets a fresh one
                worker_.end(1);
                worker_pid_ = -1;
            }
        }
    } catch (const DatabaseError& e) {
        // An output that is not recorded would be lost: the attempt is given up and the frame rendered again when there is room.
        log_event("error", "job store", {{"render", job.id}, {"what", e.what()}});
        if (is == "output") {
            space_wanted_ = true;
            worker_.send({{"do", "stop"}, {"id", job.id}, {"how", "pause"}});
            finish(State::Paused, "disk-full");
        }
    }
    changed();
}

/// Adds what a job took to the counters.
void JobQueue::count(const Job& job) {
    for (const char* phase : {"load", "build", "compile"})
        if (const auto it = job.timings.find(phase); it != job.timings.end() && it->is_number()) metrics_.observe("alder_build_seconds", fmt::format("phase=\"{}\"", phase), it->get<double>());
    if (const auto it = job.timings.find("first_image"); it != job.timings.end() && it->is_number()) metrics_.observe("alder_first_image_seconds", {}, it->get<double>());
    if (!job.stats.is_object()) return;
    const auto add = [&](const char* name, const std::string& labels, const nlohmann::json& value) {
        if (value.is_number()) metrics_.count(name, labels, value.get<double>());
    };
    if (const auto rays = job.stats.find("rays"); rays != job.stats.end())
        for (const auto& [kind, n] : rays->items()) add("alder_rays", fmt::format("kind=\"{}\"", kind), n);
    add("alder_samples", {}, job.stats.value("samples", nlohmann::json()));
    add("alder_shading_points", {}, job.stats.value("shading_points", nlohmann::json()));
    add("alder_node_evaluations", "outcome=\"run\"", job.stats.value("node_evaluations", nlohmann::json()));
    add("alder_node_evaluations", "outcome=\"skipped\"", job.stats.value("node_evaluations_skipped", nlohmann::json()));
    add("alder_nonfinite_samples", {}, job.stats.value("nonfinite_samples", nlohmann::json()));
}

void JobQueue::finish(State state, const std::string& reason) {
    Active& a = *active_;
    a.job.state = state;
    a.job.reason = reason;
    if (is_terminal(state)) a.job.ended = wall_seconds();
    a.finished = true;
    settle();
}

void JobQueue::settle() {
    if (!active_ || !active_->finished) return;
    Job& job = active_->job;
    try {
        store_.update(job);
    } catch (const DatabaseError& e) {   // once a loop, until the disk has room
        log_event("error", "job store", {{"render", job.id}, {"what", e.what()}});
        return;
    }
    if (job.state == State::Cancelled || job.state == State::Failed) ::unlink(RenderFolder(options_.data, job.id).checkpoint().c_str());
    ::unlink((RenderFolder(options_.data, job.id).root + "/snapshot.exr").c_str());
    metrics_.count("alder_renders_ended", fmt::format("state=\"{}\"", state_name(job.state)));
    log_event("info", "render", {{"render", job.id}, {"state", state_name(job.state)}, {"attempt", job.attempt}});
    active_.reset();
    look_for_work_ = true;
    changed();
}

void JobQueue::worker_ended() {
    const std::string how = worker_.alive() ? worker_.reap() : "killed: it did not stop";
    worker_pid_ = -1;
    if (!active_ || active_->finished) return;
    ++worker_failures_;
    worker_retry_at_ = worker_failures_ > 3 ? monotonic() + 1 : 0;
    Job& job = active_->job;
    const std::string log = RenderFolder(options_.data, job.id).log();
    append_log(log, "error", fmt::format("the worker ended: {}", how));
    for (const std::string& line : crash_lines_) append_log(log, "error", "  " + line);
    metrics_.count("alder_worker_crashes");
    log_event("error", "worker ended", {{"render", job.id}, {"how", how}, {"attempt", job.attempt}});
    if (active_->stop == "cancel") return finish(State::Cancelled);
    if (active_->stop == "pause") return finish(State::Paused);
    if (active_->acknowledged && ++job.crashes >= kCrashesMost) {
        job.problem = {{"type", "/problems/render-crashed"}, {"detail", fmt::format("the worker ended {} times in a row while rendering it, last by {}", job.crashes, how)}};
        return finish(State::Failed);
    }
    finish(State::Queued);
}

/// Renders that were paused for want of space go on when there is some.
void JobQueue::look_after_space() {
    space_at_ = monotonic() + kSpaceSeconds;
    bool left = false;
    try {
        for (const std::string& id : store_.ids_in(State::Paused)) {
            auto job = store_.get(id);
            if (!job || job->reason.empty()) continue;
            // Room for what did not fit, its checkpoint and some more: else it would only be paused again.
            if (!assets_.has_room(2 * job->progress.value("needed_bytes", uint64_t{0}) + (1 << 20))) {
                left = true;
                continue;
            }
            job->progress.erase("needed_bytes");
            job->state = State::Queued;
            job->reason.clear();
            store_.update(*job);
            look_for_work_ = true;
        }
    } catch (const DatabaseError&) {
        left = true;
    }
    space_wanted_ = left;
    changed();
}

void JobQueue::clean_up(double now) {
    clean_at_ = now + kCleanSeconds;
    try {
        for (const std::string& id : store_.due(wall_seconds())) {
            auto job = store_.get(id);
            if (!job) continue;
            job->expired = true;
            store_.update(*job);
            RenderFolder(options_.data, id).remove();
        }
        store_.forget(wall_seconds() - kAnswersSeconds);
    } catch (const DatabaseError& e) {
        log_event("error", "job store", {{"what", e.what()}});
    }
}

/// Folders of renders that the store does not know: removed ones whose folder a killed daemon left.
void JobQueue::sweep_orphans() {
    std::error_code code;
    std::vector<std::string> ids;
    for (const auto& entry : std::filesystem::directory_iterator(options_.data + "/renders", code)) ids.push_back(entry.path().filename().string());
    for (const std::string& id : ids) {
        {
            const std::lock_guard lock(mutex_);
            if (stopping_) return;
        }
        try {
            if (id < started_id_ && !store_.exists(id)) RenderFolder(options_.data, id).remove();
        } catch (const DatabaseError&) {
            return;
        }
    }
}

}  // namespace alder::jobs
