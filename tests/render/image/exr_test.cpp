// EXR: what is written is read back; names, types and windows as documented; same image, same bytes; broken files are errors.
#include "render/image/exr.h"

#include <gtest/gtest.h>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfStandardAttributes.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace alder {
namespace {

Layer layer(const std::string& name, std::vector<std::string> channels, bool data, int pixels, float start) {
    Layer l{name, std::move(channels), data, {}};
    for (size_t c = 0; c < l.channels.size(); ++c) {
        std::vector<float>& p = l.planes.emplace_back(size_t(pixels));
        for (int i = 0; i < pixels; ++i) p[i] = start + float(c) * 0.25f + float(i) / 3.0f;
    }
    return l;
}

Image picture() {
    Image image;
    image.width = 5;
    image.height = 40;   // more than two zip blocks
    image.full_width = 20;
    image.full_height = 50;
    image.crop_x = 3;
    image.crop_y = 7;
    image.layers = {layer("", {"R", "G", "B", "A"}, false, 200, 0), layer("direct_diffuse", {"R", "G", "B"}, false, 200, 1),
                    layer("Z", {""}, true, 200, 1e6f), layer("P", {"X", "Y", "Z"}, true, 200, -3), layer("wear", {""}, false, 200, 2)};
    image.attributes = {{"alder/samples", "64"}, {"alder/seed", "4294967295"}, {"alder/complete", "1"}, {"alder/estimated_error", "0.0125"},
                        {"alder/settings", "{\"samples\":64}"}, {"comments", "für alle"}, {"worldToCamera", "1 0 0 0 0 1 0 0 0 0 1 0 0.5 0 0 1"}};
    return image;
}

std::string scratch(const std::string& name) {
    const std::filesystem::path dir = std::filesystem::path(ALDER_BINARY_DIR) / "test_scratch" / "exr";
    std::filesystem::create_directories(dir);
    return (dir / name).string();
}

TEST(Exr, float_files_come_back_bit_for_bit) {
    const Image image = picture();
    std::string error;
    const std::vector<uint8_t> bytes = encode_exr(image, {.all_float = true}, error);
    ASSERT_FALSE(bytes.empty()) << error;
    const std::optional<Image> back = decode_exr(bytes, error);
    ASSERT_TRUE(back) << error;
    EXPECT_EQ(back->width, 5);
    EXPECT_EQ(back->height, 40);
    EXPECT_EQ(back->full_width, 20);
    EXPECT_EQ(back->full_height, 50);
    EXPECT_EQ(back->crop_x, 3);
    EXPECT_EQ(back->crop_y, 7);
    ASSERT_EQ(back->layers.size(), image.layers.size());
    EXPECT_EQ(back->layers[0].name, "");
    for (const Layer& l : image.layers) {
        const Layer* b = back->find(l.name);
        ASSERT_TRUE(b) << l.name;
        EXPECT_EQ(b->channels, l.channels);
        EXPECT_EQ(b->planes, l.planes) << l.name;
    }
    for (const auto& [name, value] : image.attributes) {
        ASSERT_TRUE(find_attribute(*back, name)) << name;
        EXPECT_EQ(*find_attribute(*back, name), value);
    }
}

TEST(Exr, colour_is_half_and_data_is_float) {
    Image image = picture();
    image.layers[0].planes[0][0] = 1e9f;
    image.layers[0].planes[0][1] = -INFINITY;
    std::string error;
    const std::string path = scratch("types.exr");
    ASSERT_TRUE(write_exr(path, image, {}, error)) << error;
    Imf::InputFile file(path.c_str());
    const Imf::ChannelList& c = file.header().channels();
    for (const char* name : {"R", "A", "direct_diffuse.B", "wear"}) {
        ASSERT_TRUE(c.findChannel(name)) << name;
        EXPECT_EQ(c.findChannel(name)->type, Imf::HALF) << name;
    }
    for (const char* name : {"Z", "P.X", "P.Z"}) {
        ASSERT_TRUE(c.findChannel(name)) << name;
        EXPECT_EQ(c.findChannel(name)->type, Imf::FLOAT) << name;
    }
    EXPECT_EQ(file.header().compression(), Imf::ZIP_COMPRESSION);
    EXPECT_EQ(file.header().displayWindow(), Imath::Box2i(Imath::V2i(0, 0), Imath::V2i(19, 49)));
    EXPECT_EQ(file.header().dataWindow(), Imath::Box2i(Imath::V2i(3, 7), Imath::V2i(7, 46)));
    EXPECT_NEAR(Imf::chromaticities(file.header()).white.x, 0.3127f, 1e-6f);
    EXPECT_EQ(file.header().typedAttribute<Imf::IntAttribute>("alder/complete").value(), 1);
    EXPECT_FLOAT_EQ(file.header().typedAttribute<Imf::FloatAttribute>("alder/estimated_error").value(), 0.0125f);

    const std::optional<Image> back = read_exr(path, error);
    ASSERT_TRUE(back) << error;
    EXPECT_EQ(back->find("")->planes[0][0], 65504) << "too large for a half: the largest, not infinity";
    EXPECT_EQ(back->find("")->planes[0][1], -INFINITY);
    EXPECT_NEAR(back->find("direct_diffuse")->planes[1][4], image.layers[1].planes[1][4], 2e-3f);
    EXPECT_TRUE(back->find("P")->data);
    EXPECT_FALSE(back->find("wear")->data);
}

TEST(Exr, equal_images_give_equal_bytes_in_memory_and_on_disk) {
    std::string error;
    const std::string a = scratch("a.exr"), b = scratch("other_name.exr");
    ASSERT_TRUE(write_exr(a, picture(), {}, error)) << error;
    ASSERT_TRUE(write_exr(b, picture(), {}, error)) << error;
    const std::vector<uint8_t> memory = encode_exr(picture(), {}, error);
    for (const std::string& path : {a, b}) {
        std::ifstream in(path, std::ios::binary);
        const std::vector<uint8_t> bytes{std::istreambuf_iterator<char>(in), {}};
        EXPECT_EQ(bytes, memory) << path;
    }
}

TEST(Exr, nothing_is_left_behind_where_writing_fails) {
    std::string error;
    EXPECT_FALSE(write_exr(scratch("no_such_folder") + "/x.exr", picture(), {}, error));
    EXPECT_NE(error.find("cannot create"), std::string::npos) << error;
    Image twice = picture();
    twice.layers.push_back(twice.layers[1]);
    EXPECT_FALSE(write_exr(scratch("twice.exr"), twice, {}, error));
    EXPECT_NE(error.find("direct_diffuse.R"), std::string::npos) << error;
    Image shorter = picture();
    shorter.layers[2].planes[0].pop_back();
    EXPECT_FALSE(write_exr(scratch("short.exr"), shorter, {}, error));
    for (const auto& f : std::filesystem::directory_iterator(std::filesystem::path(scratch("x")).parent_path())) {
        EXPECT_EQ(f.path().extension(), ".exr") << f.path();
    }
    EXPECT_FALSE(std::filesystem::exists(scratch("twice.exr")));
}

TEST(Exr, every_truncation_and_flipped_header_bytes_are_errors_or_images_never_crashes) {
    std::string error;
    const std::vector<uint8_t> whole = encode_exr(picture(), {}, error);
    for (size_t n = 0; n < whole.size(); n += 1 + n / 64) {
        EXPECT_FALSE(decode_exr(std::span(whole).first(n), error)) << n << " bytes of " << whole.size();
    }
    uint32_t random = 1;
    for (int i = 0; i < 150; ++i) {
        std::vector<uint8_t> bad = whole;
        for (int k = 0; k < 3; ++k) {
            random = random * 1664525u + 1013904223u;
            bad[(random >> 8) % 1600] ^= uint8_t(random >> 3 | 1);
        }
        (void)decode_exr(bad, error, {.side = 4096, .channels = 64, .bytes = 1 << 22});
    }
}

TEST(Exr, limits_are_checked_before_pixels_are_allocated) {
    std::string error;
    const std::vector<uint8_t> bytes = encode_exr(picture(), {}, error);
    EXPECT_FALSE(decode_exr(bytes, error, {.side = 16}));
    EXPECT_NE(error.find("5 x 40"), std::string::npos) << error;
    EXPECT_FALSE(decode_exr(bytes, error, {.channels = 5}));
    EXPECT_FALSE(decode_exr(bytes, error, {.bytes = 1000}));
}

}  // namespace
}  // namespace alder
