// Reading of images in tiles.
#include "nodes/texture/image_tiles.h"

#include <OpenImageIO/imagecache.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <mutex>
#include <vector>

namespace alder {
namespace {

namespace fs = std::filesystem;
using OIIO::TypeDesc;

/// One cache for all images, with no copy of what it read kept longer than needed: the tiles above it are the cache proper.
OIIO::ImageCache& image_cache() {
    static OIIO::ImageCache* const cache = [] {
        OIIO::ImageCache* const c = OIIO::ImageCache::create(false);
        c->attribute("unassociatedalpha", 1);  // alpha is applied here, in the file's numbers
        c->attribute("automip", 0);
        c->attribute("autotile", TileCache::kSide);
        c->attribute("accept_untiled", 1);
        c->attribute("max_open_files", 64);
        c->attribute("failure_retries", 0);
        return c;
    }();
    return *cache;
}
std::atomic<bool> cache_used{false};

/// How often a file has been opened anew because it changed: readers of the former contents must not see the new ones.
class Generations {
  public:
    uint64_t open(const std::string& path) {
        std::error_code no_error;
        const Stamp now{fs::last_write_time(path, no_error), fs::file_size(path, no_error)};
        const std::lock_guard lock(mutex_);
        Known& known = files_[path];
        if (known.generation == 0 || known.stamp != now) {
            if (known.generation != 0) image_cache().invalidate(OIIO::ustring(path), true);
            known.stamp = now;
            ++known.generation;
        }
        return known.generation;
    }
    uint64_t current(const std::string& path) {
        const std::lock_guard lock(mutex_);
        return files_[path].generation;
    }

  private:
    using Stamp = std::pair<fs::file_time_type, uintmax_t>;
    struct Known {
        Stamp stamp;
        uint64_t generation = 0;
    };
    std::mutex mutex_;
    std::map<std::string, Known> files_;
};
Generations& generations() {
    static auto* const g = new Generations;
    return *g;
}

/// A file that goes with its owner.
class ScratchFile {
  public:
    explicit ScratchFile(const char* extension) {
        std::error_code ec;
        std::string name = (fs::temp_directory_path(ec) / "alder-texture-XXXXXX").string() + extension;
        const int fd = ec ? -1 : ::mkstemps(name.data(), static_cast<int>(std::string_view(extension).size()));
        if (fd < 0) return;
        ::close(fd);
        path_ = name;
    }
    ~ScratchFile() {
        if (!path_.empty()) ::unlink(path_.c_str());
    }
    ScratchFile(const ScratchFile&) = delete;
    const std::string& path() const { return path_; }

  private:
    std::string path_;
};

class CachedTiles final : public TileReader {
  public:
    CachedTiles(std::string path, const OIIO::ImageSpec& spec, const PixelTreatment& treatment, std::unique_ptr<ScratchFile> scratch)
        : path_(std::move(path)), name_(path_), x_(spec.x), y_(spec.y), height_(spec.height), treatment_(treatment), scratch_(std::move(scratch)),
          generation_(scratch_ ? 0 : generations().open(path_)) {
        cache_used = true;
    }
    ~CachedTiles() override {
        if (scratch_) image_cache().invalidate(name_, true);
    }
    bool read(int x, int y, int width, int height, std::byte* out, std::string& fault) const override {
        try {
            if (!scratch_ && generations().current(path_) != generation_) {
                fault = "the file was changed while it was in use";
                return false;
            }
            const size_t texel = treatment_.from_bytes(), count = static_cast<size_t>(width) * height;
            std::vector<std::byte> own(treatment_.converts() ? count * texel : 0);
            std::byte* const pixels = treatment_.converts() ? own.data() : out;
            const auto row = static_cast<OIIO::stride_t>(texel) * width;
            // Rows count upwards here and downwards there.
            const int top = y_ + height_ - y - height;
            if (!image_cache().get_pixels(name_, 0, 0, x_ + x, x_ + x + width, top, top + height, 0, 1, 0, treatment_.read_channels(), oiio_type(treatment_.from),
                                          pixels + row * (height - 1), static_cast<OIIO::stride_t>(texel), -row, OIIO::AutoStride)) {
                fault = image_cache().geterror();
                if (fault.empty()) fault = "cannot be read";
                return false;
            }
            treatment_.apply(pixels, count, out);
            return true;
        } catch (const std::exception& e) {
            fault = e.what();
            return false;
        }
    }

