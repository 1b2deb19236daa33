// TLS for the daemon's door (--tls-cert, --tls-key): 1.2 and later, with OpenSSL's defaults for servers.
#pragma once
#include <memory>
#include <string>

struct ssl_st;
struct ssl_ctx_st;

namespace alder::http {

class Tls {
  public:
    /// PEM files: the certificate with its chain, and its key. Empty, or a sentence that says why they cannot be used.
    std::string load(const std::string& certificate, const std::string& key);
    bool active() const { return context_ != nullptr; }
    /// For a connection that was accepted; closed by ~Session.
    class Session {
      public:
        Session(const Tls& tls, int fd);
        ~Session();
        Session(const Session&) = delete;
        Session& operator=(const Session&) = delete;

        enum class Want { Done, Read, Write, Closed, Failed };
        /// Each does what it can without waiting; Read and Write say what to poll for before the next try.
        Want handshake();
        Want read(char* data, size_t size, size_t& got);
        Want write(const char* data, size_t size, size_t& sent);
        /// Tells the client that nothing more comes.
        void shut_down();

      private:
        Want result(int code);
        ssl_st* ssl_;
    };

  private:
    struct Free {
        void operator()(ssl_ctx_st* c) const;
    };
    std::unique_ptr<ssl_ctx_st, Free> context_;
};

}  // namespace alder::http
