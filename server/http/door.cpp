// The door: listens, gives each connection a thread of its own up to a limit, and hands vetted requests to one handler.
#include "server/http/door.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <condition_variable>
#include <cstring>
#include <mutex>
#include <thread>
#include <unordered_map>

#include <fmt/format.h>

#include "server/http/connection.h"

namespace alder::http {
namespace {

constexpr size_t kConnectionStackBytes = 1 << 20;   // reserved, not committed; engine work runs elsewhere

/// "HOST:PORT" or "[HOST]:PORT"; false where it is neither.
bool split_address(const std::string& address, std::string& host, std::string& port) {
    const size_t colon = address.rfind(':');
    if (colon == std::string::npos || colon + 1 == address.size()) return false;
    host = address.substr(0, colon);
    port = address.substr(colon + 1);
    if (port.find_first_not_of("0123456789") != std::string::npos || port.size() > 5 || std::stoi(port) > 65535) return false;
    if (host.size() >= 2 && host.front() == '[' && host.back() == ']')
        host = host.substr(1, host.size() - 2);
    else if (host.find(':') != std::string::npos)
        return false;
    return !host.empty();
}

std::string header_safe(std::string value) {
    for (char& c : value)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
    return value;
}

std::string http_date() {
    char text[40];
    const time_t now = time(nullptr);
    tm utc{};
    gmtime_r(&now, &utc);
    strftime(text, sizeof text, "%a, %d %b %Y %H:%M:%S GMT", &utc);
    return text;
}

struct FileCloser {
    const int fd;
    explicit FileCloser(int f) : fd(f) {}
    FileCloser(const FileCloser&) = delete;
    FileCloser& operator=(const FileCloser&) = delete;
    ~FileCloser() {
        if (fd >= 0) ::close(fd);
    }
};

void run_function(std::function<void()>* raw) {
    const std::unique_ptr<std::function<void()>> function(raw);
    (*function)();
}

/// A detached thread with a small stack. False where the system has none left.
bool spawn(std::function<void()> function) {
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, kConnectionStackBytes);
    pthread_attr_setdetachstate(&attributes, PTHREAD_CREATE_DETACHED);
    auto* argument = new std::function<void()>(std::move(function));
    pthread_t thread;
    const int error = pthread_create(
        &thread, &attributes,
        [](void* p) -> void* {
            run_function(static_cast<std::function<void()>*>(p));
            return nullptr;
        },
        argument);
    pthread_attr_destroy(&attributes);
    if (error) delete argument;
    return error == 0;
}

}  // namespace

std::string time_sorted_id() {
    static constexpr char kDigits[] = "0123456789abcdefghjkmnpqrstvwxyz";
    const uint64_t milliseconds = static_cast<uint64_t>(
        std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::system_clock::now().time_since_epoch()).count());
    unsigned char random[16];
    if (getrandom(random, sizeof random, 0) != sizeof random) std::abort();   // cannot fail for so few bytes
    std::string id(26, '0');
    for (int i = 0; i < 10; ++i) id[i] = kDigits[(milliseconds >> (5 * (9 - i))) & 31];
    for (int i = 0; i < 16; ++i) id[10 + i] = kDigits[random[i] & 31];
    return id;
}

// The library's server, as far as it is used: it reads the body and writes the answer. Accepting, threads, limits and routes
// are not its business, so its own listening is never started.
struct Door::Impl : private httplib::Server {
    Limits limits;
    Door::Handler handler;
    Tls tls;
    std::string bound;
    std::string socket_path;   ///< of a unix socket, to be removed
    int port = 0;
    int listener = -1, wake = -1;
    std::thread acceptor;

    struct State {
        bool busy = false;
    };
    std::mutex mutex;
    std::condition_variable all_gone;
    std::unordered_map<int, State> open;
    bool stopping = false;

