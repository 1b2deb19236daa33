// PNG and JPEG: decoded again they show the values that the curve promises.
#include "render/image/view.h"

#include <gtest/gtest.h>

#include <png.h>

#include <cmath>

namespace alder {
namespace {

Image ramp(int n) {
    Image image;
    image.width = n;
    image.height = 2;
    Layer beauty{"", {"R", "G", "B", "A"}, false, std::vector<std::vector<float>>(4, std::vector<float>(size_t(n) * 2))};
    for (int i = 0; i < n * 2; ++i) {
        beauty.planes[0][i] = std::exp2(float(i) / 16 - 12);
        beauty.planes[1][i] = float(i) / float(n);
        beauty.planes[2][i] = i % 3 == 0 ? NAN : -1;
        beauty.planes[3][i] = i % 2 ? 0.5f : 1;
    }
    image.layers = {beauty, {"Z", {""}, true, {std::vector<float>(size_t(n) * 2, 0.5f)}}};
    return image;
}

std::vector<uint8_t> decode_png(const std::vector<uint8_t>& bytes, int& channels) {
    png_image p{};
    p.version = PNG_IMAGE_VERSION;
    if (!png_image_begin_read_from_memory(&p, bytes.data(), bytes.size())) return {};
    channels = p.format & PNG_FORMAT_FLAG_ALPHA ? 4 : 3;
    p.format = channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
    std::vector<uint8_t> out(PNG_IMAGE_SIZE(p));
    png_image_finish_read(&p, nullptr, out.data(), 0, nullptr);
    return out;
}

TEST(View, eight_bits_are_the_curve_rounded_exactly) {
    const Image image = ramp(256);
    for (const ViewTransform t : {ViewTransform::Srgb, ViewTransform::Linear, ViewTransform::FilmicNone}) {
        for (const float exposure : {0.0f, -1.5f, 2.0f}) {
            int channels = 0;
            std::string error;
            const std::vector<uint8_t> px = to_display(image, {.exposure = exposure, .transform = t}, channels, error);
            ASSERT_EQ(channels, 3);
            for (size_t i = 0; i < 512; ++i) {
                for (int c = 0; c < 2; ++c) {
                    const float v = display_value(image.layers[0].planes[c][i], std::exp2(exposure), t);
                    EXPECT_EQ(px[i * 3 + c], int(v * 255 + 0.5f)) << "pixel " << i << " transform " << int(t);
                }
                EXPECT_EQ(px[i * 3 + 2], 0) << "negative and NaN are black";
            }
        }
    }
}

TEST(View, curves_have_their_known_values) {
    EXPECT_NEAR(display_value(0.18f, 1, ViewTransform::Srgb), 0.46136f, 1e-4f);
    EXPECT_NEAR(display_value(7, 1, ViewTransform::Srgb), 1, 1e-6f);
    EXPECT_EQ(display_value(0.25f, 2, ViewTransform::Linear), 0.5f);
    // Blender 4.5, view Filmic, look None.
    EXPECT_NEAR(display_value(0.15093671f, 1, ViewTransform::FilmicNone), 0.46581215f, 0.002f);
    EXPECT_NEAR(display_value(1.06438462f, 1, ViewTransform::FilmicNone), 0.81606776f, 0.002f);
    EXPECT_NEAR(display_value(3.91412233f, 1, ViewTransform::FilmicNone), 0.94798201f, 0.002f);
    float last = 0;
    for (float x = 1e-5f; x < 30; x *= 1.01f) {
        const float y = display_value(x, 1, ViewTransform::FilmicNone);
        EXPECT_GE(y, last) << x;
        last = y;
    }
}

TEST(View, png_keeps_pixels_and_unassociated_alpha) {
    const Image image = ramp(64);
    std::string error;
    for (const bool alpha : {false, true}) {
        const View view{.alpha = alpha};
        int expected_channels = 0, channels = 0;
        const std::vector<uint8_t> expected = to_display(image, view, expected_channels, error);
        const std::vector<uint8_t> bytes = encode_png(image, view, error);
        ASSERT_FALSE(bytes.empty()) << error;
        EXPECT_EQ(decode_png(bytes, channels), expected);
        EXPECT_EQ(channels, alpha ? 4 : 3);
        if (alpha) {
            EXPECT_EQ(expected[7], 128);
            EXPECT_EQ(expected[5], int(display_value(image.layers[0].planes[1][1], 2, ViewTransform::Srgb) * 255 + 0.5f));
        }
        EXPECT_EQ(bytes, encode_png(image, view, error)) << "same image, same bytes";
    }
}

TEST(View, a_layer_of_one_channel_is_grey_and_an_unknown_one_an_error) {
    std::string error;
    int channels = 0;
    const std::vector<uint8_t> px = to_display(ramp(4), {.transform = ViewTransform::Linear, .layer = "Z"}, channels, error);
    EXPECT_EQ(px, std::vector<uint8_t>(24, 128));
    EXPECT_TRUE(encode_png(ramp(4), {.layer = "nope"}, error).empty());
    EXPECT_NE(error.find("nope"), std::string::npos);
}

TEST(View, jpeg_begins_as_one_and_grows_with_quality) {
    std::string error;
    const std::vector<uint8_t> good = encode_jpeg(ramp(256), {.quality = 95}, error), poor = encode_jpeg(ramp(256), {.quality = 10}, error);
    ASSERT_GT(poor.size(), 100u) << error;
    EXPECT_EQ(good[0], 0xff);
    EXPECT_EQ(good[1], 0xd8);
    EXPECT_GT(good.size(), poor.size());
    Image wide = ramp(40000);   // JPEG's limit is 65500 a side
    wide.width = 80000;
    wide.height = 1;
    EXPECT_TRUE(encode_jpeg(wide, {}, error).empty());
    EXPECT_FALSE(error.empty());
}

}  // namespace
}  // namespace alder
