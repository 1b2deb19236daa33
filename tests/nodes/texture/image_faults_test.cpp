// Textures that are missing or broken, as graphs meet them: one warning with the place and the file, magenta, errors where the request is
// strict; filtering of textures and noise through a graph.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "nodes/texture/image_store.h"
#include "render/evaluate.h"

namespace alder {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

class ImageFaultsTest : public ::testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("alder_faults_test_" + std::to_string(getpid()));
        fs::create_directories(folder_);
        std::ofstream(folder_ / "broken.png") << "no picture";
        options_.material.resolve_image = [this](const json& image, std::string& error) {
            const fs::path path = folder_ / image.value("file", "");
            if (fs::exists(path)) return path.string();
            error = path.string() + ": " + std::string(kNoSuchFile);
            return std::string();
        };
    }
    void TearDown() override { fs::remove_all(folder_); }
    static json request(const char* file) {
        return {{"graph", {{"nodes", {{"tex/1", {{"type", "ShaderNodeTexImage"}, {"params", {{"image", {{"file", file}}}}}}},
                                      {"two", {{"type", "ShaderNodeMath"}, {"params", {{"operation", "ADD"}, {"Value", {{"node", "tex/1"}, {"output", "Color"}}},
                                                                                      {"Value_001", {{"node", "tex/1"}, {"output", "Alpha"}}}}}}}}}}},
                {"outputs", {"tex/1.Color", "two"}}};
    }
    fs::path folder_;
    EvaluateOptions options_;
};

