// Heads of requests: what is taken, what is refused, and by which row of the error table.
#include "server/http/head.h"

#include <gtest/gtest.h>

namespace alder::http {
namespace {

std::string fault_of(const std::string& bytes, Head* out = nullptr) {
    Head head;
    const auto fault = parse_head(bytes, Limits{}, head);
    if (out) *out = head;
    return fault ? fault->type : "";
}

TEST(HttpHead, plain_request_is_read) {
    Head head;
    ASSERT_EQ(fault_of("POST /v1/scenes/scn_1/materials/a%2Fb%20c?x=1&y=%C3%A4+b HTTP/1.1\r\nHost: localhost:7420\r\nX-A:  b \r\nContent-Length: 12\r\n\r\n", &head), "");
    EXPECT_EQ(head.method, "POST");
    EXPECT_EQ(head.segments, (std::vector<std::string>{"v1", "scenes", "scn_1", "materials", "a/b c"}));
    EXPECT_EQ(head.query, (std::vector<std::pair<std::string, std::string>>{{"x", "1"}, {"y", "\xC3\xA4 b"}}));
    EXPECT_EQ(*head.header("x-a"), "b");
    EXPECT_EQ(head.content_length, 12u);
    EXPECT_TRUE(head.keep_alive);
    EXPECT_EQ(head.host, "localhost:7420");
}

TEST(HttpHead, root_and_trailing_slash_differ) {
    Head head;
    fault_of("GET / HTTP/1.1\r\nHost: a\r\n\r\n", &head);
    EXPECT_TRUE(head.segments.empty());
    fault_of("GET /v1/ HTTP/1.1\r\nHost: a\r\n\r\n", &head);
    EXPECT_EQ(head.segments.size(), 2u);
}

TEST(HttpHead, what_two_readers_could_understand_differently_is_refused) {
    const std::string start = "POST / HTTP/1.1\r\nHost: a\r\n";
    for (const char* bad : {
             "Content-Length: 3\r\nContent-Length: 3\r\n\r\n", "Content-Length: 3\r\nTransfer-Encoding: chunked\r\n\r\n", "Content-Length: +3\r\n\r\n",
             "Content-Length: 3, 3\r\n\r\n", "Content-Length: -1\r\n\r\n", "Content-Length: 99999999999999999999\r\n\r\n", "Content-Length: 0x3\r\n\r\n",
             "Content-Length:\r\n\r\n", "Transfer-Encoding: gzip, chunked\r\n\r\n", "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n\r\n",
             "Transfer-Encoding: xchunked\r\n\r\n", "Content-Length : 3\r\n\r\n", " Content-Length: 3\r\n\r\n", "X: a\r\n b\r\n\r\n", "X: a\nY: b\r\n\r\n",
             "X\r\n\r\n", ": b\r\n\r\n", "X: a\x01\r\n\r\n", "Host: b\r\n\r\n", "Expect: something\r\n\r\n"})
        EXPECT_EQ(fault_of(start + bad), "malformed-request") << bad;
}

TEST(HttpHead, bad_request_lines_are_refused) {
    for (const char* bad : {"GET\r\n", "GET /\r\n", "GET / HTTP/2.0\r\n", "GET / http/1.1\r\n", "G T / HTTP/1.1\r\n", "GET  / HTTP/1.1\r\n", "GET a HTTP/1.1\r\n",
                            "GET /%zz HTTP/1.1\r\n", "GET /%0d%0aX HTTP/1.1\r\n", "GET /%00 HTTP/1.1\r\n", "GET /%ff HTTP/1.1\r\n", "GET /../etc HTTP/1.1\r\n",
                            "GET /%2e%2e/etc HTTP/1.1\r\n", "GET /?a=%0a HTTP/1.1\r\n", "GET * HTTP/1.1\r\n", "GET /#a HTTP/1.1\r\n", "\x16\x03\x01 / HTTP/1.1\r\n"})
        EXPECT_EQ(fault_of(std::string(bad) + "Host: a\r\n\r\n"), "malformed-request") << bad;
    EXPECT_EQ(fault_of("GET / HTTP/1.1\r\n\r\n"), "malformed-request") << "HTTP/1.1 without Host";
    EXPECT_EQ(fault_of("HEAD / HTTP/1.1\r\nHost: a\r\nContent-Length: 3\r\n\r\n"), "malformed-request");
}

TEST(HttpHead, versions_and_connection_decide_whether_it_stays_open) {
    Head head;
    EXPECT_EQ(fault_of("GET / HTTP/1.0\r\n\r\n", &head), "");
    EXPECT_FALSE(head.keep_alive);
    EXPECT_EQ(fault_of("GET / HTTP/1.0\r\nConnection: keep-alive\r\n\r\n", &head), "");
    EXPECT_TRUE(head.keep_alive);
    EXPECT_EQ(fault_of("GET / HTTP/1.1\r\nHost: a\r\nConnection: Close\r\n\r\n", &head), "");
    EXPECT_FALSE(head.keep_alive);
}

TEST(HttpHead, absolute_target_names_the_host) {
    Head head;
    ASSERT_EQ(fault_of("GET http://evil.example/v1/nodes HTTP/1.1\r\nHost: localhost\r\n\r\n", &head), "");
    EXPECT_EQ(head.host, "evil.example");
    EXPECT_EQ(head.segments, (std::vector<std::string>{"v1", "nodes"}));
}

TEST(HttpHead, sizes_are_refused_while_reading) {
    const Limits limits;
    EXPECT_EQ(head_progress(std::string(limits.request_line_bytes + 1, 'a'), limits).fault->type, "uri-too-long");
    EXPECT_EQ(head_progress("GET / HTTP/1.1\r\nX: " + std::string(limits.header_bytes, 'a'), limits).fault->type, "headers-too-large");
    EXPECT_FALSE(head_progress("GET / HTTP/1.1\r\nX: a\r\n", limits).fault);
    EXPECT_EQ(head_progress("GET / HTTP/1.1\r\nX: a\r\n", limits).end, 0u);
    EXPECT_EQ(head_progress("GET / HTTP/1.1\r\n\r\nrest", limits).end, 18u);
    std::string many = "GET / HTTP/1.1\r\nHost: a\r\n";
    for (int i = 0; i < 100; ++i) many += "X: y\r\n";
    EXPECT_EQ(fault_of(many + "\r\n"), "headers-too-large");
}

TEST(HttpHead, utf8) {
    EXPECT_TRUE(is_utf8("a\xC3\xA4\xE2\x82\xAC\xF0\x9F\x98\x80"));
    for (const char* bad : {"\x80", "\xC0\xAF", "\xE0\x80\x80", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xF8\x88\x80\x80", "\xC3", "\xE2\x82"}) EXPECT_FALSE(is_utf8(bad));
}

}  // namespace
}  // namespace alder::http
