// Image store and Image Texture: sharing, release, refusals, number formats, colour spaces, alpha, interpolation, extension.
#include <OpenImageIO/imageio.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <thread>

#include "nodes/texture/color_space.h"
#include "nodes/texture/image_store.h"
#include "tests/nodes/node_call.h"

namespace alder {
namespace {
using test::NodeCall;
namespace fs = std::filesystem;

/// A folder that is gone after the test.
class ImageTest : public ::testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("alder_image_test_" + std::to_string(getpid()) + "_" +
                                               ::testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }
    std::string path(const std::string& name) const { return (folder_ / name).string(); }

    /// Writes an image, top row first.
    std::string write(const std::string& name, int width, int height, int channels, OIIO::TypeDesc type, const std::vector<float>& pixels) {
        OIIO::ImageSpec spec(width, height, channels, type);
        if (channels == 4 || channels == 2) spec.attribute("oiio:UnassociatedAlpha", 1);
        const auto out = OIIO::ImageOutput::create(path(name));
        EXPECT_TRUE(out && out->open(path(name), spec)) << OIIO::geterror();
        EXPECT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, pixels.data())) << out->geterror();
        out->close();
        return path(name);
    }
    static std::string parameter(const std::string& file, const std::string& space = "Non-Color", const std::string& alpha = "STRAIGHT") {
        return R"({"file": ")" + file + R"(", "colorspace": ")" + space + R"(", "alpha_mode": ")" + alpha + "\"}";
    }
    static std::vector<double> at(NodeCall call, double u, double v) {
        const auto r = call.set("Vector", {u, v, 0}).run();
        return {r[0][0], r[1][0], r[2][0], r[3][0]};
    }
    fs::path folder_;
};

/// Two by two: red, green above blue, white.
const std::vector<float> kFour = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};

TEST_F(ImageTest, is_loaded_once_and_released_with_its_last_user) {
    const std::string file = write("a.png", 2, 2, 3, OIIO::TypeDesc::UINT8, kFour);
    ImageStore store;
    std::vector<std::shared_ptr<const StoredImage>> images(8);
    std::vector<std::thread> threads;
    for (auto& image : images) threads.emplace_back([&] { image = store.open({file, "Non-Color", AlphaMode::Straight}); });
    for (auto& t : threads) t.join();
    for (const auto& image : images) EXPECT_EQ(image, images[0]);
    EXPECT_EQ(store.bytes(), 2u * 2 * 4);
    auto other = store.open({file, "sRGB", AlphaMode::Straight});
    EXPECT_NE(other, images[0]);
    EXPECT_EQ(store.bytes(), 2u * 16);
    other.reset();
    images.clear();
    EXPECT_EQ(store.bytes(), 0u);
    EXPECT_TRUE(store.faults().empty());
}
TEST_F(ImageTest, a_changed_file_is_another_image) {
    ImageStore store;
    const std::string file = write("a.png", 2, 2, 3, OIIO::TypeDesc::UINT8, kFour);
    const auto before = store.open({file, "Non-Color", AlphaMode::Straight});
    write("a.png", 3, 1, 3, OIIO::TypeDesc::UINT8, {0, 0, 0, 0, 0, 0, 0, 0, 0});
    EXPECT_EQ(store.open({file, "Non-Color", AlphaMode::Straight})->width, 3);
    EXPECT_EQ(before->width, 2);
}
TEST_F(ImageTest, what_cannot_be_read_is_reported_once_and_magenta) {
    ImageStore store;
    std::ofstream(path("broken.png")) << "not an image";
    for (int i = 0; i < 3; ++i) {
        EXPECT_FALSE(store.open({path("broken.png"), "", AlphaMode::Straight})->readable());
        EXPECT_FALSE(store.open({path("absent.exr"), "", AlphaMode::Straight})->readable());
    }
    ASSERT_EQ(store.faults().size(), 2u);
    EXPECT_NE(store.faults()[0].find("broken.png"), std::string::npos) << store.faults()[0];
    const auto r = at(NodeCall("ShaderNodeTexImage").set("image", parameter(path("broken.png")).c_str()), 0.3, 0.3);
    EXPECT_EQ(r, (std::vector<double>{1, 0, 1, 1}));
    EXPECT_EQ(at(NodeCall("ShaderNodeTexImage"), 0.3, 0.3), (std::vector<double>{1, 0, 1, 1})) << "no image chosen";
}
TEST_F(ImageTest, too_large_images_are_refused_by_their_header) {
    ImageStore store;
    std::ofstream(path("wide.ppm")) << "P6\n40000 40000\n255\n";
    std::ofstream(path("huge.ppm")) << "P6\n32769 1\n255\n";
    for (const char* name : {"wide.ppm", "huge.ppm"}) EXPECT_FALSE(store.open({path(name), "", AlphaMode::Straight})->readable());
    ASSERT_EQ(store.faults().size(), 2u);
    EXPECT_NE(store.faults()[0].find("32768"), std::string::npos) << store.faults()[0];
    EXPECT_EQ(store.bytes(), 0u);
}
TEST_F(ImageTest, truncated_files_do_no_harm) {
    const std::string file = write("a.png", 64, 64, 3, OIIO::TypeDesc::UINT8, std::vector<float>(64 * 64 * 3, 0.5f));
    fs::resize_file(file, fs::file_size(file) / 2);
    ImageStore store;
    store.open({file, "", AlphaMode::Straight});
}