TEST_F(ImageFaultsTest, one_warning_with_place_and_file_and_magenta) {
    for (const auto& [file, code] : {std::pair{"absent.png", "asset-missing"}, {"broken.png", "asset-unreadable"}}) {
        Diagnostics d;
        const json answer = evaluate_request(request(file), options_, d);
        ASSERT_TRUE(d.ok()) << d.errors[0].line();
        ASSERT_EQ(d.warnings.size(), 1u) << file;
        EXPECT_EQ(d.warnings[0].pointer, "/graph/nodes/tex~11/params/image");
        EXPECT_EQ(d.warnings[0].code, code);
        EXPECT_NE(d.warnings[0].line().find(file), std::string::npos) << d.warnings[0].line();
        EXPECT_EQ(answer["outputs"]["tex/1.Color"][0], json({1.0, 0.0, 1.0}));
    }
}
TEST_F(ImageFaultsTest, strict_makes_it_an_error) {
    for (const auto& [file, code] : {std::pair{"absent.png", "asset-missing"}, {"broken.png", "asset-unreadable"}}) {
        Diagnostics d;
        json r = request(file);
        r["strict"] = true;
        EXPECT_TRUE(evaluate_request(r, options_, d).is_null());
        ASSERT_GE(d.errors.size(), 1u);
        EXPECT_EQ(d.errors[0].pointer, "/graph/nodes/tex~11/params/image");
        EXPECT_EQ(d.errors[0].code, code);
    }
}
TEST_F(ImageFaultsTest, a_material_remembers_its_faults_for_strict_renders) {
    MaterialOptions options = options_.material;
    options.pointer_prefix = "/materials/m";
    Diagnostics d;
    json graph = request("broken.png")["graph"];
    graph["outputs"]["aovs"]["x"] = {{"node", "two"}};
    const auto m = build_material(graph, options, d);
    ASSERT_TRUE(m);
    ASSERT_EQ(m->file_faults().size(), 1u);
    EXPECT_EQ(m->file_faults()[0].pointer, "/materials/m/nodes/tex~11/params/image");
    Diagnostics again;
    m->program({.outputs = {"tex/1.Color"}}, again);
    EXPECT_TRUE(again.warnings.empty()) << "said once";
}
/// Here by another program that writes the file anew: what is read from then on is not what was opened.
TEST_F(ImageFaultsTest, a_file_in_tiles_that_breaks_while_it_is_read_fails_a_strict_request) {
    constexpr int side = 256, tile = 64;
    const std::string file = (folder_ / "tiles.tif").string();
    const auto write = [&](float grey) {
        const std::vector<float> pixels(side * side * 3, grey);
        OIIO::ImageSpec spec(side, side, 3, OIIO::TypeDesc::UINT8);
        spec.tile_width = spec.tile_height = tile;
        spec.attribute("compression", grey > 0.6f ? "none" : "zip");   // another size, should the clock not have moved
        const auto out = OIIO::ImageOutput::create(file);
        ASSERT_TRUE(out->open(file, spec) && out->write_image(OIIO::TypeDesc::FLOAT, pixels.data()));
        out->close();
    };
    write(0.5f);
    ImageStore::shared().set_budget(1 << 15);
    MaterialCache cache;
    options_.cache = &cache;
    const auto red_at = [&](double u, Diagnostics& d) {
        json r = request("tiles.tif");
        r["graph"]["nodes"]["tex/1"]["params"]["Vector"] = {{"attribute", "at"}};
        r["points"] = {{"count", 1}, {"attributes", {{"at", {{u, 0.5, 0.0}}}}}};
        r["outputs"] = {"tex/1.Color"};
        r["strict"] = true;
        const json answer = evaluate_request(r, options_, d);
        return answer.is_null() ? -1 : answer["outputs"]["tex/1.Color"][0][0].get<double>();
    };
    Diagnostics before, after;
    EXPECT_NEAR(red_at(0.1, before), 0.2140, 3e-3);
    EXPECT_TRUE(before.ok());
    write(0.7f);
    const auto fresh = ImageStore::shared().open({file, "", AlphaMode::Straight});
    EXPECT_EQ(red_at(0.9, after), -1);
    ImageStore::shared().set_budget(ImageStore::kDefaultBudget);
    ASSERT_EQ(after.errors.size(), 1u);
    EXPECT_EQ(after.errors[0].pointer, "/graph/nodes/tex~11/params/image");
    EXPECT_EQ(after.errors[0].code, "asset-unreadable");
    EXPECT_NE(after.errors[0].found.find("tiles.tif"), std::string::npos) << after.errors[0].found;
}
/// Bands one texel wide: blurred by a bias, more by a larger one; of the footprint's level otherwise.
TEST_F(ImageFaultsTest, triplanar_bias_takes_coarser_levels) {
    constexpr int side = 64;
    std::vector<float> pixels(side * side * 3);
    for (int i = 0; i < side * side; ++i)
        for (int c = 0; c < 3; ++c) pixels[3 * i + c] = static_cast<float>(i % side % 2);
    const std::string file = (folder_ / "bands.exr").string();
    const auto out = OIIO::ImageOutput::create(file);
    ASSERT_TRUE(out->open(file, OIIO::ImageSpec(side, side, 3, OIIO::TypeDesc::FLOAT)) && out->write_image(OIIO::TypeDesc::FLOAT, pixels.data()));
    out->close();
    const auto spread = [&](int bias) {
        json positions = json::array(), normals = json::array(), dx = json::array(), dy = json::array();
        constexpr int count = 64;
        for (int i = 0; i < count; ++i) {
            positions.push_back({0.013 * i, 0.3, 0.0});
            normals.push_back({0.0, 0.0, 1.0});
            dx.push_back({1.0 / side, 0.0, 0.0});   // a texel a pixel
            dy.push_back({0.0, 1.0 / side, 0.0});
        }
        json r = {{"graph", {{"nodes", {{"t", {{"type", "alTriplanar"}, {"params", {{"texture", {{"file", "bands.exr"}}}, {"mipMapBias", bias}}}}}}}}},
                  {"points", {{"count", count}, {"P", positions}, {"N", normals}, {"Ng", normals}, {"dPdx", dx}, {"dPdy", dy}}}, {"outputs", {"t"}}};
        Diagnostics d;
        const json answer = evaluate_request(r, options_, d);
        EXPECT_TRUE(d.ok()) << (d.ok() ? "" : d.errors[0].line());
        double lo = 1e9, hi = -1e9;
        if (!answer.is_null())
            for (const auto& c : answer["outputs"]["t"]) lo = std::min(lo, c[0].get<double>()), hi = std::max(hi, c[0].get<double>());
        return hi - lo;
    };
    EXPECT_GT(spread(0), 0.9);
    EXPECT_NEAR(spread(-3), spread(0), 1e-6) << "finer than the image";
    EXPECT_LT(spread(2), 0.02) << "four texels";
}
TEST_F(ImageFaultsTest, names_are_pointed_at_with_the_nearest_one) {
    json r = request("broken.png");
    r["graph"]["nodes"]["tex/1"]["params"]["image"]["colorspace"] = "Linear Rec.7009";
    Diagnostics d;
    EXPECT_TRUE(evaluate_request(r, options_, d).is_null());
    ASSERT_EQ(d.errors.size(), 1u);
    EXPECT_EQ(d.errors[0].pointer, "/graph/nodes/tex~11/params/image/colorspace");
    EXPECT_EQ(d.errors[0].found, "Linear Rec.7009");
    EXPECT_EQ(d.errors[0].suggest, "Linear Rec.709");
}

