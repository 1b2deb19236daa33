// Images in tiles and mip levels: the same bits as whole images, the byte budget under threads, broken files, filtering by footprint.
#include <OpenImageIO/imageio.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include "nodes/texture/color_space.h"
#include "nodes/texture/image_store.h"
#include "nodes/texture/pyramid.h"
#include "tests/nodes/node_call.h"

namespace alder {
namespace {
using test::NodeCall;
namespace fs = std::filesystem;
using OIIO::TypeDesc;

class ImageTilesTest : public ::testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("alder_tiles_test_" + std::to_string(getpid()) + "_" +
                                               ::testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::create_directories(folder_);
    }
    void TearDown() override {
        ImageStore::shared().set_budget(ImageStore::kDefaultBudget);
        fs::remove_all(folder_);
    }
    std::string path(const std::string& name) const { return (folder_ / name).string(); }

    std::string write(const std::string& name, int width, int height, int channels, TypeDesc type, const std::vector<float>& pixels, int tile = 0) {
        OIIO::ImageSpec spec(width, height, channels, type);
        if (channels == 4 || channels == 2) spec.attribute("oiio:UnassociatedAlpha", 1);
        spec.tile_width = spec.tile_height = tile;
        const auto out = OIIO::ImageOutput::create(path(name));
        EXPECT_TRUE(out && out->open(path(name), spec)) << OIIO::geterror();
        EXPECT_TRUE(out->write_image(TypeDesc::FLOAT, pixels.data())) << out->geterror();
        out->close();
        return path(name);
    }
    static std::vector<float> noise(int width, int height, int channels, unsigned seed = 1) {
        std::mt19937 random(seed);
        std::vector<float> p(static_cast<size_t>(width) * height * channels);
        for (float& v : p) v = static_cast<float>(random() % 1024) / 1023.0f;
        return p;
    }
    static std::string parameter(const std::string& file, const std::string& space, const std::string& alpha = "STRAIGHT") {
        return R"({"file": ")" + file + R"(", "colorspace": ")" + space + R"(", "alpha_mode": ")" + alpha + "\"}";
    }
    fs::path folder_;
};

/// All four outputs at many places, some outside the image.
std::vector<std::vector<double>> lookup(const std::string& image, const char* interpolation, const char* extension) {
    std::vector<double> u, v;
    std::mt19937 random(7);
    for (int i = 0; i < 300; ++i) {
        u.push_back(static_cast<float>(random()) * 0x1p-32f * 3 - 1);
        v.push_back(static_cast<float>(random()) * 0x1p-32f * 3 - 1);
    }
    return NodeCall("ShaderNodeTexImage", u.size()).set("image", image.c_str()).set("interpolation", interpolation).set("extension", extension)
        .vary("Vector", u, 0).vary("Vector", v, 1).run();
}
bool same_bits(const std::vector<std::vector<double>>& a, const std::vector<std::vector<double>>& b) {
    if (a.size() != b.size()) return false;
    for (size_t i = 0; i < a.size(); ++i)
        if (a[i].size() != b[i].size() || std::memcmp(a[i].data(), b[i].data(), a[i].size() * sizeof(double)) != 0) return false;
    return true;
}

