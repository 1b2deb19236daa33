// The worker process: renders jobs for the daemon at a lower priority and with a memory cap of its own, so that a crash there
// costs one attempt of one render.
#pragma once

namespace alder::jobs {

/// What `alderd --worker` runs; `fd` is its end of the socket pair. Returns an exit status.
int worker_main(int fd);

}  // namespace alder::jobs