    Impl(const Limits& l, Door::Handler h) : limits(l), handler(std::move(h)) {
        svr_sock_ = 0;   // any valid number: the library stops content providers of a server it believes closed
        set_keep_alive_timeout(static_cast<time_t>(limits.idle_seconds));
        set_keep_alive_max_count(1000000);
        const auto without_body = [](const httplib::Request&, httplib::Response& out) { current().answer(out, nullptr); };
        Get("/", without_body);
        Post("/", [](const httplib::Request&, httplib::Response& out, const httplib::ContentReader& reader) {
            current().answer(out, &reader);
        });
        set_exception_handler([](const httplib::Request&, httplib::Response& out, std::exception_ptr) {
            out.status = 500;   // the library's own handler would send the exception's text
            out.set_header("Connection", "close");
        });
        set_post_routing_handler([](const httplib::Request&, httplib::Response& out) {
            if (out.get_header_value("Connection") == "close") out.headers.erase("Keep-Alive");
            if (out.status == 304 || out.status == 204) out.headers.erase("Content-Length");
        });
    }

    /// What the request in progress on this thread needs while it is inside the library.
    struct Exchange {
        Impl& door;
        Connection& connection;
        Request& request;
        bool close = false;

        void answer(httplib::Response& out, const httplib::ContentReader* reader) {
            request.read_body = [this, reader](uint64_t limit, const std::function<bool(std::string_view)>& receiver) {
                if (!reader) return BodyResult::Complete;
                if (request.content_length.value_or(0) > limit) return BodyResult::TooLarge;
                connection.allow_body(limit);
                bool stopped = false;
                const bool whole = (*reader)([&](const char* data, size_t size) {
                    stopped = !receiver(std::string_view(data, size));
                    return !stopped;
                });
                if (stopped) return BodyResult::Stopped;
                return whole ? BodyResult::Complete : connection.body_result();
            };
            request.client_gone = [this] { return connection.client_gone(); };
            Response response = door.handler(request);
            request.read_body = nullptr;
            close = response.close || !request.keep_alive || request.fault || !connection.body_finished();
            write(out, std::move(response));
        }

        void write(httplib::Response& out, Response response) {
            out.status = response.status;
            for (auto& [name, value] : response.headers) out.set_header(name, header_safe(std::move(value)));
            out.set_header("Date", http_date());
            if (request.method == "HEAD" && !out.has_header("Accept-Ranges")) out.set_header("Accept-Ranges", "none");
            if (close) out.set_header("Connection", "close");
            if (response.file) {
                const auto file = std::make_shared<FileCloser>(response.file->fd);
                const uint64_t base = response.file->offset;
                if (response.file->length > 0)
                    out.set_content_provider(
                        response.file->length, out.get_header_value("Content-Type"),
                        [file, base](size_t offset, size_t length, httplib::DataSink& sink) {
                            char piece[64 << 10];
                            const ssize_t n = pread(file->fd, piece, std::min(length, sizeof piece), static_cast<off_t>(base + offset));
                            return n > 0 && sink.write(piece, static_cast<size_t>(n));
                        });
            } else if (response.stream) {
                // Chunks, so that the connection can go on afterwards; HTTP/1.0 knows none and reads to the end.
                const auto provide = [stream = std::move(response.stream)](size_t, httplib::DataSink& sink) {
                    stream([&](std::string_view piece) { return sink.write(piece.data(), piece.size()); });
                    sink.done();
                    return true;
                };
                if (request.http_1_0) out.set_content_provider(response.stream_type, provide);
                else out.set_chunked_content_provider(response.stream_type, provide);
            } else {
                out.body = std::move(response.body);
            }
        }
    };

    static thread_local Exchange* exchange;
    static Exchange& current() { return *exchange; }

