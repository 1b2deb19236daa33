// One client's connection: deadlines, byte budgets and chunk decoding between the socket and the HTTP library.
#include "server/http/connection.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>

namespace alder::http {
namespace {

constexpr size_t kReceiveBytes = 16 << 10;

std::chrono::steady_clock::duration seconds(double s) {
    return std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(s));
}

/// Milliseconds until `deadline` for poll(), rounded up; 0 when it has passed.
int poll_milliseconds(std::chrono::steady_clock::time_point deadline) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now()).count();
    return static_cast<int>(std::clamp<int64_t>(left, 0, 60000));
}

void address_text(const sockaddr_storage& a, std::string& ip, int& port) {
    char text[INET6_ADDRSTRLEN] = "";
    port = 0;
    if (a.ss_family == AF_INET) {
        const auto& v4 = reinterpret_cast<const sockaddr_in&>(a);
        inet_ntop(AF_INET, &v4.sin_addr, text, sizeof text);
        port = ntohs(v4.sin_port);
    } else if (a.ss_family == AF_INET6) {
        const auto& v6 = reinterpret_cast<const sockaddr_in6&>(a);
        inet_ntop(AF_INET6, &v6.sin6_addr, text, sizeof text);
        port = ntohs(v6.sin6_port);
    }
    ip = a.ss_family == AF_UNIX ? "unix" : text;
}

}  // namespace

bool Connection::wait_for(short events, Clock::time_point deadline) const {
    for (;;) {
        pollfd p{fd_, events, 0};
        const int ready = poll(&p, 1, poll_milliseconds(deadline));
        if (ready > 0) return true;
        if (ready < 0 && errno != EINTR) return false;
        if (Clock::now() >= deadline) return false;
    }
}

bool Connection::greet() {
    if (!tls_) return true;
    const auto deadline = Clock::now() + seconds(limits_.head_seconds);
    for (;;) switch (tls_->handshake()) {
            case Tls::Session::Want::Done: return true;
            case Tls::Session::Want::Read:
                if (!wait_for(POLLIN, deadline)) return false;
                break;
            case Tls::Session::Want::Write:
                if (!wait_for(POLLOUT, deadline)) return false;
                break;
            default: return false;
        }
}

Connection::Got Connection::receive(Clock::time_point deadline) {
    while (tls_) {   // what OpenSSL holds already shows no sign at the socket
        if (consumed_ > 0 && (consumed_ == buffer_.size() || consumed_ >= kReceiveBytes)) {
            buffer_.erase(0, consumed_);
            consumed_ = 0;
        }
        const size_t old = buffer_.size();
        size_t got = 0;
        buffer_.resize(old + kReceiveBytes);
        const auto want = tls_->read(buffer_.data() + old, kReceiveBytes, got);
        buffer_.resize(old + got);
        if (want == Tls::Session::Want::Done) return Got::Data;
        if (want == Tls::Session::Want::Closed) return Got::End;
        if (want == Tls::Session::Want::Failed) return Got::Error;
        if (!wait_for(want == Tls::Session::Want::Read ? POLLIN : POLLOUT, deadline)) return Clock::now() >= deadline ? Got::Timeout : Got::Error;
    }
    for (;;) {
        pollfd p{fd_, POLLIN, 0};
        const int wait = poll_milliseconds(deadline);
        const int ready = poll(&p, 1, wait);
        if (ready < 0 && errno == EINTR) continue;
        if (ready < 0) return Got::Error;
        if (ready == 0) {
            if (Clock::now() >= deadline) return Got::Timeout;
            continue;
        }
        if (consumed_ > 0 && (consumed_ == buffer_.size() || consumed_ >= kReceiveBytes)) {
            buffer_.erase(0, consumed_);
            consumed_ = 0;
        }
        const size_t old = buffer_.size();
        buffer_.resize(old + kReceiveBytes);
        const ssize_t n = recv(fd_, buffer_.data() + old, kReceiveBytes, MSG_DONTWAIT);
        buffer_.resize(old + static_cast<size_t>(std::max<ssize_t>(n, 0)));
        if (n > 0) return Got::Data;
        if (n == 0) return Got::End;
        if (errno != EINTR && errno != EAGAIN && errno != EWOULDBLOCK) return Got::Error;
    }
}

