// Mip levels: each level is half as wide and high as the one below (rounded down, at least 1) and each of its texels the mean of
// what it covers, in linear light and weighted by alpha. Odd sizes: a texel covers up to three below, the outer ones in part
// (Guthe and Heckbert, "Non-Power-of-Two Mipmapping", 2005), so that every level has the mean of the image.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "nodes/texture/image_store.h"

namespace alder {

int level_count(int width, int height);
inline int level_size(int size, int level) { return size >> level > 0 ? size >> level : 1; }

/// Texels [x, x + width) of rows [y, y + height) of level `level` of the image, averaged from the level below, which `below`
/// reads: called for a rectangle there that fits in memory, it fills it without gaps between rows.
void average_level(const StoredImage& image, int level, int x, int y, int width, int height, std::byte* out,
                   const std::function<void(int x, int y, int width, int height, std::byte* out)>& below);

/// All levels above 0 of an image held whole, one after the other.
struct Pyramid {
    std::vector<size_t> offset;  ///< bytes, by level; [0] is not used
    size_t bytes = 0;
    std::unique_ptr<std::byte[]> pixels;
};
std::unique_ptr<const Pyramid> build_pyramid(const StoredImage& image);

}  // namespace alder