    void serve(int fd) {
        std::optional<Tls::Session> session;
        if (tls.active()) {
            fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK);
            session.emplace(tls, fd);
        }
        Connection connection(fd, limits, session ? &*session : nullptr);
        connection.on_busy = [this, fd](bool busy) { set_busy(fd, busy); };
        std::string remote;
        int remote_port = 0;
        connection.get_remote_ip_and_port(remote, remote_port);
        for (bool go_on = connection.greet(); go_on;) {
            Request request;
            if (!connection.next(request, request.fault)) break;
            request.remote = remote;
            request.id = time_sorted_id();
            connection.present(request, request.fault.has_value());
            Exchange here{*this, connection, request};
            exchange = &here;
            bool closed = false;
            go_on = process_request(connection, false, closed, nullptr) && !here.close && connection.body_finished();
            exchange = nullptr;
            if (go_on) go_on = set_busy(fd, false);
            else connection.linger();
        }
    }

    /// False where the door is closing and an idle connection should end.
    bool set_busy(int fd, bool busy) {
        const std::lock_guard lock(mutex);
        open[fd].busy = busy;
        return !stopping;
    }

    void admit(int fd) {
        const int on = 1;
        setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);   // fails on unix sockets, where it is not needed
        bool full;
        {
            const std::lock_guard lock(mutex);
            full = open.size() >= limits.connections || stopping;
            if (!full) open[fd] = {};
        }
        if (!full && spawn([this, fd] {
                serve(fd);
                {
                    const std::lock_guard lock(mutex);   // forgotten before it is closed: the number may be given out again
                    open.erase(fd);
                    all_gone.notify_all();
                }
                ::close(fd);
            }))
            return;
        if (!full) {
            const std::lock_guard lock(mutex);
            open.erase(fd);
        }
        static constexpr std::string_view kBody =
            R"({"type":"/problems/queue-full","title":"The service is busy","status":503,"detail":"too many connections"})";
        const std::string answer = fmt::format(
            "HTTP/1.1 503 Service Unavailable\r\nContent-Type: application/problem+json\r\nRetry-After: 1\r\n"
            "Connection: close\r\nContent-Length: {}\r\n\r\n{}",
            kBody.size(), kBody);
        if (!tls.active()) (void)!send(fd, answer.data(), answer.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        ::close(fd);
    }

    void accept_all() {
        for (;;) {
            pollfd p[2] = {{listener, POLLIN, 0}, {wake, POLLIN, 0}};
            if (poll(p, 2, -1) < 0 && errno != EINTR) return;
            if (p[1].revents) return;
            const int fd = accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
            if (fd >= 0)
                admit(fd);
            else if (errno == EMFILE || errno == ENFILE || errno == ENOMEM || errno == ENOBUFS)
                usleep(10000);   // other connections will end; a client that gave up is no reason to stop either
        }
    }
};
thread_local Door::Impl::Exchange* Door::Impl::exchange = nullptr;

Door::Door(const Limits& limits, Handler handler) : impl_(std::make_unique<Impl>(limits, std::move(handler))) {}
Door::~Door() {
    stop(0);
    std::unique_lock lock(impl_->mutex);
    impl_->all_gone.wait(lock, [&] { return impl_->open.empty(); });   // their threads still use what dies here
}
std::string Door::use_tls(const std::string& certificate, const std::string& key) { return impl_->tls.load(certificate, key); }
const std::string& Door::address() const { return impl_->bound; }
int Door::port() const { return impl_->port; }

size_t Door::connections() const {
    const std::lock_guard lock(impl_->mutex);
    return impl_->open.size();
}

bool Door::is_loopback(const std::string& address) {
    if (address.rfind("unix:", 0) == 0) return true;
    std::string host, port;
    if (!split_address(address, host, port)) return false;
    if (host == "localhost") return true;
    in_addr v4{};
    if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return (ntohl(v4.s_addr) >> 24) == 127;
    in6_addr v6{};
    return inet_pton(AF_INET6, host.c_str(), &v6) == 1 && IN6_IS_ADDR_LOOPBACK(&v6);
}

