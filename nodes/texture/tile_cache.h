// Tiles of images that are too large to be kept whole: square pieces of every mip level, read when they are first looked at and
// dropped, least recently used first, when they pass their share of the texture budget.
//
// Tiles hold pixels in their final form (alpha applied, converted), so that a lookup finds the same bits as in a whole image.
// Level 0 comes from the file; a higher level is averaged from the level below it (pyramid.h). Thread safe: the cache is cut into
// shards with a lock each, and each thread keeps the last few tiles at hand without any lock.
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

namespace alder {

class StoredImage;

/// Reads pieces of one image file in their final form. Thread safe. Made by the loader module.
class TileReader {
  public:
    virtual ~TileReader() = default;
    /// Pixels [x, x + width) of rows [y, y + height), counted upwards, to `out`, rows without gaps. False and a reason where the
    /// file cannot be read there.
    virtual bool read(int x, int y, int width, int height, std::byte* out, std::string& fault) const = 0;
};

class TileCache {
  public:
    static constexpr int kSide = 64;  ///< texels

    struct Counters {
        std::atomic<size_t> bytes{0};         ///< tiles held, those in use by threads included
        std::atomic<uint64_t> requests{0};    ///< that the threads' own few tiles could not answer
        std::atomic<uint64_t> misses{0};      ///< requests for a tile that was not there
        std::atomic<uint64_t> read{0};        ///< tiles read from files
        std::atomic<uint64_t> averaged{0};    ///< tiles of higher mip levels made
        std::atomic<uint64_t> dropped{0};     ///< to stay within the limit
    };
    struct Tile {
        int width = 0;  ///< of a row; less than kSide at the right border
        size_t bytes = 0;
        std::unique_ptr<std::byte[]> pixels;
        std::shared_ptr<Counters> counters;
        ~Tile();
    };

    explicit TileCache(size_t limit);
    ~TileCache();
    /// Drops what is too much. What threads look at right now stays, so very small limits are passed by some tiles a thread.
    void set_limit(size_t bytes);
    const Counters& counters() const { return *counters_; }

    std::shared_ptr<const Tile> tile(const StoredImage& image, int level, int column, int row);
    /// Forgets an image that is gone.
    void drop(uint64_t image);

    /// Texels (x[i], y[i]) of levels level[i] (null: of level 0), each to 16 bytes at out + 16 i. All must lie inside the image.
    static void read_texels(const StoredImage& image, const int32_t* level, const int32_t* x, const int32_t* y, int n, std::byte* out);

  private:
    struct Entry {
        std::once_flag loaded;
        std::shared_ptr<const Tile> tile;
        std::atomic<bool> ready{false};  ///< `tile` may be looked at without having waited for it
    };
    struct Slot {
        std::shared_ptr<Entry> entry;
        std::list<uint64_t>::iterator used;
    };
    struct Shard {
        std::mutex mutex;
        std::unordered_map<uint64_t, Slot> tiles;
        std::list<uint64_t> recent;  ///< last used first
    };
    static constexpr int kShards = 32;

    void trim();
    std::shared_ptr<const Tile> load(const StoredImage& image, int level, int column, int row);

    std::array<Shard, kShards> shards_;
    std::shared_ptr<Counters> counters_;
    std::atomic<size_t> limit_;
    std::atomic<uint32_t> next_shard_{0};
};

}  // namespace alder
