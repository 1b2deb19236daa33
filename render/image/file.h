// Files that are either complete or not there: written under a temporary name beside the target, synced, renamed.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace alder {

class AtomicFile {
  public:
    /// Opens the temporary file; see error().
    explicit AtomicFile(std::string path);
    ~AtomicFile();   ///< removes the temporary file unless commit() succeeded
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    bool write(const void* data, size_t bytes);
    bool seek(uint64_t position);
    uint64_t position() const { return position_; }
    /// Makes the file visible under its name. False: it is not, and error() says why.
    bool commit();
    const std::string& error() const { return error_; }

  private:
    bool fail(const char* what);
    bool flush();
    std::string path_, temporary_, error_;
    int fd_ = -1;
    uint64_t position_ = 0;         ///< where the next write goes
    std::vector<char> buffer_;      ///< ends at position_
};

bool write_file(const std::string& path, std::span<const uint8_t> bytes, std::string& error);
/// Reads at most `limit` bytes; a longer file is an error, not a truncation.
bool read_file(const std::string& path, uint64_t limit, std::vector<uint8_t>& bytes, std::string& error);

}  // namespace alder
