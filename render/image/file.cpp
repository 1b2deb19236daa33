// Files that are either complete or not there.
#include "render/image/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>

namespace alder {
namespace {

constexpr size_t kBufferBytes = size_t(1) << 20;

std::string temporary_name(const std::string& path) {
    static std::atomic<unsigned> counter{0};
    const std::filesystem::path p(path);
    const std::string name = "." + p.filename().string() + "." + std::to_string(getpid()) + "-" + std::to_string(counter++) + ".tmp";
    return (p.parent_path() / name).string();
}

}  // namespace

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)), temporary_(temporary_name(path_)) {
    fd_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd_ < 0) fail("cannot create");
}

AtomicFile::~AtomicFile() {
    if (fd_ < 0) return;
    ::close(fd_);
    ::unlink(temporary_.c_str());
}

bool AtomicFile::fail(const char* what) {
    if (error_.empty()) error_ = path_ + ": " + what + ": " + std::strerror(errno);
    return false;
}

bool AtomicFile::flush() {
    const char* p = buffer_.data();
    size_t left = buffer_.size();
    while (left > 0) {
        const ssize_t n = ::pwrite(fd_, p, left, off_t(position_ - left));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return fail("cannot write");
        p += n;
        left -= size_t(n);
    }
    buffer_.clear();
    return true;
}

bool AtomicFile::write(const void* data, size_t bytes) {
    if (!error_.empty()) return false;
    const char* p = static_cast<const char*>(data);
    buffer_.insert(buffer_.end(), p, p + bytes);
    position_ += bytes;
    return buffer_.size() < kBufferBytes || flush();
}

bool AtomicFile::seek(uint64_t position) {
    if (!error_.empty() || !flush()) return false;
    position_ = position;
    return true;
}

bool AtomicFile::commit() {
    if (!error_.empty() || !flush()) return false;
    if (::fsync(fd_) != 0 && errno != EINVAL && errno != EROFS) return fail("cannot sync");
    if (::rename(temporary_.c_str(), path_.c_str()) != 0) return fail("cannot rename");
    ::close(fd_);
    fd_ = -1;
    // The new name is durable only when the directory is; file systems that cannot sync one (EINVAL) are taken as they are.
    const std::string parent = std::filesystem::path(path_).parent_path().string();
    const int dir = ::open(parent.empty() ? "." : parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (dir >= 0) {
        ::fsync(dir);
        ::close(dir);
    }
    return true;
}

bool write_file(const std::string& path, std::span<const uint8_t> bytes, std::string& error) {
    AtomicFile f(path);
    if (f.write(bytes.data(), bytes.size()) && f.commit()) return true;
    error = f.error();
    return false;
}

bool read_file(const std::string& path, uint64_t limit, std::vector<uint8_t>& bytes, std::string& error) {
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat st {};
    if (fd < 0 || ::fstat(fd, &st) != 0) {
        error = path + ": cannot read: " + std::strerror(errno);
        if (fd >= 0) ::close(fd);
        return false;
    }
    bool ok = false;
    if (!S_ISREG(st.st_mode)) {
        error = path + ": not a file";
    } else if (uint64_t(st.st_size) > limit) {
        error = path + ": " + std::to_string(st.st_size) + " bytes, more than the limit of " + std::to_string(limit);
    } else {
        bytes.resize(size_t(st.st_size));
        size_t have = 0;
        ssize_t n = 0;
        while (have < bytes.size() && (n = ::read(fd, bytes.data() + have, bytes.size() - have)) != 0) {
            if (n < 0 && errno == EINTR) continue;
            if (n < 0) break;
            have += size_t(n);
        }
        ok = have == bytes.size();
        if (!ok) error = path + ": cannot read: " + (n < 0 ? std::strerror(errno) : "it became shorter while being read");
    }
    ::close(fd);
    return ok;
}

}  // namespace alder
