// The door: listens, gives each connection a thread of its own up to a limit, and hands vetted requests to one handler.
// A slow, idle or silent client costs its own thread and nothing else.
#pragma once
#include <memory>
#include <string>

#include "server/http/message.h"

namespace alder::http {

class Door {
  public:
    using Handler = std::function<Response(Request&)>;
    /// The handler is called from many threads at once and must not throw.
    Door(const Limits& limits, Handler handler);
    ~Door();

    /// Connections made from now on are encrypted. Empty, or a sentence saying why not.
    std::string use_tls(const std::string& certificate, const std::string& key);
    /// "127.0.0.1:7420", "[::1]:0" or "unix:PATH". Empty, or a sentence saying why not.
    std::string listen(const std::string& address);
    /// What was bound: "127.0.0.1:43211".
    const std::string& address() const;
    int port() const;   ///< 0 for a unix socket
    /// Begins to accept, on a thread of its own.
    void start();
    /// Stops accepting, ends idle connections, lets busy ones finish for `grace_seconds`, then cuts them. Returns when all are
    /// gone (true) or after another second.
    bool stop(double grace_seconds);
    size_t connections() const;

    /// Whether an address is this machine's own: what may be served without tokens.
    static bool is_loopback(const std::string& address);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// 26 characters, lower-case Crockford base 32, sortable by the time they were made (ULID).
std::string time_sorted_id();

}  // namespace alder::http
