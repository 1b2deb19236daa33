// The asset store: files named by the SHA-256 of their content.
#include "server/assets.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>

#include "server/digest.h"

namespace alder {
namespace {

namespace fs = std::filesystem;

bool sync_folder(const std::string& folder) {
    const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) return false;
    const bool ok = fsync(fd) == 0;
    ::close(fd);
    return ok;
}

bool write_all(int fd, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::write(fd, bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        bytes.remove_prefix(static_cast<size_t>(n));
    }
    return true;
}

std::string temporary_name(const std::string& folder) {
    static std::atomic<uint64_t> counter{0};
    return fmt::format("{}/{}.{}", folder, getpid(), counter++);
}

}  // namespace

bool write_durably(const std::string& path, std::string_view bytes) {
    const std::string folder = fs::path(path).parent_path().string();
    const std::string temporary = temporary_name(folder) + ".tmp";
    const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
    if (fd < 0) return false;
    const bool written = write_all(fd, bytes) && fsync(fd) == 0;
    ::close(fd);
    if (!written || ::rename(temporary.c_str(), path.c_str()) != 0) {
        ::unlink(temporary.c_str());
        return false;
    }
    return sync_folder(folder);
}

struct AssetStore::Upload::Impl {
    std::string folder, temporary;
    int fd = -1;
    uint64_t bytes = 0;
    std::atomic<uint64_t>* total = nullptr;
    Sha256 hash;
    ~Impl() {
        if (fd >= 0) ::close(fd);
        if (!temporary.empty()) ::unlink(temporary.c_str());
    }
};
AssetStore::Upload::Upload(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
AssetStore::Upload::~Upload() = default;

AssetStore::AssetStore(std::string folder, bool owner) : folder_(std::move(folder)) {
    std::error_code code;
    fs::create_directories(folder_ + "/incoming", code);
    if (code) {
        error_ = fmt::format("cannot make {}: {}", folder_, code.message());
        return;
    }
    if (!owner) return;
    for (const auto& entry : fs::directory_iterator(folder_ + "/incoming", code)) fs::remove(entry.path(), code);   // of a killed run
}

std::string AssetStore::path(const std::string& hex) const { return fmt::format("{}/{}/{}", folder_, hex.substr(0, 2), hex); }
bool AssetStore::has(const std::string& hex) const { return ::access(path(hex).c_str(), R_OK) == 0; }
std::optional<uint64_t> AssetStore::size(const std::string& hex) const {
    struct stat info{};
    if (::stat(path(hex).c_str(), &info) != 0) return std::nullopt;
    return static_cast<uint64_t>(info.st_size);
}
bool AssetStore::remove(const std::string& hex) { return ::unlink(path(hex).c_str()) == 0; }

void AssetStore::touch(const std::string& hex) const { ::utimensat(AT_FDCWD, path(hex).c_str(), nullptr, 0); }

bool AssetStore::adopt(const std::string& file, const std::string& hex) {
    const auto size = fs::path(file).empty() ? 0 : fs::file_size(file);
    const std::string folder = fmt::format("{}/{}", folder_, hex.substr(0, 2));
    const bool made = ::mkdir(folder.c_str(), 0755) == 0;
    if (!made && errno != EEXIST) return false;
    if (made && !sync_folder(folder_)) return false;
    if (::rename(file.c_str(), path(hex).c_str()) != 0 || !sync_folder(folder)) return false;
    touch(hex);
    bytes_ += size;
    return true;
}

uint64_t AssetStore::collect(double seconds, const std::function<bool(const std::string&)>& wanted) {
    uint64_t kept = 0, removed = 0;
    const auto is_old = [&](const struct stat& info) { return static_cast<double>(time(nullptr) - info.st_mtime) > seconds; };
    std::error_code code;
    for (fs::directory_iterator folder(folder_, code), end; !code && folder != end; folder.increment(code)) {
        const std::string name = folder->path().filename().string();
        const bool uploads = name == "uploads";
        if (name.size() != 2 && !uploads) continue;
        std::error_code inner;
        for (fs::directory_iterator file(folder->path(), inner), last; !inner && file != last; file.increment(inner)) {
            struct stat info {};
            if (::stat(file->path().c_str(), &info) != 0) continue;
            const std::string hex = file->path().filename().string();
            // Looked at again after `wanted`, which takes its time: who was told meanwhile that it is there has touched it.
            const bool rubbish = is_old(info) && (uploads || !wanted(hex)) && ::stat(file->path().c_str(), &info) == 0 && is_old(info);
            if (rubbish && ::unlink(file->path().c_str()) == 0) removed += static_cast<uint64_t>(info.st_size);
            else kept += static_cast<uint64_t>(info.st_size);
        }
    }
    bytes_ = kept;
    return removed;
}

bool AssetStore::has_room(uint64_t bytes) const {
    if (quota_ > 0 && bytes_ + bytes > quota_) return false;
    struct statvfs disk{};
    if (statvfs(folder_.c_str(), &disk) != 0) return false;
    const uint64_t free_bytes = static_cast<uint64_t>(disk.f_bavail) * disk.f_frsize;
    const uint64_t reserve = static_cast<uint64_t>(disk.f_blocks) * disk.f_frsize / 50;   // 2 %: where /readyz stops too
    return free_bytes > reserve && free_bytes - reserve >= bytes;
}

std::unique_ptr<AssetStore::Upload> AssetStore::begin() {
    auto impl = std::make_unique<Upload::Impl>();
    impl->folder = folder_;
    impl->total = &bytes_;
    const std::string name = temporary_name(folder_ + "/incoming");
    impl->fd = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
    if (impl->fd < 0) return nullptr;
    impl->temporary = name;
    return std::unique_ptr<Upload>(new Upload(std::move(impl)));
}

bool AssetStore::Upload::write(std::string_view bytes) {
    impl_->hash.update(bytes);
    impl_->bytes += bytes.size();
    return write_all(impl_->fd, bytes);
}
std::string AssetStore::Upload::hex() { return impl_->hash.hex(); }

bool AssetStore::Upload::commit(const std::string& hex) {
    if (fsync(impl_->fd) != 0) return false;
    const std::string folder = fmt::format("{}/{}", impl_->folder, hex.substr(0, 2));
    const bool made = ::mkdir(folder.c_str(), 0755) == 0;
    if (!made && errno != EEXIST) return false;
    if (made && !sync_folder(impl_->folder)) return false;
    if (::rename(impl_->temporary.c_str(), fmt::format("{}/{}", folder, hex).c_str()) != 0) return false;
    impl_->temporary.clear();
    *impl_->total += impl_->bytes;
    return sync_folder(folder);
}

}  // namespace alder
