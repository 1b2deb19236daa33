// Engine: compiled materials, prepared stages, and which files a document may name.
#include "server/engine.h"

#include <fcntl.h>
#include <linux/openat2.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include <fmt/format.h>

#include "render/stages.h"
#include "server/digest.h"
#include "server/errors.h"

namespace alder {
namespace {

constexpr size_t kDressedMost = 16;   // stages with a material on, each a few megabytes of programs and light tables

/// Whether `name` is a regular file beneath `root`, reached without any symbolic link.
bool is_beneath(const std::string& root, const std::string& name, bool& absent) {
    const int folder = ::open(root.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0) return false;
    open_how how{};
    how.flags = O_RDONLY | O_CLOEXEC | O_NONBLOCK;
    how.resolve = RESOLVE_BENEATH | RESOLVE_NO_SYMLINKS | RESOLVE_NO_MAGICLINKS;
    const int fd = static_cast<int>(syscall(SYS_openat2, folder, name.c_str(), &how, sizeof how));
    if (fd >= 0 || errno != ENOENT) absent = false;
    ::close(folder);
    if (fd < 0) return false;
    struct stat info{};
    const bool regular = fstat(fd, &info) == 0 && S_ISREG(info.st_mode);
    ::close(fd);
    return regular;
}

}  // namespace

void throw_missing(const std::vector<std::string>& missing) {
    Problem p{"asset-missing", fmt::format("{} asset{} not in the store", missing.size(), missing.size() == 1 ? " is" : "s are")};
    p.extra["missing"] = missing;
    throw p;
}

Engine::Engine(AssetStore& assets, std::vector<std::string> asset_roots, int threads)
    : assets_(assets), asset_roots_(std::move(asset_roots)), threads_(threads), materials_(1024) {}

std::string Engine::resolve_file(const std::string& name, std::string& error) const {
    if (asset_roots_.empty()) {
        error = "this daemon serves no files by name: name an asset by its digest, or start it with --asset-root";
        return {};
    }
    if (name.empty() || name[0] == '/' || name.find('\0') != std::string::npos) {
        error = "only relative names below an asset root are served";
        return {};
    }
    bool absent = true;
    for (const std::string& root : asset_roots_)
        if (is_beneath(root, name, absent)) return root + "/" + name;
    if (absent) return error = fmt::format("'{}': {}", name, kNoSuchFile), std::string();
    error = fmt::format("'{}' is not a file below an asset root (symbolic links are not followed)", name);
    return {};
}

std::string Engine::resolve(const nlohmann::json& image, std::string& error, std::vector<std::string>* missing) const {
    std::string asset, file;
    if (image.is_string()) {
        file = image.get<std::string>();
        if (file.rfind("sha256:", 0) == 0) std::swap(asset, file);
    } else if (image.is_object()) {
        if (const auto it = image.find("asset"); it != image.end() && it->is_string()) asset = it->get<std::string>();
        if (const auto it = image.find("file"); it != image.end() && it->is_string()) file = it->get<std::string>();
    }
    if (!asset.empty()) {
        const std::string hex = digest_hex(asset);
        if (hex.empty()) {
            error = "an asset is named sha256: and 64 lower-case hexadecimal digits";
            return {};
        }
        if (assets_.has(hex)) return assets_.path(hex);
        if (missing && std::find(missing->begin(), missing->end(), asset) == missing->end()) missing->push_back(asset);
        error = "the asset is not in the store";
        return {};
    }
    if (!file.empty()) return resolve_file(file, error);
    error = "an image is {\"asset\": \"sha256:...\"} or {\"file\": NAME}";
    return {};
}

std::shared_ptr<const Material> Engine::material(const nlohmann::json& graph, const std::string& prefix, bool lenient, Diagnostics& d, bool strict) {
    std::vector<std::string> missing;
    MaterialOptions options;
    options.lenient = lenient;
    options.strict = strict;
    options.pointer_prefix = prefix;
    options.resolve_image = [&](const nlohmann::json& image, std::string& error) { return resolve(image, error, &missing); };
    auto material = materials_.get(graph, options, d);
    if (!missing.empty()) throw_missing(missing);
    if (!material || !d.ok()) throw problem_from("graph-invalid", d);
    return material;
}

std::shared_ptr<const PreparedScene> Engine::base_stage(const std::string& name, Diagnostics& d) {
    std::shared_ptr<BaseStage> base;
    {
        const std::lock_guard lock(stages_mutex_);
        auto& slot = stages_[name];
        if (!slot) slot = std::make_shared<BaseStage>();
        base = slot;
    }
    const std::lock_guard lock(base->building);
    if (base->scene) return base->scene;
    const auto scene = make_stage(name, nullptr, 256, d);
    if (!scene) throw problem_from("settings-invalid", d);
    base->scene = prepare_scene(scene, context_, d);
    if (!base->scene) throw problem_from("internal", d);
    return base->scene;
}

void Engine::warm_up() {
    Diagnostics d;
    base_stage("shaderball", d);
}

std::shared_ptr<const PreparedScene> Engine::stage(const std::string& name, std::shared_ptr<const Material> material, Diagnostics& d) {
    {
        const std::lock_guard lock(stages_mutex_);
        for (auto it = dressed_.begin(); it != dressed_.end(); ++it)
            if (it->stage == name && it->material == material) {
                dressed_.splice(dressed_.begin(), dressed_, it);
                return dressed_.front().scene;
            }
    }
    auto scene = with_material(base_stage(name, d), 0, material, d);
    if (!scene || !d.ok()) throw problem_from("graph-invalid", d);
    const std::lock_guard lock(stages_mutex_);
    dressed_.push_front({name, std::move(material), scene});
    if (dressed_.size() > kDressedMost) dressed_.pop_back();
    return scene;
}

}  // namespace alder
