// The worker as the daemon sees it.
#include "server/jobs/worker_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>

#include "server/jobs/gate.h"

extern char** environ;

namespace alder::jobs {

std::string WorkerHandle::default_program() {
    std::error_code code;
    const auto self = std::filesystem::read_symlink("/proc/self/exe", code);
    // An upgrade may have replaced the file: the link still leads to what is running.
    if (code || self.filename().string().rfind("alderd", 0) == 0) return "/proc/self/exe";
    return (self.parent_path() / "alderd").string();
}

std::string WorkerHandle::start(const std::string& program, const nlohmann::json& setup, int gate) {
    int pair[2], pipe_ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) != 0) return fmt::format("no socket pair: {}", std::strerror(errno));
    if (pipe2(pipe_ends, O_CLOEXEC | O_NONBLOCK) != 0) {
        ::close(pair[0]);
        ::close(pair[1]);
        return fmt::format("no pipe: {}", std::strerror(errno));
    }
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, pipe_ends[1], 2);
    posix_spawn_file_actions_adddup2(&actions, 2, 1);
    posix_spawn_file_actions_adddup2(&actions, pair[1], 3);   // clears close-on-exec even where it is 3 already
    if (gate > kGateDescriptor) posix_spawn_file_actions_adddup2(&actions, gate, kGateDescriptor);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t none, defaults;
    sigemptyset(&none);
    sigemptyset(&defaults);
    sigaddset(&defaults, SIGPIPE);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &defaults);
    posix_spawnattr_setpgroup(&attributes, 0);   // a Ctrl-C at the terminal is the daemon's to handle
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    const char* const arguments[] = {"alder-worker", "--worker", nullptr};
    pid_t pid = -1;
    const int error = posix_spawn(&pid, program.c_str(), &actions, &attributes, const_cast<char* const*>(arguments), environ);
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    ::close(pair[1]);
    ::close(pipe_ends[1]);
    if (error) {
        ::close(pair[0]);
        ::close(pipe_ends[0]);
        return fmt::format("{} cannot be started: {}", program, std::strerror(error));
    }
    pid_ = pid;
    errors_ = pipe_ends[0];
    channel_ = std::make_unique<Channel>(pair[0]);
    channel_->send(setup);
    return {};
}

void WorkerHandle::read_errors(const std::function<void(const std::string&)>& take) {
    char piece[4096];
    ssize_t n = 0;
    while (errors_ >= 0 && (n = ::read(errors_, piece, sizeof piece)) > 0) {
        partial_line_.append(piece, static_cast<size_t>(n));
        size_t at = 0;
        for (size_t end; (end = partial_line_.find('\n', at)) != std::string::npos; at = end + 1) take(partial_line_.substr(at, end - at));
        partial_line_.erase(0, at);
        if (partial_line_.size() > (64 << 10)) partial_line_.clear();
    }
    if (n == 0 && errors_ >= 0) {
        ::close(errors_);
        errors_ = -1;
    }
}

void WorkerHandle::forget() {
    pid_ = -1;
    channel_.reset();
    if (errors_ >= 0) ::close(errors_);
    errors_ = -1;
    partial_line_.clear();
}

std::string WorkerHandle::reap() {
    if (pid_ <= 0) return {};
    channel_.reset();
    int status = 0;
    // Its channel is closed, so it is ending; a hundred milliseconds are plenty for the kernel to take a large process down.
    for (int i = 0; waitpid(pid_, &status, WNOHANG) == 0; ++i) {
        if (i == 100) ::kill(pid_, SIGKILL);
        usleep(1000);
    }
    forget();
    if (WIFSIGNALED(status)) return fmt::format("signal {} ({})", WTERMSIG(status), strsignal(WTERMSIG(status)));
    return fmt::format("exit status {}", WEXITSTATUS(status));
}

void WorkerHandle::end(double seconds) {
    if (pid_ <= 0) return;
    channel_.reset();
    const auto start = std::chrono::steady_clock::now();
    int status = 0;
    while (waitpid(pid_, &status, WNOHANG) == 0) {
        if (std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() > seconds) return kill();
        usleep(500);
    }
    forget();
}

void WorkerHandle::kill() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    int status = 0;
    waitpid(pid_, &status, 0);
    forget();
}

}  // namespace alder::jobs
