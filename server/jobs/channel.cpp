// Channel: JSON messages over a socket pair.
#include "server/jobs/channel.h"

#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace alder::jobs {

namespace {
constexpr size_t kMessageBytesMost = 64 << 20;
}

Channel::~Channel() {
    if (fd_ >= 0) ::close(fd_);
}

bool Channel::send(const nlohmann::json& message) {
    const std::string text = message.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    const auto size = static_cast<uint32_t>(text.size());
    std::string frame(4, '\0');
    for (int i = 0; i < 4; ++i) frame[i] = static_cast<char>(size >> (8 * i) & 0xFF);
    frame += text;
    const std::lock_guard lock(send_mutex_);
    for (size_t at = 0; at < frame.size();) {
        const ssize_t n = ::send(fd_, frame.data() + at, frame.size() - at, MSG_NOSIGNAL);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        at += static_cast<size_t>(n);
    }
    return true;
}

Channel::Got Channel::receive(nlohmann::json& message, bool wait) {
    for (;;) {
        if (buffer_.size() >= 4) {
            uint32_t size = 0;
            for (int i = 0; i < 4; ++i) size |= static_cast<uint32_t>(static_cast<unsigned char>(buffer_[i])) << (8 * i);
            if (size > kMessageBytesMost) return Got::End;
            if (buffer_.size() >= size + size_t{4}) {
                message = nlohmann::json::parse(buffer_.begin() + 4, buffer_.begin() + 4 + size, nullptr, false);
                buffer_.erase(0, size + size_t{4});
                return message.is_object() ? Got::Message : Got::End;
            }
        }
        char piece[64 << 10];
        const ssize_t n = ::recv(fd_, piece, sizeof piece, wait ? 0 : MSG_DONTWAIT);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return Got::Nothing;
        if (n <= 0) return Got::End;
        buffer_.append(piece, static_cast<size_t>(n));
    }
}

}  // namespace alder::jobs
