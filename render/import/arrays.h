// Arrays of numbers in a scene document: written out, as base64, or as a part of a buffer (a member of the container, a file
// beside the document, an asset). Sizes are checked before anything is allocated.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "graph/diagnostic.h"

namespace alder {

/// Reads a whole buffer by name; false and a reason where it is not there.
using BufferReader = std::function<bool(const std::string& name, std::vector<uint8_t>& bytes, std::string& error)>;

class ArrayReader {
  public:
    ArrayReader(BufferReader read, uint64_t byte_limit, Diagnostics& d) : read_(std::move(read)), bytes_left_(byte_limit), d_(d) {}

    /// `channels` numbers an element; `count` elements, or any number if SIZE_MAX. Finite unless `allow_nonfinite`.
    bool floats(const nlohmann::json& j, const std::string& pointer, int channels, size_t count, std::vector<float>& out);
    /// Whole numbers below `limit`.
    bool indices(const nlohmann::json& j, const std::string& pointer, int channels, size_t count, uint64_t limit, std::vector<uint32_t>& out);

  private:
    struct Span {
        std::shared_ptr<const std::vector<uint8_t>> bytes;
        size_t offset = 0, numbers = 0;
        int type = 0;
    };
    bool locate(const nlohmann::json& j, const std::string& pointer, int channels, Span& span);
    bool buffer(const std::string& name, const std::string& pointer, Span& span);
    bool charge(uint64_t bytes, const std::string& pointer);
    bool check_count(size_t numbers, const std::string& pointer, int channels, size_t count);
    bool flatten(const nlohmann::json& j, const std::string& pointer, int channels, std::vector<double>& out);
    BufferReader read_;
    uint64_t bytes_left_;
    Diagnostics& d_;
    std::map<std::string, std::shared_ptr<const std::vector<uint8_t>>> buffers_;
};

std::string encode_base64(const void* data, size_t bytes);
/// False where the text is not base64 (padding may be absent).
bool decode_base64(std::string_view text, std::vector<uint8_t>& bytes);

}  // namespace alder
