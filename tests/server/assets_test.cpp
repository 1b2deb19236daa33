// Assets: content by digest, whole or not there; ranges; races.
#include "server/assets.h"

#include <atomic>
#include <fstream>
#include <thread>

#include "server/digest.h"
#include "tests/server/daemon_fixture.h"

namespace alder {
namespace {

class AssetsTest : public test::DaemonTest {
  protected:
    static std::string name_of(const std::string& content) { return "sha256:" + sha256_hex(content); }
    test::Answer put(const std::string& content, const std::string& headers = {}) { return ask("PUT", "/v1/assets/" + name_of(content), content, headers); }
    size_t files() const {
        size_t n = 0;
        for (const auto& e : std::filesystem::recursive_directory_iterator(folder + "/assets")) n += e.is_regular_file();
        return n;
    }
};

TEST_F(AssetsTest, put_get_head_delete) {
    start();
    std::string content(300000, 'x');
    for (size_t i = 0; i < content.size(); ++i) content[i] = static_cast<char>(i * 7 + i / 251);
    const std::string path = "/v1/assets/" + name_of(content);
    EXPECT_EQ(problem_of(ask("GET", path)), "404 not-found");
    const auto first = put(content);
    EXPECT_EQ(first.status, 201) << first.body;
    EXPECT_EQ(first.headers.at("location"), path);
    EXPECT_EQ(put(content).status, 200) << "there already";
    const auto got = ask("GET", path);
    EXPECT_EQ(got.status, 200);
    EXPECT_TRUE(got.body == content) << got.body.size() << " bytes";
    EXPECT_EQ(got.headers.at("etag"), "\"" + name_of(content) + "\"");
    EXPECT_NE(got.headers.at("cache-control").find("immutable"), std::string::npos);
    const auto head = ask("HEAD", path);
    EXPECT_EQ(head.headers.at("content-length"), "300000");
    EXPECT_TRUE(head.body.empty());
    EXPECT_EQ(ask("GET", path, "", "If-None-Match: " + got.headers.at("etag") + "\r\n").status, 304);
    EXPECT_EQ(ask("DELETE", path).status, 204);
    EXPECT_EQ(problem_of(ask("DELETE", path)), "404 not-found");
    EXPECT_EQ(files(), 0u);
}

TEST_F(AssetsTest, empty_and_chunked) {
    start();
    EXPECT_EQ(put("").status, 201);
    EXPECT_EQ(ask("GET", "/v1/assets/" + name_of("")).body, "");
    test::RawClient c(daemon->port());
    c.send("PUT /v1/assets/" + name_of("abc") + " HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n2\r\nab\r\n1\r\nc\r\n0\r\n\r\n");
    EXPECT_EQ(c.receive().status, 201);
    EXPECT_EQ(ask("GET", "/v1/assets/" + name_of("abc")).headers.at("content-digest"), "sha-256=:ungWv48Bz+pBQUDeXa4iI7ADYaOWF3qctBD/YfIAFa0=:");
}

TEST_F(AssetsTest, ranges) {
    start();
    const std::string content = "0123456789";
    put(content);
    const std::string path = "/v1/assets/" + name_of(content);
    const auto range = [&](const std::string& spec, const std::string& more = {}) { return ask("GET", path, "", "Range: " + spec + "\r\n" + more); };
    const auto middle = range("bytes=2-4");
    EXPECT_EQ(middle.status, 206);
    EXPECT_EQ(middle.body, "234");
    EXPECT_EQ(middle.headers.at("content-range"), "bytes 2-4/10");
    EXPECT_EQ(range("bytes=7-").body, "789");
    EXPECT_EQ(range("bytes=-3").body, "789");
    EXPECT_EQ(range("bytes=-30").body, content);
    EXPECT_EQ(range("bytes=0-99").body, content);
    EXPECT_EQ(range("bytes=9-9").body, "9");
    for (const char* whole : {"bytes=0-1,3-4", "lines=1-2", "bytes=4-2", "bytes=a-b", "bytes=", "bytes=-", "bytes=0-1, 2-3, 4-5"}) EXPECT_EQ(range(whole).status, 200) << whole;
    const auto outside = range("bytes=10-");
    EXPECT_EQ(problem_of(outside), "416 range");
    EXPECT_EQ(outside.headers.at("content-range"), "bytes */10");
    EXPECT_EQ(range("bytes=-0").status, 416);
    EXPECT_EQ(range("bytes=2-4", "If-Range: \"other\"\r\n").status, 200);
    EXPECT_EQ(range("bytes=2-4", "If-Range: \"" + name_of(content) + "\"\r\n").status, 206);
}

TEST_F(AssetsTest, wrong_content_leaves_nothing) {
    start();
    const auto a = ask("PUT", "/v1/assets/" + name_of("right"), "wrong");
    EXPECT_EQ(problem_of(a), "422 digest-mismatch");
    EXPECT_EQ(json_of(a)["found"], name_of("wrong"));
    {
        test::RawClient c(daemon->port());   // hangs up half way
        c.send("PUT /v1/assets/" + name_of("half") + " HTTP/1.1\r\nHost: localhost\r\nContent-Length: 4\r\n\r\nha");
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    for (int i = 0; i < 100 && files() > 0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_EQ(files(), 0u);
    for (const char* bad : {"sha256:abc", "md5:0", "sha256:ABCDEF0123456789012345678901234567890123456789012345678901234567", "..%2f..%2fetc%2fpasswd"})
        EXPECT_EQ(problem_of(ask("PUT", std::string("/v1/assets/") + bad, "x")), "404 not-found") << bad;
}

TEST_F(AssetsTest, expect_is_answered_before_the_body) {
    start();
    put("there");
    test::RawClient c(daemon->port());
    c.send("PUT /v1/assets/" + name_of("there") + " HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\nExpect: 100-continue\r\n\r\n");
    EXPECT_EQ(c.receive().status, 200);
}

TEST_F(AssetsTest, what_is_missing) {
    start();
    put("a");
    const auto a = post("/v1/assets/missing", {{"digests", {name_of("a"), name_of("b")}}});
    EXPECT_EQ(json_of(a)["missing"], nlohmann::json::array({name_of("b")}));
    const auto bad = post("/v1/assets/missing", {{"digests", {"sha256:x"}}});
    EXPECT_EQ(problem_of(bad), "422 request-invalid");
    EXPECT_EQ(json_of(bad)["errors"][0]["pointer"], "/digests/0");
    EXPECT_EQ(problem_of(post("/v1/assets/missing", nlohmann::json::object())), "422 request-invalid");
}

TEST_F(AssetsTest, the_same_asset_from_many_clients_at_once) {
    start();
    const std::string content(2 << 20, 'q');
    std::atomic<int> good{0};
    std::vector<std::thread> threads;
    for (int i = 0; i < 8; ++i)
        threads.emplace_back([&] {
            const int status = put(content).status;
            good += status == 200 || status == 201;
        });
    for (auto& t : threads) t.join();
    EXPECT_EQ(good, 8);
    EXPECT_EQ(files(), 1u);
    EXPECT_TRUE(ask("GET", "/v1/assets/" + name_of(content)).body == content);
}

TEST_F(AssetsTest, survives_a_restart) {
    start();
    put("kept");
    std::ofstream(folder + "/assets/incoming/1.2") << "left by a killed daemon";
    daemon.reset();
    start();
    EXPECT_EQ(ask("GET", "/v1/assets/" + name_of("kept")).body, "kept");
    EXPECT_EQ(files(), 1u);
}

TEST(DigestNames, are_checked) {
    EXPECT_EQ(digest_hex("sha256:" + std::string(64, 'a')), std::string(64, 'a'));
    for (const std::string bad : {"", "sha256:", "sha256:a", "SHA256:", "sha512:"}) EXPECT_EQ(digest_hex(bad), "");
    EXPECT_EQ(digest_hex("sha256:" + std::string(63, 'a') + "A"), "");
    Sha256 hash;
    hash.update("ab");
    hash.update("c");
    EXPECT_EQ(hash.hex(), sha256_hex("abc"));
}

}  // namespace
}  // namespace alder