bool Connection::next(Head& head, std::optional<Fault>& fault) {
    buffer_.erase(0, consumed_);
    consumed_ = 0;
    body_ = Body::Done;
    result_ = BodyResult::Complete;
    const auto idle_deadline = Clock::now() + seconds(limits_.idle_seconds);
    // Line ends before a request are skipped (RFC 9112, section 2.2), but not without bound.
    for (size_t skipped = 0;;) {
        while (buffer_.size() >= 2 && buffer_[0] == '\r' && buffer_[1] == '\n' && skipped < 8) {
            buffer_.erase(0, 2);
            ++skipped;
        }
        if (!buffer_.empty() && buffer_ != "\r") break;
        if (receive(idle_deadline) != Got::Data) return false;
    }
    if (on_busy) on_busy(true);
    const auto head_deadline = Clock::now() + seconds(limits_.head_seconds);
    for (;;) {
        const HeadProgress progress = head_progress(buffer_, limits_);
        if (progress.fault) {
            fault = progress.fault;
            body_ = Body::Failed;
            return true;
        }
        if (progress.end) {
            fault = parse_head(std::string_view(buffer_).substr(0, progress.end), limits_, head);
            consumed_ = progress.end;
            break;
        }
        switch (receive(head_deadline)) {
            case Got::Data: break;
            case Got::Timeout:
                fault = Fault{"request-timeout", "the headers did not arrive in time"};
                body_ = Body::Failed;
                return true;
            default: return false;
        }
    }
    if (fault) {
        body_ = Body::Failed;
        return true;
    }
    left_ = head.content_length.value_or(0);
    body_ = head.chunked ? Body::ChunkSize : left_ ? Body::Length : Body::Done;
    send_continue_ = head.expects_continue && head.has_body();
    body_limit_ = body_bytes_ = raw_bytes_ = 0;
    trailer_bytes_ = 0;
    return true;
}

void Connection::present(const Head& head, bool faulty) {
    const bool body = !faulty && head.has_body();
    shown_ = head.method == "HEAD" && !body ? "HEAD" : body ? "POST" : "GET";
    shown_ += " / HTTP/1.1\r\n\r\n";
    shown_at_ = 0;
}

