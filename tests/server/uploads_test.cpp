// Uploads in pieces, and assets that nothing refers to.
#include <filesystem>
#include <thread>

#include "server/digest.h"
#include "tests/server/daemon_fixture.h"

namespace alder {
namespace {

using nlohmann::json;

class UploadsTest : public test::DaemonTest {
  protected:
    const std::string bytes = std::string(100000, 'a') + std::string(50000, 'b');
    const std::string hex = sha256_hex(bytes);
    std::string begin(const std::string& digest, uint64_t size) {
        const auto a = post("/v1/uploads", {{"digest", "sha256:" + digest}, {"size", size}});
        EXPECT_EQ(a.status, 201) << a.body;
        return a.status == 201 ? a.headers.at("location") : "";
    }
    test::Answer piece(const std::string& path, uint64_t offset, const std::string& body) {
        return ask("PATCH", path, body, "Content-Type: application/offset+octet-stream\r\nUpload-Offset: " + std::to_string(offset) + "\r\n");
    }
};

TEST_F(UploadsTest, pieces_over_a_restart_become_an_asset) {
    start();
    const std::string path = begin(hex, bytes.size());
    EXPECT_EQ(piece(path, 0, bytes.substr(0, 70000)).status, 200);
    const auto wrong = piece(path, 5, "x");
    EXPECT_EQ(problem_of(wrong), "409 upload-offset");
    EXPECT_EQ(wrong.headers.at("upload-offset"), "70000");
    daemon.reset();
    start();
    EXPECT_EQ(ask("HEAD", path).headers.at("upload-offset"), "70000");
    EXPECT_EQ(ask("GET", "/v1/assets/sha256:" + hex).status, 404) << "not before it is whole";
    const auto done = piece(path, 70000, bytes.substr(70000));
    ASSERT_EQ(done.status, 200) << done.body;
    EXPECT_TRUE(json_of(done)["complete"].get<bool>());
    EXPECT_EQ(ask("GET", "/v1/assets/sha256:" + hex).body, bytes);
    EXPECT_EQ(problem_of(ask("HEAD", path)).substr(0, 3), "404");
    const auto again = post("/v1/uploads", {{"digest", "sha256:" + hex}, {"size", bytes.size()}});
    EXPECT_EQ(again.status, 200);
    EXPECT_TRUE(json_of(again)["complete"].get<bool>()) << "nothing to send";
}

TEST_F(UploadsTest, a_connection_that_breaks_keeps_what_came) {
    start();
    const std::string path = begin(hex, bytes.size());
    {
        test::RawClient c(daemon->port());
        c.send("PATCH " + path + " HTTP/1.1\r\nHost: localhost\r\nUpload-Offset: 0\r\nContent-Length: 150000\r\n\r\n" + bytes.substr(0, 30000));
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    uint64_t offset = 0;
    test::Answer rest;
    for (int i = 0; i < 200; ++i) {   // until the daemon has noticed
        offset = std::stoull(ask("HEAD", path).headers.at("upload-offset"));
        rest = piece(path, offset, bytes.substr(offset));
        if (rest.status == 200) break;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_EQ(rest.status, 200) << rest.body;
    EXPECT_GT(offset, 0u);
    EXPECT_EQ(ask("GET", "/v1/assets/sha256:" + hex).body, bytes);
}

TEST_F(UploadsTest, what_is_wrong_is_not_kept) {
    start();
    EXPECT_EQ(problem_of(post("/v1/uploads", {{"digest", "sha256:xyz"}, {"size", -1}})), "422 request-invalid");
    const std::string path = begin(sha256_hex("other"), 4);
    EXPECT_EQ(problem_of(piece(path, 0, "abcde")), "413 body-too-large");
    EXPECT_EQ(problem_of(ask("PATCH", path, "abc")), "400 malformed-request");
    const auto mismatch = piece(path, 0, "abcd");
    EXPECT_EQ(problem_of(mismatch), "422 digest-mismatch");
    EXPECT_EQ(problem_of(piece(path, 0, "abcd")), "404 not-found");
    const std::string gone = begin(hex, bytes.size());
    EXPECT_EQ(ask("DELETE", gone).status, 204);
    EXPECT_EQ(problem_of(piece(gone, 0, "abcd")), "404 not-found");
    for (const char* bad : {"/v1/uploads/upl_x", "/v1/uploads/..%2F..%2Flock", "/v1/uploads/upl_AAAAAAAAAAAAAAAAAAAAAAAAAA"}) EXPECT_EQ(problem_of(ask("GET", bad)), "404 not-found") << bad;
}

TEST_F(UploadsTest, assets_that_nothing_refers_to_go_after_their_time) {
    options.asset_ttl = 1;
    start();
    ASSERT_EQ(ask("PUT", "/v1/assets/sha256:" + hex, bytes).status, 201);
    const std::string image = "not an image, but named by a scene", image_hex = sha256_hex(image);
    ASSERT_EQ(ask("PUT", "/v1/assets/sha256:" + image_hex, image).status, 201);
    const json graph = {{"version", 1},
                        {"nodes", {{"t", {{"type", "ShaderNodeTexImage"}, {"params", {{"image", {{"asset", "sha256:" + image_hex}}}}}}},
                                   {"s", {{"type", "alSurface"}, {"params", {{"diffuseColor", {{"node", "t"}, {"output", "Color"}}}}}}}}},
                        {"outputs", {{"surface", {{"node", "s"}}}}}};
    const auto made = post("/v1/scenes", {{"alder_scene", 1},
                                          {"cameras", {{"c", {{"look_at", {{"from", {0, -5, 1}}, {"to", {0, 0, 1}}}}, {"fov_degrees", 40}}}}},
                                          {"materials", {{"m", graph}}},
                                          {"meshes", {{"t", {{"positions", {{-1, 0, 0}, {1, 0, 0}, {0, 0, 2}}}, {"triangles", {{0, 1, 2}}}}}}},
                                          {"instances", {{"a", {{"mesh", "t"}, {"material", "m"}}}}}});
    ASSERT_EQ(made.status, 201) << made.body;
    const auto there = [&](const std::string& h) { return ask("HEAD", "/v1/assets/sha256:" + h).status == 200; };
    for (int i = 0; i < 600 && there(hex); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_FALSE(there(hex));
    EXPECT_TRUE(there(image_hex)) << "a scene refers to it";
    EXPECT_EQ(ask("DELETE", "/v1/scenes/" + json_of(made)["id"].get<std::string>()).status, 204);
    for (int i = 0; i < 600 && there(image_hex); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_FALSE(there(image_hex));
}

TEST_F(UploadsTest, the_quota_is_told) {
    start();
    daemon->service().assets.set_quota(200000);
    ASSERT_EQ(ask("PUT", "/v1/assets/sha256:" + hex, bytes).status, 201);
    const std::string more(100000, 'c');
    EXPECT_EQ(problem_of(ask("PUT", "/v1/assets/sha256:" + sha256_hex(more), more)), "507 storage");
    EXPECT_EQ(problem_of(post("/v1/uploads", {{"digest", "sha256:" + sha256_hex(more)}, {"size", more.size()}})), "507 storage");
}

}  // namespace
}  // namespace alder
