// Looks an image up at texture coordinates: nearest texel, linear or cubic between texels, and what lies outside the image.
// Follows Cycles' CPU kernel, its rounding at texel borders included. Cubic is the uniform B-spline, which smooths.
#if defined(ALDER_NODES_TEXTURE_IMAGE_LOOKUP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_TEXTURE_IMAGE_LOOKUP_INL_H_
#undef ALDER_NODES_TEXTURE_IMAGE_LOOKUP_INL_H_
#else
#define ALDER_NODES_TEXTURE_IMAGE_LOOKUP_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <cstring>

#include "nodes/num/math-inl.h"
#include "nodes/num/vec-inl.h"
#include "nodes/texture/image_store.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

enum ImageInterpolation { kInterpolateLinear, kInterpolateClosest, kInterpolateCubic, kInterpolateSmart };
enum ImageExtension { kExtendRepeat, kExtendEdge, kExtendClip, kExtendMirror };

template <class F>
struct Rgba {
    Vec3<F> rgb;
    F a;
    HWY_INLINE Rgba() {}
    HWY_INLINE Rgba(Vec3<F> c, F alpha) : rgb(c), a(alpha) {}
};

/// sRGB's curve to linear light (IEC 61966-2-1), negative to 0. Between the linear part and 1 by c' = y²·p(√y), y = (c + 0.055)/1.055,
/// p a minimax polynomial: 9e-7 relative.
template <class F>
HWY_INLINE F srgb_to_linear(F c) {
    const F y = (c + F(0.055f)) * F(1.0f / 1.055f);
    const F t = sqrt(max(y, F(0))) - F(0.65f);
    F p = F(0.156026741f);
    p = mad(p, t, F(-0.106654241f));
    p = mad(p, t, F(0.0589097671f));
    p = mad(p, t, F(-0.0672022867f));
    p = mad(p, t, F(0.0830332519f));
    p = mad(p, t, F(-0.134215742f));
    p = mad(p, t, F(0.871975303f));
    p = mad(p, t, F(0.708485275f));
    F curved = y * y * p;
    if (any(c > F(1.0001f))) curved = select(c > F(1.0001f), pow(y, F(2.4f)), curved);
    return select(c < F(0.04045f), max(c, F(0)) * F(1.0f / 12.92f), curved);
}

/// The same to Cycles' last bits, which a nearest texel keeps: y^2.4 as the cube of the fifth root of y⁴, by three steps of Newton's
/// method from a guess off the float's exponent. Twice the time of srgb_to_linear.
template <class F>
HWY_INLINE F srgb_to_linear_as_cycles(F c) {
    if constexpr (std::is_same_v<F, double>) {
        return srgb_to_linear(c);
    } else {
        const F y = (c + F(0.055f)) * F(1.0f / 1.055f), y2 = y * y, y4 = y2 * y2;
        const F guess = to_float<F>(float_bits(y * F(std::bit_cast<float>(0x4f55a7fb)))) * F(0.8f);
        F x = bits_to_float<F>(to_int(guess));
        for (int i = 0; i < 3; ++i) {
            const F x2 = x * x;
            x = mad(F(4), x, y4 / (x2 * x2)) * F(0.2f);
        }
        return select(c < F(0.04045f), max(c * F(1.0f / 12.92f), F(0)), x * (x * x));
    }
}

/// A half float's value from its bits, exactly. (Cycles' conversion of textures lifts zero to 3e-5.)
template <class F>
HWY_INLINE F half_to_float(Int<F> bits) {
    const F magnitude = bits_to_float<F>(shl<13>(bits & Int<F>(0x7fff))) * F(0x1p112f);
    return select((bits & Int<F>(0x8000)) == Int<F>(0), magnitude, -magnitude);
}

/// Where the texels of all lanes lie: in the image, or copied together from its tiles. Columns and rows must be inside the level.
template <class F>
struct TexelPlaces {
    const std::byte* at[kMostLanes<F>];
    std::byte copies[16 * kMostLanes<F>];  ///< of tiles, which may go while others are looked at

    HWY_INLINE TexelPlaces(const StoredImage& image, Int<F> column, Int<F> row) { find(image, column, row, nullptr); }
    HWY_INLINE TexelPlaces(const StoredImage& image, Int<F> column, Int<F> row, Int<F> level) {
        alignas(64) int32_t l[kMostLanes<F>];
        store_ints<F>(level, l);
        find(image, column, row, l);
    }

