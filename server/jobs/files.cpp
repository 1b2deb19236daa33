// Files of renders: written so that they are whole or not there.
#include "server/jobs/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <filesystem>

#include <fmt/format.h>

#include "server/digest.h"
#include "server/jobs/job.h"

namespace alder::jobs {

namespace fs = std::filesystem;

bool is_no_space(int error) { return error == ENOSPC || error == EDQUOT || error == EFBIG; }

int write_all(int fd, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::write(fd, bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return n == 0 ? ENOSPC : errno;
        bytes.remove_prefix(static_cast<size_t>(n));
    }
    return 0;
}

int sync_folder(const std::string& folder) {
    const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) return errno;
    const int error = fsync(fd) == 0 ? 0 : errno;
    ::close(fd);
    return error;
}

int write_whole(const std::string& path, const std::function<int(int fd)>& write) {
    static std::atomic<uint64_t> counter{0};
    const std::string temporary = fmt::format("{}.{}.{}.tmp", path, getpid(), counter++);
    const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
    if (fd < 0) return errno;
    int error = write(fd);
    if (!error && fsync(fd) != 0) error = errno;
    if (::close(fd) != 0 && !error) error = errno;
    if (!error && ::rename(temporary.c_str(), path.c_str()) != 0) error = errno;
    if (error) {
        ::unlink(temporary.c_str());
        return error;
    }
    return sync_folder(fs::path(path).parent_path().string());
}

int write_whole(const std::string& path, std::string_view bytes) {
    return write_whole(path, [bytes](int fd) { return write_all(fd, bytes); });
}

int RenderFolder::prepare() const {
    std::error_code code;
    const bool made = fs::create_directories(outputs(), code);
    if (code) return code.value();
    if (made)
        for (const std::string& folder : {root, fs::path(root).parent_path().string()})
            if (const int error = sync_folder(folder)) return error;
    for (const std::string& folder : {root, outputs()})
        for (const auto& entry : fs::directory_iterator(folder, code))
            if (entry.path().extension() == ".tmp") fs::remove(entry.path(), code);
    return 0;
}

void RenderFolder::remove() const {
    std::error_code code;
    fs::remove_all(root, code);
}

void append_log(const std::string& path, const char* level, std::string_view text) {
    const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    if (fd < 0) return;
    std::string line(text.substr(0, 16 << 10));
    for (char& c : line)
        if (static_cast<unsigned char>(c) < 0x20) c = ' ';
    (void)!write_all(fd, fmt::format("{} {:5} {}\n", time_text(wall_seconds()).get<std::string>(), level, line));
    ::close(fd);
}

std::string file_digest(const std::string& path) {
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) return {};
    Sha256 hash;
    char piece[64 << 10];
    ssize_t n = 0;
    while ((n = ::read(fd, piece, sizeof piece)) > 0) hash.update({piece, static_cast<size_t>(n)});
    ::close(fd);
    return n < 0 ? std::string() : hash.hex();
}

}  // namespace alder::jobs
