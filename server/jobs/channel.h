// Channel: JSON messages between the daemon and its worker over a socket pair.
//
// A message is a little-endian 32-bit length and that many bytes of JSON, an object. The daemon sends what to do in "do",
// the worker what has happened in "is":
//
//   do: setup     data, asset_roots, threads, texture_mib, color_configuration, memory_bytes, checkpoint_seconds, priority: once, first
//   do: render    id, snapshot (digest of the scene revision), request (the body as accepted), done (frames written already)
//   do: stop      id, how (cancel, pause, yield, drain, deadline): at the next stage of a tile; the film is put away unless cancelled
//   do: snapshot  id, ticket: writes what there is after the pass under way to the render's folder
//
//   is: ready
//   is: state       id, state (preparing, rendering, writing), timings, warnings
//   is: progress    id, fraction, samples, estimated_error, eta, frames_done, frames: at most four a second
//   is: checkpoint  id, samples, seconds
//   is: output      id, file, frame, bytes, digest, layers, complete: the file is whole and on disk
//   is: snapshot    id, ticket, file, samples; file empty where there is none yet
//   is: done        id, stats, timings
//   is: stopped     id, how
//   is: paused      id, reason (disk-full), bytes (that did not fit)
//   is: failed      id, type, detail, errors
#pragma once
#include <mutex>
#include <string>

#include <nlohmann/json.hpp>

namespace alder::jobs {

class Channel {
  public:
    explicit Channel(int fd) : fd_(fd) {}
    ~Channel();
    Channel(const Channel&) = delete;
    Channel& operator=(const Channel&) = delete;

    int fd() const { return fd_; }
    /// Whole, from any thread. False where the other side is gone.
    bool send(const nlohmann::json& message);
    enum class Got { Message, Nothing, End };
    /// One message. `wait`: until there is one; else what has arrived only.
    Got receive(nlohmann::json& message, bool wait);

  private:
    int fd_;
    std::mutex send_mutex_;
    std::string buffer_;
};

}  // namespace alder::jobs