  private:
    HWY_INLINE void find(const StoredImage& image, Int<F> column, Int<F> row, const int32_t* level) {
        const int lanes = static_cast<int>(NumOf<F>::width());
        if (!image.is_tiled() && !level) {
            alignas(64) int32_t number[kMostLanes<F>];
            store_ints<F>(row * Int<F>(image.width) + column, number);
            const std::byte* const pixels = image.pixels.get();
            const size_t texel = image.texel_bytes();
            for (int i = 0; i < lanes; ++i) at[i] = pixels + texel * static_cast<uint32_t>(number[i]);
            return;
        }
        alignas(64) int32_t x[kMostLanes<F>], y[kMostLanes<F>];
        store_ints<F>(column, x);
        store_ints<F>(row, y);
        if (image.is_tiled()) {
            TileCache::read_texels(image, level, x, y, lanes, copies);
            for (int i = 0; i < lanes; ++i) at[i] = copies + 16 * i;
        } else {
            for (int i = 0; i < lanes; ++i) at[i] = image.texel(level[i], x[i], y[i]);
        }
    }
};

/// Loads go lane by lane and are turned into lanes afterwards: that is no slower than a gather and has no limit of 2^31 bytes.
template <class F>
HWY_INLINE Rgba<F> load_texels(const StoredImage& image, const TexelPlaces<F>& places) {
    constexpr int n = kMostLanes<F>;
    const std::byte* const* const at = places.at;
    const int lanes = static_cast<int>(NumOf<F>::width());
    alignas(64) int32_t low[n], high[n];
    const F byte_scale(1.0f / 255.0f), short_scale(1.0f / 65535.0f);
    const Int<F> byte_mask(0xff), short_mask(0xffff);
    if (image.channels == 4) {
        switch (image.format) {
            case StoredImage::Format::U8: {
                for (int i = 0; i < lanes; ++i) std::memcpy(low + i, at[i], 4);
                const Int<F> v = load_ints<F>(low);
                return {{to_float<F>(v & byte_mask) * byte_scale, to_float<F>(shr<8>(v) & byte_mask) * byte_scale,
                         to_float<F>(shr<16>(v) & byte_mask) * byte_scale},
                        to_float<F>(shr<24>(v)) * byte_scale};
            }
            case StoredImage::Format::F32: {
                alignas(64) float texels[4 * n];
                for (int i = 0; i < lanes; ++i) std::memcpy(texels + 4 * i, at[i], 16);
                F c[4];
                load_floats_by_four(texels, c);
                return {{c[0], c[1], c[2]}, c[3]};
            }
            default: {
                for (int i = 0; i < lanes; ++i) {
                    std::memcpy(low + i, at[i], 4);
                    std::memcpy(high + i, at[i] + 4, 4);
                }
                const Int<F> l = load_ints<F>(low), h = load_ints<F>(high);
                if (image.format == StoredImage::Format::F16)
                    return {{half_to_float<F>(l), half_to_float<F>(shr<16>(l)), half_to_float<F>(h)}, half_to_float<F>(shr<16>(h))};
                return {{to_float<F>(l & short_mask) * short_scale, to_float<F>(shr<16>(l)) * short_scale, to_float<F>(h & short_mask) * short_scale},
                        to_float<F>(shr<16>(h)) * short_scale};
            }
        }
    }
    F grey;
    switch (image.format) {
        case StoredImage::Format::U8:
            for (int i = 0; i < lanes; ++i) low[i] = static_cast<uint8_t>(*at[i]);
            grey = to_float<F>(load_ints<F>(low)) * byte_scale;
            break;
        case StoredImage::Format::F32: {
            alignas(64) float texels[n];
            for (int i = 0; i < lanes; ++i) std::memcpy(texels + i, at[i], 4);
            grey = load_floats<F>(texels);
            break;
        }
        default:
            for (int i = 0; i < lanes; ++i) {
                uint16_t v;
                std::memcpy(&v, at[i], 2);
                low[i] = v;
            }
            grey = image.format == StoredImage::Format::F16 ? half_to_float<F>(load_ints<F>(low)) : to_float<F>(load_ints<F>(low)) * short_scale;
    }
    return {Vec3<F>(grey), F(1)};
}

