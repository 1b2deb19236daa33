// Pictures for screens: 8-bit PNG and JPEG of one layer, with exposure and a view transform.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "render/image/image.h"

namespace alder {

enum class ViewTransform : uint8_t {
    Srgb,        ///< IEC 61966-2-1 curve, values above 1 clipped
    Linear,      ///< no curve
    FilmicNone,  ///< Blender's Filmic view without a look
};
std::optional<ViewTransform> view_transform_from_name(std::string_view name);   // "srgb", "linear", "filmic-none"

struct View {
    float exposure = 0;   ///< stops
    ViewTransform transform = ViewTransform::Srgb;
    bool alpha = false;   ///< PNG: keep alpha (not associated, as PNG wants it); else over black
    std::string layer;    ///< "" = beauty
    int quality = 90;     ///< JPEG, 1 ... 100
};

/// 8-bit pixels, rows from the top; 3 or (alpha) 4 channels. A layer of one channel is shown grey.
std::vector<uint8_t> to_display(const Image& image, const View& view, int& channels, std::string& error);
/// Empty and a reason in `error` where there is no such layer.
std::vector<uint8_t> encode_png(const Image& image, const View& view, std::string& error);
std::vector<uint8_t> encode_jpeg(const Image& image, const View& view, std::string& error);

/// One value, scene linear to display, 0..1 (before rounding to 8 bits).
float display_value(float linear, float scale, ViewTransform transform);

}  // namespace alder
