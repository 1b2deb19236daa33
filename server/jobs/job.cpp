// Job: states by name, and the document that clients see.
#include "server/jobs/job.h"

#include <chrono>
#include <cmath>
#include <ctime>

#include <fmt/format.h>

namespace alder::jobs {
namespace {

constexpr const char* kStateNames[] = {"queued", "preparing", "rendering", "writing", "paused", "succeeded", "failed", "cancelled"};

}  // namespace

const char* state_name(State state) { return kStateNames[static_cast<int>(state)]; }
bool state_from_name(const std::string& name, State& state) {
    for (int i = 0; i < 8; ++i)
        if (name == kStateNames[i]) return state = static_cast<State>(i), true;
    return false;
}

double wall_seconds() {
    return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

nlohmann::json time_text(double seconds) {
    if (seconds <= 0) return nullptr;
    const double whole = std::floor(seconds);
    const time_t t = static_cast<time_t>(whole);
    tm utc{};
    gmtime_r(&t, &utc);
    return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday, utc.tm_hour, utc.tm_min,
                       utc.tm_sec, static_cast<int>((seconds - whole) * 1000));
}

nlohmann::json Job::document() const {
    nlohmann::json files = nlohmann::json::array();
    for (const Output& o : outputs)
        files.push_back({{"file", o.file}, {"frame", o.frame}, {"bytes", o.bytes}, {"digest", o.digest}, {"layers", o.layers}, {"complete", o.complete}});
    const std::string self = "/v1/renders/" + id;
    nlohmann::json j = {{"id", id},
                        {"state", state_name(state)},
                        {"reason", reason.empty() ? nlohmann::json() : nlohmann::json(reason)},
                        {"etag", etag()},
                        {"attempt", attempt},
                        {"priority", priority},
                        {"scene", {{"id", scene}, {"revision", scene_etag}}},
                        {"progress", progress},
                        {"timings", timings},
                        {"created", time_text(created)},
                        {"started", time_text(started)},
                        {"ended", time_text(ended)},
                        {"retain", retain},
                        {"expired", expired},
                        {"warnings", warnings},
                        {"labels", labels},
                        {"outputs", std::move(files)},
                        {"links", {{"self", self}, {"outputs", self + "/outputs"}, {"log", self + "/log"}, {"stats", self + "/stats"}, {"cancel", self + "/cancel"}}}};
    if (!problem.is_null()) j["problem"] = problem;
    return j;
}

}  // namespace alder::jobs
