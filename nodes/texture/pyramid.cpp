// Mip levels of images.
#include "nodes/texture/pyramid.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "nodes/texture/color_space.h"

namespace alder {
namespace {

using Format = StoredImage::Format;

float half_value(uint16_t h) {
    const float magnitude = std::bit_cast<float>(static_cast<uint32_t>(h & 0x7fff) << 13) * 0x1p112f;
    return h & 0x8000 ? -magnitude : magnitude;
}
/// To the nearest half, ties to even; what is too large becomes the largest.
uint16_t half_bits(float v) {
    const uint16_t sign = std::signbit(v) ? 0x8000 : 0;
    const float magnitude = std::min(std::abs(v), 65504.0f);
    // Scaled so that the float's denormal steps are the half's: the addition rounds away the 13 bits too many.
    uint32_t bits = std::bit_cast<uint32_t>(magnitude * 0x1p-112f);
    if (magnitude < 0x1p-14f) bits = static_cast<uint32_t>(std::nearbyint(magnitude * 0x1p24f)) << 13;
    else bits += 0xfff + (bits >> 13 & 1);
    return static_cast<uint16_t>(sign | bits >> 13);
}

float read_number(const std::byte* p, Format format) {
    uint16_t u16;
    float f32;
    switch (format) {
        case Format::U8: return static_cast<float>(static_cast<uint8_t>(*p)) / 255.0f;
        case Format::U16: std::memcpy(&u16, p, 2); return static_cast<float>(u16) / 65535.0f;
        case Format::F16: std::memcpy(&u16, p, 2); return half_value(u16);
        default: std::memcpy(&f32, p, 4); return f32;
    }
}
void write_number(std::byte* p, Format format, float v) {
    switch (format) {
        case Format::U8: *p = static_cast<std::byte>(std::lround(std::clamp(v, 0.0f, 1.0f) * 255.0f)); return;
        case Format::U16: {
            const uint16_t u = static_cast<uint16_t>(std::lround(std::clamp(v, 0.0f, 1.0f) * 65535.0f));
            std::memcpy(p, &u, 2);
            return;
        }
        case Format::F16: {
            const uint16_t h = half_bits(v);
            std::memcpy(p, &h, 2);
            return;
        }
        default: std::memcpy(p, &v, 4);
    }
}

/// IEC 61966-2-1.
float decoded(float c) { return c < 0.04045f ? std::max(c, 0.0f) / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f); }
float encoded(float c) { return c < 0.0031308f ? std::max(c, 0.0f) * 12.92f : 1.055f * std::pow(c, 1 / 2.4f) - 0.055f; }
float decoded_byte(std::byte b) {
    static const auto table = [] {
        std::array<float, 256> t;
        for (int i = 0; i < 256; ++i) t[i] = decoded(static_cast<float>(i) / 255.0f);
        return t;
    }();
    return table[static_cast<uint8_t>(b)];
}

/// A texel in linear light, colour multiplied by alpha.
using Light = std::array<float, 4>;
Light light_of(const StoredImage& image, const std::byte* p) {
    const size_t size = image.texel_bytes() / image.channels;
    Light l{0, 0, 0, 1};
    const bool bytes = image.format == Format::U8;
    if (image.channels == 4) l[3] = read_number(p + 3 * size, image.format);
    const bool partial = image.channels == 4 && image.divide_by_alpha && l[3] > 0 && l[3] < 1;
    for (int c = 0; c < std::min(image.channels, 3); ++c) {
        if (!image.is_srgb) l[c] = read_number(p + c * size, image.format);
        else if (partial) l[c] = decoded(read_number(p + c * size, image.format) / l[3]) * l[3];
        else l[c] = bytes ? decoded_byte(p[c]) : decoded(read_number(p + c * size, image.format));
    }
    return l;
}
void put_light(const StoredImage& image, const Light& l, std::byte* p) {
    const size_t size = image.texel_bytes() / image.channels;
    const bool partial = image.channels == 4 && image.divide_by_alpha && l[3] > 0 && l[3] < 1;
    for (int c = 0; c < std::min(image.channels, 3); ++c) {
        float v = l[c];
        if (image.is_srgb) v = partial ? encoded(v / l[3]) * l[3] : encoded(v);
        write_number(p + c * size, image.format, v);
    }
    if (image.channels == 4) write_number(p + 3 * size, image.format, l[3]);
}

/// The texels below that one texel covers along an axis.
struct Cover {
    int first = 0, count = 1;
    float weight[3] = {1, 0, 0};
    Cover(int at, int below, int size) {
        if (below == 1) return;
        first = 2 * at;
        if (below % 2 == 0) {
            count = 2;
            weight[0] = weight[1] = 0.5f;
        } else {
            count = 3;
            const float n = static_cast<float>(below);
            weight[0] = static_cast<float>(size - at) / n;
            weight[1] = static_cast<float>(size) / n;
            weight[2] = static_cast<float>(at + 1) / n;
        }
    }
};

}  // namespace