bool Connection::client_gone() const {
    pollfd p{fd_, POLLRDHUP, 0};
    return poll(&p, 1, 0) > 0 && (p.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
}

void Connection::linger() {
    if (tls_) tls_->shut_down();
    ::shutdown(fd_, SHUT_WR);
    const auto deadline = Clock::now() + seconds(1);
    for (size_t discarded = 0; discarded < (4 << 20);) {
        buffer_.clear();
        consumed_ = 0;
        if (receive(deadline) != Got::Data) break;
        discarded += buffer_.size();
    }
}

ssize_t Connection::read(char* data, size_t size) {
    if (shown_at_ < shown_.size()) {
        const size_t n = std::min(size, shown_.size() - shown_at_);
        std::memcpy(data, shown_.data() + shown_at_, n);
        shown_at_ += n;
        return static_cast<ssize_t>(n);
    }
    return read_body(data, size);
}

ssize_t Connection::fail(BodyResult why) {
    body_ = Body::Failed;
    result_ = why;
    return -1;
}

bool Connection::fill_body() {
    if (consumed_ < buffer_.size()) return true;
    if (send_continue_) {
        send_continue_ = false;
        const std::string_view go_on = "HTTP/1.1 100 Continue\r\n\r\n";
        if (write(go_on.data(), go_on.size()) < 0) {
            fail(BodyResult::Disconnected);
            return false;
        }
    }
    if (raw_bytes_ == 0) body_started_ = Clock::now();
    const double allowed = limits_.body_grace_seconds + static_cast<double>(raw_bytes_) / limits_.body_bytes_per_second;
    switch (receive(body_started_ + seconds(allowed))) {
        case Got::Data: raw_bytes_ += buffer_.size() - consumed_; return true;
        case Got::Timeout: fail(BodyResult::TooSlow); return false;
        default: fail(BodyResult::Disconnected); return false;
    }
}

ssize_t Connection::take(char* data, size_t size) {
    if (!fill_body()) return -1;
    const size_t n = static_cast<size_t>(std::min<uint64_t>({size, left_, buffer_.size() - consumed_}));
    std::memcpy(data, buffer_.data() + consumed_, n);
    consumed_ += n;
    left_ -= n;
    body_bytes_ += n;
    return static_cast<ssize_t>(n);
}

bool Connection::read_line(std::string& line, size_t limit) {
    line.clear();
    for (;;) {
        if (!fill_body()) return false;
        const char c = buffer_[consumed_++];
        if (c == '\n') {
            if (line.empty() || line.back() != '\r') break;
            line.pop_back();
            return true;
        }
        if (line.size() == limit) break;
        line.push_back(c);
    }
    fail(BodyResult::Malformed);
    return false;
}

ssize_t Connection::read_body(char* data, size_t size) {
    std::string line;
    for (;;) switch (body_) {
            case Body::None:
            case Body::Done: return 0;
            case Body::Failed: return -1;
            case Body::Length: {
                if (left_ > body_limit_ - std::min(body_limit_, body_bytes_)) return fail(BodyResult::TooLarge);
                const ssize_t n = take(data, size);
                if (n > 0 && left_ == 0) body_ = Body::Done;
                return n;
            }
            case Body::ChunkSize: {
                if (!read_line(line, 256)) return -1;
                std::string_view digits = std::string_view(line).substr(0, line.find(';'));   // extensions are dropped
                while (!digits.empty() && (digits.back() == ' ' || digits.back() == '\t')) digits.remove_suffix(1);
                const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), left_, 16);
                if (digits.empty() || digits.size() > 16 || error != std::errc() || end != digits.data() + digits.size())
                    return fail(BodyResult::Malformed);
                if (left_ > body_limit_ - std::min(body_limit_, body_bytes_)) return fail(BodyResult::TooLarge);
                body_ = left_ ? Body::ChunkData : Body::Trailer;
                break;
            }
            case Body::ChunkData: {
                const ssize_t n = take(data, size);
                if (n > 0 && left_ == 0) body_ = Body::ChunkEnd;
                return n;
            }
            case Body::ChunkEnd:
                if (!read_line(line, 2)) return -1;
                if (!line.empty()) return fail(BodyResult::Malformed);
                body_ = Body::ChunkSize;
                break;
            case Body::Trailer:   // trailing fields are read and dropped: nothing here uses them
                if (!read_line(line, 4096)) return -1;
                trailer_bytes_ += line.size();
                if (line.empty()) {
                    body_ = Body::Done;
                    return 0;
                }
                if (trailer_bytes_ > 4096) return fail(BodyResult::Malformed);
                break;
        }
}

ssize_t Connection::write(const char* data, size_t size) {
    const auto deadline = Clock::now() + seconds(limits_.write_stall_seconds);
    if (tls_) return write_encrypted(data, size, deadline);
    for (;;) {
        const ssize_t n = send(fd_, data, size, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (n >= 0) return n;
        if (errno == EINTR) continue;
        if (errno != EAGAIN && errno != EWOULDBLOCK) return -1;
        pollfd p{fd_, POLLOUT, 0};
        if (poll(&p, 1, poll_milliseconds(deadline)) == 0 && Clock::now() >= deadline) return -1;
    }
}

ssize_t Connection::write_encrypted(const char* data, size_t size, Clock::time_point deadline) {
    for (;;) {
        size_t sent = 0;
        const auto want = tls_->write(data, size, sent);
        if (want == Tls::Session::Want::Done) return static_cast<ssize_t>(sent);
        if (want != Tls::Session::Want::Read && want != Tls::Session::Want::Write) return -1;
        if (!wait_for(want == Tls::Session::Want::Read ? POLLIN : POLLOUT, deadline)) return -1;
    }
}

void Connection::get_remote_ip_and_port(std::string& ip, int& port) const {
    sockaddr_storage a{};
    socklen_t length = sizeof a;
    getpeername(fd_, reinterpret_cast<sockaddr*>(&a), &length);
    address_text(a, ip, port);
}
void Connection::get_local_ip_and_port(std::string& ip, int& port) const {
    sockaddr_storage a{};
    socklen_t length = sizeof a;
    getsockname(fd_, reinterpret_cast<sockaddr*>(&a), &length);
    address_text(a, ip, port);
}

}  // namespace alder::http
