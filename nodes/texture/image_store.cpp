// Loading of images through OpenImageIO, and the store that shares them. Alpha and number formats follow Cycles' image manager.
#include "nodes/texture/image_store.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>

#include "nodes/texture/color_space.h"

#if __has_include(<Imath/half.h>)
#include <Imath/half.h>
#else
#include <OpenEXR/half.h>
#endif

namespace alder {
namespace {

using OIIO::TypeDesc;

size_t bytes_of(StoredImage::Format f) { return f == StoredImage::Format::U8 ? 1 : f == StoredImage::Format::F32 ? 4 : 2; }

/// The format that pixels are kept in: the file's, integers of other widths as 8 bit, doubles as float.
StoredImage::Format format_of(const OIIO::ImageSpec& spec) {
    bool is_float = spec.format.is_floating_point();
    for (const TypeDesc& t : spec.channelformats) is_float |= t.is_floating_point();
    if (spec.format == TypeDesc::HALF) return StoredImage::Format::F16;
    if (is_float) return StoredImage::Format::F32;
    return spec.format == TypeDesc::USHORT ? StoredImage::Format::U16 : StoredImage::Format::U8;
}
TypeDesc oiio_type(StoredImage::Format f) {
    switch (f) {
        case StoredImage::Format::U8: return TypeDesc::UINT8;
        case StoredImage::Format::U16: return TypeDesc::USHORT;
        case StoredImage::Format::F16: return TypeDesc::HALF;
        default: return TypeDesc::FLOAT;
    }
}

/// Whether the file's colours still have to be multiplied by alpha. OpenImageIO's mark is missing for some formats.
bool is_unassociated(const OIIO::ImageSpec& spec, std::string_view format) {
    if (spec.get_int_attribute("oiio:UnassociatedAlpha", 0)) return true;
    if (spec.alpha_channel < 0) return false;
    if (format == "targa") return spec.get_int_attribute("targa:alpha_type", -1) != 4;
    return format == "dds" || format == "psd";
}

/// Integer files without a colour space are sRGB; float files linear, unless the file or its format says sRGB.
bool is_srgb_by_default(const OIIO::ImageSpec& spec, std::string_view format, StoredImage::Format pixels) {
    if (pixels == StoredImage::Format::U8 || pixels == StoredImage::Format::U16) return true;
    const std::string hint = spec.get_string_attribute("oiio:ColorSpace");
    if (hint == "sRGB" || hint == "GammaCorrected") return true;
    return hint.empty() && (format == "png" || format == "jpeg" || format == "tiff" || format == "dpx" || format == "jpeg2000");
}

float to_float(uint8_t v) { return static_cast<float>(v) / 255.0f; }
float to_float(uint16_t v) { return static_cast<float>(v) / 65535.0f; }
float to_float(half v) { return v; }
float to_float(float v) { return v; }
// In the file's own numbers, truncating as Cycles does.
uint8_t times(uint8_t a, uint8_t b) { return static_cast<uint8_t>(static_cast<uint32_t>(a) * b / 255); }
uint16_t times(uint16_t a, uint16_t b) { return static_cast<uint16_t>(static_cast<uint32_t>(a) * b / 65535); }
half times(half a, half b) { return half(static_cast<float>(a) * static_cast<float>(b)); }
float times(float a, float b) { return a * b; }
template <class T>
T one();
template <>
uint8_t one<uint8_t>() { return 255; }
template <>
uint16_t one<uint16_t>() { return 65535; }
template <>
half one<half>() { return half(1.0f); }
template <>
float one<float>() { return 1.0f; }

/// Fills the channels that the file does not have, applies alpha, removes what is not finite. `p`: four numbers a pixel.
template <class T>
void complete_pixels(T* p, size_t count, int file_channels, bool multiply, bool drop_alpha) {
    for (size_t i = 0; i < count; ++i, p += 4) {
        if (file_channels == 2) {  // grey and alpha
            p[3] = p[1];
            p[1] = p[2] = p[0];
        } else if (file_channels == 3) {
            p[3] = one<T>();
        }
        if (multiply && file_channels >= 4) {
            for (int c = 0; c < 3; ++c) p[c] = times(p[c], p[3]);
        }
        if (drop_alpha) p[3] = one<T>();
    }
}
template <class T>
void remove_nonfinite(T* p, size_t pixels, int channels) {
    for (size_t i = 0; i < pixels; ++i, p += channels) {
        bool finite = true;
        for (int c = 0; c < channels; ++c) finite &= std::isfinite(to_float(p[c]));
        if (!finite) std::fill(p, p + channels, T(0.0f));
    }
}
/// Converts to linear Rec.709; the colours are taken out of their alpha meanwhile.
template <class From, class To>
void convert_pixels(const From* from, To* to, size_t pixels, int channels, const ColorSpace& space) {
    for (size_t i = 0; i < pixels; ++i, from += channels, to += channels) {
        float rgb[3];
        for (int c = 0; c < 3; ++c) rgb[c] = to_float(from[channels == 4 ? c : 0]);
        const float alpha = channels == 4 ? to_float(from[3]) : 1.0f;
        const bool divide = !(alpha <= 0.0f || alpha == 1.0f);
        if (divide) {
            for (float& c : rgb) c /= alpha;
        }
        space.to_linear_rec709(rgb);
        if (divide) {
            for (float& c : rgb) c *= alpha;
        }
        for (int c = 0; c < std::min(channels, 3); ++c) to[c] = To(rgb[c]);
        if (channels == 4) to[3] = To(alpha);
    }
}

/// Loads the file into `image`, or says why not.
std::string load(const ImageRequest& request, StoredImage& image) {
    const bool automatic = request.color_space.empty();
    std::optional<ColorSpace> space;
    if (!automatic) {
        space = find_color_space(request.color_space);
        if (!space) return fmt::format("colour space \"{}\" is not known; there are {}", request.color_space, fmt::join(color_space_names(), ", "));
    }
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);  // alpha is applied here, in the file's numbers
    const std::unique_ptr<OIIO::ImageInput> in = OIIO::ImageInput::open(request.path, &config);
    if (!in) return OIIO::geterror();
    const OIIO::ImageSpec spec = in->spec();
    const std::string format_name = in->format_name();

