// Images in memory, shared by everything that reads them. A file opened with the same interpretation (colour space, alpha) is
// loaded once for the whole process, however many materials, renders or threads ask; its pixels go when the last user does.
//
// Pixels keep the file's number format (8, 16 bit, half, float) and one or four channels, bottom row first. Readers reach them
// only through image_lookup-inl.h, which asks for texels by column and row: tiles read on demand under a byte budget can take
// the place of whole images there and here, and nowhere else.
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

/// One loaded image. Immutable once published. (Image is what the renderer makes.)
class StoredImage {
  public:
    enum class Format : uint8_t { U8, U16, F16, F32 };
    static constexpr int kLargestSide = 32768, kMostChannels = 64;

    int width = 0, height = 0;          ///< 0: could not be read; looked up as magenta
    int channels = 0;                   ///< 1 or 4
    Format format = Format::U8;
    bool is_srgb = false;               ///< to be made linear after interpolation, as Cycles does it
    bool divide_by_alpha = false;       ///< where alpha is used too, colour is divided by it after interpolation
    size_t bytes = 0;
    std::unique_ptr<std::byte[]> pixels;

    bool readable() const { return width > 0; }
    ~StoredImage();

  private:
    friend class ImageStore;
    std::atomic<size_t>* counter_ = nullptr;  ///< of the store, which lives for the process
};

class ImageStore {
  public:
    /// The process's store.
    static ImageStore& shared();

    /// The image of that file, loaded now if it is not in memory. Never null: where it cannot be read, the fault is logged once
    /// and the image is not readable(). Threads that ask for the same image at once wait for one load.
    std::shared_ptr<const StoredImage> open(const ImageRequest& request);

    /// Bytes of pixels held at this moment.
    size_t bytes() const { return bytes_.load(std::memory_order_relaxed); }
    /// What could not be read so far: "PATH: REASON", each once.
    std::vector<std::string> faults() const;

  private:
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

    mutable std::mutex mutex_;
    std::map<Key, std::weak_ptr<Entry>> entries_;
    std::vector<std::string> faults_;
    std::atomic<size_t> bytes_{0};
};

/// Reads an Image parameter: {"file", "colorspace", "alpha_mode"}, or null for none (an empty path). Appends what is wrong.
ImageRequest parse_image_request(const std::string& json, std::vector<std::string>& errors);

}  // namespace alder