TEST_F(ImageTest, v_grows_upwards_and_texels_lie_where_they_should) {
    const std::string image = parameter(write("a.png", 2, 2, 3, OIIO::TypeDesc::UINT8, kFour));
    NodeCall call("ShaderNodeTexImage");
    call.set("image", image.c_str()).set("interpolation", "Closest");
    EXPECT_EQ(at(call, 0.25, 0.75), (std::vector<double>{1, 0, 0, 1}));
    EXPECT_EQ(at(call, 0.75, 0.75), (std::vector<double>{0, 1, 0, 1}));
    EXPECT_EQ(at(call, 0.25, 0.25), (std::vector<double>{0, 0, 1, 1}));
    EXPECT_EQ(at(call, 0.75, 0.25), (std::vector<double>{1, 1, 1, 1}));
    call.set("interpolation", "Linear");
    EXPECT_EQ(at(call, 0.25, 0.75), (std::vector<double>{1, 0, 0, 1}));
    EXPECT_EQ(at(call, 0.5, 0.5), (std::vector<double>{0.5, 0.5, 0.5, 1}));
}
TEST_F(ImageTest, outside_the_image) {
    const std::string image = parameter(write("a.png", 2, 2, 3, OIIO::TypeDesc::UINT8, kFour));
    const auto red = [&](const char* extension, double u, double v) {
        return at(NodeCall("ShaderNodeTexImage").set("image", image.c_str()).set("interpolation", "Closest").set("extension", extension), u, v);
    };
    EXPECT_EQ(red("REPEAT", 1.25, -0.25), (std::vector<double>{1, 0, 0, 1}));
    EXPECT_EQ(red("EXTEND", -5, 9), (std::vector<double>{1, 0, 0, 1}));
    EXPECT_EQ(red("MIRROR", 1.75, 1.25), (std::vector<double>{1, 0, 0, 1}));
    EXPECT_EQ(red("MIRROR", -0.25, 0.75), (std::vector<double>{1, 0, 0, 1}));
    EXPECT_EQ(red("CLIP", 1.25, 0.75), (std::vector<double>{0, 0, 0, 0}));
    EXPECT_EQ(red("CLIP", 0.25, 0.75), (std::vector<double>{1, 0, 0, 1}));
    for (const char* extension : {"REPEAT", "EXTEND", "CLIP", "MIRROR"}) {
        for (const char* interpolation : {"Closest", "Linear", "Cubic"}) {
            for (double x : {1e9, -1e9, 3e38, -3e38, HUGE_VAL, -HUGE_VAL, std::nan("")}) {
                at(NodeCall("ShaderNodeTexImage").set("image", image.c_str()).set("extension", extension).set("interpolation", interpolation), x, 0.5);
                at(NodeCall("ShaderNodeTexImage").set("image", image.c_str()).set("extension", extension).set("interpolation", interpolation), 0.5, x);
            }
        }
    }
}
TEST_F(ImageTest, a_constant_image_is_constant_under_every_filter) {
    std::vector<float> grey(5 * 3 * 3, 0.25f);
    for (const char* name : {"a.exr", "half.exr", "a.tif"}) {
        const auto type = std::string(name) == "half.exr" ? OIIO::TypeDesc::HALF : std::string(name) == "a.exr" ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT16;
        const std::string image = parameter(write(name, 5, 3, 3, type, grey));
        for (const char* interpolation : {"Closest", "Linear", "Cubic", "Smart"}) {
            for (double u : {-1.3, 0.0, 0.21, 0.5, 0.99, 4.4}) {
                const auto r = at(NodeCall("ShaderNodeTexImage").set("image", image.c_str()).set("interpolation", interpolation), u, 0.77 - u);
                for (int c = 0; c < 3; ++c) EXPECT_NEAR(r[c], 0.25, 1e-5) << name << " " << interpolation << " " << u;
                EXPECT_NEAR(r[3], 1, 1e-6);
            }
        }
    }
}
TEST_F(ImageTest, one_and_two_channels) {
    const auto grey = at(NodeCall("ShaderNodeTexImage").set("image", parameter(write("g.exr", 1, 1, 1, OIIO::TypeDesc::FLOAT, {0.3f})).c_str()), 0.5, 0.5);
    for (int c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(static_cast<float>(grey[c]), 0.3f);
    EXPECT_EQ(grey[3], 1);
    const auto both = at(NodeCall("ShaderNodeTexImage").set("image", parameter(write("ga.png", 1, 1, 2, OIIO::TypeDesc::UINT8, {0.2f, 0.6f})).c_str()), 0.5, 0.5);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(both[c], 0.2, 1e-6);
    EXPECT_NEAR(both[3], 0.6, 1e-6);
}
TEST_F(ImageTest, alpha_modes) {
    const std::string file = write("a.png", 1, 1, 4, OIIO::TypeDesc::UINT8, {0.8f, 0.4f, 0.2f, 0.6f});
    const auto image = [&](const char* space, const char* alpha) {
        return NodeCall("ShaderNodeTexImage").set("image", parameter(file, space, alpha).c_str());
    };
    EXPECT_NEAR(at(image("Linear Rec.709", "STRAIGHT"), 0.5, 0.5)[0], 0.8, 0.01);
    EXPECT_NEAR(at(image("Linear Rec.709", "STRAIGHT"), 0.5, 0.5)[3], 0.6, 1e-6);
    EXPECT_NEAR(at(image("Linear Rec.709", "STRAIGHT").without("Alpha"), 0.5, 0.5)[0], 0.8 * 0.6, 0.01) << "multiplied by alpha where it is not used";
    EXPECT_NEAR(at(image("Linear Rec.709", "CHANNEL_PACKED"), 0.5, 0.5)[0], 0.8, 1e-6);
    EXPECT_NEAR(at(image("Linear Rec.709", "NONE"), 0.5, 0.5)[3], 1, 1e-6);
    EXPECT_NEAR(at(image("Non-Color", "STRAIGHT").without("Alpha"), 0.5, 0.5)[0], 0.8, 1e-6) << "data is left alone";
}
TEST_F(ImageTest, srgb_is_made_linear) {
    for (int value : {0, 1, 10, 11, 64, 128, 200, 254, 255}) {
        const float v = static_cast<float>(value) / 255;
        const std::string image = parameter(write("a.png", 1, 1, 3, OIIO::TypeDesc::UINT8, {v, v, v}), "sRGB");
        const double expected = v < 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
        for (const char* interpolation : {"Linear", "Closest"})
            EXPECT_NEAR(at(NodeCall("ShaderNodeTexImage").set("image", image.c_str()).set("interpolation", interpolation), 0.5, 0.5)[0], expected,
                        2e-6 * expected) << value;
    }
    // Without a name: integers sRGB, floats linear.
    ImageStore store;
    EXPECT_TRUE(store.open({write("b.png", 1, 1, 3, OIIO::TypeDesc::UINT8, {1, 1, 1}), "", AlphaMode::Straight})->is_srgb);
    EXPECT_FALSE(store.open({write("b.exr", 1, 1, 3, OIIO::TypeDesc::FLOAT, {1, 1, 1}), "", AlphaMode::Straight})->is_srgb);
}
TEST_F(ImageTest, colour_spaces_keep_white_and_convert_primaries) {
    for (const std::string& name : color_space_names()) {
        if (name.starts_with("Linear CIE-XYZ") || name.ends_with("Log")) continue;
        float white[3] = {1, 1, 1};
        find_color_space(name)->to_linear_rec709(white);
        for (float c : white) EXPECT_NEAR(c, 1, 1e-4) << name;
    }
    float d65[3] = {0.950456f, 1, 1.089058f};
    find_color_space("Linear CIE-XYZ D65")->to_linear_rec709(d65);
    for (float c : d65) EXPECT_NEAR(c, 1, 1e-4);
    float ap1[3] = {1, 0, 0};  // published AP1 to Rec.709 matrix, first column (ACES TB-2014-004 with Bradford)
    find_color_space("ACEScg")->to_linear_rec709(ap1);
    EXPECT_NEAR(ap1[0], 1.70505, 2e-4);
    EXPECT_NEAR(ap1[1], -0.13026, 2e-4);
    EXPECT_NEAR(ap1[2], -0.02400, 2e-4);
    EXPECT_FALSE(find_color_space("Filmic sRGB").has_value());
}
TEST(ImageParameter, faults_are_named) {
    std::vector<std::string> errors;
    parse_image_request(R"({"file": "a.png", "colorspace": "sRBG", "alpha_mode": "HALF"})", errors);
    ASSERT_EQ(errors.size(), 2u);
    EXPECT_NE(errors[0].find("sRBG"), std::string::npos);
    EXPECT_NE(errors[1].find("HALF"), std::string::npos);
    errors.clear();
    EXPECT_EQ(parse_image_request("null", errors).path, "");
    EXPECT_TRUE(errors.empty());
}
TEST_F(ImageTest, projections) {
    // A column that tells latitude, a row that tells longitude.
    std::vector<float> pixels;
    for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) pixels.insert(pixels.end(), {(static_cast<float>(x) + 0.5f) / 64, 1 - (static_cast<float>(y) + 0.5f) / 64, 0});
    }
    const std::string image = parameter(write("uv.exr", 64, 64, 3, OIIO::TypeDesc::FLOAT, pixels));
    NodeCall sphere("ShaderNodeTexImage");
    sphere.set("image", image.c_str()).set("projection", "SPHERE");
    const auto s = sphere.set("Vector", {1.0, 0.5, 0.5}).run();  // towards +x from the middle
    EXPECT_NEAR(s[0][0], 0.25, 1e-5);
    EXPECT_NEAR(s[1][0], 0.5, 1e-5);
    NodeCall tube("ShaderNodeTexImage");
    const auto t = tube.set("image", image.c_str()).set("projection", "TUBE").set("Vector", {1.0, 0.5, 0.7}).run();
    EXPECT_NEAR(t[0][0], 0.25, 1e-5);
    EXPECT_NEAR(t[1][0], 0.7, 1e-5);
    const auto box = [&](std::initializer_list<double> normal, double blend) {
        NodeCall call("ShaderNodeTexImage");
        call.set("image", image.c_str()).set("projection", "BOX").set("projection_blend", blend).set("Vector", {0.2, 0.3, 0.6}).global(Global::N, normal);
        call.global(Global::ObjectToWorldX, {1, 0, 0}).global(Global::ObjectToWorldY, {0, 1, 0}).global(Global::ObjectToWorldZ, {0, 0, 1});
        const auto r = call.run();
        return std::pair(r[0][0], r[1][0]);
    };
    EXPECT_NEAR(box({1, 0, 0}, 0).first, 0.3, 1e-5);
    EXPECT_NEAR(box({1, 0, 0}, 0).second, 0.6, 1e-5);
    EXPECT_NEAR(box({-1, 0, 0}, 0).first, 0.7, 1e-5);
    EXPECT_NEAR(box({0, -1, 0}, 0).first, 0.2, 1e-5);
    EXPECT_NEAR(box({0, 0, 1}, 0).second, 0.2, 1e-5);
    const double h = std::sqrt(0.5);
    EXPECT_NEAR(box({h, -h, 0}, 0.5).first, (0.3 + 0.2) / 2, 1e-4) << "half way between two sides";
}
TEST_F(ImageTest, environment_directions) {
    std::vector<float> pixels;
    for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) pixels.insert(pixels.end(), {(static_cast<float>(x) + 0.5f) / 64, 1 - (static_cast<float>(y) + 0.5f) / 64, 0});
    }
    const std::string image = parameter(write("uv.exr", 64, 64, 3, OIIO::TypeDesc::FLOAT, pixels));
    const auto uv = [&](double x, double y, double z) {
        const auto r = NodeCall("ShaderNodeTexEnvironment").set("image", image.c_str()).set("Vector", {x, y, z}).run();
        return std::pair(r[0][0], r[1][0]);
    };
    EXPECT_NEAR(uv(1, 0, 0).first, 0.5, 1e-5);
    EXPECT_NEAR(uv(0, -1, 0).first, 0.75, 1e-5);
    EXPECT_NEAR(uv(0, 1, 0).first, 0.25, 1e-5);
    EXPECT_NEAR(uv(1, 0, 1).second, 0.75, 1e-5);
    EXPECT_NEAR(uv(3, 0, 3).second, 0.75, 1e-5) << "length does not matter";
}

}  // namespace
}  // namespace alder
