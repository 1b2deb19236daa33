// The .alder container: a ZIP archive that holds scene.json and the files it names. Any ZIP tool can look into one.
// Names of members are keys, never paths: nothing is unpacked to where a name says.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/image/file.h"

namespace alder {

struct ContainerLimits {
    size_t members = 1 << 20;
    uint64_t bytes = uint64_t(16) << 30;   ///< of all members unpacked
    uint64_t ratio = 200;                  ///< unpacked : file
};

/// Read-only. Thread safe: reading a member touches no shared state.
class Container {
  public:
    ~Container();
    /// Null and a reason where the file is no acceptable archive: the directory is checked against the file's size and the
    /// limits before anything is allocated.
    static std::shared_ptr<const Container> open(const std::string& path, std::string& error, const ContainerLimits& limits = {});
    static std::shared_ptr<const Container> from_memory(std::vector<uint8_t> bytes, std::string& error, const ContainerLimits& limits = {});

    bool has(std::string_view name) const { return members_.find(name) != members_.end(); }
    uint64_t size(std::string_view name) const;   ///< 0 if there is no such member
    std::vector<std::string> names() const;
    /// Unpacks and verifies the checksum.
    bool read(std::string_view name, std::vector<uint8_t>& bytes, std::string& error) const;

  private:
    struct Member {
        uint64_t header = 0, packed = 0, size = 0;
        uint32_t crc = 0;
        bool deflated = false;
    };
    Container() = default;
    bool read_at(uint64_t offset, void* to, size_t n) const;
    bool read_directory(const ContainerLimits& limits, std::string& error);
    bool add_member(const uint8_t* entry, size_t& left, std::string& error, size_t& used);
    int fd_ = -1;
    std::vector<uint8_t> memory_;
    uint64_t file_bytes_ = 0;
    std::map<std::string, Member, std::less<>> members_;
};

/// Writes members uncompressed, without times: the same members give the same bytes.
class ContainerWriter {
  public:
    explicit ContainerWriter(std::string path) : file_(std::move(path)) {}
    bool add(const std::string& name, std::span<const uint8_t> bytes);
    bool commit();
    const std::string& error() const { return error_.empty() ? file_.error() : error_; }

  private:
    struct Entry {
        std::string name;
        uint64_t offset, size;
        uint32_t crc;
    };
    AtomicFile file_;
    std::vector<Entry> entries_;
    std::string error_;
};

}  // namespace alder
