// alderd: starts the daemon, waits for signals, stops it.
#include <csignal>
#include <cstdio>
#include <cstring>
#include <unistd.h>

#include "server/daemon.h"
#include "server/jobs/worker.h"
#include "server/log.h"

int main(int argc, char** argv) {
    using namespace alder;
    if (argc == 2 && std::strcmp(argv[1], "--worker") == 0) return jobs::worker_main(3);
    ServiceOptions options;
    if (const int status = parse_options(argc, argv, options); status >= 0) return status;
    start_log(options.log_level);

    // Signals are taken by this thread alone, in sigwait(): nothing runs in a handler.
    sigset_t signals;
    sigemptyset(&signals);
    for (const int s : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals, s);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    std::signal(SIGPIPE, SIG_IGN);

    Daemon daemon(options);
    if (const auto error = daemon.start()) {
        std::fprintf(stderr, "alderd: %s\n", error->sentence.c_str());
        return error->exit_status;
    }
    daemon.warm_up();

    for (int s = 0;;) {
        if (sigwait(&signals, &s) != 0) continue;
        if (s != SIGHUP) break;
        const std::string error = daemon.service().access.reload();
        log_event(error.empty() ? "info" : "error", "tokens read again", error.empty() ? nlohmann::json::object() : nlohmann::json{{"error", error}});
    }
    log_event("info", "stopping");
    // A second signal ends the process at once.
    std::signal(SIGTERM, [](int) { _exit(0); });
    std::signal(SIGINT, [](int) { _exit(0); });
    pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
    const bool clean = daemon.stop();
    log_event("info", "stopped", {{"clean", clean}});
    _exit(0);   // what could still run is cancelled or harmless; destructors of libraries' threads are not waited for
}
