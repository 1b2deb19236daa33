// The queue of renders: takes jobs, hands one at a time to the worker, keeps their state in the store, and tells who waits.
//
// One thread of its own speaks with the worker. All changes of a job are made under one lock and are on disk before anyone
// hears of them; only the progress of the running attempt lives in memory alone.
#pragma once
#include <atomic>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "server/jobs/store.h"
#include "server/jobs/gate.h"
#include "server/jobs/worker_process.h"

namespace alder {
class AssetStore;
class Metrics;
struct ServiceOptions;
}  // namespace alder

namespace alder::jobs {

class JobQueue {
  public:
    JobQueue(const ServiceOptions& options, AssetStore& assets, Metrics& metrics);
    ~JobQueue();
    /// Opens the store and takes up what was left. Empty, or a sentence saying why not.
    std::string start();
    /// Takes no more up, has the running render put away, ends the worker. Within `seconds`, else the last checkpoint counts.
    void stop(double seconds);
    /// Starts the worker before it is needed.
    void warm_up();

    JobStore& store() { return store_; }
    void submit(const Job& job, const std::vector<std::string>& assets, const Remembered* answer);
    /// With live progress. Throws not-found.
    Job get(const std::string& id);
    std::vector<Job> list(const ListFilter& filter);
    /// Until `enough` says so, `seconds` have passed, the client left or the daemon stops.
    Job wait(const std::string& id, double seconds, const std::function<bool(const Job&)>& enough, const std::function<bool()>& client_gone);

    // Each returns the job as it is afterwards; they throw state-conflict where it cannot be.
    Job cancel(const std::string& id);
    Job pause(const std::string& id);
    Job resume(const std::string& id);
    void remove(const std::string& id);
    /// Changes a job that `edit` checks and alters; where it says so the render is continued with its new settings.
    Job edit(const std::string& id, const std::function<bool(Job&)>& edit);

    struct Snapshot {
        std::string file;
        uint64_t samples = 0;
    };
    /// What the running render has so far, written by the worker. Nothing where it does not run or nothing is there yet.
    std::optional<Snapshot> snapshot(const std::string& id, double seconds);

    /// A key is in use while its request is being answered. False: it is already.
    bool begin_key(const std::string& user, const std::string& key);
    void end_key(const std::string& user, const std::string& key);

    /// Memory that the worker may have, in bytes.
    uint64_t memory_cap() const;
    /// Holds the worker's tiles while somebody waits for a picture of the daemon.
    Gate& gate() { return gate_; }

    pid_t worker_pid() const { return worker_pid_; }
    bool worker_fails() const { return worker_failures_ >= 3; }
    std::string data_folder() const;

  private:
    struct Active {
        Job job;
        std::string stop;          ///< how, where it is to stop
        bool stop_sent = false, finished = false;
        bool acknowledged = false; ///< the worker has begun: its end is the render's doing
        double stop_at = 0;        ///< monotonic seconds
        double begun = 0;
        uint64_t changes = 0;
    };

    void run();
    void dispatch(std::unique_lock<std::mutex>& lock);
    std::string start_worker();
    void take(const nlohmann::json& message);
    void finish(State state, const std::string& reason = {});
    void settle();                 ///< stores what finished; again later where the disk refuses
    void worker_ended();
    void send_stops();
    void look_after_space();
    void clean_up(double now);
    void sweep_orphans();
    void wake();
    void changed();
    Job& edited(const std::string& id, Job& stored);
    void keep(Job& job);
    void count(const Job& job);
    void ask_to_stop(const std::string& how);

    const ServiceOptions& options_;
    AssetStore& assets_;
    Metrics& metrics_;
    JobStore store_;
    std::mutex mutex_;
    std::condition_variable changed_;
    uint64_t change_ = 0;
    std::optional<Active> active_;
    std::map<std::string, uint64_t> turns_;   ///< by user: when it was last served
    uint64_t turn_ = 0;
    std::map<int64_t, std::optional<Snapshot>> snapshots_;
    std::set<std::pair<std::string, std::string>> keys_;
    int64_t ticket_ = 0;
    std::vector<std::string> crash_lines_;
    std::string epoch_, started_id_;
    bool stopping_ = false, draining_ = false, warm_wanted_ = false, look_for_work_ = true, space_wanted_ = false;
    double clean_at_ = 0, space_at_ = 0, worker_retry_at_ = 0;

    Gate gate_;
    WorkerHandle worker_;
    std::atomic<pid_t> worker_pid_{-1};
    std::atomic<int> worker_failures_{0};
    int wake_fd_ = -1;
    std::thread thread_, sweeper_;
};

}  // namespace alder::jobs