TEST_F(ImageTilesTest, tiles_give_the_bits_of_the_whole_image) {
    constexpr int w = 203, h = 149;  // no multiples of anything
    struct Case {
        const char* name;
        int channels, tile;
        TypeDesc type;
    };
    const Case cases[] = {{"rgb.png", 3, 0, TypeDesc::UINT8}, {"rgba.png", 4, 0, TypeDesc::UINT8}, {"deep.png", 4, 0, TypeDesc::UINT16}, {"grey.png", 1, 0, TypeDesc::UINT8},
                          {"greya.png", 2, 0, TypeDesc::UINT8}, {"half.exr", 3, 0, TypeDesc::HALF}, {"float.exr", 4, 0, TypeDesc::FLOAT}, {"photo.jpg", 3, 0, TypeDesc::UINT8},
                          {"tiled.exr", 3, 32, TypeDesc::HALF}, {"tiled.tif", 3, 64, TypeDesc::UINT8}, {"tiled16.tif", 4, 48, TypeDesc::UINT16}, {"float.tif", 1, 0, TypeDesc::FLOAT}};
    for (const Case& c : cases) {
        const std::string file = write(c.name, w, h, c.channels, c.type, noise(w, h, c.channels), c.tile);
        for (const char* space : {"sRGB", "Non-Color", "ACEScg"}) {
            for (const char* alpha : {"STRAIGHT", "CHANNEL_PACKED", "NONE"}) {
                if (c.channels % 2 == 1 && alpha[0] != 'S') continue;
                const std::string image = parameter(file, space, alpha);
                for (const auto& [interpolation, extension] : {std::pair{"Linear", "REPEAT"}, {"Closest", "MIRROR"}, {"Cubic", "CLIP"}, {"Smart", "EXTEND"}}) {
                    ImageStore::shared().set_budget(ImageStore::kDefaultBudget);
                    const auto whole = lookup(image, interpolation, extension);
                    ImageStore::shared().set_budget(1 << 15);
                    const uint64_t read = ImageStore::shared().usage().tiles_read;
                    const auto tiled = lookup(image, interpolation, extension);
                    EXPECT_GT(ImageStore::shared().usage().tiles_read, read) << file << ": was not read in tiles";
                    EXPECT_TRUE(same_bits(whole, tiled)) << file << " " << space << " " << alpha << " " << interpolation << " " << extension;
                }
            }
        }
    }
}

TEST_F(ImageTilesTest, the_budget_holds_under_eight_threads) {
    constexpr int side = 2048;
    std::vector<float> pixels(static_cast<size_t>(side) * side * 4);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            float* const p = pixels.data() + (static_cast<size_t>(y) * side + x) * 4;
            p[0] = static_cast<float>(x & 255) / 255, p[1] = static_cast<float>((side - 1 - y) & 255) / 255, p[2] = static_cast<float>((x >> 8) * 8 + ((side - 1 - y) >> 8)) / 255, p[3] = 1;
        }
    const std::string file = write("big.tif", side, side, 4, TypeDesc::UINT8, pixels, 64);
    constexpr size_t budget = size_t{8} << 20;
    ImageStore store(budget);
    const auto image = store.open({file, "Non-Color", AlphaMode::ChannelPacked});
    ASSERT_TRUE(image->readable()) << image->fault;
    ASSERT_TRUE(image->is_tiled());
    EXPECT_EQ(store.bytes(), 0u);
    std::atomic<size_t> most{0};
    std::atomic<int> wrong{0};
    std::vector<std::thread> threads;
    for (int t = 0; t < 8; ++t)
        threads.emplace_back([&, t] {
            std::mt19937 random(static_cast<unsigned>(t));
            for (int round = 0; round < 3000; ++round) {
                int32_t x[16], y[16];
                for (int i = 0; i < 16; ++i) x[i] = static_cast<int32_t>(random() % side), y[i] = static_cast<int32_t>(random() % side);
                std::byte out[256];
                TileCache::read_texels(*image, nullptr, x, y, 16, out);
                for (int i = 0; i < 16; ++i) {
                    const int expected[3] = {x[i] & 255, y[i] & 255, (x[i] >> 8) * 8 + (y[i] >> 8)};
                    for (int c = 0; c < 3; ++c) wrong += static_cast<int>(out[16 * i + c]) != expected[c];
                }
                const size_t now = store.usage().tile_bytes;
                for (size_t m = most; now > m && !most.compare_exchange_weak(m, now);) {}
            }
        });
    for (auto& t : threads) t.join();
    EXPECT_EQ(wrong, 0);
    // 16 tiles a thread may be in use beyond the limit; they are within the budget here.
    EXPECT_LE(most, budget) << "most bytes of tiles at a time";
    EXPECT_GT(most, budget / 2) << "the budget is used";
    const auto u = store.usage();
    EXPECT_GT(u.tiles_dropped, 0u);
    EXPECT_GE(u.tile_requests, u.tile_misses);
    EXPECT_EQ(u.tile_misses, u.tiles_read);
}

