// The asset store: files named by the SHA-256 of their content. A name that is there is whole and on disk; two clients may
// send the same content at once.
#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace alder {

class AssetStore {
  public:
    /// Makes the folders below `folder` where needed. Check error(). Who does not own the store leaves uploads in progress alone.
    explicit AssetStore(std::string folder, bool owner = true);
    const std::string& error() const { return error_; }

    bool has(const std::string& hex) const;
    std::string path(const std::string& hex) const;   ///< for readers inside this process; the file may not be there
    std::optional<uint64_t> size(const std::string& hex) const;
    bool remove(const std::string& hex);
    /// Used again: counts as new for what removes old ones.
    void touch(const std::string& hex) const;
    /// Takes a whole file of this file system, whose digest is known, into the store.
    bool adopt(const std::string& file, const std::string& hex);
    /// Removes assets older than `seconds` that `wanted` does not name, and uploads left unfinished for so long. Bytes that went.
    uint64_t collect(double seconds, const std::function<bool(const std::string& hex)>& wanted);
    /// Bytes of all assets, as counted last, and what they may be together (0: the disk decides).
    uint64_t bytes() const { return bytes_; }
    void set_quota(uint64_t bytes) { quota_ = bytes; }
    /// Whether `bytes` more would leave the disk with its reserve.
    bool has_room(uint64_t bytes) const;

    /// One upload in progress: written to a temporary name, hashed on the way. Gone without a trace unless committed.
    class Upload {
      public:
        ~Upload();
        bool write(std::string_view bytes);
        /// What was received so far, finished: call once, before commit.
        std::string hex();
        /// On disk under its digest: file synced, renamed, folder synced.
        bool commit(const std::string& hex);

      private:
        friend class AssetStore;
        struct Impl;
        std::unique_ptr<Impl> impl_;
        explicit Upload(std::unique_ptr<Impl> impl);
    };
    /// Null where the disk refuses.
    std::unique_ptr<Upload> begin();

  private:
    std::string folder_, error_;
    std::atomic<uint64_t> bytes_{0};
    uint64_t quota_ = 0;
};

/// Writes a small file so that it is whole or not there: temporary name, fsync, rename, fsync of the folder.
bool write_durably(const std::string& path, std::string_view bytes);

}  // namespace alder
