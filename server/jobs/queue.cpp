// The queue of renders: what routes ask of it. What its thread does is in dispatch.cpp.
#include "server/jobs/queue.h"

#include <sys/eventfd.h>
#include <sys/random.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "server/errors.h"
#include "server/http/door.h"
#include "server/jobs/files.h"
#include "server/log.h"
#include "server/metrics.h"
#include "server/options.h"

namespace alder::jobs {
namespace {

constexpr double kCancelSeconds = 10;   // a worker that does not stop by then is ended

[[noreturn]] void conflict(const Job& job, const char* verb) {
    Problem p{"state-conflict", fmt::format("the render is {}: it cannot be {}", state_name(job.state), verb)};
    p.extra["state"] = state_name(job.state);
    throw p;
}

/// Of a process; 0 where there is none.
uint64_t resident_bytes(pid_t pid) {
    if (pid <= 0) return 0;
    std::ifstream file(fmt::format("/proc/{}/statm", pid));
    uint64_t whole = 0, resident = 0;
    file >> whole >> resident;
    return file ? resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE)) : 0;
}

}  // namespace

JobQueue::JobQueue(const ServiceOptions& options, AssetStore& assets, Metrics& metrics) : options_(options), assets_(assets), metrics_(metrics) {
    uint32_t random = 0;
    (void)!getrandom(&random, sizeof random, 0);
    epoch_ = fmt::format("{:08x}", random);
}

JobQueue::~JobQueue() {
    stop(2);
    if (wake_fd_ >= 0) ::close(wake_fd_);
}

std::string JobQueue::data_folder() const { return options_.data; }

std::string JobQueue::start() {
    std::error_code code;
    std::filesystem::create_directories(options_.data + "/renders", code);
    if (code) return fmt::format("cannot make {}/renders: {}", options_.data, code.message());
    if (std::string error = store_.open(options_.data); !error.empty()) return error;
    try {
        const auto recovered = store_.recover();
        for (const std::string& id : recovered) {
            append_log(RenderFolder(options_.data, id).log(), "warn", "the daemon ended while this render was in hand: queued again");
            metrics_.count("alder_recoveries");
        }
        if (!recovered.empty()) log_event("warn", "renders taken up again", {{"renders", recovered.size()}});
        space_wanted_ = !store_.ids_in(State::Paused).empty();
    } catch (const DatabaseError& e) {
        return fmt::format("the job store cannot be used: {}", e.what());
    }
    started_id_ = "rnd_" + http::time_sorted_id();
    wake_fd_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (wake_fd_ < 0) return "no event descriptor";
    for (const State s : {State::Queued, State::Paused, State::Succeeded, State::Failed, State::Cancelled})
        metrics_.gauge("alder_renders", [this, s] { return static_cast<double>(store_.count(s)); }, fmt::format("state=\"{}\"", state_name(s)));
    metrics_.gauge("alder_renders", [this] {
        const std::lock_guard lock(mutex_);
        return active_ ? 1.0 : 0.0;
    }, "state=\"rendering\"");
    metrics_.gauge("alder_store_bytes", [this] { return static_cast<double>(store_.output_bytes()); }, "what=\"outputs\"");
    metrics_.gauge("alder_memory_bytes", [this] { return static_cast<double>(resident_bytes(worker_pid_)); }, "pool=\"worker\"");
    metrics_.gauge("alder_memory_bytes", [] { return static_cast<double>(resident_bytes(getpid())); }, "pool=\"daemon\"");
    thread_ = std::thread([this] { run(); });
    sweeper_ = std::thread([this] { sweep_orphans(); });
    return {};
}

void JobQueue::stop(double seconds) {
    {
        std::unique_lock lock(mutex_);
        if (!thread_.joinable()) return;
        draining_ = true;
        ask_to_stop("drain");
        wake();
        changed_.notify_all();
        changed_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return !active_; });
        stopping_ = true;
        wake();
    }
    thread_.join();
    sweeper_.join();
    worker_.end(1);
}

void JobQueue::warm_up() {
    const std::lock_guard lock(mutex_);
    warm_wanted_ = true;
    wake();
}

void JobQueue::wake() {
    const uint64_t one = 1;
    (void)!::write(wake_fd_, &one, sizeof one);
}

void JobQueue::changed() {
    ++change_;
    changed_.notify_all();
}

void JobQueue::submit(const Job& job, const std::vector<std::string>& assets, const Remembered* answer) {
    store_.insert(job, assets, answer);
    const std::lock_guard lock(mutex_);
    look_for_work_ = true;
    changed();
    wake();
}

Job JobQueue::get(const std::string& id) {
    {
        const std::lock_guard lock(mutex_);
        if (active_ && active_->job.id == id) return active_->job;
    }
    auto job = store_.get(id);
    if (!job) throw Problem{"not-found", fmt::format("there is no render '{}'", id.substr(0, 64))};
    return std::move(*job);
}

std::vector<Job> JobQueue::list(const ListFilter& filter) {
    if (filter.state && is_active(*filter.state)) {   // the store does not follow each step of the running one
        const std::lock_guard lock(mutex_);
        if (!active_ || active_->job.state != *filter.state) return {};
        const Job& job = active_->job;
        bool fits = (filter.before.empty() || job.id < filter.before) && (!filter.scene || job.scene == *filter.scene) && (!filter.user || job.user == *filter.user);
        for (const auto& [name, value] : filter.labels) fits = fits && job.labels.contains(name) && job.labels.value(name, "") == value;
        return fits ? std::vector<Job>{job} : std::vector<Job>{};
    }
    auto jobs = store_.list(filter);
    const std::lock_guard lock(mutex_);
    for (Job& job : jobs)
        if (active_ && active_->job.id == job.id) job = active_->job;
    return jobs;
}

