// The worker as the daemon sees it: started when needed, spoken to, watched, ended.
#pragma once
#include <sys/types.h>

#include <functional>
#include <memory>
#include <string>

#include "server/jobs/channel.h"

namespace alder::jobs {

/// Used by the queue's thread alone, apart from pid().
class WorkerHandle {
  public:
    /// The program that understands --worker: this one if it is alderd, else the alderd beside it.
    static std::string default_program();
    ~WorkerHandle() { kill(); }

    bool alive() const { return pid_ > 0; }
    pid_t pid() const { return pid_; }
    /// Starts it and sends `setup`. Empty, or a sentence saying why not. `gate`: a descriptor that it gets, or -1.
    std::string start(const std::string& program, const nlohmann::json& setup, int gate = -1);
    bool send(const nlohmann::json& message) { return channel_ && channel_->send(message); }
    /// For poll(): -1 where it is not running.
    int channel_fd() const { return channel_ ? channel_->fd() : -1; }
    int error_fd() const { return errors_; }
    Channel::Got receive(nlohmann::json& message) { return channel_ ? channel_->receive(message, false) : Channel::Got::End; }
    /// Whole lines it wrote to stderr.
    void read_errors(const std::function<void(const std::string& line)>& take);
    /// After its end was seen: waits for it and says how it ended ("signal 11 (Segmentation fault)").
    std::string reap();
    /// Ends it: closes the channel, waits a moment, then kills.
    void end(double seconds);
    void kill();

  private:
    void forget();
    pid_t pid_ = -1;
    std::unique_ptr<Channel> channel_;
    int errors_ = -1;
    std::string partial_line_;
};

}  // namespace alder::jobs
