// From a file's pixels to those that are kept. Rounding as in Cycles' image manager.
#include "nodes/texture/image_pixels.h"

#include <algorithm>
#include <cmath>

#if __has_include(<Imath/half.h>)
#include <Imath/half.h>
#else
#include <OpenEXR/half.h>
#endif

namespace alder {
namespace {

using Format = StoredImage::Format;
size_t bytes_of(Format f) { return f == Format::U8 ? 1 : f == Format::F32 ? 4 : 2; }

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
template <class From, class To, class Space>
void convert_pixels(const From* from, To* to, size_t pixels, int channels, const Space& space) {
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

template <class Fn>
void with_numbers(Format format, std::byte* p, const Fn& fn) {
    switch (format) {
        case Format::U8: return fn(reinterpret_cast<uint8_t*>(p));
        case Format::U16: return fn(reinterpret_cast<uint16_t*>(p));
        case Format::F16: return fn(reinterpret_cast<half*>(p));
        case Format::F32: return fn(reinterpret_cast<float*>(p));
    }
}

}  // namespace

size_t PixelTreatment::from_bytes() const { return bytes_of(from) * static_cast<size_t>(channels); }
size_t PixelTreatment::to_bytes() const { return bytes_of(to) * static_cast<size_t>(channels); }

void PixelTreatment::apply(std::byte* in, size_t count, std::byte* out) const {
    if (channels == 4)
        with_numbers(from, in, [&](auto* p) { complete_pixels(p, count, file_channels, multiply, drop_alpha); });
    if (converts())
        with_numbers(from, in, [&](auto* p) {
            const auto into = [&](auto* to_pixels) {
                if (configured) convert_pixels(p, to_pixels, count, channels, *configured);
                else convert_pixels(p, to_pixels, count, channels, *space);
            };
            if (to == Format::F32) into(reinterpret_cast<float*>(out));
            else into(reinterpret_cast<half*>(out));
        });
    else if (in != out)
        std::copy(in, in + count * from_bytes(), out);
    if (to == Format::F16) remove_nonfinite(reinterpret_cast<half*>(out), count, channels);
    if (to == Format::F32) remove_nonfinite(reinterpret_cast<float*>(out), count, channels);
}

}  // namespace alder