/// a mod n, in [0, n); for |a| below 2^24, beyond that some number of the range.
template <class F>
HWY_INLINE Int<F> positive_modulo(Int<F> a, Int<F> n) {
    if constexpr (std::is_same_v<F, VF>) {
        VI r = a - to_int(floor(to_float<VF>(a) / to_float<VF>(n))) * n;
        r = select(r < VI(0), r + n, r);
        r = select(r >= n, r - n, r);
        return min(max(r, VI(0)), n - VI(1));
    } else {
        const int32_t r = a % n;
        return r < 0 ? r + n : r;
    }
}
/// The column (or row) that `i` stands for; always inside the image.
template <class F>
HWY_INLINE Int<F> wrapped(Int<F> i, Int<F> n, int extension) {
    using I = Int<F>;
    switch (extension) {
        case kExtendRepeat: return positive_modulo<F>(i, n);
        case kExtendMirror: {
            const Mask<F> negative = i < I(0);
            const I from_zero = select(negative, I(-1) - i, i);
            const I m = positive_modulo<F>(from_zero, n + n);
            return min(max(select(m >= n, n + n - I(1) - m, m), I(0)), n - I(1));
        }
        default: return min(max(i, I(0)), n - I(1));  // clip: masked by the caller
    }
}

/// The texels along one axis that a coordinate reads: kTaps of them, with their weights.
template <int kTaps, class F>
struct AxisTaps {
    Int<F> at[kTaps];
    F weight[kTaps];
    HWY_INLINE AxisTaps(F coordinate, Int<F> n, int extension) {
        using I = Int<F>;
        const F size = to_float<F>(n), x = kTaps == 1 ? coordinate * size : mad(coordinate, size, F(-0.5f));
        // Truncation less one for negative numbers, not floor: a negative coordinate on a texel's border belongs to the texel below.
        const I cell = to_int(x) - select(x < F(0), I(1), I(0));
        const F t = x - to_float<F>(cell);
        if constexpr (kTaps == 1) {
            weight[0] = F(1);
        } else if constexpr (kTaps == 2) {
            weight[0] = F(1) - t;
            weight[1] = t;
        } else {
            const F sixth(1.0f / 6.0f);
            weight[0] = mad(mad(mad(-sixth, t, F(0.5f)), t, F(-0.5f)), t, sixth);
            weight[1] = mad(mad(F(0.5f), t, F(-1)) * t, t, F(2.0f / 3.0f));
            weight[2] = mad(mad(mad(F(-0.5f), t, F(0.5f)), t, F(0.5f)), t, sixth);
            weight[3] = sixth * t * t * t;
        }
        for (int i = 0; i < kTaps; ++i) {
            const I texel = cell + I(i - (kTaps == 4 ? 1 : 0));
            at[i] = wrapped<F>(texel, n, extension);
            if (extension == kExtendClip) weight[i] = select((texel >= I(0)) & (texel < n), weight[i], F(0));
        }
    }
};

template <int kTaps, class F>
HWY_INLINE void add_texel(Rgba<F>& sum, const Rgba<F>& texel, F w) {
    if constexpr (kTaps == 1) {
        sum.rgb = texel.rgb * w;
        sum.a = texel.a * w;
    } else {
        for (int c = 0; c < 3; ++c) sum.rgb[c] = mad(w, texel.rgb[c], sum.rgb[c]);
        sum.a = mad(w, texel.a, sum.a);
    }
}
template <int kTaps, class F>
HWY_INLINE Rgba<F> filter_image(const StoredImage& image, F u, F v, int extension) {
    const AxisTaps<kTaps, F> x(u, Int<F>(image.width), extension), y(v, Int<F>(image.height), extension);
    Rgba<F> sum(Vec3<F>(F(0)), F(0));
    for (int j = 0; j < kTaps; ++j)
        for (int i = 0; i < kTaps; ++i)
            add_texel<kTaps>(sum, load_texels<F>(image, TexelPlaces<F>(image, x.at[i], y.at[j])), y.weight[j] * x.weight[i]);
    if (image.channels == 1) sum.a = F(1);  // one channel has no alpha, not even outside the clipped image
    return sum;
}
/// The same, linear, in a mip level of each lane's own.
template <class F>
HWY_INLINE Rgba<F> filter_level(const StoredImage& image, F u, F v, Int<F> level, int extension) {
    using I = Int<F>;
    // Sizes by powers of two, exactly: what is shifted out is what the division leaves after the point.
    const F scale = bits_to_float<F>(shl<23>(I(127) - level));
    const I width = max(to_int(to_float<F>(I(image.width)) * scale), I(1)), height = max(to_int(to_float<F>(I(image.height)) * scale), I(1));
    const AxisTaps<2, F> x(u, width, extension), y(v, height, extension);
    Rgba<F> sum(Vec3<F>(F(0)), F(0));
    for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i)
            add_texel<2>(sum, load_texels<F>(image, TexelPlaces<F>(image, x.at[i], y.at[j], level)), y.weight[j] * x.weight[i]);
    if (image.channels == 1) sum.a = F(1);
    return sum;
}

