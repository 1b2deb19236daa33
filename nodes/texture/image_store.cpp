// The store of images; the loader is a module that is opened with the first image.
#include "nodes/texture/image_store.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "nodes/schema.h"
#include "nodes/texture/color_space.h"
#include "nodes/texture/image_load.h"
#include "nodes/texture/pyramid.h"

namespace alder {
namespace {

constexpr size_t kAlwaysWhole = 16384;  ///< bytes: such an image is smaller than what is kept to find its tiles

struct Loader {
    decltype(&alder_load_image) load = nullptr;
    decltype(&alder_color_names) color_names = nullptr;
    decltype(&alder_image_read_bytes) read_bytes = nullptr;
    std::string fault;
};
std::atomic<bool> loader_open{false};

/// The module beside the program, or where an installation keeps it.
const Loader& loader() {
    static const Loader instance = [] {
        Loader l;
        std::error_code no_error;
        const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", no_error).parent_path();
        for (const std::filesystem::path& path : {program / "alder_images.so", program.parent_path() / "lib" / "alder" / "alder_images.so"}) {
            void* const module = std::filesystem::exists(path, no_error) ? dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL) : nullptr;
            if (module) l.load = reinterpret_cast<decltype(&alder_load_image)>(dlsym(module, "alder_load_image"));
            if (module) l.color_names = reinterpret_cast<decltype(&alder_color_names)>(dlsym(module, "alder_color_names"));
            if (module) l.read_bytes = reinterpret_cast<decltype(&alder_image_read_bytes)>(dlsym(module, "alder_image_read_bytes"));
            if (l.load && l.color_names && l.read_bytes) {
                loader_open = true;
                return l;
            }
            l.load = nullptr;
            if (const char* error = dlerror()) l.fault = error;
        }
        if (l.fault.empty()) l.fault = "the image loader alder_images.so is not beside the program";
        return l;
    }();
    return instance;
}

std::atomic<void (*)(const std::string&)>& fault_listener() {
    static std::atomic<void (*)(const std::string&)> listener{nullptr};
    return listener;
}

std::mutex& configuration_mutex() {
    static std::mutex mutex;
    return mutex;
}
std::string& configuration_path() {
    static std::string path = [] {
        const char* const text = std::getenv("OCIO");
        return std::string(text ? text : "");
    }();
    return path;
}
std::string color_configuration() {
    const std::lock_guard lock(configuration_mutex());
    return configuration_path();
}

/// "PARAMETER: FOUND\nEXPECTED\nSUGGESTION" for a name that neither we nor the configuration know.
void check_color_space(const std::string& name, std::vector<std::string>& errors) {
    if (find_color_space(name)) return;
    std::vector<std::string> names = color_space_names(), every = color_space_names(true);
    std::string further = "further ones need an OpenColorIO configuration ($OCIO)";
    if (const std::string path = color_configuration(); !path.empty()) {
        const ConfigurationNames* const c = loader().color_names ? loader().color_names(path) : nullptr;
        for (const auto* list : {c ? &c->names : nullptr, c ? &c->aliases : nullptr}) {
            if (!list) continue;
            if (std::find(list->begin(), list->end(), name) != list->end()) return;
            every.insert(every.end(), list->begin(), list->end());
        }
        if (c) names.insert(names.end(), c->names.begin(), c->names.end());
        further = !c ? loader().fault : !c->fault.empty() ? c->fault : "those of " + path;
    }
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    errors.push_back(fmt::format("image.colorspace: {}\na colour space: {}; {}\n{}", name, fmt::join(names, ", "), further, nearest_name(name, every)));
}

}  // namespace

void set_image_fault_listener(void (*listener)(const std::string& fault)) { fault_listener() = listener; }

void set_color_configuration(const std::string& path) {
    const std::lock_guard lock(configuration_mutex());
    if (!path.empty()) configuration_path() = path;
}

StoredImage::StoredImage() {
    static std::atomic<uint64_t> next{1};
    id_ = next.fetch_add(1, std::memory_order_relaxed);
}
StoredImage::~StoredImage() {
    if (!store_ || !readable()) return;
    if (is_tiled()) {
        tiles_->drop(id_);
        store_->tiled_.fetch_sub(1, std::memory_order_relaxed);
    } else {
        store_->release(bytes + (pyramid_ ? pyramid_->bytes : 0));
        store_->whole_.fetch_sub(1, std::memory_order_relaxed);
    }
}
const Pyramid& StoredImage::pyramid() const {
    std::call_once(pyramid_made_, [this] {
        pyramid_ = build_pyramid(*this);
        if (store_) store_->add(pyramid_->bytes);
    });
    return *pyramid_;
}
const std::byte* StoredImage::texel(int level, int x, int y) const {
    const std::byte* const from = level == 0 ? pixels.get() : pyramid().pixels.get() + pyramid().offset[level];
    return from + texel_bytes() * (static_cast<size_t>(y) * level_size(width, level) + x);
}
void StoredImage::report_broken(const std::string& reason) const {
    std::call_once(broken_, [&] {
        const std::string fault = fmt::format("{}: {}", path_, reason);
        broken_reason_ = reason;
        is_broken_.store(true, std::memory_order_release);
        if (store_) store_->report(fault);
        // Nobody waits for an answer about it: the warnings of the request have been given.
        if (const auto listener = fault_listener().load()) listener(fault);
    });
}

