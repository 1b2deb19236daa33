// The store of images in memory; the loader is a module that is opened with the first image.
#include "nodes/texture/image_store.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "nodes/texture/color_space.h"
#include "nodes/texture/image_load.h"

namespace alder {
namespace {

struct Loader {
    decltype(&alder_load_image) load = nullptr;
    std::string fault;
};

/// The module beside the program, or where an installation keeps it.
const Loader& loader() {
    static const Loader instance = [] {
        Loader l;
        std::error_code no_error;
        const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", no_error).parent_path();
        for (const std::filesystem::path& path : {program / "alder_images.so", program.parent_path() / "lib" / "alder" / "alder_images.so"}) {
            void* const module = std::filesystem::exists(path, no_error) ? dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL) : nullptr;
            if (module) l.load = reinterpret_cast<decltype(&alder_load_image)>(dlsym(module, "alder_load_image"));
            if (l.load) return l;
            if (const char* error = dlerror()) l.fault = error;
        }
        if (l.fault.empty()) l.fault = "the image loader alder_images.so is not beside the program";
        return l;
    }();
    return instance;
}

}  // namespace

StoredImage::~StoredImage() {
    if (counter_) counter_->fetch_sub(bytes, std::memory_order_relaxed);
}

ImageStore& ImageStore::shared() {
    static ImageStore* const store = new ImageStore;  // never destroyed: images may outlive static destruction
    return *store;
}

std::shared_ptr<const StoredImage> ImageStore::open(const ImageRequest& request) {
    Key key{request, {}, 0};
    std::error_code no_error;
    key.modified = std::filesystem::last_write_time(request.path, no_error);
    key.size = std::filesystem::file_size(request.path, no_error);
    std::shared_ptr<Entry> entry;
    {
        const std::lock_guard lock(mutex_);
        std::erase_if(entries_, [](const auto& e) { return e.second.expired(); });
        entry = entries_[key].lock();
        if (!entry) entries_[key] = entry = std::make_shared<Entry>();
    }
    std::call_once(entry->loaded, [&] {
        std::string fault = loader().fault;
        if (loader().load) loader().load(request, entry->image, fault);
        if (!entry->image.readable()) report(fmt::format("{}: {}", request.path, fault.empty() ? "cannot be read" : fault));
        entry->image.counter_ = &bytes_;
        bytes_.fetch_add(entry->image.bytes, std::memory_order_relaxed);
    });
    return {entry, &entry->image};
}

void ImageStore::report(const std::string& fault) {
    const std::lock_guard lock(mutex_);
    if (std::find(faults_.begin(), faults_.end(), fault) != faults_.end()) return;
    faults_.push_back(fault);
    spdlog::warn("image {}", fault);
}
std::vector<std::string> ImageStore::faults() const {
    const std::lock_guard lock(mutex_);
    return faults_;
}

ImageRequest parse_image_request(const std::string& json, std::vector<std::string>& errors) {
    ImageRequest request;
    const nlohmann::json j = nlohmann::json::parse(json, nullptr, false);
    if (j.is_null()) return request;
    if (j.is_string()) {
        request.path = j.get<std::string>();
        return request;
    }
    if (!j.is_object()) {
        errors.push_back("image: {\"file\": NAME, \"colorspace\": ..., \"alpha_mode\": ...} expected");
        return request;
    }
    const auto text = [&](const char* name) -> std::string {
        const auto it = j.find(name);
        if (it == j.end() || it->is_null()) return {};
        if (it->is_string()) return it->get<std::string>();
        errors.push_back(fmt::format("image.{}: a string expected", name));
        return {};
    };
    request.path = text("file");
    request.color_space = text("colorspace");
    if (request.color_space == "auto" || request.color_space == "__builtin_auto") request.color_space.clear();
    if (!request.color_space.empty() && !find_color_space(request.color_space))
        errors.push_back(fmt::format("image.colorspace: \"{}\" is not known; there are {}", request.color_space, fmt::join(color_space_names(), ", ")));
    const std::string alpha = text("alpha_mode");
    if (alpha.empty() || alpha == "STRAIGHT" || alpha == "unassociated" || alpha == "auto") request.alpha = AlphaMode::Straight;
    else if (alpha == "PREMUL" || alpha == "associated") request.alpha = AlphaMode::Premultiplied;
    else if (alpha == "CHANNEL_PACKED" || alpha == "channel_packed") request.alpha = AlphaMode::ChannelPacked;
    else if (alpha == "NONE" || alpha == "ignore") request.alpha = AlphaMode::None;
    else errors.push_back(fmt::format("image.alpha_mode: \"{}\" is not known; there are STRAIGHT, PREMUL, CHANNEL_PACKED, NONE", alpha));
    return request;
}

}  // namespace alder
