// Accepting a render: from the body of POST /v1/renders to a job that needs nothing more from anyone.
#pragma once
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/jobs/job.h"
#include "server/jobs/settings.h"
#include "server/service.h"

namespace alder::jobs {

struct Accepted {
    Job job;
    std::vector<std::string> assets;   ///< every digest it needs, the revision's own included
    bool from_cache = false;           ///< the job has ended: an equal one was there
};
/// Checks all that can be checked, keeps the revision of the scene, overrides applied, in the asset store, and looks for an
/// equal result. Throws the problem where it cannot be rendered.
Accepted accept(Service& s, http::Request& request, const nlohmann::json& body, const JobSettings& settings, Diagnostics& d);

/// Equal for renders with equal results; empty where it depends on the clock.
std::string result_key(const std::string& snapshot, const nlohmann::json& body, const JobSettings& settings);

}  // namespace alder::jobs