  private:
    std::string path_;
    OIIO::ustring name_;
    int x_, y_, height_;
    PixelTreatment treatment_;
    std::unique_ptr<ScratchFile> scratch_;
    uint64_t generation_;
};

size_t read_bytes() {
    if (!cache_used) return 0;
    long long bytes = 0;
    image_cache().getattribute("stat:cache_memory_used", TypeDesc::INT64, &bytes);
    return bytes > 0 ? static_cast<size_t>(bytes) : 0;
}

/// Copies the image, some rows at a time, into a file with tiles and without compression. The numbers stay as they are.
std::string write_tiled(OIIO::ImageInput& in, const PixelTreatment& t, const std::string& path, OIIO::ImageSpec& spec) {
    spec = OIIO::ImageSpec(in.spec().width, in.spec().height, t.read_channels(), oiio_type(t.from));
    spec.tile_width = spec.tile_height = TileCache::kSide;
    spec.attribute("compression", "none");
    spec.attribute("oiio:UnassociatedAlpha", 1);
    spec.alpha_channel = -1;
    spec.channelnames.clear();
    for (int c = 0; c < spec.nchannels; ++c) spec.channelnames.push_back(std::string(1, "RGBA"[c]));
    const uint64_t bytes = spec.image_bytes();
    if (bytes > (uint64_t{3} << 30)) spec.attribute("tiff:bigtiff", 1);
    std::error_code ec;
    const auto space = fs::space(fs::path(path).parent_path(), ec);
    if (!ec && space.available < bytes + bytes / 8)
        return fmt::format("its tiles need {} bytes in {}, {} are free", bytes, fs::path(path).parent_path().string(), space.available);
    const auto out = OIIO::ImageOutput::create(path);
    if (!out || !out->open(path, spec)) return out ? out->geterror() : OIIO::geterror();
    std::vector<std::byte> rows(spec.scanline_bytes() * TileCache::kSide);
    const int y0 = in.spec().y;
    for (int y = 0; y < spec.height; y += TileCache::kSide) {
        const int end = std::min(y + TileCache::kSide, spec.height);
        if (!in.read_scanlines(0, 0, y0 + y, y0 + end, 0, 0, spec.nchannels, spec.format, rows.data())) return in.geterror();
        if (!out->write_tiles(0, spec.width, y, end, 0, 1, spec.format, rows.data())) return out->geterror();
    }
    return out->close() ? std::string() : out->geterror();
}

}  // namespace

TypeDesc oiio_type(StoredImage::Format f) {
    switch (f) {
        case StoredImage::Format::U8: return TypeDesc::UINT8;
        case StoredImage::Format::U16: return TypeDesc::USHORT;
        case StoredImage::Format::F16: return TypeDesc::HALF;
        default: return TypeDesc::FLOAT;
    }
}

bool can_be_tiled(const OIIO::ImageSpec& spec) {
    if (spec.tile_width == 0) return true;
    // The cache keeps these as they are; others it would turn into floats.
    return spec.channelformats.empty() &&
           (spec.format == TypeDesc::UINT8 || spec.format == TypeDesc::USHORT || spec.format == TypeDesc::HALF || spec.format == TypeDesc::FLOAT);
}

std::unique_ptr<TileReader> open_tiles(const std::string& path, OIIO::ImageInput& in, const PixelTreatment& t, size_t cache_bytes, std::string& fault) {
    // What is smaller than this the cache does not accept.
    image_cache().attribute("max_memory_MB", std::max(10.0f, static_cast<float>(cache_bytes) / (1 << 20)));
    if (in.spec().tile_width > 0) return std::make_unique<CachedTiles>(path, in.spec(), t, nullptr);
    const bool is_float = t.from == StoredImage::Format::F16 || t.from == StoredImage::Format::F32;
    auto scratch = std::make_unique<ScratchFile>(is_float ? ".exr" : ".tif");
    if (scratch->path().empty()) {
        fault = "there is no folder for temporary files, which its tiles need";
        return nullptr;
    }
    OIIO::ImageSpec spec;
    fault = write_tiled(in, t, scratch->path(), spec);
    if (!fault.empty()) return nullptr;
    const std::string name = scratch->path();
    return std::make_unique<CachedTiles>(name, spec, t, std::move(scratch));
}

}  // namespace alder

extern "C" size_t alder_image_read_bytes() { return alder::read_bytes(); }
