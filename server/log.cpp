// Logs: one JSON object a line on stderr.
#include "server/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

namespace alder {
namespace {

spdlog::logger& logger() {
    static const auto instance = [] {
        auto l = std::make_shared<spdlog::logger>("alder", std::make_shared<spdlog::sinks::stderr_sink_mt>());
        l->set_level(spdlog::level::warn);   // until start_log(): tests stay quiet
        l->flush_on(spdlog::level::trace);
        return l;
    }();
    return *instance;
}

}  // namespace

void start_log(const std::string& level) { logger().set_level(spdlog::level::from_str(level)); }

void log_event(const char* level, const char* event, const nlohmann::json& fields) {
    const auto severity = spdlog::level::from_str(level);
    if (!logger().should_log(severity)) return;
    // The pattern writes time, level and event; the fields follow as members of the same object.
    std::string members = fields.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    members = members.size() > 2 ? "," + members.substr(1) : "}";
    static const bool once = [] {
        logger().set_pattern("{\"time\":\"%Y-%m-%dT%H:%M:%S.%eZ\",\"level\":\"%l\",%v", spdlog::pattern_time_type::utc);
        return true;
    }();
    (void)once;
    logger().log(severity, "\"event\":\"{}\"{}", event, members);
}

}  // namespace alder
