// Logs: one JSON object a line on stderr.
#pragma once
#include <string>

#include <nlohmann/json.hpp>

namespace alder {

/// Once, before anything is logged. Levels: debug, info, warn, error.
void start_log(const std::string& level);
void log_event(const char* level, const char* event, const nlohmann::json& fields = nlohmann::json::object());

}  // namespace alder
