// Loading of images through OpenImageIO: a module of its own (alder_images.so), opened by the image store when the first image is
// asked for. OpenImageIO brings some 240 libraries; linked into every program they cost 0.2 s of processor time at each start.
// Alpha and number formats follow Cycles' image manager. What does not fit the store's budget gets a reader of tiles instead.
#include "nodes/texture/image_load.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <filesystem>

#include "nodes/texture/image_pixels.h"
#include "nodes/texture/image_tiles.h"

namespace alder {
namespace {

using OIIO::TypeDesc;

/// The format that pixels are kept in: the file's, integers of other widths as 8 bit, doubles as float.
StoredImage::Format format_of(const OIIO::ImageSpec& spec) {
    bool is_float = spec.format.is_floating_point();
    for (const TypeDesc& t : spec.channelformats) is_float |= t.is_floating_point();
    if (spec.format == TypeDesc::HALF) return StoredImage::Format::F16;
    if (is_float) return StoredImage::Format::F32;
    return spec.format == TypeDesc::USHORT ? StoredImage::Format::U16 : StoredImage::Format::U8;
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

/// A file of so few bytes cannot hold so many pixels: deflate, all that PNG knows, packs 1032 bytes into one at best (RFC 1951), PNM
/// eight pixels; and OpenImageIO takes what is missing of a PNM for black.
bool announces_too_much(const OIIO::ImageSpec& spec, std::string_view format, const std::string& path) {
    const uint64_t most_packed = format == "png" ? 1040 : format == "pnm" ? 8 : 0;
    std::error_code no_error;
    return most_packed > 0 && spec.image_bytes(true) / most_packed > std::filesystem::file_size(path, no_error) + 1024;
}

/// Loads the file into `image`, or says why not.
std::string load(const ImageRequest& request, const LoadOptions& options, StoredImage& image) {
    const bool automatic = request.color_space.empty();
    PixelTreatment t;
    if (!automatic) {
        t.space = find_color_space(request.color_space);
        if (!t.space && options.color_configuration.empty()) return fmt::format("colour space \"{}\" is not known", request.color_space);
        std::string fault;
        if (!t.space) t.configured = find_configured_space(options.color_configuration, request.color_space, fault);
        if (!t.space && !t.configured) return fault;
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
    if (announces_too_much(spec, format_name, request.path))
        return fmt::format("announces {} x {} pixels, more than a file of its size can hold", spec.width, spec.height);

    t.from = t.to = format_of(spec);
    t.channels = spec.nchannels == 1 ? 1 : 4;
    t.file_channels = spec.nchannels;
    if (automatic) {
        t.space.emplace();
        if (is_srgb_by_default(spec, format_name, t.from)) t.space->curve = ColorSpace::Curve::Srgb;
    }
    const bool is_data = t.space ? t.space->is_data : t.configured->is_data, is_srgb = t.space && t.space->is_srgb();
    const bool relates = !is_data && request.alpha != AlphaMode::ChannelPacked && request.alpha != AlphaMode::None;
    t.multiply = relates && is_unassociated(spec, format_name);
    t.drop_alpha = request.alpha == AlphaMode::None;
    if (is_data || is_srgb || (t.space && t.space->is_linear_rec709())) {  // sRGB is made linear after interpolation, as Cycles does it
        t.space.reset();
        t.configured.reset();
    }
    // Integers cannot hold what a conversion gives: half floats then.
    if (t.converts() && t.from != StoredImage::Format::F32) t.to = StoredImage::Format::F16;

    const size_t pixels = static_cast<size_t>(spec.width) * spec.height, bytes = pixels * t.to_bytes();
    if (options.reserve(bytes) || !can_be_tiled(spec)) {
        std::unique_ptr<std::byte[]> data(new (std::nothrow) std::byte[pixels * t.from_bytes()]);
        if (!data) return fmt::format("{} bytes of memory are not available", pixels * t.from_bytes());
        const OIIO::stride_t row = static_cast<OIIO::stride_t>(t.from_bytes()) * spec.width;
        // Upwards: texture coordinates count from the bottom row.
        if (!in->read_image(0, 0, 0, t.read_channels(), oiio_type(t.from), data.get() + row * (spec.height - 1), t.from_bytes(), -row, OIIO::AutoStride))
            return in->geterror();
        if (t.converts()) {
            std::unique_ptr<std::byte[]> converted(new (std::nothrow) std::byte[bytes]);
            if (!converted) return fmt::format("{} bytes of memory are not available", bytes);
            t.apply(data.get(), pixels, converted.get());
            data = std::move(converted);
        } else {
            t.apply(data.get(), pixels, data.get());
        }
        image.pixels = std::move(data);
    } else {
        std::string fault;
        image.reader = open_tiles(request.path, *in, t, options.read_cache_bytes, fault);
        if (!image.reader) return fault;
    }
    image.width = spec.width;
    image.height = spec.height;
    image.channels = t.channels;
    image.format = t.to;
    image.is_srgb = is_srgb;
    image.divide_by_alpha = relates;
    image.bytes = bytes;
    return {};
}

}  // namespace
}  // namespace alder

extern "C" void alder_load_image(const alder::ImageRequest& request, const alder::LoadOptions& options, alder::StoredImage& image, std::string& fault) {
    try {
        fault = alder::load(request, options, image);
    } catch (const std::exception& e) {  // plug-ins of OpenImageIO may throw on broken files
        fault = e.what();
    }
    if (fault.empty()) return;
    image.width = 0;
    image.pixels.reset();
    image.reader.reset();
}
