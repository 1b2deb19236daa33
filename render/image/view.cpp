// Pictures for screens. PNG and JPEG are written with their own libraries: a daemon's first preview must not wait for an
// image library's plug-ins.
#include "render/image/view.h"

#include <cstdio>   // jpeglib.h needs it before
#include <jpeglib.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <csetjmp>
#include <cstdlib>
#include <mutex>

namespace alder {
namespace {

float srgb_curve(float x) { return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f; }

/// Fit to the grey ramp of Blender 4.5's view "Filmic", look "None", over 2^-12.4 ... 2^4; largest error 0.37 of an 8-bit step.
/// t is the log2 shaper: 16.5 stops from 2^-12.473931.
float filmic_curve(float x) {
    constexpr double kFit[] = {-0.8130165, -4.382312, 34.13627, -145.0321, 305.9746, -283.8441, 94.84605};
    if (!(x > 0)) return 0;
    const double t = std::clamp((std::log2(double(x)) + 12.473931188) / 16.5, 0.0, 1.0);
    double p = 0;
    for (int k = 6; k >= 0; --k) p = p * t + kFit[k];
    return float(std::clamp(t + t * (1 - t) * p, 0.0, 1.0));
}

/// Exact rounding to 8 bits without a power per pixel: the linear value at which each code begins, and for every exponent
/// and first seven bits of the mantissa the code to begin the search with.
class Quantizer {
  public:
    explicit Quantizer(ViewTransform transform) {
        begin_[0] = 0;
        for (int code = 1; code < 256; ++code) {
            uint32_t lo = 0, hi = std::bit_cast<uint32_t>(1e30f);   // the curve is monotone: bisect over the bit patterns
            while (hi - lo > 1) {
                const uint32_t mid = lo + (hi - lo) / 2;
                (display_value(std::bit_cast<float>(mid), 1, transform) * 255 + 0.5f >= float(code) ? hi : lo) = mid;
            }
            begin_[code] = std::bit_cast<float>(hi);
        }
        int code = 0;
        for (uint32_t bucket = 0; bucket < first_.size(); ++bucket) {
            const float x = std::bit_cast<float>(bucket << 16);
            while (code < 255 && x >= begin_[code + 1]) ++code;
            first_[bucket] = uint8_t(code);
        }
    }
    uint8_t operator()(float x) const {
        if (!(x > 0)) return 0;   // NaN is black
        int code = first_[std::bit_cast<uint32_t>(x) >> 16];
        while (code < 255 && x >= begin_[code + 1]) ++code;
        return uint8_t(code);
    }

