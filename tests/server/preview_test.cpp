// POST /v1/preview: pictures of every type, tags, caching, faults, and that a warm preview builds nothing again.
#include <algorithm>

#include "render/image/exr.h"
#include "render/stages.h"
#include "tests/server/daemon_fixture.h"

namespace alder {
namespace {

using nlohmann::json;

class PreviewTest : public test::DaemonTest {
  protected:
    static json request(int samples = 1, double roughness = 0.3) { return {{"graph", surface_graph(roughness)}, {"stage", "sphere"}, {"size", 32}, {"samples", samples}}; }
    static std::optional<Image> exr_of(const test::Answer& a) {
        std::string error;
        auto image = decode_exr({reinterpret_cast<const uint8_t*>(a.body.data()), a.body.size()}, error);
        EXPECT_TRUE(image) << error;
        return image;
    }
};

TEST_F(PreviewTest, every_type) {
    start();
    const auto png = post("/v1/preview", request(), "Accept: image/png\r\n");
    ASSERT_EQ(png.status, 200) << png.body;
    EXPECT_EQ(png.body.substr(0, 4), "\x89PNG");
    EXPECT_EQ(png.headers.at("content-type"), "image/png");
    EXPECT_EQ(png.headers.at("alder-samples"), "1");
    EXPECT_EQ(png.headers.at("alder-warnings"), "0");
    EXPECT_NE(png.headers.at("server-timing").find("render;dur="), std::string::npos);
    EXPECT_EQ(post("/v1/preview", request()).body, png.body) << "PNG is what no Accept means";
    EXPECT_EQ(post("/v1/preview", request(), "Accept: image/jpeg\r\n").body.substr(0, 2), "\xFF\xD8");
    const auto answer = json_of(post("/v1/preview", request(), "Accept: application/json\r\n"));
    EXPECT_EQ(answer["stats"]["samples"], 1);
    EXPECT_GT(answer["stats"]["rays"]["camera"], 0);
    const auto exr = exr_of(post("/v1/preview", request(), "Accept: image/x-exr\r\n"));
    ASSERT_TRUE(exr);
    EXPECT_EQ(exr->width, 32);
    const auto& red = exr->find("")->planes[0];
    EXPECT_GT(*std::max_element(red.begin(), red.end()), 0.01f) << "something is lit";
    const auto oblong = exr_of(post("/v1/preview", {{"graph", surface_graph()}, {"stage", "sphere"}, {"size", {40, 24}}, {"samples", 1}}, "Accept: image/x-exr\r\n"));
    ASSERT_TRUE(oblong);
    EXPECT_EQ(oblong->width, 40);
    EXPECT_EQ(oblong->height, 24);
}

TEST_F(PreviewTest, layers_of_the_exr) {
    start();
    json r = request(4);
    r["graph"] = surface_graph();
    r["graph"]["nodes"]["w"] = {{"type", "alRemapFloat"}, {"params", {{"input", 0.25}}}};
    r["graph"]["outputs"]["aovs"] = {{"wear", {{"node", "w"}}}};
    r["aovs"] = {"shading", "data", "wear"};
    const auto image = exr_of(post("/v1/preview", r, "Accept: image/x-exr\r\n"));
    ASSERT_TRUE(image);
    for (const char* name : {"", "direct_diffuse", "indirect_specular", "Z", "N", "wear"}) EXPECT_TRUE(image->find(name)) << name;
    const auto& wear = image->find("wear")->planes[0];
    EXPECT_NEAR(*std::max_element(wear.begin(), wear.end()), 0.25f, 1e-3f);
}

TEST_F(PreviewTest, samples_make_it_deterministic_and_tagged) {
    start();
    const auto a = post("/v1/preview", request(), "Accept: image/x-exr\r\n");
    ASSERT_EQ(a.status, 200) << a.body;
    const std::string etag = a.headers.at("etag");
    const auto b = post("/v1/preview", request(), "Accept: image/x-exr\r\n");
    EXPECT_EQ(b.body, a.body);
    EXPECT_NE(b.headers.at("server-timing").find("cache"), std::string::npos) << "the second comes from the cache";
    const auto unchanged = post("/v1/preview", request(), "Accept: image/x-exr\r\nIf-None-Match: " + etag + "\r\n");
    EXPECT_EQ(unchanged.status, 304);
    EXPECT_TRUE(unchanged.body.empty());
    for (const auto& [what, other] : {std::pair<std::string, json>{"samples", request(2)}, {"graph", request(1, 0.4)}}) {
        const auto c = post("/v1/preview", other, "Accept: image/x-exr\r\n");
        EXPECT_NE(c.headers.at("etag"), etag) << what;
        EXPECT_NE(c.body, a.body) << what;
    }
    EXPECT_NE(post("/v1/preview", request(), "Accept: image/png\r\n").headers.at("etag"), etag);
    options.cache_mib = 0;
    daemon.reset();
    start();
    EXPECT_EQ(post("/v1/preview", request(), "Accept: image/x-exr\r\n").body, a.body) << "rendered again in another daemon";
}

TEST_F(PreviewTest, a_budget_has_no_tag) {
    start();
    json r = request();
    r.erase("samples");
    r["budget"] = 0.05;
    const auto a = post("/v1/preview", r, "Accept: application/json\r\n");
    ASSERT_EQ(a.status, 200) << a.body;
    EXPECT_EQ(a.headers.count("etag"), 0u);
    EXPECT_GE(json_of(a)["stats"]["samples"], 1);
    r["samples"] = 3;
    EXPECT_EQ(problem_of(post("/v1/preview", r)), "422 settings-invalid");
}

TEST_F(PreviewTest, all_faults_at_once) {
    start();
    const auto a = post("/v1/preview", {{"graph", surface_graph()}, {"stage", "spher"}, {"size", 0}, {"samles", 4}, {"seed", -1}, {"view", {{"transform", "rec709"}}}});
    EXPECT_EQ(problem_of(a), "422 settings-invalid");
    std::map<std::string, std::string> found;
    for (const auto& e : errors_of(a)) found[e["pointer"]] = e.value("suggest", "");
    EXPECT_EQ(found.size(), 5u) << a.body;
    EXPECT_EQ(found["/stage"], "sphere");
    EXPECT_EQ(found["/samles"], "samples");
    EXPECT_TRUE(found.count("/view/transform"));
    json bad = request();
    bad["graph"]["nodes"]["s"]["params"]["specular1Roughnes"] = 0.1;
    const auto graph = post("/v1/preview", bad);
    EXPECT_EQ(problem_of(graph), "422 graph-invalid");
    EXPECT_EQ(json_of(graph)["errors"][0]["pointer"], "/graph/nodes/s/params/specular1Roughnes");
    EXPECT_EQ(json_of(graph)["errors"][0]["suggest"], "specular1Roughness");
    bad["lenient"] = true;
    const auto lenient = post("/v1/preview", bad);
    EXPECT_EQ(lenient.status, 200) << lenient.body;
    EXPECT_EQ(lenient.headers.at("alder-warnings"), "1");
    json layer = request();
    layer["view"] = {{"layer", "nonsense"}};
    EXPECT_EQ(problem_of(post("/v1/preview", layer, "Accept: image/png\r\n")), "422 settings-invalid");
}

TEST_F(PreviewTest, missing_assets_are_all_listed) {
    start();
    const std::string one = "sha256:" + std::string(64, '1'), two = "sha256:" + std::string(64, '2');
    json r = request();
    for (const auto& [name, digest] : {std::pair{"i", one}, {"j", two}})
        r["graph"]["nodes"][name] = {{"type", "ShaderNodeTexImage"}, {"params", {{"image", {{"asset", digest}}}}}};
    if (!find_node("ShaderNodeTexImage")) GTEST_SKIP() << "this version has no image textures";
    r["graph"]["nodes"]["s"]["params"]["diffuseColor"] = {{"node", "i"}, {"output", "Color"}};
    r["graph"]["nodes"]["s"]["params"]["specular1Color"] = {{"node", "j"}, {"output", "Color"}};
    const auto a = post("/v1/preview", r);
    EXPECT_EQ(problem_of(a), "422 asset-missing");
    EXPECT_EQ(json_of(a)["missing"].size(), 2u) << a.body;
}

TEST_F(PreviewTest, every_stage) {
    start();
    for (const auto name : stage_names()) {
        const auto a = post("/v1/preview", {{"graph", surface_graph()}, {"stage", std::string(name)}, {"size", 16}, {"samples", 1}});
        EXPECT_EQ(a.status, 200) << name << ": " << a.body;
    }
}

TEST_F(PreviewTest, a_client_that_hangs_up_ends_its_render) {
    start();
    {
        test::RawClient c(daemon->port());
        const std::string body = json{{"graph", surface_graph()}, {"stage", "sphere"}, {"size", 1024}, {"samples", 1 << 20}}.dump();
        c.send("POST /v1/preview HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
        for (int i = 0; i < 1000 && daemon->service().preview_lane.running() == 0; ++i) usleep(2000);
        ASSERT_EQ(daemon->service().preview_lane.running(), 1u);
        usleep(100000);
    }
    for (int i = 0; i < 2500 && daemon->service().preview_lane.running() > 0; ++i) usleep(2000);
    EXPECT_EQ(daemon->service().preview_lane.running(), 0u);
    EXPECT_EQ(post("/v1/preview", request()).status, 200);
}

TEST_F(PreviewTest, stopping_cancels_what_does_not_end) {
    options.stop_seconds = 0.2;
    start();
    test::RawClient c(daemon->port());
    const std::string body = json{{"graph", surface_graph()}, {"stage", "sphere"}, {"size", 1024}, {"samples", 1 << 20}}.dump();
    c.send("POST /v1/preview HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
    for (int i = 0; i < 1000 && daemon->service().preview_lane.running() == 0; ++i) usleep(2000);
    const auto begin = std::chrono::steady_clock::now();
    daemon->stop();
    daemon.reset();
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(9));
}

}  // namespace
}  // namespace alder
