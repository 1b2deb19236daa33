// What `alder render` and `alder preview` share.
#include "clients/cli/picture.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <mutex>

#include <fmt/format.h>

#include "clients/cli/common.h"
#include "graph/json_text.h"
#include "nodes/texture/image_store.h"

namespace alder::cli {
namespace {

std::atomic<bool> interrupted{false};
std::atomic<bool> progress_shown{false};

void on_signal(int) {
    if (interrupted.exchange(true)) _exit(kInterrupted);
}

std::string lower_extension(const std::string& path) {
    const size_t dot = path.rfind('.');
    std::string e = dot == std::string::npos ? "" : path.substr(dot);
    for (char& c : e) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return e;
}

}  // namespace

const std::atomic<bool>& interruptible() {
    struct sigaction action {};
    action.sa_handler = on_signal;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    return interrupted;
}

void check_image_name(const std::string& path) {
    const std::string e = lower_extension(path);
    if (e != ".exr" && e != ".png" && e != ".jpg" && e != ".jpeg") fail(kWrong, path + ": the name must end in .exr, .png, .jpg or .jpeg");
}

void write_image(const std::string& path, const Image& image, const ExrOptions& exr, const View& view) {
    const std::string e = lower_extension(path);
    std::string error;
    const std::vector<uint8_t> bytes = e == ".exr" ? encode_exr(image, exr, error) : e == ".png" ? encode_png(image, view, error) : encode_jpeg(image, view, error);
    if (bytes.empty()) fail(kWrong, path + ": " + error);
    write_bytes(path, bytes.data(), bytes.size());
}

void parse_resolution(const std::string& text, RenderRequest& request) {
    char end = 0;
    if (std::sscanf(text.c_str(), "%dx%d%c", &request.width, &request.height, &end) != 2 || request.width < 1 || request.height < 1 || request.width > 16384 ||
        request.height > 16384)
        fail(kWrong, "--resolution " + text + ": expected WIDTHxHEIGHT, 1 to 16384 each");
}

void parse_crop(const std::string& text, RenderRequest& request) {
    char end = 0;
    int* c = request.crop;
    if (std::sscanf(text.c_str(), "%d,%d,%d,%d%c", c, c + 1, c + 2, c + 3, &end) != 4 || c[0] < 0 || c[1] < 0 || c[0] >= c[2] || c[1] >= c[3])
        fail(kWrong, "--crop " + text + ": expected x0,y0,x1,y1 with x0 < x1 and y0 < y1");
}

Setting parse_setting(const std::string& text) {
    const size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) fail(kWrong, "--set " + text + ": expected MATERIAL/NODE.PARAM=VALUE");
    Diagnostics d;
    const std::string value = text.substr(equals + 1);
    auto json = parse_json(value, JsonLimits{}, d);
    return {text.substr(0, equals), json ? std::move(*json) : nlohmann::json(value)};
}

std::shared_ptr<const Material> apply_setting(const Material& material, const std::string& node_param, const nlohmann::json& value, const std::string& text) {
    const auto& document = material.document();
    const auto nodes = document.find("nodes");
    for (size_t dot = node_param.rfind('.'); dot != std::string::npos && dot > 0; dot = node_param.rfind('.', dot - 1)) {
        const std::string node = node_param.substr(0, dot);
        if (nodes == document.end() || !nodes->contains(node)) continue;
        Diagnostics d;
        auto edited = material.with_param("/nodes/" + pointer_token(node) + "/params/" + pointer_token(node_param.substr(dot + 1)), value, d);
        report("--set " + text, d);
        if (!edited) fail(kWrong, "--set " + text + ": cannot be applied");
        return edited;
    }
    std::vector<std::string> names;
    if (nodes != document.end())
        for (const auto& [name, node] : nodes->items()) names.push_back(name);
    const std::string near = nearest_name(node_param.substr(0, node_param.rfind('.')), names);
    fail(kWrong, fmt::format("--set {}: the graph has no such node{}", text, near.empty() ? "" : fmt::format("; did you mean '{}'?", near)));
}

uint64_t peak_memory_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<uint64_t>(usage.ru_maxrss) * 1024;
}

namespace {
nlohmann::json texture_usage() {
    const ImageStore::Usage u = ImageStore::shared().usage();
    return {{"budget_bytes", u.budget_bytes}, {"whole_bytes", u.whole_bytes}, {"tile_bytes", u.tile_bytes}, {"read_ahead_bytes", u.read_bytes},
            {"images_whole", u.whole_images}, {"images_tiled", u.tiled_images}, {"tile_requests", u.tile_requests}, {"tile_misses", u.tile_misses},
            {"tiles_read", u.tiles_read}, {"tiles_averaged", u.tiles_averaged}, {"tiles_dropped", u.tiles_dropped}, {"faults", ImageStore::shared().faults()}};
}
}  // namespace

nlohmann::json statistics(const RenderStats& s, double load_seconds, double write_seconds) {
    return {{"seconds", {{"load", load_seconds}, {"build", s.build_seconds}, {"compile", s.compile_seconds}, {"render", s.render_seconds}, {"write", write_seconds}}},
            {"rays", {{"camera", s.camera_rays}, {"bounce", s.bounce_rays}, {"shadow", s.shadow_rays}, {"subsurface", s.subsurface_rays}, {"timed_paths", s.timed_paths}, {"total", s.camera_rays + s.bounce_rays + s.shadow_rays + s.subsurface_rays}}},
            {"shading_points", s.shading_points},
            {"medium_segments", s.medium_segments},
            {"medium_points", s.medium_points},
            {"media_ignored", s.media_ignored},
            {"node_evaluations", s.node_evaluations},
            {"node_evaluations_skipped", s.node_skipped},
            {"nonfinite_samples", s.nonfinite_samples},
            {"samples", s.samples},
            {"estimated_error", s.estimated_error},
            {"complete", s.complete},
            {"skipped", s.skipped},
            {"textures", texture_usage()},
            {"peak_memory_bytes", peak_memory_bytes()}};
}

std::function<void(double)> progress_printer(bool quiet, bool lines) {
    if (lines)
        return [](double fraction) {
            static std::mutex mutex;
            static int told = -1;
            const std::lock_guard lock(mutex);
            const int thousandths = static_cast<int>(fraction * 1000);
            if (thousandths == told) return;
            told = thousandths;
            std::fprintf(stderr, "progress %.3f\n", fraction);
            std::fflush(stderr);
        };
    if (quiet || !isatty(STDERR_FILENO)) return {};
    return [](double fraction) {
        static std::mutex mutex;
        static int shown = -1;
        const std::lock_guard lock(mutex);
        const int percent = static_cast<int>(fraction * 100);
        if (percent == shown) return;
        shown = percent;
        progress_shown = true;
        std::fprintf(stderr, "\r%3d %%", percent);
    };
}
void end_progress() {
    if (progress_shown.exchange(false)) std::fprintf(stderr, "\r     \r");
}

}  // namespace alder::cli
