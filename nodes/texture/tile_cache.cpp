// The cache of tiles.
#include "nodes/texture/tile_cache.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "nodes/texture/image_store.h"
#include "nodes/texture/pyramid.h"

namespace alder {
namespace {

// Image, level (16 of them reach 1 x 1 from 32768), row and column of the tile in one number.
constexpr int kIndexBits = 9, kLevelBits = 4;
static_assert(StoredImage::kLargestSide / TileCache::kSide == 1 << kIndexBits);
uint64_t key_of(uint64_t image, int level, int column, int row) {
    return (((image << kLevelBits | static_cast<uint64_t>(level)) << kIndexBits | static_cast<uint64_t>(row)) << kIndexBits) | static_cast<uint64_t>(column);
}
uint64_t image_of(uint64_t key) { return key >> (kLevelBits + 2 * kIndexBits); }
uint64_t mixed(uint64_t key) {
    key *= 0x9e3779b97f4a7c15u;
    return key ^ key >> 32;
}

/// A thread's own few tiles: most lookups end here, without a lock. Held until something else takes their place.
struct ThreadTiles {
    static constexpr int kMany = 16;
    uint64_t key[kMany] = {};
    std::shared_ptr<const TileCache::Tile> tile[kMany];
};

}  // namespace

TileCache::Tile::~Tile() {
    if (counters) counters->bytes.fetch_sub(bytes, std::memory_order_relaxed);
}

TileCache::TileCache(size_t limit) : counters_(std::make_shared<Counters>()), limit_(limit) {}
TileCache::~TileCache() = default;

void TileCache::set_limit(size_t bytes) {
    limit_.store(bytes, std::memory_order_relaxed);
    trim();
}

std::shared_ptr<const TileCache::Tile> TileCache::tile(const StoredImage& image, int level, int column, int row) {
    const uint64_t key = key_of(image.id(), level, column, row);
    Shard& shard = shards_[mixed(key) % kShards];
    counters_->requests.fetch_add(1, std::memory_order_relaxed);
    std::shared_ptr<Entry> entry;
    {
        const std::lock_guard lock(shard.mutex);
        const auto it = shard.tiles.find(key);
        if (it != shard.tiles.end()) {
            shard.recent.splice(shard.recent.begin(), shard.recent, it->second.used);
            entry = it->second.entry;
        } else {
            shard.recent.push_front(key);
            entry = std::make_shared<Entry>();
            shard.tiles.emplace(key, Slot{entry, shard.recent.begin()});
        }
    }
    // Outside the lock: other tiles of the shard can be had meanwhile. A level waits only for lower ones, so there is no circle.
    std::call_once(entry->loaded, [&] {
        counters_->misses.fetch_add(1, std::memory_order_relaxed);
        entry->tile = load(image, level, column, row);
        entry->ready.store(true, std::memory_order_release);
        trim();
    });
    return entry->tile;
}

std::shared_ptr<const TileCache::Tile> TileCache::load(const StoredImage& image, int level, int column, int row) {
    const int x = column * kSide, y = row * kSide;
    const int width = std::min(kSide, level_size(image.width, level) - x), height = std::min(kSide, level_size(image.height, level) - y);
    auto tile = std::make_shared<Tile>();
    tile->width = width;
    const size_t texel = image.texel_bytes();
    tile->bytes = texel * static_cast<size_t>(width) * static_cast<size_t>(height);
    tile->pixels.reset(new std::byte[tile->bytes]);
    tile->counters = counters_;
    counters_->bytes.fetch_add(tile->bytes, std::memory_order_relaxed);
    if (level > 0) {
        counters_->averaged.fetch_add(1, std::memory_order_relaxed);
        average_level(image, level, x, y, width, height, tile->pixels.get(), [&](int x0, int y0, int w, int h, std::byte* out) {
            for (int r = y0 / kSide; r <= (y0 + h - 1) / kSide; ++r)
                for (int c = x0 / kSide; c <= (x0 + w - 1) / kSide; ++c) {
                    const auto part = this->tile(image, level - 1, c, r);
                    const int left = std::max(x0, c * kSide), right = std::min(x0 + w, (c + 1) * kSide);
                    for (int v = std::max(y0, r * kSide); v < std::min(y0 + h, (r + 1) * kSide); ++v)
                        std::memcpy(out + texel * (static_cast<size_t>(v - y0) * w + (left - x0)),
                                    part->pixels.get() + texel * (static_cast<size_t>(v - r * kSide) * part->width + (left - c * kSide)), texel * (right - left));
                }
        });
        return tile;
    }
    counters_->read.fetch_add(1, std::memory_order_relaxed);
    std::string fault;
    if (!image.reader->read(x, y, width, height, tile->pixels.get(), fault)) {
        image.report_broken(fault);
        // Magenta in the image's own numbers: 1 is all bits of an integer.
        const auto one = [&](std::byte* to, int channel, bool on) {
            const size_t size = texel / image.channels;
            const uint32_t bits = !on ? 0 : image.format == StoredImage::Format::F16 ? 0x3c00u : image.format == StoredImage::Format::F32 ? 0x3f800000u : ~0u;
            std::memcpy(to + channel * size, &bits, size);
        };
        for (size_t i = 0; i < static_cast<size_t>(width) * height; ++i)
            for (int c = 0; c < image.channels; ++c) one(tile->pixels.get() + i * texel, c, c != 1);
    }
    return tile;
}

/// Takes the least recently used tiles of one shard after the other until the limit holds.
void TileCache::trim() {
    const size_t limit = limit_.load(std::memory_order_relaxed);
    int without_any = 0;
    while (counters_->bytes.load(std::memory_order_relaxed) > limit && without_any < kShards) {
        Shard& shard = shards_[next_shard_.fetch_add(1, std::memory_order_relaxed) % kShards];
        std::shared_ptr<Entry> dropped;  // destroyed after the lock
        {
            const std::lock_guard lock(shard.mutex);
            for (auto it = shard.recent.rbegin(); it != shard.recent.rend(); ++it) {
                const auto slot = shard.tiles.find(*it);
                // Someone loads it, waits for it or looks at it: it would not free anything.
                if (slot->second.entry.use_count() > 1 || !slot->second.entry->ready.load(std::memory_order_acquire) || slot->second.entry->tile.use_count() > 1) continue;
                dropped = std::move(slot->second.entry);
                shard.recent.erase(slot->second.used);
                shard.tiles.erase(slot);
                break;
            }
        }
        without_any = dropped ? 0 : without_any + 1;
        if (dropped) counters_->dropped.fetch_add(1, std::memory_order_relaxed);
    }
}

void TileCache::drop(uint64_t image) {
    for (Shard& shard : shards_) {
        std::vector<std::shared_ptr<Entry>> gone;
        const std::lock_guard lock(shard.mutex);
        for (auto it = shard.tiles.begin(); it != shard.tiles.end();) {
            if (image_of(it->first) != image) {
                ++it;
                continue;
            }
            gone.push_back(std::move(it->second.entry));
            shard.recent.erase(it->second.used);
            it = shard.tiles.erase(it);
        }
    }
}

void TileCache::read_texels(const StoredImage& image, const int32_t* level, const int32_t* x, const int32_t* y, int n, std::byte* out) {
    thread_local ThreadTiles own;
    const size_t texel = image.texel_bytes();
    for (int i = 0; i < n; ++i) {
        const int l = level ? level[i] : 0, column = x[i] / kSide, row = y[i] / kSide;
        const uint64_t key = key_of(image.id(), l, column, row);
        const size_t slot = mixed(key) % ThreadTiles::kMany;
        if (own.key[slot] != key) {
            own.tile[slot] = image.tiles().tile(image, l, column, row);
            own.key[slot] = key;
        }
        const Tile& tile = *own.tile[slot];
        const size_t at = static_cast<size_t>(y[i] - row * kSide) * tile.width + static_cast<size_t>(x[i] - column * kSide);
        std::memcpy(out + 16 * i, tile.pixels.get() + texel * at, texel);
    }
}

}  // namespace alder