ImageStore::ImageStore(size_t budget) : budget_(budget), tiles_(std::make_shared<TileCache>(budget)) { share_out(); }
ImageStore::~ImageStore() = default;

ImageStore& ImageStore::shared() {
    static ImageStore* const store = [] {  // never destroyed: images may outlive static destruction
        const char* const text = std::getenv("ALDER_TEXTURE_MIB");
        const long long mib = text ? std::strtoll(text, nullptr, 10) : 0;
        return new ImageStore(mib > 0 && mib < (1ll << 40) ? static_cast<size_t>(mib) << 20 : kDefaultBudget);
    }();
    return *store;
}

void ImageStore::set_budget(size_t bytes) {
    budget_.store(bytes, std::memory_order_relaxed);
    share_out();
}
/// Whole images may take five eighths, the file reader one eighth; tiles get what is left of the budget, a sixteenth at least.
bool ImageStore::reserve(size_t bytes) {
    const size_t most = bytes <= kAlwaysWhole ? SIZE_MAX : budget() / 8 * 5;
    size_t held = bytes_.load(std::memory_order_relaxed);
    do {
        if (bytes > most || held > most - bytes) return false;
    } while (!bytes_.compare_exchange_weak(held, held + bytes, std::memory_order_relaxed));
    share_out();
    return true;
}
void ImageStore::add(size_t bytes) {
    bytes_.fetch_add(bytes, std::memory_order_relaxed);
    share_out();
}
void ImageStore::release(size_t bytes) {
    bytes_.fetch_sub(bytes, std::memory_order_relaxed);
    share_out();
}
void ImageStore::share_out() {
    const size_t spoken_for = bytes() + read_share(), all = budget();
    tiles_->set_limit(std::max(all > spoken_for ? all - spoken_for : 0, all / 16));
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
        StoredImage& image = entry->image;
        image.path_ = request.path;
        image.tiles_ = tiles_;
        size_t held = 0;
        LoadOptions options;
        options.read_cache_bytes = read_share();
        options.color_configuration = color_configuration();
        options.reserve = [&](size_t bytes) {
            if (!reserve(bytes)) return false;
            held += bytes;
            return true;
        };
        std::string fault = std::filesystem::exists(request.path, no_error) ? loader().fault : "there is no such file";
        if (fault.empty()) loader().load(request, options, image, fault);
        if (!image.readable()) {
            image.fault = fault.empty() ? "cannot be read" : fault;
            report(fmt::format("{}: {}", request.path, image.fault));
        }
        const size_t kept = image.readable() && !image.is_tiled() ? image.bytes : 0;
        if (held > kept) release(held - kept);
        if (kept > held) add(kept - held);
        image.store_ = this;
        if (image.readable()) (image.is_tiled() ? tiled_ : whole_).fetch_add(1, std::memory_order_relaxed);
    });
    return {entry, &entry->image};
}

ImageStore::Usage ImageStore::usage() const {
    const TileCache::Counters& t = tiles_->counters();
    Usage u;
    u.budget_bytes = budget();
    u.whole_bytes = bytes();
    u.tile_bytes = t.bytes;
    u.read_bytes = loader_open ? loader().read_bytes() : 0;
    u.whole_images = whole_;
    u.tiled_images = tiled_;
    u.tile_requests = t.requests;
    u.tile_misses = t.misses;
    u.tiles_read = t.read;
    u.tiles_averaged = t.averaged;
    u.tiles_dropped = t.dropped;
    const std::lock_guard lock(mutex_);
    u.faults = faults_.size();
    return u;
}

void ImageStore::report(const std::string& fault) {
    const std::lock_guard lock(mutex_);
    if (std::find(faults_.begin(), faults_.end(), fault) != faults_.end()) return;
    faults_.push_back(fault);
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
    if (const auto missing = j.find("missing"); missing != j.end()) return request;  // said where the document was read
    request.path = text("file");
    request.color_space = text("colorspace");
    if (request.color_space == "auto" || request.color_space == "__builtin_auto") request.color_space.clear();
    if (!request.color_space.empty()) check_color_space(request.color_space, errors);
    const std::string alpha = text("alpha_mode");
    if (alpha.empty() || alpha == "STRAIGHT" || alpha == "unassociated" || alpha == "auto") request.alpha = AlphaMode::Straight;
    else if (alpha == "PREMUL" || alpha == "associated") request.alpha = AlphaMode::Premultiplied;
    else if (alpha == "CHANNEL_PACKED" || alpha == "channel_packed") request.alpha = AlphaMode::ChannelPacked;
    else if (alpha == "NONE" || alpha == "ignore") request.alpha = AlphaMode::None;
    else {
        const std::vector<std::string> modes{"STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"};
        errors.push_back(fmt::format("image.alpha_mode: {}\nSTRAIGHT, PREMUL, CHANNEL_PACKED or NONE\n{}", alpha, nearest_name(alpha, modes)));
    }
    return request;
}

}  // namespace alder