TEST_F(ImageTilesTest, whole_images_take_their_share_and_give_it_back) {
    const std::string a = write("a.exr", 256, 256, 3, TypeDesc::FLOAT, noise(256, 256, 3)), b = write("b.exr", 256, 256, 3, TypeDesc::FLOAT, noise(256, 256, 3, 2));
    ImageStore store(size_t{2} << 20);  // one of them fits five eighths
    auto first = store.open({a, "Non-Color", AlphaMode::Straight});
    auto second = store.open({b, "Non-Color", AlphaMode::Straight});
    EXPECT_FALSE(first->is_tiled());
    EXPECT_TRUE(second->is_tiled());
    EXPECT_EQ(store.usage().whole_images, 1u);
    EXPECT_EQ(store.usage().tiled_images, 1u);
    first.reset();
    second.reset();
    EXPECT_EQ(store.usage().tiled_images, 0u);
    EXPECT_FALSE(store.open({b, "Non-Color", AlphaMode::Straight})->is_tiled());
    EXPECT_EQ(store.bytes(), 0u);
}

TEST_F(ImageTilesTest, a_changed_tiled_file_is_not_mixed_with_its_former_contents) {
    const std::string file = write("a.tif", 256, 256, 3, TypeDesc::UINT8, std::vector<float>(256 * 256 * 3, 1.0f), 64);
    ImageStore store(1 << 16);
    const auto before = store.open({file, "Non-Color", AlphaMode::Straight});
    write("a.tif", 192, 256, 3, TypeDesc::UINT8, std::vector<float>(192 * 256 * 3, 0.0f), 64);
    const auto after = store.open({file, "Non-Color", AlphaMode::Straight});
    ASSERT_TRUE(after->is_tiled() && before->is_tiled());
    const int32_t x = 10, y = 10;
    std::byte out[16];
    TileCache::read_texels(*after, nullptr, &x, &y, 1, out);
    EXPECT_EQ(static_cast<int>(out[0]), 0);
    TileCache::read_texels(*before, nullptr, &x, &y, 1, out);
    EXPECT_EQ(static_cast<int>(out[1]), 0) << "magenta: what it was is gone";
    EXPECT_EQ(static_cast<int>(out[0]), 255);
    ASSERT_EQ(store.faults().size(), 1u);
    EXPECT_NE(store.faults()[0].find("changed"), std::string::npos) << store.faults()[0];
}

TEST_F(ImageTilesTest, mip_levels_keep_the_mean_light) {
    for (const auto& [w, h] : {std::pair{64, 64}, {37, 101}, {1, 19}, {5, 1}}) {
        for (const char* space : {"Non-Color", "sRGB"}) {
            const std::string file = write("m.exr", w, h, 3, TypeDesc::FLOAT, noise(w, h, 3));
            ImageStore store;
            const auto image = store.open({file, space, AlphaMode::Straight});
            ASSERT_TRUE(image->readable());
            const int levels = level_count(w, h);
            EXPECT_EQ(level_size(w, levels - 1), 1);
            EXPECT_EQ(level_size(h, levels - 1), 1);
            const auto linear = [&](float c) { return !image->is_srgb ? c : c < 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f); };
            double first = 0;
            for (int l = 0; l < levels; ++l) {
                double sum = 0;
                for (int y = 0; y < level_size(h, l); ++y)
                    for (int x = 0; x < level_size(w, l); ++x) {
                        float v;
                        std::memcpy(&v, image->texel(l, x, y), 4);
                        sum += linear(v);
                    }
                sum /= static_cast<double>(level_size(w, l)) * level_size(h, l);
                if (l == 0) first = sum;
                EXPECT_NEAR(sum, first, 2e-6) << w << " x " << h << " " << space << " level " << l;
            }
        }
    }
}
TEST_F(ImageTilesTest, mip_levels_in_tiles_have_the_bits_of_the_pyramid) {
    constexpr int w = 301, h = 187;
    for (const auto& type : {TypeDesc(TypeDesc::UINT8), TypeDesc(TypeDesc::HALF)}) {
        const bool bytes = type == TypeDesc::UINT8;
        const std::string file = write(bytes ? "a.png" : "a.exr", w, h, 4, type, noise(w, h, 4));
        ImageStore roomy, tight(1 << 16);
        const auto whole = roomy.open({file, "sRGB", AlphaMode::Straight}), tiled = tight.open({file, "sRGB", AlphaMode::Straight});
        ASSERT_TRUE(!whole->is_tiled() && tiled->is_tiled());
        for (int l = 0; l < level_count(w, h); ++l)
            for (int y = 0; y < level_size(h, l); ++y)
                for (int x = 0; x < level_size(w, l); ++x) {
                    std::byte out[16];
                    TileCache::read_texels(*tiled, &l, &x, &y, 1, out);
                    ASSERT_EQ(std::memcmp(out, whole->texel(l, x, y), whole->texel_bytes()), 0) << "level " << l << " at " << x << ", " << y;
                }
    }
}
TEST_F(ImageTilesTest, transparent_texels_do_not_darken_coarser_levels) {
    const std::string file = write("a.tif", 2, 1, 4, TypeDesc::UINT8, {1, 0.5f, 0.25f, 1, 0, 0, 0, 0});
    ImageStore store;
    const auto image = store.open({file, "sRGB", AlphaMode::Straight});
    uint8_t texel[4];
    std::memcpy(texel, image->texel(1, 0, 0), 4);
    EXPECT_NEAR(texel[3], 128, 1);
    EXPECT_NEAR(texel[0] * 255.0 / texel[3], 255, 3) << "the colour taken out of its alpha stays";
    EXPECT_NEAR(texel[1] * 255.0 / texel[3], 128, 3);
}