    // From the header, before anything is allocated: a few bytes of file can announce a terabyte.
    if (spec.width <= 0 || spec.height <= 0 || spec.nchannels <= 0) return "the image is empty";
    if (spec.width > StoredImage::kLargestSide || spec.height > StoredImage::kLargestSide)
        return fmt::format("{} x {} pixels; at most {} a side can be read", spec.width, spec.height, StoredImage::kLargestSide);
    if (spec.nchannels > StoredImage::kMostChannels)
        return fmt::format("{} channels; at most {} can be read", spec.nchannels, StoredImage::kMostChannels);
    if (spec.depth > 1) return "volume images cannot be used as textures";
    if (spec.deep) return "deep images cannot be used as textures";

    StoredImage::Format format = format_of(spec);
    const int channels = spec.nchannels == 1 ? 1 : 4, read_channels = std::min(spec.nchannels, 4);
    const size_t pixels = static_cast<size_t>(spec.width) * spec.height, texel = bytes_of(format) * channels;
    std::unique_ptr<std::byte[]> data(new (std::nothrow) std::byte[pixels * texel]);
    if (!data) return fmt::format("{} bytes of memory are not available", pixels * texel);
    const OIIO::stride_t row = static_cast<OIIO::stride_t>(texel) * spec.width;
    // Upwards: texture coordinates count from the bottom row.
    if (!in->read_image(0, 0, 0, read_channels, oiio_type(format), data.get() + row * (spec.height - 1), texel, -row, OIIO::AutoStride))
        return in->geterror();

    if (automatic) {
        space.emplace();
        if (is_srgb_by_default(spec, format_name, format)) space->curve = ColorSpace::Curve::Srgb;
    }
    const bool relates = !space->is_data && request.alpha != AlphaMode::ChannelPacked && request.alpha != AlphaMode::None;
    const bool multiply = relates && is_unassociated(spec, format_name);
    const auto with_pixels = [&](auto&& fn) {
        switch (format) {
            case StoredImage::Format::U8: return fn(reinterpret_cast<uint8_t*>(data.get()));
            case StoredImage::Format::U16: return fn(reinterpret_cast<uint16_t*>(data.get()));
            case StoredImage::Format::F16: return fn(reinterpret_cast<half*>(data.get()));
            case StoredImage::Format::F32: return fn(reinterpret_cast<float*>(data.get()));
        }
    };
    if (channels == 4)
        with_pixels([&](auto* p) { complete_pixels(p, pixels, spec.nchannels, multiply, request.alpha == AlphaMode::None); });
    if (!space->is_data && !space->is_linear_rec709() && !space->is_srgb()) {
        // Integers cannot hold what a conversion gives: half floats then.
        const StoredImage::Format wide = format == StoredImage::Format::F32 ? format : StoredImage::Format::F16;
        std::unique_ptr<std::byte[]> converted(new (std::nothrow) std::byte[pixels * channels * bytes_of(wide)]);
        if (!converted) return fmt::format("{} bytes of memory are not available", pixels * channels * bytes_of(wide));
        with_pixels([&](auto* p) {
            if (wide == StoredImage::Format::F32) convert_pixels(p, reinterpret_cast<float*>(converted.get()), pixels, channels, *space);
            else convert_pixels(p, reinterpret_cast<half*>(converted.get()), pixels, channels, *space);
        });
        data = std::move(converted);
        format = wide;
    }
    if (format == StoredImage::Format::F16) remove_nonfinite(reinterpret_cast<half*>(data.get()), pixels, channels);
    if (format == StoredImage::Format::F32) remove_nonfinite(reinterpret_cast<float*>(data.get()), pixels, channels);

