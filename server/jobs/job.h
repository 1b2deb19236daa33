// Job: what the service knows of one render, from its acceptance until its data is removed.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace alder::jobs {

enum class State : uint8_t { Queued, Preparing, Rendering, Writing, Paused, Succeeded, Failed, Cancelled };
const char* state_name(State state);
bool state_from_name(const std::string& name, State& state);
inline bool is_terminal(State s) { return s == State::Succeeded || s == State::Failed || s == State::Cancelled; }
/// A worker has it in hand.
inline bool is_active(State s) { return s == State::Preparing || s == State::Rendering || s == State::Writing; }

/// A file of the result, whole and on disk.
struct Output {
    std::string file;
    int frame = 0;
    uint64_t bytes = 0;
    std::string digest;   ///< "sha256:HEX"
    std::vector<std::string> layers;
    bool complete = true;
};

/// Times are seconds since 1970, 0 where it has not happened.
struct Job {
    std::string id, user;
    State state = State::Queued;
    std::string reason;              ///< why it is paused
    int64_t version = 1;             ///< grows with each change that is stored
    int attempt = 0;                 ///< times a worker took it up
    int crashes = 0;                 ///< attempts in a row that ended with the worker and without a new checkpoint
    int64_t priority = 50;
    double created = 0, started = 0, ended = 0, retain = 0;
    bool expired = false;            ///< its files have been removed
    std::string scene, scene_etag;   ///< as the client named them
    std::string snapshot;            ///< digest of the scene revision, overrides included, in the asset store
    std::string cache_key;           ///< equal keys have equal results; empty: depends on time
    nlohmann::json request;          ///< the body as accepted
    nlohmann::json labels = nlohmann::json::object();
    nlohmann::json progress = nlohmann::json::object();
    nlohmann::json timings = nlohmann::json::object();
    nlohmann::json warnings = nlohmann::json::array();
    nlohmann::json problem;          ///< of a failed one: type, detail, errors
    nlohmann::json stats;
    std::vector<Output> outputs;
    /// Of the running attempt, not stored: counts what changed since `version`.
    std::string live_tag;

    std::string etag() const { return "\"" + std::to_string(version) + live_tag + "\""; }
    /// The document of API.md, section 4.
    nlohmann::json document() const;
};

/// Now, in seconds since 1970.
double wall_seconds();
/// RFC 3339, UTC, with milliseconds; null for 0.
nlohmann::json time_text(double seconds);

}  // namespace alder::jobs