/// A call as the builder makes it where textures are filtered: Vector at the next pixels stands in the places of globals.
std::vector<double> filtered(const std::string& image, double u, double v, double step_u, double step_v, const char* interpolation = "Linear") {
    const auto r = NodeCall("ShaderNodeTexImage").set("image", image.c_str()).set("interpolation", interpolation).set("Vector", {u, v, 0})
                       .global(Global::Dpdx, {u + step_u, v, 0}).global(Global::Dpdy, {u, v + step_v, 0}).global(Global::PixelFootprint, {1}).run();
    return {r[0][0], r[1][0], r[2][0], r[3][0]};
}
TEST_F(ImageTilesTest, filtering_goes_from_the_image_to_its_mean) {
    constexpr int side = 128;
    const std::vector<float> pixels = noise(side, side, 3);
    double mean = 0;
    for (size_t i = 0; i < pixels.size(); i += 3) mean += pixels[i];
    mean /= side * side;
    const std::string file = write("a.exr", side, side, 3, TypeDesc::FLOAT, pixels);
    for (const size_t budget : {ImageStore::kDefaultBudget, size_t{1} << 16}) {
        ImageStore::shared().set_budget(budget);
        const std::string image = parameter(file, "Non-Color");
        const auto plain = NodeCall("ShaderNodeTexImage").set("image", image.c_str()).set("Vector", {0.37, 0.61, 0}).run();
        EXPECT_EQ(filtered(image, 0.37, 0.61, 0.9 / side, 0.9 / side)[0], plain[0][0]) << "less than a texel: as without";
        EXPECT_EQ(filtered(image, 0.37, 0.61, std::nan(""), 1)[0], plain[0][0]) << "a footprint that is not known is none";
        EXPECT_NEAR(filtered(image, 0.37, 0.61, 1, 1)[0], mean, 1e-5);
        EXPECT_NEAR(filtered(image, 0.37, 0.61, 1e30, 1e30)[0], mean, 1e-5);
        EXPECT_EQ(filtered(image, 0.37, 0.61, 1, 1, "Closest")[0],
                  NodeCall("ShaderNodeTexImage").set("image", image.c_str()).set("interpolation", "Closest").set("Vector", {0.37, 0.61, 0}).run()[0][0]);
        // The spread over the image falls by half a level, as that of independent texels does; bilinear weights take some more.
        double last = 1e9;
        for (const double texels : {1.0, 2.0, 4.0, 8.0, 16.0}) {
            double variance = 0;
            for (int i = 1; i <= 256; ++i) {  // the R2 sequence
                const double d = filtered(image, std::fmod(i * 0.754877666, 1), std::fmod(i * 0.569840291, 1), texels / side, texels / side)[0] - mean;
                variance += d * d / 256;
            }
            EXPECT_LT(variance, 0.5 * last) << texels << " texels a pixel";
            last = variance;
        }
    }
}
TEST_F(ImageTilesTest, filtering_is_by_the_shorter_step) {
    constexpr int side = 64;
    std::vector<float> pixels;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) pixels.insert(pixels.end(), 3, static_cast<float>(x % 2));
    const std::string image = parameter(write("a.exr", side, side, 3, TypeDesc::FLOAT, pixels), "Non-Color");
    EXPECT_NEAR(filtered(image, 1.5 / side, 0.5, 1.0 / side, 8.0 / side)[0], 1, 1e-5) << "one texel across: the stripes stay";
    EXPECT_NEAR(filtered(image, 1.5 / side, 0.5, 4.0 / side, 4.0 / side)[0], 0.5, 1e-5);
    EXPECT_NEAR(filtered(image, 1.5 / side, 0.5, 1.0 / side, 1000.0)[0], 0.5, 1e-5) << "but not at any stretch";
}