Job JobQueue::wait(const std::string& id, double seconds, const std::function<bool(const Job&)>& enough, const std::function<bool()>& client_gone) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    for (;;) {
        uint64_t seen = 0;
        {
            const std::lock_guard lock(mutex_);
            seen = change_;
        }
        Job job = get(id);
        if (enough(job)) return job;
        std::unique_lock lock(mutex_);
        do {   // the client is looked at five times a second, the store only when something changed
            if (draining_ || std::chrono::steady_clock::now() >= end || (client_gone && client_gone())) return job;
            changed_.wait_for(lock, std::chrono::milliseconds(200), [&] { return change_ != seen || draining_; });
        } while (change_ == seen);
    }
}

/// The job to change under the lock: the running one, or the stored.
Job& JobQueue::edited(const std::string& id, Job& stored) {
    if (active_ && active_->job.id == id) return active_->job;
    auto job = store_.get(id);
    if (!job) throw Problem{"not-found", fmt::format("there is no render '{}'", id.substr(0, 64))};
    return stored = std::move(*job);
}

void JobQueue::keep(Job& job) {
    store_.update(job);
    look_for_work_ = true;
    changed();
    wake();
}

void JobQueue::ask_to_stop(const std::string& how) {
    if (!active_ || active_->finished) return;
    if (active_->stop == "cancel") return;
    active_->stop = how;
    active_->stop_sent = false;
    wake();
}

Job JobQueue::cancel(const std::string& id) {
    {
        const std::lock_guard lock(mutex_);
        Job stored;
        Job& job = edited(id, stored);
        if (job.state == State::Cancelled) return job;
        if (is_terminal(job.state)) conflict(job, "cancelled");
        if (&job == &stored) {
            job.state = State::Cancelled;
            job.reason.clear();
            job.ended = wall_seconds();
            keep(job);
            ::unlink(RenderFolder(options_.data, id).checkpoint().c_str());
            return job;
        }
        ask_to_stop("cancel");
    }
    return wait(id, kCancelSeconds + 2, [](const Job& j) { return is_terminal(j.state); }, {});
}

Job JobQueue::pause(const std::string& id) {
    {
        const std::lock_guard lock(mutex_);
        Job stored;
        Job& job = edited(id, stored);
        if (is_terminal(job.state)) conflict(job, "paused");
        if (&job == &stored) {
            if (job.state == State::Paused && job.reason.empty()) return job;
            job.state = State::Paused;
            job.reason.clear();
            keep(job);
            return job;
        }
        ask_to_stop("pause");
    }
    return wait(id, kCancelSeconds + 2, [](const Job& j) { return !is_active(j.state); }, {});
}

Job JobQueue::resume(const std::string& id) {
    const std::lock_guard lock(mutex_);
    Job stored;
    Job& job = edited(id, stored);
    if (is_terminal(job.state)) conflict(job, "resumed");
    if (job.state != State::Paused) return job;
    job.state = State::Queued;
    job.reason.clear();
    keep(job);
    return job;
}

void JobQueue::remove(const std::string& id) {
    bool running = false;
    {
        const std::lock_guard lock(mutex_);
        Job stored;
        running = &edited(id, stored) != &stored;
        if (running) ask_to_stop("cancel");
    }
    if (running) wait(id, kCancelSeconds + 2, [](const Job& j) { return is_terminal(j.state); }, {});
    const std::lock_guard lock(mutex_);
    if (active_ && active_->job.id == id) throw Problem{"state-conflict", "the worker does not stop the render"};
    store_.remove(id);
    RenderFolder(options_.data, id).remove();
    changed();
}

Job JobQueue::edit(const std::string& id, const std::function<bool(Job&)>& edit) {
    const std::lock_guard lock(mutex_);
    Job stored;
    Job& job = edited(id, stored);
    const bool running = &job != &stored;
    Job next = job;
    const bool go_on = edit(next);
    if (go_on && is_terminal(next.state)) {
        next.state = State::Queued;
        next.ended = 0;
        next.stats = nullptr;
        next.crashes = 0;
        next.outputs.clear();
        store_.clear_outputs(id);
    }
    if (running) next.live_tag.clear();
    keep(next);
    job = next;
    if (running && go_on) ask_to_stop("yield");   // and taken up again from what it has, with the new settings
    return next;
}

bool JobQueue::begin_key(const std::string& user, const std::string& key) {
    const std::lock_guard lock(mutex_);
    return keys_.emplace(user, key).second;
}
void JobQueue::end_key(const std::string& user, const std::string& key) {
    const std::lock_guard lock(mutex_);
    keys_.erase({user, key});
}

std::optional<JobQueue::Snapshot> JobQueue::snapshot(const std::string& id, double seconds) {
    std::unique_lock lock(mutex_);
    if (!active_ || active_->job.id != id || active_->finished) return std::nullopt;
    const int64_t ticket = ++ticket_;
    snapshots_[ticket] = std::nullopt;
    const int64_t asked = ticket;
    const std::string running = id;
    if (!worker_.send({{"do", "snapshot"}, {"id", running}, {"ticket", asked}})) {
        snapshots_.erase(asked);
        return std::nullopt;
    }
    changed_.wait_for(lock, std::chrono::duration<double>(seconds),
                      [&] { return snapshots_[asked].has_value() || !active_ || active_->job.id != running || draining_; });
    auto found = std::move(snapshots_[asked]);
    snapshots_.erase(asked);
    if (found && found->file.empty()) found.reset();
    return found;
}

}  // namespace alder::jobs
