// The service as a client sees it: methods, types, errors, limits, access, evaluation and validation.
#include "server/service.h"

#include <fstream>
#include <thread>

#include "server/build_id.h"
#include "server/digest.h"
#include "tests/server/daemon_fixture.h"

namespace alder {
namespace {

using nlohmann::json;

class ServiceTest : public test::DaemonTest {};

TEST_F(ServiceTest, health_pages_answer) {
    start();
    EXPECT_EQ(ask("GET", "/livez").status, 200);
    EXPECT_TRUE(json_of(ask("GET", "/readyz"))["ready"].get<bool>());
    EXPECT_EQ(json_of(ask("GET", "/v1/version"))["version"], ALDER_VERSION);
    EXPECT_NE(build_id(), "unknown");
    EXPECT_EQ(ask("GET", "/").headers.at("location"), "/ui");
    const auto home = ask("GET", "/about");
    EXPECT_EQ(home.status, 200);
    EXPECT_EQ(home.headers.at("content-type"), "text/html; charset=utf-8");
    EXPECT_EQ(home.headers.at("alder-request-id").size(), 26u);
    const std::string metrics = ask("GET", "/metrics").body;
    EXPECT_NE(metrics.find("alder_http_requests_total{route=\"/livez\",method=\"GET\",code=\"200\"} 1"), std::string::npos);
    EXPECT_EQ(metrics.substr(metrics.size() - 6), "# EOF\n");
}

TEST_F(ServiceTest, every_error_kind_has_its_page) {
    start();
    std::set<std::string> seen;
    for (const ErrorKind& kind : error_kinds()) {
        EXPECT_TRUE(seen.insert(kind.type).second) << kind.type << " twice";
        EXPECT_EQ(ask("GET", std::string("/problems/") + kind.type).status, 200) << kind.type;
        EXPECT_GE(kind.status, 400);
        EXPECT_LT(kind.status, 600);
    }
    EXPECT_EQ(problem_of(ask("GET", "/problems/nonsense")), "404 not-found");
}

TEST_F(ServiceTest, methods_paths_and_types_are_refused_by_the_book) {
    start();
    const auto wrong = ask("DELETE", "/v1/nodes");
    EXPECT_EQ(problem_of(wrong), "405 method");
    EXPECT_EQ(wrong.headers.at("allow"), "GET, HEAD, OPTIONS");
    EXPECT_EQ(wrong.headers.at("content-type"), "application/problem+json");
    EXPECT_EQ(problem_of(ask("TRACE", "/v1/nodes")), "405 method");
    EXPECT_EQ(problem_of(ask("GET", "/v1/nodes/")), "404 not-found");
    EXPECT_EQ(problem_of(ask("GET", "/v2/nodes")), "404 not-found");
    EXPECT_EQ(problem_of(ask("GET", "/v1/preview")), "405 method");
    const auto options = ask("OPTIONS", "/v1/assets/x");
    EXPECT_EQ(options.status, 204);
    EXPECT_EQ(options.headers.at("allow"), "GET, HEAD, PUT, DELETE, OPTIONS");
    const auto head = ask("HEAD", "/v1/version");
    EXPECT_EQ(head.status, 200);
    EXPECT_TRUE(head.body.empty());
    EXPECT_EQ(problem_of(ask("POST", "/v1/evaluate", "{}", "Content-Type: text/plain\r\n")), "415 media-type");
    EXPECT_EQ(problem_of(ask("POST", "/v1/evaluate", "{}", "Content-Type: application/json\r\nContent-Encoding: gzip\r\n")), "415 media-type");
    EXPECT_EQ(problem_of(post("/v1/evaluate", json::object(), "Accept: image/png\r\n")), "406 not-acceptable");
    EXPECT_EQ(problem_of(post("/v1/preview", json::object(), "Accept: text/html;q=0.9, image/png;q=0\r\n")), "406 not-acceptable");
}

TEST_F(ServiceTest, json_is_read_strictly) {
    start();
    const auto raw = [&](const std::string& body) { return ask("POST", "/v1/evaluate", body, "Content-Type: application/json\r\n"); };
    const auto bad = raw("{\"graph\": {},\n  \"points\": }");
    EXPECT_EQ(problem_of(bad), "400 malformed-json");
    EXPECT_EQ(json_of(bad)["line"], 2);
    EXPECT_EQ(json_of(bad)["column"], 13);
    EXPECT_EQ(problem_of(raw("")), "400 malformed-json");
    EXPECT_EQ(problem_of(raw("{\"a\": NaN}")), "400 malformed-json");
    EXPECT_EQ(problem_of(raw("{\"a\": 1e999}")), "400 malformed-json");
    EXPECT_EQ(problem_of(raw("{\"a\": \"\xff\"}")), "400 malformed-json");
    EXPECT_EQ(problem_of(raw("{} x")), "400 malformed-json");
    const auto twice = raw("{\"graph\": {\"nodes\": {\"a\": 1, \"a\": 2}}}");
    EXPECT_EQ(problem_of(twice), "400 duplicate-key");
    EXPECT_EQ(json_of(twice)["errors"][0]["pointer"], "/graph/nodes/a");
    EXPECT_EQ(problem_of(raw("{\"a\": " + std::string(64, '[') + std::string(64, ']') + "}")), "422 limit-exceeded");
    EXPECT_EQ(problem_of(raw("[1]")), "422 request-invalid");
    EXPECT_EQ(problem_of(raw("{\"a\": 0." + std::string(100, '1') + "}")), "422 limit-exceeded");
}

TEST_F(ServiceTest, bodies_are_limited) {
    options.limits.body_bytes = 5000;
    start();
    const auto a = ask("POST", "/v1/evaluate", "\"" + std::string(6000, 'a') + "\"", "Content-Type: application/json\r\n");
    EXPECT_EQ(problem_of(a), "413 body-too-large");
    EXPECT_EQ(json_of(a)["limit"], 5000);
    EXPECT_EQ(json_of(a)["limit_option"], "--max-body");
}

TEST_F(ServiceTest, evaluates) {
    start();
    const auto a = post("/v1/evaluate", {{"graph", remap_graph(2)}, {"points", {{"count", 3}, {"attributes", {{"x", {0.25, 0.5, 0.75}}}}}}, {"outputs", {"r"}}});
    ASSERT_EQ(a.status, 200) << a.body;
    const json values = json_of(a)["outputs"]["r"];
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(values[i].get<double>(), 0.5 * i, 1e-6);
    EXPECT_EQ(json_of(a)["stats"]["points"], 3);
}

TEST_F(ServiceTest, all_faults_at_once_with_the_nearest_names) {
    start();
    json graph = remap_graph();
    graph["nodes"]["r"]["params"]["RMPgian"] = 1;
    graph["nodes"]["q"] = {{"type", "alRemapFlot"}};
    const auto a = post("/v1/evaluate", {{"graph", graph}, {"points", {{"count", 1}}}, {"outputs", {"r"}}});
    EXPECT_EQ(problem_of(a), "422 request-invalid");
    std::map<std::string, std::string> suggestions;
    for (const auto& e : errors_of(a)) suggestions[e["pointer"]] = e.value("suggest", "");
    EXPECT_EQ(suggestions["/graph/nodes/r/params/RMPgian"], "RMPgain");
    EXPECT_EQ(suggestions["/graph/nodes/q/type"], "alRemapFloat");
}

TEST_F(ServiceTest, validation_reports_instead_of_refusing) {
    start();
    const auto good = json_of(post("/v1/graphs/validate", {{"graph", surface_graph()}}));
    EXPECT_TRUE(good["ok"].get<bool>()) << good;
    EXPECT_EQ(good["compiled"]["nodes"], 1);
    EXPECT_FALSE(good["compiled"]["closures"].empty());
    json graph = remap_graph();
    graph["nodes"]["r"]["params"]["RMPgian"] = 1;
    const auto bad = json_of(post("/v1/graphs/validate", {{"graph", graph}}));
    EXPECT_FALSE(bad["ok"].get<bool>());
    EXPECT_EQ(bad["errors"][0]["pointer"], "/graph/nodes/r/params/RMPgian");
    const auto lenient = json_of(post("/v1/graphs/validate", {{"graph", graph}, {"lenient", true}}));
    EXPECT_TRUE(lenient["ok"].get<bool>()) << lenient;
    EXPECT_EQ(lenient["warnings"].size(), 1u);
    EXPECT_EQ(problem_of(post("/v1/graphs/validate", {{"grap", graph}})), "422 request-invalid");
}

TEST_F(ServiceTest, the_catalogue_lists_every_node) {
    start();
    const auto a = ask("GET", "/v1/nodes");
    const json list = json_of(a)["items"];
    ASSERT_EQ(list.size(), all_nodes().size());
    for (const auto& node : list) {
        EXPECT_FALSE(node["name"].get<std::string>().empty());
        EXPECT_FALSE(node["outputs"].empty()) << node["name"];
        for (const auto& p : node["params"])
            if (p["type"] == "enum") {
                bool found = false;
                for (const auto& item : p["enum"]) found = found || item["name"] == p["default"];
                EXPECT_TRUE(found) << node["name"] << "." << p["name"] << ": the default is not among the items";
            }
    }
    EXPECT_EQ(ask("GET", "/v1/nodes", "", "If-None-Match: " + a.headers.at("etag") + "\r\n").status, 304);
    const auto one = json_of(ask("GET", "/v1/nodes/alRemapFloat"));
    EXPECT_EQ(one["system"], "alshaders");
    EXPECT_EQ(one["params"][0]["name"], "input");
    EXPECT_EQ(json_of(ask("GET", "/v1/nodes/alRemapFlot"))["suggest"], "alRemapFloat");
    EXPECT_LT(ask("GET", "/v1/nodes?view=summary").body.size(), a.body.size() / 4);
    EXPECT_EQ(problem_of(ask("GET", "/v1/nodes?vew=summary")), "400 malformed-request");
}

TEST_F(ServiceTest, web_pages_cannot_reach_a_loopback_daemon) {
    start();
    test::RawClient c(daemon->port());
    c.send("GET /v1/version HTTP/1.1\r\nHost: evil.example\r\n\r\n");
    EXPECT_EQ(problem_of(c.receive()), "421 host-refused");
    test::RawClient absolute(daemon->port());
    absolute.send("GET http://evil.example/v1/version HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_EQ(problem_of(absolute.receive()), "421 host-refused");
    EXPECT_EQ(problem_of(ask("GET", "/v1/version", "", "Origin: http://evil.example\r\n")), "403 origin-refused");
    EXPECT_EQ(problem_of(ask("GET", "/v1/version", "", "Origin: null\r\n")), "403 origin-refused");
    EXPECT_EQ(ask("GET", "/v1/version", "", "Origin: http://localhost\r\n").status, 200);
}

TEST_F(ServiceTest, allowed_origins_may_read) {
    options.allowed_origins = {"https://look.example"};
    start();
    const auto a = ask("GET", "/v1/version", "", "Origin: https://look.example\r\n");
    EXPECT_EQ(a.status, 200);
    EXPECT_EQ(a.headers.at("access-control-allow-origin"), "https://look.example");
    const auto preflight = ask("OPTIONS", "/v1/preview", "", "Origin: https://look.example\r\nAccess-Control-Request-Method: POST\r\n");
    EXPECT_EQ(preflight.status, 204);
    EXPECT_NE(preflight.headers.at("access-control-allow-methods").find("POST"), std::string::npos);
}

TEST_F(ServiceTest, loopback_hosts) {
    for (const char* own : {"localhost", "LOCALHOST:7420", "a.localhost:1", "127.0.0.1", "127.9.9.9:80", "[::1]", "[::1]:80"}) EXPECT_TRUE(is_loopback_host(own)) << own;
    for (const char* other : {"", "example.org", "localhost.example.org", "127.0.0.1.example.org", "0.0.0.0", "[::2]", "10.0.0.1:7420"}) EXPECT_FALSE(is_loopback_host(other)) << other;
}

TEST_F(ServiceTest, tokens_and_scopes) {
    std::filesystem::create_directories(folder);
    options.token_file = folder + "/tokens";
    std::ofstream(options.token_file) << "# people\nann:read,render:" << sha256_hex("ann's token") << "\nbob:read:" << sha256_hex("bob's token") << ":quota=3\n";
    start();
    EXPECT_EQ(ask("GET", "/livez").status, 200) << "health needs no token";
    const auto none = ask("GET", "/v1/version");
    EXPECT_EQ(problem_of(none), "401 token-missing");
    EXPECT_EQ(none.headers.at("www-authenticate"), "Bearer");
    EXPECT_EQ(problem_of(ask("GET", "/v1/version", "", "Authorization: Bearer wrong\r\n")), "401 token-invalid");
    EXPECT_EQ(problem_of(ask("GET", "/nowhere")), "401 token-missing") << "what is there is nobody's business";
    EXPECT_EQ(ask("GET", "/v1/version", "", "Authorization: Bearer bob's token\r\n").status, 200);
    const json request = {{"graph", remap_graph()}, {"points", {{"count", 1}}}, {"outputs", {"r"}}};
    EXPECT_EQ(problem_of(post("/v1/evaluate", request, "Authorization: Bearer bob's token\r\n")), "403 scope-missing");
    EXPECT_EQ(post("/v1/evaluate", request, "Authorization: bearer ann's token\r\n").status, 200);

    std::ofstream(options.token_file) << "broken line\n";
    EXPECT_NE(daemon->service().access.reload(), "") << "a wrong file changes nothing";
    EXPECT_EQ(ask("GET", "/v1/version", "", "Authorization: Bearer bob's token\r\n").status, 200);
    std::ofstream(options.token_file) << "cleo:admin:" << sha256_hex("cleo's token") << "\n";
    EXPECT_EQ(daemon->service().access.reload(), "");
    EXPECT_EQ(problem_of(ask("GET", "/v1/version", "", "Authorization: Bearer bob's token\r\n")), "401 token-invalid");
    EXPECT_EQ(ask("GET", "/v1/version", "", "Authorization: Bearer cleo's token\r\n").status, 200);
}

TEST_F(ServiceTest, refuses_to_be_reachable_without_tokens) {
    options.listen = "0.0.0.0:0";
    Daemon open(options);
    const auto error = open.start();
    ASSERT_TRUE(error.has_value());
    EXPECT_EQ(error->exit_status, 2);
    EXPECT_NE(error->sentence.find("--token-file"), std::string::npos);
}

TEST_F(ServiceTest, one_daemon_a_data_folder) {
    start();
    Daemon second(options);
    const auto error = second.start();
    ASSERT_TRUE(error.has_value());
    EXPECT_EQ(error->exit_status, 2);
}

TEST_F(ServiceTest, draining_takes_no_new_work) {
    start();
    daemon->service().draining = true;
    const auto a = post("/v1/evaluate", {{"graph", remap_graph()}, {"points", {{"count", 1}}}, {"outputs", {"r"}}});
    EXPECT_EQ(problem_of(a), "503 draining");
    EXPECT_EQ(a.headers.count("retry-after"), 1u);
    EXPECT_EQ(ask("GET", "/readyz").status, 503);
    EXPECT_EQ(ask("GET", "/livez").status, 200);
}

TEST_F(ServiceTest, head_faults_are_problems_too) {
    start();
    test::RawClient c(daemon->port());
    c.send("GET /" + std::string(9000, 'a') + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_EQ(problem_of(c.receive()), "414 uri-too-long");
    test::RawClient d(daemon->port());
    d.send("GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1\r\nTransfer-Encoding: chunked\r\n\r\n");
    const auto a = d.receive();
    EXPECT_EQ(problem_of(a), "400 malformed-request");
    EXPECT_EQ(a.headers.at("connection"), "close");
}

TEST_F(ServiceTest, files_only_below_an_asset_root_and_through_no_link) {
    namespace fs = std::filesystem;
    fs::create_directories(folder + "/root/sub");
    std::ofstream(folder + "/root/sub/a.txt") << "a";
    std::ofstream(folder + "/secret.txt") << "s";
    fs::create_symlink(folder + "/secret.txt", folder + "/root/link.txt");
    fs::create_directory_symlink(folder, folder + "/root/up");
    options.asset_roots = {folder + "/root"};
    start();
    const Engine& engine = daemon->service().engine;
    std::string error;
    EXPECT_NE(engine.resolve_file("sub/a.txt", error), "");
    EXPECT_NE(engine.resolve_file("sub/../sub/a.txt", error), "") << "dots that stay inside";
    for (const char* bad : {"link.txt", "up/secret.txt", "../secret.txt", "sub/../../secret.txt", "/etc/passwd", "", "sub", "nothing", "sub/a.txt/"})
        EXPECT_EQ(engine.resolve_file(bad, error), "") << bad;
}

TEST_F(ServiceTest, a_full_lane_says_so_and_a_vanished_client_frees_its_place) {
    options.queue = 1;
    start();
    Service& s = daemon->service();
    Lane lane("test", 1, 1);
    std::atomic<bool> go{false}, cancelled{false};
    const auto running = lane.submit([&](const std::atomic<bool>& cancel) {
        while (!go && !cancel) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        cancelled = cancel.load();
    });
    ASSERT_TRUE(running);
    while (lane.running() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const auto waiting = lane.submit([](const std::atomic<bool>&) {});
    ASSERT_TRUE(waiting);
    http::Request request;
    try {
        s.run(lane, request, 0, [](const std::atomic<bool>&) {});
        FAIL() << "the queue was full";
    } catch (const Problem& p) {
        EXPECT_EQ(p.type, "queue-full");
        EXPECT_EQ(p.headers[0].first, "Retry-After");
    }
    running->cancel = true;
    EXPECT_TRUE(waiting->wait(5));
    EXPECT_TRUE(cancelled);
    request.client_gone = [] { return true; };
    bool stopped = false;
    EXPECT_THROW(s.run(lane, request, 0,
                       [&](const std::atomic<bool>& cancel) {
                           for (int i = 0; i < 2000 && !cancel; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
                           stopped = cancel;
                       }),
                 Problem);
    EXPECT_TRUE(stopped);
}

}  // namespace
}  // namespace alder