/// Takes alpha out where both are used, and makes the colour linear.
template <class F>
HWY_INLINE Rgba<F> finish_lookup(const StoredImage& image, Rgba<F> r, bool uses_alpha, bool exact) {
    if (uses_alpha && image.divide_by_alpha) {
        const Mask<F> partial = (r.a != F(1)) & (r.a != F(0));
        // By the reciprocal: what Cycles is compiled to.
        if (any(partial)) r.rgb = select<F>(partial, r.rgb * (F(1) / select(partial, r.a, F(1))), r.rgb);
    }
    if (image.is_srgb)
        for (int c = 0; c < 3; ++c) r.rgb[c] = exact ? srgb_to_linear_as_cycles(r.rgb[c]) : srgb_to_linear(r.rgb[c]);
    return r;
}

/// The image at (u, v): interpolated, alpha taken out where both are used, linear. Magenta where there is no image.
template <class F>
HWY_INLINE Rgba<F> lookup_image(const StoredImage* image, F u, F v, int interpolation, int extension, bool uses_alpha) {
    if (!image || !image->readable()) return {{F(1), F(0), F(1)}, F(1)};
    Rgba<F> r;
    switch (interpolation) {
        case kInterpolateClosest: r = filter_image<1>(*image, u, v, extension); break;
        case kInterpolateLinear: r = filter_image<2>(*image, u, v, extension); break;
        default: r = filter_image<4>(*image, u, v, extension); break;
    }
    return finish_lookup(*image, r, uses_alpha, interpolation == kInterpolateClosest);
}

/// How far texture coordinates move from pixel to pixel.
template <class F>
struct UvSteps {
    F dudx, dvdx, dudy, dvdy;
    HWY_INLINE UvSteps() : dudx(0), dvdx(0), dudy(0), dvdy(0) {}
};

/// The same with the image blurred to what the pixel covers: linear between the two mip levels whose texels are as large as the shorter
/// step to the next pixel. Along the longer one the samples of the pixel do the averaging, exactly; a blur by the longer one would smear
/// the other direction. Closest images are left as they are: blending their texels is what they do not want.
template <class F>
HWY_INLINE Rgba<F> lookup_image_filtered(const StoredImage* image, F u, F v, const UvSteps<F>& steps, int interpolation, int extension, bool uses_alpha) {
    if (!image || !image->readable() || interpolation == kInterpolateClosest) return lookup_image(image, u, v, interpolation, extension, uses_alpha);
    constexpr float kMostStretched = 1.0f / 16.0f;  // more would take more samples than pixels get
    const F w(static_cast<float>(image->width)), h(static_cast<float>(image->height));
    const F xu = steps.dudx * w, xv = steps.dvdx * h, yu = steps.dudy * w, yv = steps.dvdy * h;
    const F x2 = xu * xu + xv * xv, y2 = yu * yu + yv * yv;
    const F texels2 = max(min(x2, y2), max(x2, y2) * F(kMostStretched * kMostStretched));
    const F top(static_cast<float>(std::bit_width(static_cast<unsigned>(std::max(image->width, image->height))) - 1));
    const Mask<F> coarse = texels2 > F(1);  // false for NaN
    if (!any(coarse)) return lookup_image(image, u, v, interpolation, extension, uses_alpha);
    const F level = select(coarse, min(F(0.5f) * log2(select(coarse, texels2, F(1))), top), F(0));
    const F lower = floor(level), t = level - lower;
    const Int<F> fine = to_int(lower);
    Rgba<F> r;
    const Mask<F> at_image = lower == F(0);
    if (any(at_image)) r = lookup_image(image, u, v, interpolation, extension, uses_alpha);
    if (!all(at_image)) {
        const Rgba<F> s = finish_lookup(*image, filter_level<F>(*image, u, v, fine, extension), uses_alpha, false);
        if (any(at_image)) {
            r.rgb = select<F>(at_image, r.rgb, s.rgb);
            r.a = select(at_image, r.a, s.a);
        } else {
            r = s;
        }
    }
    const Rgba<F> coarser = finish_lookup(*image, filter_level<F>(*image, u, v, min(fine + Int<F>(1), to_int(top)), extension), uses_alpha, false);
    for (int c = 0; c < 3; ++c) r.rgb[c] = select(coarse, mad(t, coarser.rgb[c] - r.rgb[c], r.rgb[c]), r.rgb[c]);
    r.a = select(coarse, mad(t, coarser.a - r.a, r.a), r.a);
    return r;
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
