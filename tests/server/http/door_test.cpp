// The door: hostile, slow and silent clients cost their own connection and nothing else.
#include "server/http/door.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/server/raw_client.h"

namespace alder::http {
namespace {

using test::Answer;
using test::RawClient;

double seconds_of(const std::function<void()>& f) {
    const auto start = std::chrono::steady_clock::now();
    f();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Echoes the body's size; "/slow" takes half a second, "/ignore" leaves the body alone, "/boom" throws.
class HttpDoor : public ::testing::Test {
  protected:
    Limits limits;
    std::unique_ptr<Door> door;
    std::atomic<int> gone{0};

    HttpDoor() {
        limits.head_seconds = 0.5;
        limits.idle_seconds = 1;
        limits.body_grace_seconds = 0.5;
        limits.write_stall_seconds = 0.5;
        limits.body_bytes = 100000;
        limits.connections = 64;
    }
    void open() {
        door = std::make_unique<Door>(limits, [this](Request& r) { return handle(r); });
        ASSERT_EQ(door->listen("127.0.0.1:0"), "");
        door->start();
    }
    Response handle(Request& r) {
        if (r.fault) return Response::text(r.fault->type == "uri-too-long" ? 414 : r.fault->type == "headers-too-large" ? 431 : r.fault->type == "request-timeout" ? 408 : 400, r.fault->type, "text/plain");
        if (r.target == "/boom") throw std::runtime_error("secret");
        if (r.target == "/ignore") return Response::text(200, "ignored", "text/plain");
        if (r.target == "/large") return Response::text(200, std::string(64 << 20, 'x'), "text/plain");
        if (r.target == "/slow")
            for (int i = 0; i < 50; ++i) {
                std::this_thread::sleep_for(std::chrono::milliseconds(10));
                if (r.client_gone()) {
                    ++gone;
                    break;
                }
            }
        uint64_t bytes = 0, sum = 0;
        const auto result = r.read_body(limits.body_bytes, [&](std::string_view piece) {
            bytes += piece.size();
            for (const char c : piece) sum += static_cast<unsigned char>(c);
            return true;
        });
        switch (result) {
            case BodyResult::Complete: return Response::text(200, r.method + " " + std::to_string(bytes) + " " + std::to_string(sum), "text/plain");
            case BodyResult::TooLarge: return Response::text(413, "too large", "text/plain");
            case BodyResult::TooSlow: return Response::text(408, "too slow", "text/plain");
            default: return Response::text(400, "malformed", "text/plain");
        }
    }
    Answer get(const std::string& target = "/") { return RawClient(door->port()).ask("GET", target); }
};

TEST_F(HttpDoor, answers_and_keeps_the_connection) {
    open();
    RawClient c(door->port());
    for (int i = 0; i < 3; ++i) EXPECT_EQ(c.ask("GET", "/").body, "GET 0 0");
    EXPECT_EQ(c.ask("POST", "/", "abc").body, "POST 3 294");
    EXPECT_EQ(c.ask("PUT", "/", "").body, "PUT 0 0");
    EXPECT_EQ(c.ask("DELETE", "/", "a").body, "DELETE 1 97");
    EXPECT_EQ(c.ask("BREW", "/").body, "BREW 0 0");
    const Answer head = c.ask("HEAD", "/");
    EXPECT_EQ(head.headers.at("content-length"), "8");
    EXPECT_EQ(c.ask("GET", "/").status, 200) << "after HEAD";
    EXPECT_EQ(door->connections(), 1u);
}

TEST_F(HttpDoor, pipelined_requests_are_answered_in_order) {
    open();
    RawClient c(door->port());
    c.send("POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 1\r\n\r\naPOST / HTTP/1.1\r\nHost: a\r\nContent-Length: 2\r\n\r\nab\r\nGET / HTTP/1.1\r\nHost: a\r\n\r\n");
    EXPECT_EQ(c.receive().body, "POST 1 97");
    EXPECT_EQ(c.receive().body, "POST 2 195");
    EXPECT_EQ(c.receive().body, "GET 0 0");
}

TEST_F(HttpDoor, chunked_bodies) {
    open();
    RawClient c(door->port());
    const std::string head = "POST / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n";
    c.send(head + "1\r\na\r\n2;ext=1\r\nab\r\n0\r\nTrailer: x\r\n\r\n");
    EXPECT_EQ(c.receive().body, "POST 3 292");
    c.send(head + "0\r\n\r\n");
    EXPECT_EQ(c.receive().body, "POST 0 0") << "the connection goes on";
    for (const char* bad : {"-1\r\na\r\n0\r\n\r\n", "+1\r\na\r\n0\r\n\r\n", "0x1\r\na\r\n0\r\n\r\n", "\r\n", "g\r\n", "1\r\nab\r\n0\r\n\r\n", "1\na\n0\n\n", "11111111111111111\r\n",
                            "1 1\r\na\r\n"}) {
        RawClient d(door->port());
        d.send(head + bad);
        const Answer a = d.receive(2);
        EXPECT_TRUE(a.status == 400 || a.status == 413) << bad << " -> " << a.status;
        EXPECT_TRUE(d.ended(3)) << bad;
    }
}

TEST_F(HttpDoor, bodies_stop_at_their_limit) {
    open();
    RawClient c(door->port());
    c.send("POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 200000000000\r\n\r\n");
    EXPECT_EQ(c.receive(2).status, 413);
    RawClient d(door->port());
    d.send("POST / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n");
    std::string chunk = "2000\r\n" + std::string(0x2000, 'x') + "\r\n";
    for (int i = 0; i < 40 && d.send(chunk); ++i) {
    }
    EXPECT_EQ(d.receive(3).status, 413) << "a chunked body";
    RawClient e(door->port());
    e.send("POST / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\nffffffffffffffff\r\n");
    EXPECT_EQ(e.receive(3).status, 413) << "one huge chunk";
}

TEST_F(HttpDoor, heads_stop_at_their_limit) {
    open();
    RawClient c(door->port());
    c.send("GET /" + std::string(9000, 'a') + " HTTP/1.1\r\nHost: a\r\n\r\n");
    EXPECT_EQ(c.receive(2).status, 414);
    RawClient d(door->port());
    d.send("GET / HTTP/1.1\r\nHost: a\r\nX: " + std::string(20000, 'a'));   // never ends
    EXPECT_EQ(d.receive(2).status, 431);
    RawClient e(door->port());
    std::string many = "GET / HTTP/1.1\r\nHost: a\r\n";
    for (int i = 0; i < 120; ++i) many += "X" + std::to_string(i) + ": y\r\n";
    e.send(many + "\r\n");
    EXPECT_EQ(e.receive(2).status, 431);
}

TEST_F(HttpDoor, idle_connections_block_nobody) {
    open();
    std::vector<std::unique_ptr<RawClient>> idle;
    for (int i = 0; i < 50; ++i) idle.push_back(std::make_unique<RawClient>(door->port()));
    idle[0]->ask("GET", "/");
    const double seconds = seconds_of([&] { EXPECT_EQ(get().status, 200); });
    EXPECT_LT(seconds, 0.3);
    EXPECT_TRUE(idle[1]->ended(3)) << "idle connections end after their time";
}

TEST_F(HttpDoor, a_byte_at_a_time_is_given_up) {
    open();
    RawClient c(door->port());
    const std::string request = "GET / HTTP/1.1\r\nHost: a\r\nX-Long-Header: aaaaaaaaaaaaaaaaaaaaaaaaaaaaa\r\n\r\n";
    const double seconds = seconds_of([&] {
        for (const char byte : request) {
            if (!c.send({&byte, 1})) break;
            if (c.ended(0.05)) break;
        }
    });
    EXPECT_LT(seconds, 3);
    RawClient d(door->port());
    d.send("POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 5000\r\n\r\nabc");
    EXPECT_EQ(d.receive(5).status, 408) << "a body that does not come";
    EXPECT_EQ(get().status, 200);
}

TEST_F(HttpDoor, a_client_that_never_reads_is_given_up) {
    open();
    RawClient c(door->port());
    c.send("GET /large HTTP/1.1\r\nHost: a\r\n\r\n");
    for (int i = 0; i < 60 && door->connections() > 0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_EQ(door->connections(), 0u);
}

TEST_F(HttpDoor, connections_are_limited) {
    limits.connections = 4;
    open();
    std::vector<std::unique_ptr<RawClient>> idle;
    for (int i = 0; i < 4; ++i) {
        idle.push_back(std::make_unique<RawClient>(door->port()));
        ASSERT_EQ(idle.back()->ask("GET", "/").status, 200);
    }
    RawClient c(door->port());
    c.send("GET / HTTP/1.1\r\nHost: a\r\n\r\n");
    const Answer a = c.receive(2);
    EXPECT_EQ(a.status, 503);
    EXPECT_EQ(a.headers.count("retry-after"), 1u);
    idle.clear();
    for (int i = 0; i < 40 && door->connections() > 0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(25));
    EXPECT_EQ(get().status, 200) << "places come free again";
}

TEST_F(HttpDoor, expect_continue) {
    open();
    RawClient c(door->port());
    c.send("POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 3\r\nExpect: 100-continue\r\n\r\n");
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    c.send("abc");
    EXPECT_EQ(c.receive(2).body, "POST 3 294") << "after 100 Continue";
    RawClient d(door->port());
    d.send("POST /ignore HTTP/1.1\r\nHost: a\r\nContent-Length: 3\r\nExpect: 100-continue\r\n\r\n");
    EXPECT_EQ(d.receive(2).body, "ignored") << "no body was asked for";
    EXPECT_TRUE(d.ended(3));
}

TEST_F(HttpDoor, an_unread_body_does_not_become_a_request) {
    open();
    RawClient c(door->port());
    const std::string inner = "GET /inner HTTP/1.1\r\nHost: a\r\n\r\n";
    c.send("POST /ignore HTTP/1.1\r\nHost: a\r\nContent-Length: " + std::to_string(inner.size()) + "\r\n\r\n" + inner);
    EXPECT_EQ(c.receive(2).body, "ignored");
    EXPECT_EQ(c.receive(1).status, 0);
}

TEST_F(HttpDoor, exceptions_leak_nothing) {
    open();
    RawClient c(door->port());
    c.send("GET /boom HTTP/1.1\r\nHost: a\r\n\r\n");
    const Answer a = c.receive(2);
    EXPECT_EQ(a.status, 500);
    EXPECT_EQ(a.body.find("secret"), std::string::npos);
    for (const auto& [name, value] : a.headers) EXPECT_EQ(value.find("secret"), std::string::npos) << name;
}

TEST_F(HttpDoor, a_client_that_hangs_up_is_noticed) {
    open();
    {
        RawClient c(door->port());
        c.send("GET /slow HTTP/1.1\r\nHost: a\r\n\r\n");
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    for (int i = 0; i < 40 && !gone; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(25));
    EXPECT_EQ(gone, 1);
}

TEST_F(HttpDoor, stopping_finishes_what_runs) {
    open();
    RawClient busy(door->port()), idle(door->port());
    idle.ask("GET", "/");
    busy.send("GET /slow HTTP/1.1\r\nHost: a\r\n\r\n");
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    const int port = door->port();
    std::thread stopper([&] { EXPECT_TRUE(door->stop(5)); });
    EXPECT_EQ(busy.receive(3).status, 200);
    stopper.join();
    EXPECT_TRUE(idle.ended(1));
    EXPECT_FALSE(RawClient(port).connected());
}

TEST_F(HttpDoor, many_at_once) {
    open();
    std::atomic<int> good{0};
    std::vector<std::thread> threads;
    for (int t = 0; t < 16; ++t)
        threads.emplace_back([&] {
            RawClient c(door->port());
            for (int i = 0; i < 50; ++i) good += c.ask("POST", "/", std::string(i * 37, 'a')).status == 200;
        });
    for (auto& t : threads) t.join();
    EXPECT_EQ(good, 800);
}

TEST_F(HttpDoor, unix_socket) {
    const std::string path = ::testing::TempDir() + "alder_door_test.sock";
    door = std::make_unique<Door>(limits, [this](Request& r) { return handle(r); });
    ASSERT_EQ(door->listen("unix:" + path), "");
    door->start();
    Door second(limits, [this](Request& r) { return handle(r); });
    EXPECT_NE(second.listen("unix:/nonexistent/folder/a.sock"), "");
    door.reset();
    EXPECT_NE(::access(path.c_str(), F_OK), 0) << "removed at the end";
}

TEST(HttpDoorAddress, loopback) {
    for (const char* own : {"127.0.0.1:1", "127.3.4.5:1", "[::1]:1", "localhost:1", "unix:/a"}) EXPECT_TRUE(Door::is_loopback(own)) << own;
    for (const char* other : {"0.0.0.0:1", "[::]:1", "192.168.1.1:1", "example.org:1", "127.0.0.1", "::1:1"}) EXPECT_FALSE(Door::is_loopback(other)) << other;
}

TEST(HttpDoorAddress, ids_sort_by_time) {
    const std::string a = time_sorted_id();
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
    const std::string b = time_sorted_id();
    EXPECT_LT(a, b);
    EXPECT_EQ(a.size(), 26u);
    EXPECT_EQ(a.find_first_not_of("0123456789abcdefghijklmnopqrstuvwxyz"), std::string::npos);
}

}  // namespace
}  // namespace alder::http
