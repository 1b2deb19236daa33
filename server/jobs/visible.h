// What a client may see of renders.
#pragma once
#include "server/jobs/job.h"
#include "server/service.h"

namespace alder::jobs {

/// The render that the request's path names, where this client may see it; else it is not there.
Job visible(Service& s, const http::Request& request);

}  // namespace alder::jobs
