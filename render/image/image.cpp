// Names and small accessors of an Image.
#include "render/image/image.h"

#include <charconv>
#include <set>

namespace alder {

const Layer* Image::find(const std::string& name) const {
    for (const Layer& l : layers) {
        if (l.name == name) return &l;
    }
    return nullptr;
}

std::string channel_name(const Layer& layer, size_t channel) {
    const std::string& c = layer.channels[channel];
    if (layer.name.empty()) return c;
    return c.empty() ? layer.name : layer.name + "." + c;
}

int channel_rank(std::string_view channel) {
    static constexpr std::string_view kOrder = "RGBAXYZWUVrgbaxyzwuv";
    if (channel.size() != 1) return 100;
    const size_t i = kOrder.find(channel[0]);
    return i == std::string_view::npos ? 100 : int(i);
}

const std::string* find_attribute(const Image& image, std::string_view name) {
    for (const auto& [key, value] : image.attributes) {
        if (key == name) return &value;
    }
    return nullptr;
}

std::optional<double> number_attribute(const Image& image, std::string_view name) {
    const std::string* text = find_attribute(image, name);
    if (!text) return std::nullopt;
    double x = 0;
    const char* end = text->data() + text->size();
    const auto [p, error] = std::from_chars(text->data(), end, x);
    if (error != std::errc() || p != end) return std::nullopt;
    return x;
}

void set_attribute(Image& image, std::string_view name, std::string value) {
    for (auto& [key, old] : image.attributes) {
        if (key == name) {
            old = std::move(value);
            return;
        }
    }
    image.attributes.emplace_back(std::string(name), std::move(value));
}

namespace {
template <class T>
std::string shortest(T x) {
    char buffer[40];
    const auto [p, error] = std::to_chars(buffer, buffer + sizeof(buffer), x);
    return {buffer, p};
}
}  // namespace

std::string number_text(double x) { return shortest(x); }
std::string number_text(float x) { return shortest(x); }

std::string image_fault(const Image& image) {
    if (image.width <= 0 || image.height <= 0) return "the image has no pixels";
    if (image.layers.empty()) return "the image has no layers";
    const size_t pixels = size_t(image.width) * size_t(image.height);
    std::set<std::string> names;
    for (const Layer& l : image.layers) {
        if (l.channels.size() != l.planes.size()) return "layer \"" + l.name + "\" has not one plane for each channel";
        for (size_t c = 0; c < l.channels.size(); ++c) {
            const std::string name = channel_name(l, c);
            if (name.empty() || name.size() > 255 || name.find('\0') != std::string::npos) {
                return "\"" + name + "\" cannot be the name of an EXR channel (1 to 255 bytes)";
            }
            if (!names.insert(name).second) return "two layers would both write the channel \"" + name + "\"";
            if (l.planes[c].size() != pixels) return "channel \"" + name + "\" has not one value for each pixel";
        }
    }
    return {};
}

}  // namespace alder
