// Child processes.
#include "clients/cli/ci/child.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>

extern char** environ;

namespace alder::cli {

ChildResult run_program(const std::string& program, const std::vector<std::string>& arguments) {
    ChildResult result;
    const auto start = std::chrono::steady_clock::now();
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) return {3, 0, std::strerror(errno)};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
    std::vector<char*> argv{const_cast<char*>(program.c_str())};
    for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    pid_t pid = 0;
    const int fault = posix_spawnp(&pid, program.c_str(), &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    if (fault != 0) {
        close(ends[0]);
        return {3, 0, program + ": " + std::strerror(fault)};
    }
    char buffer[4096];
    while (true) {
        const ssize_t n = read(ends[0], buffer, sizeof(buffer));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) break;
        result.errors.append(buffer, size_t(n));
        if (result.errors.size() > 8192) result.errors.erase(0, result.errors.size() - 4096);
    }
    close(ends[0]);
    int status = 0;
    while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
    }
    result.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return result;
}

ChildResult run_self(const std::vector<std::string>& arguments) { return run_program("/proc/self/exe", arguments); }

}  // namespace alder::cli
