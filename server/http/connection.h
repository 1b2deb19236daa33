// One client's connection: deadlines, byte budgets and chunk decoding between the socket and the HTTP library.
//
// cpp-httplib 0.11.4 buffers header lines without limit, lets chunked bodies pass its size limit, decodes escapes in header
// values and waits on slow senders. So it never sees what a client sent: this stream reads and vets the head itself, then
// shows the library a short head of its own and the decoded, counted body.
#pragma once
#include <chrono>
#include <string>

#include <httplib.h>

#include "server/http/head.h"
#include "server/http/tls.h"

namespace alder::http {

class Connection final : public httplib::Stream {
  public:
    using Clock = std::chrono::steady_clock;
    /// `tls`: null, or what encrypts the connection; its descriptor must not block then.
    Connection(int fd, const Limits& limits, Tls::Session* tls = nullptr) : fd_(fd), limits_(limits), tls_(tls) {}

    /// The TLS handshake, within the time that headers have. True where there is none to make.
    bool greet();

    /// Waits for the next request and parses its head. False: the client left, or stayed silent too long.
    bool next(Head& head, std::optional<Fault>& fault);
    /// How many body bytes may come; the library's reading stops there.
    void allow_body(uint64_t limit) { body_limit_ = limit; }
    BodyResult body_result() const { return result_; }
    /// Whether another request may follow: the body was read to its end, or there was none.
    bool body_finished() const { return body_ == Body::Done; }
    /// Whether the client has closed its sending side or the connection is broken.
    bool client_gone() const;
    /// Closes so that an answer already sent is not lost to a reset: sends FIN, then takes what still comes for a moment.
    void linger();
    /// What the library is to see as the head of the request just parsed.
    void present(const Head& head, bool faulty);
    /// False until the first byte of a request is there: such a connection may be ended at any time.
    std::function<void(bool busy)> on_busy;

    bool is_readable() const override { return true; }
    bool is_writable() const override { return true; }
    ssize_t read(char* data, size_t size) override;
    ssize_t write(const char* data, size_t size) override;
    void get_remote_ip_and_port(std::string& ip, int& port) const override;
    void get_local_ip_and_port(std::string& ip, int& port) const override;
    /// The library refuses descriptors beyond FD_SETSIZE because it uses select(); nothing here does.
    socket_t socket() const override { return 0; }

  private:
    enum class Body { None, Length, ChunkSize, ChunkData, ChunkEnd, Trailer, Done, Failed };
    enum class Got { Data, End, Timeout, Error };

    Got receive(Clock::time_point deadline);   ///< appends to buffer_
    bool wait_for(short events, Clock::time_point deadline) const;   ///< false: the time is over, or the connection broken
    ssize_t write_encrypted(const char* data, size_t size, Clock::time_point deadline);
    ssize_t read_body(char* data, size_t size);
    ssize_t take(char* data, size_t size);     ///< up to `size` bytes of body from the buffer or the socket
    bool read_line(std::string& line, size_t limit);
    bool fill_body();
    ssize_t fail(BodyResult why);

    int fd_;
    const Limits& limits_;
    Tls::Session* tls_;
    std::string buffer_;        ///< received, not yet consumed
    size_t consumed_ = 0;
    std::string shown_;         ///< the head for the library
    size_t shown_at_ = 0;
    Body body_ = Body::None;
    BodyResult result_ = BodyResult::Complete;
    bool send_continue_ = false;
    uint64_t left_ = 0;         ///< bytes left of the body or chunk
    uint64_t body_limit_ = 0;
    uint64_t body_bytes_ = 0;   ///< decoded so far
    uint64_t raw_bytes_ = 0;    ///< received for this body, framing included
    size_t trailer_bytes_ = 0;
    Clock::time_point body_started_;
};

}  // namespace alder::http