TEST_F(ImageTilesTest, broken_files_are_magenta_and_say_why_whole_or_tiled) {
    const std::string good = write("good.png", 200, 200, 3, TypeDesc::UINT8, noise(200, 200, 3));
    std::string bytes;
    {
        std::ifstream in(good, std::ios::binary);
        bytes.assign(std::istreambuf_iterator<char>(in), {});
    }
    const auto put = [&](const char* name, const std::string& content) { std::ofstream(path(name), std::ios::binary) << content; };
    put("truncated.png", bytes.substr(0, bytes.size() / 2));
    put("empty.png", "");
    put("short.png", bytes.substr(0, 20));
    put("rubbish.exr", std::string(5000, 'x'));
    std::string huge = bytes;  // the header's width and height, with its checksum wrong too
    huge.replace(16, 8, std::string("\0\0\x75\x30\0\0\x75\x30", 8));
    put("huge.png", huge);
    put("endless.ppm", "P6\n30000 30000\n255\nabc");
    // A folder of temporary files of its own: other programs of ours write theirs at the same time.
    const std::string temporary = path("temporary");
    ASSERT_TRUE(fs::create_directories(temporary));
    const char* before = getenv("TMPDIR");
    const std::string restore = before ? before : "";
    setenv("TMPDIR", temporary.c_str(), 1);
    for (const size_t budget : {ImageStore::kDefaultBudget, size_t{1} << 16}) {
        ImageStore store(budget);
        for (const char* name : {"truncated.png", "empty.png", "short.png", "rubbish.exr", "huge.png", "absent.png", "endless.ppm"}) {
            const auto image = store.open({path(name), "", AlphaMode::Straight});
            EXPECT_FALSE(image->readable()) << name << " with " << budget;
            EXPECT_FALSE(image->fault.empty()) << name;
        }
        EXPECT_EQ(store.faults().size(), 7u);
        EXPECT_EQ(store.bytes(), 0u) << "nothing is kept of them";
    }
    ASSERT_EQ(fs::temp_directory_path().string(), temporary);
    for (const auto& entry : fs::directory_iterator(temporary)) ADD_FAILURE() << "left behind: " << entry.path();
    restore.empty() ? unsetenv("TMPDIR") : setenv("TMPDIR", restore.c_str(), 1);
}
TEST_F(ImageTilesTest, a_png_bomb_is_refused_by_its_header) {
    // A right header with its checksum and no data: 30000 x 30000 pixels in 57 bytes.
    const unsigned char bomb[] = {0x89, 'P', 'N', 'G', 13, 10, 26, 10, 0, 0, 0, 13, 'I', 'H', 'D', 'R', 0, 0, 0x75, 0x30, 0, 0, 0x75, 0x30, 8, 2, 0, 0, 0};
    uint32_t crc = ~0u;
    for (size_t i = 12; i < sizeof bomb; ++i) {
        crc ^= bomb[i];
        for (int k = 0; k < 8; ++k) crc = crc & 1 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
    }
    crc = ~crc;
    std::string file(reinterpret_cast<const char*>(bomb), sizeof bomb);
    for (int k = 3; k >= 0; --k) file += static_cast<char>(crc >> 8 * k & 255);
    file += std::string("\0\0\0\0IDAT\x35\xaf\x06\x1e\0\0\0\0IEND\xae\x42\x60\x82", 24);
    std::ofstream(path("bomb.png"), std::ios::binary) << file;
    ImageStore store;
    const auto image = store.open({path("bomb.png"), "", AlphaMode::Straight});
    EXPECT_FALSE(image->readable());
    EXPECT_NE(image->fault.find("30000 x 30000"), std::string::npos) << image->fault;
}