std::string Door::listen(const std::string& address) {
    Impl& d = *impl_;
    const auto why = [&](const char* what) { return fmt::format("{} {}: {}", what, address, std::strerror(errno)); };
    if (address.rfind("unix:", 0) == 0) {
        const std::string path = address.substr(5);
        sockaddr_un a{};
        a.sun_family = AF_UNIX;
        if (path.empty() || path.size() >= sizeof a.sun_path) return fmt::format("the socket path '{}' is empty or too long", path);
        std::memcpy(a.sun_path, path.c_str(), path.size() + 1);
        struct stat info{};
        if (lstat(path.c_str(), &info) == 0 && S_ISSOCK(info.st_mode)) ::unlink(path.c_str());   // left by an earlier run
        d.listener = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
        if (d.listener < 0) return why("cannot make a socket for");
        const mode_t old = umask(0177);
        const int failed = ::bind(d.listener, reinterpret_cast<sockaddr*>(&a), sizeof a);
        umask(old);
        if (failed) return why("cannot bind");
        d.socket_path = path;
        d.bound = address;
    } else {
        std::string host, port;
        if (!split_address(address, host, port)) return fmt::format("'{}' is not HOST:PORT, [IPV6]:PORT or unix:PATH", address);
        if (host == "localhost") host = "127.0.0.1";
        addrinfo hints{}, *found = nullptr;
        hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE;
        hints.ai_socktype = SOCK_STREAM;
        if (getaddrinfo(host.c_str(), port.c_str(), &hints, &found) != 0) return fmt::format("'{}' is not a numeric address", host);
        d.listener = ::socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
        const int on = 1;
        if (d.listener >= 0) setsockopt(d.listener, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
        const int failed = d.listener < 0 ? -1 : ::bind(d.listener, found->ai_addr, found->ai_addrlen);
        const int family = found->ai_family;
        freeaddrinfo(found);
        if (failed) return why("cannot bind");
        sockaddr_storage a{};
        socklen_t length = sizeof a;
        getsockname(d.listener, reinterpret_cast<sockaddr*>(&a), &length);
        d.port = ntohs(family == AF_INET6 ? reinterpret_cast<sockaddr_in6&>(a).sin6_port : reinterpret_cast<sockaddr_in&>(a).sin_port);
        d.bound = family == AF_INET6 ? fmt::format("[{}]:{}", host, d.port) : fmt::format("{}:{}", host, d.port);
    }
    if (::listen(d.listener, 1024) != 0) return why("cannot listen on");
    d.wake = eventfd(0, EFD_CLOEXEC);
    return d.wake < 0 ? why("no event descriptor for") : std::string();
}

void Door::start() {
    impl_->acceptor = std::thread([this] { impl_->accept_all(); });
}

bool Door::stop(double grace_seconds) {
    Impl& d = *impl_;
    const auto until = [](double s) {
        return std::chrono::steady_clock::now() + std::chrono::milliseconds(static_cast<int64_t>(s * 1000));
    };
    if (d.acceptor.joinable()) {
        const uint64_t one = 1;
        (void)!::write(d.wake, &one, sizeof one);
        d.acceptor.join();
    }
    for (int* fd : {&d.listener, &d.wake})
        if (*fd >= 0) {
            ::close(*fd);
            *fd = -1;
        }
    if (!d.socket_path.empty()) ::unlink(d.socket_path.c_str());
    d.socket_path.clear();
    std::unique_lock lock(d.mutex);
    d.stopping = true;
    for (const auto& [fd, state] : d.open)
        if (!state.busy) ::shutdown(fd, SHUT_RD);   // wakes its reader; an answer just being written still leaves
    if (!d.all_gone.wait_until(lock, until(grace_seconds), [&] { return d.open.empty(); }))
        for (const auto& [fd, state] : d.open) ::shutdown(fd, SHUT_RDWR);
    return d.all_gone.wait_until(lock, until(1), [&] { return d.open.empty(); });
}

}  // namespace alder::http
