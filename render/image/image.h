// Names and small accessors of an Image: what its planes are called in an EXR file, its attributes as numbers.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "render/render.h"

namespace alder {

/// Name of a plane as an EXR channel: "R" (beauty), "direct_diffuse.R", "Z" (a layer of one channel has no suffix).
std::string channel_name(const Layer& layer, size_t channel);

/// Order in which people expect channels: R G B A, X Y Z W, U V, others by name. For sorting.
int channel_rank(std::string_view channel);

const std::string* find_attribute(const Image& image, std::string_view name);
std::optional<double> number_attribute(const Image& image, std::string_view name);
void set_attribute(Image& image, std::string_view name, std::string value);

/// Shortest text that reads back as the same float or double, independent of the locale.
std::string number_text(double x);
std::string number_text(float x);

/// Empty, or what is wrong with the image: planes of a wrong size, two channels of one name, an unwritable name.
std::string image_fault(const Image& image);

}  // namespace alder
