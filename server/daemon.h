// Daemon: the service behind its door, from checked options to a clean stop. What main() runs, and tests start in-process.
#pragma once
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "server/http/door.h"
#include "server/service.h"

namespace alder {

class Daemon {
  public:
    explicit Daemon(const ServiceOptions& options);
    ~Daemon();

    struct StartError {
        int exit_status;        ///< 2: the options are wrong; 3: the machine refuses
        std::string sentence;
    };
    /// Checks what only the machine can tell, listens and begins to serve. Nothing where all went well.
    std::optional<StartError> start();
    /// Builds what the first preview needs, on a thread of its own.
    void warm_up();
    /// Takes no new work, lets running requests finish for a while, then cancels them. False where something would not end.
    bool stop();

    int port() const { return door_->port(); }
    const std::string& address() const { return door_->address(); }
    Service& service() { return *service_; }

  private:
    ServiceOptions options_;
    int lock_ = -1;             ///< of the data folder: one daemon each
    std::unique_ptr<Service> service_;
    std::unique_ptr<http::Door> door_;
    std::thread warmer_;
    std::thread cleaner_;       ///< removes assets that nothing refers to
    std::mutex cleaner_mutex_;
    std::condition_variable cleaner_wake_;
    bool cleaner_ends_ = false;
    void clean_assets();
};

}  // namespace alder