  private:
    std::array<float, 256> begin_;
    std::array<uint8_t, 0x8000> first_;
};

const Quantizer& quantizer(ViewTransform transform) {
    static const Quantizer srgb(ViewTransform::Srgb), linear(ViewTransform::Linear), filmic(ViewTransform::FilmicNone);
    switch (transform) {
        case ViewTransform::Srgb: return srgb;
        case ViewTransform::Linear: return linear;
        case ViewTransform::FilmicNone: return filmic;
    }
    return srgb;
}

const std::vector<float>* plane(const Layer& l, std::initializer_list<const char*> names) {
    for (const char* n : names) {
        for (size_t c = 0; c < l.channels.size(); ++c) {
            if (l.channels[c] == n) return &l.planes[c];
        }
    }
    return nullptr;
}

void append_png(png_structp png, png_bytep data, png_size_t n) {
    auto* out = static_cast<std::vector<uint8_t>*>(png_get_io_ptr(png));
    out->insert(out->end(), data, data + n);
}

struct JpegError {
    jpeg_error_mgr manager;
    std::jmp_buf jump;
    char message[JMSG_LENGTH_MAX];
};
[[noreturn]] void jpeg_failed(j_common_ptr c) {
    auto* e = reinterpret_cast<JpegError*>(c->err);
    c->err->format_message(c, e->message);
    std::longjmp(e->jump, 1);
}

/// Apart from anything with a destructor: libjpeg reports errors by longjmp.
bool compress_jpeg(const uint8_t* pixels, int width, int height, int quality, unsigned char** data, unsigned long* bytes, JpegError& error) {
    jpeg_compress_struct c{};
    c.err = jpeg_std_error(&error.manager);
    error.manager.error_exit = jpeg_failed;
    jpeg_create_compress(&c);
    if (setjmp(error.jump)) {
        jpeg_destroy_compress(&c);
        return false;
    }
    jpeg_mem_dest(&c, data, bytes);
    c.image_width = JDIMENSION(width);
    c.image_height = JDIMENSION(height);
    c.input_components = 3;
    c.in_color_space = JCS_RGB;
    jpeg_set_defaults(&c);
    jpeg_set_quality(&c, quality, TRUE);
    if (quality >= 90) c.comp_info[0].h_samp_factor = c.comp_info[0].v_samp_factor = 1;   // full colour resolution
    jpeg_start_compress(&c, TRUE);
    while (c.next_scanline < c.image_height) {
        JSAMPROW row = const_cast<JSAMPROW>(pixels + size_t(c.next_scanline) * size_t(width) * 3);
        jpeg_write_scanlines(&c, &row, 1);
    }
    jpeg_finish_compress(&c);
    jpeg_destroy_compress(&c);
    return true;
}

/// Likewise: libpng reports errors by longjmp.
bool compress_png(const uint8_t* pixels, int width, int height, int channels, std::vector<uint8_t>& out) {
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png ? png_create_info_struct(png) : nullptr;
    if (!info || setjmp(png_jmpbuf(png))) {
        png_destroy_write_struct(&png, &info);
        return false;
    }
    png_set_write_fn(png, &out, append_png, nullptr);
    png_set_IHDR(png, info, png_uint_32(width), png_uint_32(height), 8, channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, info, PNG_sRGB_INTENT_RELATIVE);
    png_set_compression_level(png, 3);   // 2.5x faster than the default and some percent larger: previews are looked at once
    png_set_filter(png, 0, PNG_FILTER_SUB | PNG_FILTER_UP);
    png_write_info(png, info);
    for (int y = 0; y < height; ++y) png_write_row(png, const_cast<png_bytep>(pixels + size_t(y) * size_t(width) * size_t(channels)));
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    return true;
}

}  // namespace

std::optional<ViewTransform> view_transform_from_name(std::string_view name) {
    if (name == "srgb") return ViewTransform::Srgb;
    if (name == "linear") return ViewTransform::Linear;
    if (name == "filmic-none") return ViewTransform::FilmicNone;
    return std::nullopt;
}

float display_value(float linear, float scale, ViewTransform transform) {
    const float x = linear * scale;
    if (!(x > 0)) return 0;
    switch (transform) {
        case ViewTransform::Srgb: return srgb_curve(std::min(x, 1.0f));
        case ViewTransform::Linear: return std::min(x, 1.0f);
        case ViewTransform::FilmicNone: return filmic_curve(x);
    }
    return 0;
}

std::vector<uint8_t> to_display(const Image& image, const View& view, int& channels, std::string& error) {
    const Layer* l = image.find(view.layer);
    const size_t pixels = size_t(std::max(image.width, 0)) * size_t(std::max(image.height, 0));
    if (!l || l->planes.empty() || pixels == 0) {
        error = "the image has no layer \"" + view.layer + "\"";
        return {};
    }
    const std::vector<float>* rgb[3] = {plane(*l, {"R", "r", "X", "U"}), plane(*l, {"G", "g", "Y", "V"}), plane(*l, {"B", "b", "Z"})};
    if (!rgb[0]) rgb[0] = rgb[1] = rgb[2] = &l->planes[0];
    const std::vector<float>* alpha = view.alpha ? plane(*l, {"A", "a"}) : nullptr;
    channels = view.alpha ? 4 : 3;
    const float scale = std::exp2(view.exposure);
    const Quantizer& q = quantizer(view.transform);
    std::vector<uint8_t> out(pixels * size_t(channels));
    for (size_t i = 0; i < pixels; ++i) {
        const float a = alpha ? std::clamp((*alpha)[i], 0.0f, 1.0f) : 1;
        const float unassociate = a > 0 ? scale / a : scale;
        for (int c = 0; c < 3; ++c) out[i * channels + c] = rgb[c] ? q((*rgb[c])[i] * unassociate) : 0;
        if (view.alpha) out[i * channels + 3] = uint8_t(a * 255 + 0.5f);
    }
    return out;
}

std::vector<uint8_t> encode_png(const Image& image, const View& view, std::string& error) {
    int channels = 3;
    const std::vector<uint8_t> pixels = to_display(image, view, channels, error);
    if (pixels.empty()) return {};
    std::vector<uint8_t> out;
    out.reserve(pixels.size() / 2 + 1024);
    if (compress_png(pixels.data(), image.width, image.height, channels, out)) return out;
    error = "the PNG could not be written";
    return {};
}

std::vector<uint8_t> encode_jpeg(const Image& image, const View& view, std::string& error) {
    View opaque = view;
    opaque.alpha = false;
    int channels = 3;
    const std::vector<uint8_t> pixels = to_display(image, opaque, channels, error);
    if (pixels.empty()) return {};
    unsigned char* data = nullptr;
    unsigned long bytes = 0;
    JpegError jpeg{};
    std::vector<uint8_t> out;
    if (compress_jpeg(pixels.data(), image.width, image.height, std::clamp(view.quality, 1, 100), &data, &bytes, jpeg)) {
        out.assign(data, data + bytes);
    } else {
        error = std::string("the JPEG could not be written: ") + jpeg.message;
    }
    std::free(data);
    return out;
}

}  // namespace alder
