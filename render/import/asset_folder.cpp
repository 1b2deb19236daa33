// Files for what exists only in memory.
#include "render/import/asset_folder.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <mutex>

#include "graph/digest.h"
#include "render/image/file.h"

namespace alder {
namespace {

class TemporaryFolder {
  public:
    TemporaryFolder() {
        std::error_code ec;
        std::string name = (std::filesystem::temp_directory_path(ec) / "alder-XXXXXX").string();
        if (!ec && ::mkdtemp(name.data())) path_ = name;
    }
    ~TemporaryFolder() {
        std::error_code ec;
        if (!path_.empty()) std::filesystem::remove_all(path_, ec);
    }
    const std::string& path() const { return path_; }

  private:
    std::string path_;
};

}  // namespace

std::string store_temporary_asset(std::span<const uint8_t> bytes, const std::string& extension, std::string& error) {
    static TemporaryFolder folder;
    static std::mutex mutex;
    if (folder.path().empty()) {
        error = "there is no folder for temporary files";
        return {};
    }
    const std::string digest = sha256_hex({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    const bool plain = extension.size() > 1 && extension.size() <= 8 && extension.find_first_not_of(".abcdefghijklmnopqrstuvwxyz0123456789") == std::string::npos;
    const std::string path = folder.path() + "/" + digest + (plain ? extension : "");
    const std::lock_guard lock(mutex);
    std::error_code ec;
    if (std::filesystem::exists(path, ec)) return path;
    return write_file(path, bytes, error) ? path : std::string();
}

}  // namespace alder
