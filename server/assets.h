// The asset store: files named by the SHA-256 of their content. A name that is there is whole and on disk; two clients may
// send the same content at once.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace alder {

class AssetStore {
  public:
    /// Makes the folders below `folder` where needed. Check error().
    explicit AssetStore(std::string folder);
    const std::string& error() const { return error_; }

    bool has(const std::string& hex) const;
    std::string path(const std::string& hex) const;   ///< for readers inside this process; the file may not be there
    std::optional<uint64_t> size(const std::string& hex) const;
    bool remove(const std::string& hex);
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
};

/// Writes a small file so that it is whole or not there: temporary name, fsync, rename, fsync of the folder.
bool write_durably(const std::string& path, std::string_view bytes);

}  // namespace alder
