// The job store: renders, their results and idempotency keys in SQLite. What a method has returned is on disk.
#pragma once
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/jobs/database.h"
#include "server/jobs/job.h"

namespace alder::jobs {

/// The answer to a request that came with an Idempotency-Key.
struct Remembered {
    std::string user, key;
    std::string request_digest;   ///< of method, path and body
    int status = 0;
    std::string body, render;
};

struct ListFilter {
    std::optional<State> state;
    std::optional<std::string> scene, user;
    std::vector<std::pair<std::string, std::string>> labels;
    std::string before;   ///< cursor: ids that sort below it
    int limit = 100;
};

/// Thread safe. Throws DatabaseError where the disk refuses.
class JobStore {
  public:
    /// Opens DATA/jobs.db, brings its schema up to date. Empty, or a sentence saying why not.
    std::string open(const std::string& folder);

    /// A new job with what it refers to, and the answer of its request, in one transaction.
    void insert(const Job& job, const std::vector<std::string>& assets, const Remembered* answer);
    /// Stores all that may change; job.version grows.
    void update(Job& job);
    void add_output(const std::string& id, const Output& output);
    void clear_outputs(const std::string& id);
    bool remove(const std::string& id);

    std::optional<Job> get(const std::string& id);
    std::vector<Job> list(const ListFilter& filter);
    bool exists(const std::string& id);
    int64_t count(std::optional<State> state, const std::string* user = nullptr);   ///< nothing: those not ended
    /// Ids of the first queued job of each user, among the highest priority.
    std::vector<std::pair<std::string, std::string>> next_by_user();   ///< user, id
    std::vector<std::string> ids_in(State state);
    /// What was in hand when the last process ended is queued again. Their ids.
    std::vector<std::string> recover();
    /// Ended renders whose time is over.
    std::vector<std::string> due(double now);
    /// A succeeded render with files and this key.
    std::optional<std::string> find_result(const std::string& cache_key);

    std::optional<Remembered> remembered(const std::string& user, const std::string& key, double oldest);
    /// Whether a render that has not ended refers to the asset ("sha256:HEX"); its id, or empty.
    std::string user_of(const std::string& digest);
    /// Whether any render that still has its data refers to it.
    bool names(const std::string& digest);
    /// Forgets answers older than `oldest`.
    void forget(double oldest);
    /// Files named by outputs of all renders, in bytes.
    uint64_t output_bytes();

  private:
    void migrate();
    Job row(Statement& s);
    void load_outputs(Job& job);

    std::mutex write_mutex_, read_mutex_;
    Database writer_, reader_;
};

}  // namespace alder::jobs
