// The functions of the image loader module (alder_images.so).
#pragma once
#include <functional>
#include <string>

#include "nodes/texture/image_store.h"

namespace alder {

struct LoadOptions {
    /// Whether that many bytes may be held whole; they count as held from then on.
    std::function<bool(size_t)> reserve;
    size_t read_cache_bytes = 0;      ///< for reading tiles, of all images together
    std::string color_configuration;  ///< OpenColorIO's; empty: none
};

/// Names of a configuration's colour spaces that have a way to linear Rec.709, roles and aliases included.
struct ConfigurationNames {
    std::vector<std::string> names, aliases;
    std::string fault;  ///< why the configuration cannot be used
};

}  // namespace alder

/// Reads the file into `image`, or leaves it unreadable and says why. Throws nothing. Thread safe.
extern "C" void alder_load_image(const alder::ImageRequest& request, const alder::LoadOptions& options, alder::StoredImage& image, std::string& fault);
/// Thread safe; read once and kept.
extern "C" const alder::ConfigurationNames* alder_color_names(const std::string& configuration);
/// Bytes that reading tiles takes beside the tiles.
extern "C" size_t alder_image_read_bytes();
