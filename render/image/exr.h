// EXR files: an Image with all its layers in one part, scan lines, names as compositing programs expect them; and back.
// Equal images give equal bytes: nothing of time, host, path or thread count is written.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/image/image.h"

namespace alder {

struct ExrOptions {
    bool all_float = false;   ///< colour as 32-bit float too; data layers always are
    enum class Compression : uint8_t { None, Zip, Zips, Piz, Rle } compression = Compression::Zip;
};

/// The file as bytes; empty and a reason in `error` where the image cannot be written.
std::vector<uint8_t> encode_exr(const Image& image, const ExrOptions& options, std::string& error);
/// To a temporary name, then renamed: the file is whole or not there.
bool write_exr(const std::string& path, const Image& image, const ExrOptions& options, std::string& error);

/// Checked on the header, before pixels are allocated.
struct ExrLimits {
    int side = 32768;
    int channels = 1024;
    uint64_t bytes = uint64_t(4) << 30;   ///< of all planes as float
};
/// Single-part files of scan lines or tiles. Layers come back beauty first, then by name; `data` is set for layers that the
/// file holds as float.
std::optional<Image> read_exr(const std::string& path, std::string& error, const ExrLimits& limits = {});
std::optional<Image> decode_exr(std::span<const uint8_t> bytes, std::string& error, const ExrLimits& limits = {});

}  // namespace alder
