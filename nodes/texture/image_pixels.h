// From a file's pixels to those that are kept: missing channels, alpha, colour space, numbers that are not finite. Part of the loader
// module; the same for whole images and for tiles.
#pragma once
#include <cstddef>
#include <memory>
#include <optional>

#include "nodes/texture/color_configuration.h"
#include "nodes/texture/color_space.h"
#include "nodes/texture/image_store.h"

namespace alder {

struct PixelTreatment {
    StoredImage::Format from = StoredImage::Format::U8;  ///< as read
    StoredImage::Format to = StoredImage::Format::U8;    ///< as kept
    int file_channels = 0, channels = 0;                 ///< in the file; kept: 1 or 4
    bool multiply = false;                               ///< colour by alpha
    bool drop_alpha = false;
    std::optional<ColorSpace> space;                     ///< to be converted from; neither: nothing to convert
    std::shared_ptr<const ConfiguredSpace> configured;

    bool converts() const { return space || configured; }
    size_t from_bytes() const;  ///< of a pixel
    size_t to_bytes() const;
    int read_channels() const { return file_channels < 4 ? file_channels : 4; }
    /// `count` pixels of `channels` numbers each. `out` may be `in` where nothing is converted.
    void apply(std::byte* in, size_t count, std::byte* out) const;
};

}  // namespace alder
