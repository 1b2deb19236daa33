// A client for tests that may say anything: bytes out, bytes in, over a loopback socket. No HTTP library is involved.
#pragma once
#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <map>
#include <string>
#include <string_view>

namespace alder::test {

struct Answer {
    int status = 0;                              ///< 0: the connection ended without one
    std::map<std::string, std::string> headers;  ///< names in lower case
    std::string body;
};

class RawClient {
  public:
    explicit RawClient(int port) : fd_(::socket(AF_INET, SOCK_STREAM, 0)) {
        sockaddr_in a{};
        a.sin_family = AF_INET;
        a.sin_port = htons(static_cast<uint16_t>(port));
        a.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        connected_ = ::connect(fd_, reinterpret_cast<sockaddr*>(&a), sizeof a) == 0;
    }
    ~RawClient() { close(); }
    RawClient(const RawClient&) = delete;
    RawClient& operator=(const RawClient&) = delete;

    bool connected() const { return connected_; }
    void close() {
        if (fd_ >= 0) ::close(fd_);
        fd_ = -1;
    }
    bool send(std::string_view bytes) {
        while (!bytes.empty()) {
            const ssize_t n = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
            if (n <= 0) return false;
            bytes.remove_prefix(static_cast<size_t>(n));
        }
        return true;
    }
    /// One answer; status 0 where the connection ends or `seconds` pass first.
    Answer receive(double seconds = 10, bool head_only = false) {
        const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(static_cast<int64_t>(seconds * 1000));
        Answer a;
        size_t head = std::string::npos;
        while ((head = buffer_.find("\r\n\r\n")) == std::string::npos)
            if (!more(end)) return a;
        a.status = std::stoi(buffer_.substr(9, 3));
        size_t at = buffer_.find("\r\n") + 2;
        while (at < head + 2) {
            const size_t line_end = buffer_.find("\r\n", at), colon = buffer_.find(':', at);
            std::string name = buffer_.substr(at, colon - at);
            for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
            a.headers[name] = buffer_.substr(colon + 2, line_end - colon - 2);
            at = line_end + 2;
        }
        buffer_.erase(0, head + 4);
        if (a.status == 100) return receive(seconds, head_only);
        const size_t length = head_only || !a.headers.count("content-length") ? 0 : std::stoul(a.headers["content-length"]);
        while (buffer_.size() < length)
            if (!more(end)) return a;
        a.body = buffer_.substr(0, length);
        buffer_.erase(0, length);
        return a;
    }
    /// All that has come, once `wanted` has, the connection has ended, or `seconds` have passed.
    std::string receive_until(std::string_view wanted, double seconds) {
        const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(static_cast<int64_t>(seconds * 1000));
        while (buffer_.find(wanted) == std::string::npos && more(end)) {
        }
        return buffer_;
    }
    /// What has come and was not taken as an answer.
    const std::string& received() const { return buffer_; }
    /// Whether the server ends the connection within `seconds`.
    bool ended(double seconds) {
        const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(static_cast<int64_t>(seconds * 1000));
        while (more(end)) {
        }
        return closed_;
    }
    Answer ask(const std::string& method, const std::string& target, const std::string& body = {}, const std::string& headers = {}) {
        std::string request = method + " " + target + " HTTP/1.1\r\nHost: localhost\r\n" + headers;
        if (!body.empty() || method == "POST" || method == "PUT") request += "Content-Length: " + std::to_string(body.size()) + "\r\n";
        if (!send(request + "\r\n" + body)) return {};
        return receive(60, method == "HEAD");
    }

  private:
    bool more(std::chrono::steady_clock::time_point end) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now()).count();
        pollfd p{fd_, POLLIN, 0};
        if (left <= 0 || ::poll(&p, 1, static_cast<int>(left)) <= 0) return false;
        char piece[65536];
        const ssize_t n = ::recv(fd_, piece, sizeof piece, 0);
        if (n <= 0) {
            closed_ = true;
            return false;
        }
        buffer_.append(piece, static_cast<size_t>(n));
        return true;
    }
    int fd_;
    bool connected_ = false, closed_ = false;
    std::string buffer_;
};

}  // namespace alder::test
