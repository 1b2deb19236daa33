// Images shared by everything that reads them. A file opened with the same interpretation (colour space, alpha) is loaded once for
// the whole process, however many materials, renders or threads ask; its pixels go when the last user does.
//
// Images are kept whole while they fit the byte budget, because a lookup then is a plain load; those beyond it are read in tiles
// (tile_cache.h). Pixels keep the file's number format (8, 16 bit, half, float) and one or four channels, bottom row first.
// Readers reach them only through image_lookup-inl.h and find the same bits in both.
#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "nodes/texture/tile_cache.h"

namespace alder {

enum class AlphaMode : uint8_t {
    Straight,       ///< colour is not multiplied by alpha in the file
    Premultiplied,  ///< it is
    ChannelPacked,  ///< alpha is another channel, unrelated to the colour
    None,           ///< alpha counts as 1
};

/// What is asked for: a file and how to read it.
struct ImageRequest {
    std::string path;
    std::string color_space;  ///< empty: sRGB for integer files, linear for float ones unless the file says otherwise
    AlphaMode alpha = AlphaMode::Straight;
    auto operator<=>(const ImageRequest&) const = default;
};

struct Pyramid;

/// One loaded image. Immutable once published. (Image is what the renderer makes.)
class StoredImage {
  public:
    enum class Format : uint8_t { U8, U16, F16, F32 };
    static constexpr int kLargestSide = 32768, kMostChannels = 64;

    StoredImage();
    ~StoredImage();

    int width = 0, height = 0;          ///< 0: could not be read; looked up as magenta
    int channels = 0;                   ///< 1 or 4
    Format format = Format::U8;
    bool is_srgb = false;               ///< to be made linear after interpolation, as Cycles does it
    bool divide_by_alpha = false;       ///< where alpha is used too, colour is divided by it after interpolation
    size_t bytes = 0;                   ///< of all pixels of level 0, held or not
    std::unique_ptr<std::byte[]> pixels;   ///< null where the image is read in tiles
    std::unique_ptr<TileReader> reader;    ///< of an image in tiles
    std::string fault;                  ///< why it could not be read

    bool readable() const { return width > 0; }
    bool is_tiled() const { return pixels == nullptr; }
    size_t texel_bytes() const { return (format == Format::U8 ? 1 : format == Format::F32 ? 4 : 2) * size_t(channels); }
    uint64_t id() const { return id_; }
    TileCache& tiles() const { return *tiles_; }
    /// Levels above 0 of a whole image, made when first asked for.
    const Pyramid& pyramid() const;
    /// Of an image that is held whole; level 0 is the image.
    const std::byte* texel(int level, int x, int y) const;
    /// A part of the file turned out to be broken while it was looked up. Told once an image.
    void report_broken(const std::string& reason) const;
    /// What was reported so; empty: nothing yet.
    std::string broken() const { return is_broken_.load(std::memory_order_acquire) ? broken_reason_ : std::string(); }
    const std::string& path() const { return path_; }

  private:
    friend class ImageStore;
    class ImageStore* store_ = nullptr;  ///< which outlives its images
    std::shared_ptr<TileCache> tiles_;
    std::string path_;
    uint64_t id_ = 0;
    mutable std::once_flag pyramid_made_, broken_;
    mutable std::atomic<bool> is_broken_{false};
    mutable std::string broken_reason_;
    mutable std::unique_ptr<const Pyramid> pyramid_;
};

class ImageStore {
  public:
    static constexpr size_t kDefaultBudget = size_t{4} << 30;

    explicit ImageStore(size_t budget = kDefaultBudget);
    ~ImageStore();
    /// The process's store. Its budget is ALDER_TEXTURE_MIB, where that is set.
    static ImageStore& shared();

    /// Bytes that pixels, mip levels, tiles and what is read ahead of them may take together. Images that are held whole already
    /// stay so.
    void set_budget(size_t bytes);
    size_t budget() const { return budget_.load(std::memory_order_relaxed); }

    /// The image of that file, opened now if it is not yet. Never null: where it cannot be read, the image is not readable()
    /// and says why. Threads that ask for the same image at once wait for one load.
    std::shared_ptr<const StoredImage> open(const ImageRequest& request);

    /// Bytes of whole images and their mip levels held at this moment.
    size_t bytes() const { return bytes_.load(std::memory_order_relaxed); }
    struct Usage {
        size_t budget_bytes = 0, whole_bytes = 0, tile_bytes = 0, read_bytes = 0;
        uint64_t whole_images = 0, tiled_images = 0;
        uint64_t tile_requests = 0, tile_misses = 0, tiles_read = 0, tiles_averaged = 0, tiles_dropped = 0, faults = 0;
    };
    Usage usage() const;
    /// What could not be read so far: "PATH: REASON", each once.
    std::vector<std::string> faults() const;

  private:
    friend class StoredImage;
    /// A file that changed on disk is another image.
    struct Key {
        ImageRequest request;
        std::filesystem::file_time_type modified;
        uintmax_t size = 0;
        auto operator<=>(const Key&) const = default;
    };
    struct Entry {
        std::once_flag loaded;
        StoredImage image;
    };
    void report(const std::string& fault);
    bool reserve(size_t bytes);
    void add(size_t bytes);
    void release(size_t bytes);
    size_t read_share() const { return budget() / 8; }   ///< of the file reader below the tiles
    void share_out();

    mutable std::mutex mutex_;
    std::map<Key, std::weak_ptr<Entry>> entries_;
    std::vector<std::string> faults_;
    std::atomic<size_t> bytes_{0}, budget_;
    std::atomic<uint64_t> whole_{0}, tiled_{0};
    std::shared_ptr<TileCache> tiles_;
};

/// Reads an Image parameter: {"file", "colorspace", "alpha_mode"}, or null for none (an empty path). Appends what is wrong.
ImageRequest parse_image_request(const std::string& json, std::vector<std::string>& errors);

/// Who hears of files that turn out to be broken while they are looked up, when the request's warnings have been given already.
void set_image_fault_listener(void (*listener)(const std::string& fault));

/// An OpenColorIO configuration that further names of colour spaces are looked up in; empty: $OCIO, where it is set.
void set_color_configuration(const std::string& path);

}  // namespace alder