int level_count(int width, int height) { return std::bit_width(static_cast<unsigned>(std::max(width, height))); }

void average_level(const StoredImage& image, int level, int x, int y, int width, int height, std::byte* out,
                   const std::function<void(int, int, int, int, std::byte*)>& below) {
    const int below_width = level_size(image.width, level - 1), below_height = level_size(image.height, level - 1);
    const int level_width = level_size(image.width, level), level_height = level_size(image.height, level);
    const Cover left(x, below_width, level_width), right(x + width - 1, below_width, level_width);
    const Cover bottom(y, below_height, level_height), top(y + height - 1, below_height, level_height);
    const int w = right.first + right.count - left.first, h = top.first + top.count - bottom.first;
    const size_t texel = image.texel_bytes();
    std::vector<std::byte> source(texel * static_cast<size_t>(w) * static_cast<size_t>(h));
    below(left.first, bottom.first, w, h, source.data());
    std::vector<Light> light(static_cast<size_t>(w) * static_cast<size_t>(h));
    for (size_t i = 0; i < light.size(); ++i) light[i] = light_of(image, source.data() + i * texel);
    for (int j = 0; j < height; ++j) {
        const Cover v(y + j, below_height, level_height);
        for (int i = 0; i < width; ++i) {
            const Cover u(x + i, below_width, level_width);
            Light sum{0, 0, 0, 0};
            for (int b = 0; b < v.count; ++b)
                for (int a = 0; a < u.count; ++a) {
                    const Light& l = light[static_cast<size_t>(v.first + b - bottom.first) * w + (u.first + a - left.first)];
                    const float weight = u.weight[a] * v.weight[b];
                    for (int c = 0; c < 4; ++c) sum[c] += weight * l[c];
                }
            put_light(image, sum, out + texel * (static_cast<size_t>(j) * width + i));
        }
    }
}

std::unique_ptr<const Pyramid> build_pyramid(const StoredImage& image) {
    auto p = std::make_unique<Pyramid>();
    const int levels = level_count(image.width, image.height);
    const size_t texel = image.texel_bytes();
    p->offset.assign(levels, 0);
    for (int l = 1; l < levels; ++l) {
        p->offset[l] = p->bytes;
        p->bytes += texel * level_size(image.width, l) * level_size(image.height, l);
    }
    p->pixels.reset(new std::byte[std::max<size_t>(p->bytes, 1)]);
    for (int l = 1; l < levels; ++l) {
        const std::byte* const from = l == 1 ? image.pixels.get() : p->pixels.get() + p->offset[l - 1];
        const int from_width = level_size(image.width, l - 1), width = level_size(image.width, l), height = level_size(image.height, l);
        const auto below = [&](int x, int y, int w, int h, std::byte* out) {
            for (int j = 0; j < h; ++j)
                std::memcpy(out + texel * static_cast<size_t>(j) * w, from + texel * (static_cast<size_t>(y + j) * from_width + x), texel * w);
        };
        constexpr int kRows = 16;  // at a time: what is read stays in the cache
        for (int y = 0; y < height; y += kRows)
            average_level(image, l, 0, y, width, std::min(kRows, height - y), p->pixels.get() + p->offset[l] + texel * static_cast<size_t>(y) * width, below);
    }
    return p;
}

}  // namespace alder
