// What `alder render` and `alder preview` share: interruption, writing images, edits by --set, statistics.
#pragma once
#include <atomic>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "graph/material.h"
#include "render/image/exr.h"
#include "render/image/view.h"
#include "render/render.h"

namespace alder::cli {

/// From now on the first SIGINT or SIGTERM sets the flag; the second ends the process.
const std::atomic<bool>& interruptible();

/// By the extension: .exr, .png, .jpg or .jpeg. Fails where it cannot be written.
void write_image(const std::string& path, const Image& image, const ExrOptions& exr, const View& view);
/// Fails early where the extension is not one of these.
void check_image_name(const std::string& path);

/// "WxH".
void parse_resolution(const std::string& text, RenderRequest& request);
/// "x0,y0,x1,y1".
void parse_crop(const std::string& text, RenderRequest& request);

/// One --set: "NODE.PARAM=VALUE"; the value is JSON, or else a string.
struct Setting {
    std::string target;   ///< "NODE.PARAM" or "MATERIAL/NODE.PARAM"
    nlohmann::json value;
};
Setting parse_setting(const std::string& text);
/// The material with the setting applied; `node_param` is "NODE.PARAM", split at the last dot that names a node.
std::shared_ptr<const Material> apply_setting(const Material& material, const std::string& node_param, const nlohmann::json& value, const std::string& text);

/// Peak memory of this process so far.
uint64_t peak_memory_bytes();
nlohmann::json statistics(const RenderStats& stats, double load_seconds, double write_seconds);

/// Prints progress on stderr where that is a terminal and `quiet` is not set; with `lines`, for programs, as lines "progress 0.43".
std::function<void(double)> progress_printer(bool quiet, bool lines = false);
void end_progress();

}  // namespace alder::cli