/// The texture is looked up through a Mapping that shrinks it: the filter must see that.
TEST_F(ImageFaultsTest, texture_filter_sees_the_graph_before_the_image) {
    constexpr int side = 64;
    std::vector<float> pixels(side * side * 3);
    std::mt19937 random(3);
    double mean = 0;
    for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<float>(random() % 256) / 255;
    for (size_t i = 0; i < pixels.size(); i += 3) mean += pixels[i] / (side * side);
    const std::string file = (folder_ / "n.exr").string();
    const auto out = OIIO::ImageOutput::create(file);
    ASSERT_TRUE(out->open(file, OIIO::ImageSpec(side, side, 3, OIIO::TypeDesc::FLOAT)) && out->write_image(OIIO::TypeDesc::FLOAT, pixels.data()));
    out->close();
    const auto red = [&](double scale, bool filter) {
        json r = {{"graph", {{"nodes", {{"map", {{"type", "ShaderNodeMapping"}, {"params", {{"Vector", {{"attribute", "nothing"}}}, {"Scale", {scale, scale, 1.0}}}}}},
                                        {"tex", {{"type", "ShaderNodeTexImage"}, {"params", {{"image", {{"file", "n.exr"}, {"colorspace", "Non-Color"}}}, {"Vector", {{"node", "map"}}}}}}},
                                        {"uv", {{"type", "ShaderNodeTexCoord"}}}}}}},
                  {"points", {{"count", 1}, {"uv", {{0.31, 0.62, 0.0}}}, {"duvdx", {0.001, 0.0, 0.0}}, {"duvdy", {0.0, 0.001, 0.0}}}},
                  {"texture_filter", filter}, {"outputs", {"tex.Color"}}};
        r["graph"]["nodes"]["map"]["params"]["Vector"] = {{"node", "uv"}, {"output", "UV"}};
        Diagnostics d;
        const json answer = evaluate_request(r, options_, d);
        EXPECT_TRUE(d.ok()) << (d.ok() ? "" : d.errors[0].line());
        return answer.is_null() ? -1 : answer["outputs"]["tex.Color"][0][0].get<double>();
    };
    EXPECT_EQ(red(1, true), red(1, false)) << "0.06 texels a pixel";
    EXPECT_NEAR(red(1000, true), mean, 1e-3) << "64 texels a pixel: the whole image";
    EXPECT_GT(std::abs(red(1000, false) - mean), 1e-2);
}

/// Means over a pixel, by brute force and by the filter.
TEST_F(ImageFaultsTest, noise_filter_keeps_what_a_pixel_can_hold) {
    const auto values = [&](const json& node, const char* output, double width, bool filter, int points) {
        json p = json::array();
        std::mt19937 random(9);
        for (int i = 0; i < points; ++i) p.push_back({random() * 0x1p-32 * 50, random() * 0x1p-32 * 50, random() * 0x1p-32 * 50});
        const json r = {{"graph", {{"nodes", {{"n", node}}}}}, {"noise_filter", filter}, {"outputs", {output}},
                        {"points", {{"count", points}, {"P", p}, {"generated", p}, {"dPdx", {width, 0.0, 0.0}}, {"dPdy", {0.0, width, 0.0}},
                                    {"dgendx", {width, 0.0, 0.0}}, {"dgendy", {0.0, width, 0.0}}}}};
        Diagnostics d;
        const json answer = evaluate_request(r, options_, d);
        EXPECT_TRUE(d.ok()) << (d.ok() ? "" : d.errors[0].line());
        std::vector<double> v;
        if (!answer.is_null())
            for (const auto& x : answer["outputs"][output]) v.push_back(x.is_array() ? x[0].get<double>() : x.get<double>());
        return v;
    };
    const auto moments = [](const std::vector<double>& v) {
        double mean = 0, squares = 0;
        for (double x : v) mean += x / static_cast<double>(v.size());
        for (double x : v) squares += (x - mean) * (x - mean) / static_cast<double>(v.size());
        return std::pair(mean, squares);
    };
    const json noise = {{"type", "ShaderNodeTexNoise"}, {"params", {{"Scale", 1.0}, {"Detail", 4.0}}}};
    const json fractal = {{"type", "alFractal"}, {"params", {{"octaves", 5}, {"RMPinputMin", -2.0}, {"RMPinputMax", 2.0}, {"color1", {0, 0, 0}}, {"color2", {1, 1, 1}}}}};
    for (const auto& [node, output] : {std::pair{noise, "n.Fac"}, {fractal, "n"}}) {
        const auto plain = values(node, output, 0, false, 2000), same = values(node, output, 0.01, true, 2000);
        EXPECT_EQ(plain, same) << output << ": a footprint far below the finest octave changes nothing";
        const auto whole = moments(plain);
        double last = whole.second;
        for (const double width : {0.2, 0.5, 1.0, 2.5}) {
            const auto m = moments(values(node, output, width, true, 2000));
            EXPECT_NEAR(m.first, whole.first, 0.02) << output << " width " << width << ": the mean stays";
            EXPECT_LE(m.second, last * 1.001) << output << " width " << width;
            last = m.second;
        }
        EXPECT_LT(last, 1e-12) << output << ": nothing is left of the first octave";
        // The octaves that stay keep their size: half of the first octave's lattice a pixel leaves that one alone.
        EXPECT_GT(moments(values(node, output, 0.5, true, 2000)).second, 0.5 * whole.second) << output;
    }
}

}  // namespace
}  // namespace alder