    image.width = spec.width;
    image.height = spec.height;
    image.channels = channels;
    image.format = format;
    image.is_srgb = space->is_srgb();
    image.divide_by_alpha = relates;
    image.bytes = pixels * channels * bytes_of(format);
    image.pixels = std::move(data);
    return {};
}

}  // namespace

StoredImage::~StoredImage() {
    if (counter_) counter_->fetch_sub(bytes, std::memory_order_relaxed);
}

ImageStore& ImageStore::shared() {
    static ImageStore* const store = new ImageStore;  // never destroyed: images may outlive static destruction
    return *store;
}

std::shared_ptr<const StoredImage> ImageStore::open(const ImageRequest& request) {
    Key key{request, {}, 0};
    std::error_code no_error;
    key.modified = std::filesystem::last_write_time(request.path, no_error);
    key.size = std::filesystem::file_size(request.path, no_error);
    std::shared_ptr<Entry> entry;
    {
        const std::lock_guard lock(mutex_);
        std::erase_if(entries_, [](const auto& e) { return e.second.expired(); });
        entry = entries_[key].lock();
        if (!entry) entries_[key] = entry = std::make_shared<Entry>();
    }
    std::call_once(entry->loaded, [&] {
        std::string fault;
        try {
            fault = load(request, entry->image);
        } catch (const std::exception& e) {  // plug-ins of OpenImageIO may throw on broken files
            fault = e.what();
            entry->image.width = 0;
        }
        if (!entry->image.readable()) report(fmt::format("{}: {}", request.path, fault.empty() ? "cannot be read" : fault));
        entry->image.counter_ = &bytes_;
        bytes_.fetch_add(entry->image.bytes, std::memory_order_relaxed);
    });
    return {entry, &entry->image};
}

void ImageStore::report(const std::string& fault) {
    const std::lock_guard lock(mutex_);
    if (std::find(faults_.begin(), faults_.end(), fault) != faults_.end()) return;
    faults_.push_back(fault);
    spdlog::warn("image {}", fault);
}
std::vector<std::string> ImageStore::faults() const {
    const std::lock_guard lock(mutex_);
    return faults_;
}

ImageRequest parse_image_request(const std::string& json, std::vector<std::string>& errors) {
    ImageRequest request;
    const nlohmann::json j = nlohmann::json::parse(json, nullptr, false);
    if (j.is_null()) return request;
    if (j.is_string()) {
        request.path = j.get<std::string>();
        return request;
    }
    if (!j.is_object()) {
        errors.push_back("image: {\"file\": NAME, \"colorspace\": ..., \"alpha_mode\": ...} expected");
        return request;
    }
    const auto text = [&](const char* name) -> std::string {
        const auto it = j.find(name);
        if (it == j.end() || it->is_null()) return {};
        if (it->is_string()) return it->get<std::string>();
        errors.push_back(fmt::format("image.{}: a string expected", name));
        return {};
    };
    request.path = text("file");
    request.color_space = text("colorspace");
    if (request.color_space == "auto" || request.color_space == "__builtin_auto") request.color_space.clear();
    if (!request.color_space.empty() && !find_color_space(request.color_space))
        errors.push_back(fmt::format("image.colorspace: \"{}\" is not known; there are {}", request.color_space, fmt::join(color_space_names(), ", ")));
    const std::string alpha = text("alpha_mode");
    if (alpha.empty() || alpha == "STRAIGHT" || alpha == "unassociated" || alpha == "auto") request.alpha = AlphaMode::Straight;
    else if (alpha == "PREMUL" || alpha == "associated") request.alpha = AlphaMode::Premultiplied;
    else if (alpha == "CHANNEL_PACKED" || alpha == "channel_packed") request.alpha = AlphaMode::ChannelPacked;
    else if (alpha == "NONE" || alpha == "ignore") request.alpha = AlphaMode::None;
    else errors.push_back(fmt::format("image.alpha_mode: \"{}\" is not known; there are STRAIGHT, PREMUL, CHANNEL_PACKED, NONE", alpha));
    return request;
}

}  // namespace alder