TEST(ColorSpaces, curves_and_matrices_of_blenders_configuration) {
    struct Row {
        const char* name;
        float out[3];  ///< of 0.25, 0.5, 0.75
    };
    // From Blender 4.5's configuration by OpenColorIO 2.1; its matrices have a white of four digits.
    const Row rows[] = {{"sRGB", {0.050876077f, 0.214041144f, 0.522521496f}},
        {"Linear Rec.2020", {0.066654354f, 0.529073358f, 0.784282863f}},
        {"Linear DCI-P3 D65", {0.193729475f, 0.510536790f, 0.779539526f}},
        {"Linear FilmLight E-Gamut", {-0.030377537f, 0.487097144f, 0.872815847f}},
        {"Display P3", {0.014170147f, 0.220913067f, 0.556087434f}},
        {"ACEScg", {0.052913852f, 0.529940069f, 0.794434786f}},
        {"ACES2065-1", {-0.227273047f, 0.545073628f, 0.796124160f}},
        {"Linear CIE-XYZ D65", {-0.332352608f, 0.726856947f, 0.704816997f}},
        {"Linear CIE-XYZ E", {-0.406592429f, 0.758827806f, 0.771850467f}},
        {"Rec.1886", {0.035896819f, 0.189464554f, 0.501356900f}},
        {"Rec.2020", {-0.088236853f, 0.205996469f, 0.541221380f}},
        {"Filmic Log", {0.003067053f, 0.053514317f, 0.933724403f}},
        {"AgX Log", {-7.764944553f, -12.561262131f, 109.844612122f}}};
    for (const Row& r : rows) {
        const auto space = find_color_space(r.name);
        ASSERT_TRUE(space) << r.name;
        float c[3] = {0.25f, 0.5f, 0.75f};
        space->to_linear_rec709(c);
        const float largest = std::max({1.0f, std::abs(r.out[0]), std::abs(r.out[1]), std::abs(r.out[2])});
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(c[i], r.out[i], 3e-4 * largest) << r.name << " channel " << i;
    }
    EXPECT_FALSE(find_color_space("Filmic sRGB")) << "made of tables: a configuration's";
}
TEST_F(ImageTilesTest, a_configuration_gives_further_spaces) {
    std::ofstream(path("config.ocio")) << R"(ocio_profile_version: 2
roles: {default: lin_rec709, scene_linear: lin_rec709}
file_rules:
  - !<Rule> {name: Default, colorspace: default}
displays:
  sRGB:
    - !<View> {name: Raw, colorspace: lin_rec709}
colorspaces:
  - !<ColorSpace>
    name: lin_rec709
  - !<ColorSpace>
    name: squared
    aliases: [twice]
    to_scene_reference: !<ExponentTransform> {value: 2}
  - !<ColorSpace>
    name: numbers
    isdata: true
)";
    set_color_configuration(path("config.ocio"));
    const std::string file = write("a.exr", 1, 1, 3, TypeDesc::FLOAT, {0.5f, 0.25f, 2});
    for (const char* name : {"squared", "twice"}) {
        std::vector<std::string> errors;
        const ImageRequest request = parse_image_request(parameter(file, name), errors);
        ASSERT_TRUE(errors.empty()) << errors[0];
        ImageStore store;
        const auto image = store.open(request);
        ASSERT_TRUE(image->readable()) << image->fault;
        float texel[3];
        std::memcpy(texel, image->texel(0, 0, 0), 12);
        EXPECT_NEAR(texel[0], 0.25f, 1e-6);
        EXPECT_NEAR(texel[1], 0.0625f, 1e-6);
        EXPECT_NEAR(texel[2], 4, 1e-5);
    }
    std::vector<std::string> errors;
    parse_image_request(parameter(file, "numbers"), errors);
    EXPECT_TRUE(errors.empty());
    parse_image_request(parameter(file, "squred"), errors);
    ASSERT_EQ(errors.size(), 1u);
    EXPECT_NE(errors[0].find("\nsquared"), std::string::npos) << "the nearest name: " << errors[0];
    EXPECT_NE(errors[0].find("squared;"), std::string::npos);
}

}  // namespace
}  // namespace alder
