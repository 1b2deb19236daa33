// Files for what exists only in memory: images inside containers and .glb files, which readers of images want as files.
#pragma once
#include <cstdint>
#include <span>
#include <string>

namespace alder {

/// Writes the bytes into this process's own temporary folder, named by their digest (so once), and returns the path. Empty and
/// a reason in `error` where that fails. `extension` (".png") only helps readers that look at names. The folder is private to
/// the user and removed when the process ends in good order.
std::string store_temporary_asset(std::span<const uint8_t> bytes, const std::string& extension, std::string& error);

}  // namespace alder
