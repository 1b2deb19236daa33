// Reading of images in tiles through OpenImageIO's image cache. Part of the loader module.
#pragma once
#include <OpenImageIO/imageio.h>

#include "nodes/texture/image_pixels.h"

namespace alder {

OIIO::TypeDesc oiio_type(StoredImage::Format f);

/// Whether tiles would hold the same numbers as the whole image.
bool can_be_tiled(const OIIO::ImageSpec& spec);

/// A reader of the file's tiles; null and a reason where that cannot be. `in` has the file open and nothing read yet.
/// A file without tiles is first written anew with tiles, into a temporary file that goes with the reader: the usual compressed
/// formats can only be read from the top, and a picture asks for rows in any order. So a broken file shows here as well.
std::unique_ptr<TileReader> open_tiles(const std::string& path, OIIO::ImageInput& in, const PixelTreatment& treatment, size_t cache_bytes, std::string& fault);

}  // namespace alder
