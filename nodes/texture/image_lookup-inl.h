// Looks an image up at texture coordinates: nearest texel, linear or cubic between texels, and what lies outside the image.
// Follows Cycles' CPU kernel, its rounding at texel borders included. Cubic is the uniform B-spline, which smooths.
#if defined(ALDER_NODES_TEXTURE_IMAGE_LOOKUP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_TEXTURE_IMAGE_LOOKUP_INL_H_
#undef ALDER_NODES_TEXTURE_IMAGE_LOOKUP_INL_H_
#else
#define ALDER_NODES_TEXTURE_IMAGE_LOOKUP_INL_H_
#endif

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

/// Texels by number (row · width + column, inside the image). Loads go lane by lane and are turned into lanes afterwards: that
/// is no slower than a gather and has no limit of 2^31 bytes.
template <class F>
HWY_INLINE Rgba<F> fetch_texels(const StoredImage& image, Int<F> number) {
    constexpr int n = kMostLanes<F>;
    alignas(64) int32_t at[n];
    store_ints<F>(number, at);
    const std::byte* const pixels = image.pixels.get();
    const int lanes = static_cast<int>(NumOf<F>::width());
    alignas(64) int32_t low[n], high[n];
    const F byte_scale(1.0f / 255.0f), short_scale(1.0f / 65535.0f);
    const Int<F> byte_mask(0xff), short_mask(0xffff);
    if (image.channels == 4) {
        switch (image.format) {
            case StoredImage::Format::U8: {
                for (int i = 0; i < lanes; ++i) std::memcpy(low + i, pixels + size_t{4} * static_cast<uint32_t>(at[i]), 4);
                const Int<F> v = load_ints<F>(low);
                return {{to_float<F>(v & byte_mask) * byte_scale, to_float<F>(shr<8>(v) & byte_mask) * byte_scale,
                         to_float<F>(shr<16>(v) & byte_mask) * byte_scale},
                        to_float<F>(shr<24>(v)) * byte_scale};
            }
            case StoredImage::Format::F32: {
                alignas(64) float texels[4 * n];
                for (int i = 0; i < lanes; ++i) std::memcpy(texels + 4 * i, pixels + size_t{16} * static_cast<uint32_t>(at[i]), 16);
                F c[4];
                load_floats_by_four(texels, c);
                return {{c[0], c[1], c[2]}, c[3]};
            }
            default: {
                for (int i = 0; i < lanes; ++i) {
                    const std::byte* const texel = pixels + size_t{8} * static_cast<uint32_t>(at[i]);
                    std::memcpy(low + i, texel, 4);
                    std::memcpy(high + i, texel + 4, 4);
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
            for (int i = 0; i < lanes; ++i) low[i] = static_cast<uint8_t>(pixels[static_cast<uint32_t>(at[i])]);
            grey = to_float<F>(load_ints<F>(low)) * byte_scale;
            break;
        case StoredImage::Format::F32: {
            alignas(64) float texels[n];
            for (int i = 0; i < lanes; ++i) std::memcpy(texels + i, pixels + size_t{4} * static_cast<uint32_t>(at[i]), 4);
            grey = load_floats<F>(texels);
            break;
        }
        default:
            for (int i = 0; i < lanes; ++i) {
                uint16_t v;
                std::memcpy(&v, pixels + size_t{2} * static_cast<uint32_t>(at[i]), 2);
                low[i] = v;
            }
            grey = image.format == StoredImage::Format::F16 ? half_to_float<F>(load_ints<F>(low)) : to_float<F>(load_ints<F>(low)) * short_scale;
    }
    return {Vec3<F>(grey), F(1)};
}

/// a mod n, in [0, n); for |a| below 2^24, beyond that some number of the range.
template <class F>
HWY_INLINE Int<F> positive_modulo(Int<F> a, int32_t n) {
    if constexpr (std::is_same_v<F, VF>) {
        const VI m(n);
        VI r = a - to_int(floor(to_float<VF>(a) / VF(n))) * m;
        r = select(r < VI(0), r + m, r);
        r = select(r >= m, r - m, r);
        return min(max(r, VI(0)), VI(n - 1));
    } else {
        const int32_t r = a % n;
        return r < 0 ? r + n : r;
    }
}
/// The column (or row) that `i` stands for; always inside the image.
template <class F>
HWY_INLINE Int<F> wrapped(Int<F> i, int32_t n, int extension) {
    using I = Int<F>;
    switch (extension) {
        case kExtendRepeat: return positive_modulo<F>(i, n);
        case kExtendMirror: {
            const Mask<F> negative = i < I(0);
            const I from_zero = select(negative, I(-1) - i, i);
            const I m = positive_modulo<F>(from_zero, 2 * n);
            return min(max(select(m >= I(n), I(2 * n - 1) - m, m), I(0)), I(n - 1));
        }
        default: return min(max(i, I(0)), I(n - 1));  // clip: masked by the caller
    }
}

/// The texels along one axis that a coordinate reads: kTaps of them, with their weights.
template <int kTaps, class F>
struct AxisTaps {
    Int<F> at[kTaps];
    F weight[kTaps];
    HWY_INLINE AxisTaps(F coordinate, int32_t n, int extension) {
        using I = Int<F>;
        const F x = kTaps == 1 ? coordinate * F(n) : mad(coordinate, F(n), F(-0.5f));
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
            if (extension == kExtendClip) weight[i] = select((texel >= I(0)) & (texel < I(n)), weight[i], F(0));
        }
    }
};

template <int kTaps, class F>
HWY_INLINE Rgba<F> filter_image(const StoredImage& image, F u, F v, int extension) {
    const AxisTaps<kTaps, F> x(u, image.width, extension), y(v, image.height, extension);
    Rgba<F> sum(Vec3<F>(F(0)), F(0));
    for (int j = 0; j < kTaps; ++j) {
        const Int<F> row = y.at[j] * Int<F>(image.width);
        for (int i = 0; i < kTaps; ++i) {
            const F w = y.weight[j] * x.weight[i];
            const Rgba<F> texel = fetch_texels<F>(image, row + x.at[i]);
            if constexpr (kTaps == 1) {
                sum.rgb = texel.rgb * w;
                sum.a = texel.a * w;
            } else {
                for (int c = 0; c < 3; ++c) sum.rgb[c] = mad(w, texel.rgb[c], sum.rgb[c]);
                sum.a = mad(w, texel.a, sum.a);
            }
        }
    }
    if (image.channels == 1) sum.a = F(1);  // one channel has no alpha, not even outside the clipped image
    return sum;
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
    if (uses_alpha && image->divide_by_alpha) {
        const Mask<F> partial = (r.a != F(1)) & (r.a != F(0));
        // By the reciprocal: what Cycles is compiled to.
        if (any(partial)) r.rgb = select<F>(partial, r.rgb * (F(1) / select(partial, r.a, F(1))), r.rgb);
    }
    if (image->is_srgb) {
        const bool exact = interpolation == kInterpolateClosest;
        for (int c = 0; c < 3; ++c) r.rgb[c] = exact ? srgb_to_linear_as_cycles(r.rgb[c]) : srgb_to_linear(r.rgb[c]);
    }
    return r;
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
