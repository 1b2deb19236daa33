// Renders as jobs: accepted once, rendered by a worker that may die, the same bits in the end.
#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include "render/image/exr.h"
#include "server/digest.h"
#include "server/jobs/files.h"
#include "tests/server/daemon_fixture.h"

namespace alder {
namespace {

using nlohmann::json;

class RendersTest : public test::DaemonTest {
  protected:
    RendersTest() {
        options.checkpoint_seconds = 0;
        options.checkpoint_fraction = 0.02;
    }
    static json document() {
        return {{"alder_scene", 1},
                {"cameras", {{"cam", {{"look_at", {{"from", {0, -5, 1}}, {"to", {0, 0, 1}}}}, {"fov_degrees", 40}}}, {"near", {{"look_at", {{"from", {0, -3, 1}}, {"to", {0, 0, 1}}}}, {"fov_degrees", 40}}}}},
                {"camera", "cam"},
                {"materials", {{"red", surface_graph()}}},
                {"meshes", {{"tri", {{"positions", {{-1, 0, 0}, {1, 0, 0}, {0, 0, 2}}}, {"triangles", {{0, 1, 2}}}}}}},
                {"instances", {{"a", {{"mesh", "tri"}, {"material", "red"}}}}},
                {"lights", {{"sun", {{"type", "sun"}, {"strength", 3}, {"angle_degrees", 20}}}}}};
    }
    std::string scene() {
        const auto a = post("/v1/scenes", document());
        EXPECT_EQ(a.status, 201) << a.body;
        return a.status == 201 ? json_of(a)["id"].get<std::string>() : "";
    }
    json submit(const json& body, const std::string& headers = {}) {
        const auto a = post("/v1/renders", body, headers);
        EXPECT_EQ(a.status, 202) << a.body;
        return json_of(a);
    }
    json read(const std::string& id) { return json_of(ask("GET", "/v1/renders/" + id)); }
    json until(const std::string& id, const std::function<bool(const json&)>& enough, double seconds = 60) {
        const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
        json j;
        do {
            j = read(id);
            if (enough(j)) return j;
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        } while (std::chrono::steady_clock::now() < end);
        ADD_FAILURE() << "not within " << seconds << " s: " << j;
        return j;
    }
    json ended(const std::string& id) {
        return until(id, [](const json& j) { return j["state"] == "succeeded" || j["state"] == "failed" || j["state"] == "cancelled"; });
    }
    static std::string digest_of(const json& render) { return render["outputs"].size() == 1 ? render["outputs"][0]["digest"].get<std::string>() : "none: " + render.dump(); }
    /// Long enough to be met while it renders, short enough for a test.
    static json long_render(const std::string& scene, int samples = 2048) { return {{"scene", scene}, {"samples", samples}, {"resolution", {64, 64}}}; }
    pid_t worker() const { return daemon->service().renders.worker_pid(); }
};

TEST_F(RendersTest, accepted_rendered_and_fetched) {
    start();
    const auto made = post("/v1/renders", {{"scene", scene()}, {"samples", 4}, {"resolution", {32, 24}}, {"labels", {{"shot", "sq10"}}}, {"output", {{"name", "x.%04d"}}}, {"frame", 7}});
    ASSERT_EQ(made.status, 202) << made.body;
    EXPECT_EQ(made.headers.at("retry-after"), "1");
    const std::string id = json_of(made)["id"];
    EXPECT_EQ(made.headers.at("location"), "/v1/renders/" + id);
    const json done = ended(id);
    ASSERT_EQ(done["state"], "succeeded") << done;
    EXPECT_EQ(done["progress"]["fraction"], 1);
    EXPECT_EQ(done["progress"]["samples"], 4);
    EXPECT_EQ(done["attempt"], 1);
    ASSERT_EQ(done["outputs"].size(), 1u);
    EXPECT_EQ(done["outputs"][0]["file"], "x.0007.exr");
    const std::string path = "/v1/renders/" + id + "/outputs/x.0007.exr";
    const auto file = ask("GET", path);
    ASSERT_EQ(file.status, 200) << file.body;
    EXPECT_EQ("sha256:" + sha256_hex(file.body), digest_of(done));
    EXPECT_EQ(file.headers.at("etag"), "\"" + digest_of(done) + "\"");
    EXPECT_EQ(file.headers.at("content-digest"), digest_header(sha256_hex(file.body)));
    const auto part = ask("GET", path, "", "Range: bytes=10-19\r\n");
    EXPECT_EQ(part.status, 206);
    EXPECT_EQ(part.body, file.body.substr(10, 10));
    EXPECT_EQ(ask("GET", path, "", "If-None-Match: " + file.headers.at("etag") + "\r\n").status, 304);
    EXPECT_EQ(problem_of(ask("GET", path, "", "Range: bytes=99999999-\r\n")), "416 range");
    EXPECT_EQ(problem_of(ask("GET", "/v1/renders/" + id + "/outputs/..%2Fcheckpoint")), "404 not-found");
    EXPECT_EQ(json_of(ask("GET", "/v1/renders/" + id + "/outputs"))["items"].size(), 1u);
    EXPECT_NE(ask("GET", "/v1/renders/" + id + "/log").body.find("succeeded"), std::string::npos);
    EXPECT_EQ(json_of(ask("GET", "/v1/renders/" + id + "/stats"))["stats"]["samples"], 4);
    const auto png = ask("GET", "/v1/renders/" + id + "/snapshot.png");
    EXPECT_EQ(png.body.substr(1, 3), "PNG");
    EXPECT_EQ(ask("DELETE", "/v1/renders/" + id).status, 204);
    EXPECT_EQ(problem_of(ask("GET", "/v1/renders/" + id)), "404 not-found");
    EXPECT_FALSE(std::filesystem::exists(folder + "/renders/" + id));
}

TEST_F(RendersTest, idempotency_keys) {
    start();
    const json body = {{"scene", scene()}, {"samples", 2}, {"resolution", {16, 16}}};
    const auto first = post("/v1/renders", body, "Idempotency-Key: \"k1\"\r\n");
    ASSERT_EQ(first.status, 202);
    ended(json_of(first)["id"]);
    const auto again = post("/v1/renders", body, "Idempotency-Key: \"k1\"\r\n");
    EXPECT_EQ(again.status, 202);
    EXPECT_EQ(again.body, first.body) << "byte for byte, whatever has become of the render";
    EXPECT_EQ(again.headers.at("idempotency-replayed"), "true");
    const auto waited = post("/v1/renders", body, "Idempotency-Key: \"k1\"\r\nPrefer: wait=30\r\nAccept: image/x-exr\r\n");
    EXPECT_EQ(waited.status, 200);
    EXPECT_EQ(waited.headers.at("location"), first.headers.at("location"));
    json other = body;
    other["samples"] = 3;
    EXPECT_EQ(problem_of(post("/v1/renders", other, "Idempotency-Key: \"k1\"\r\n")), "422 idempotency-key-reused");
    EXPECT_EQ(problem_of(post("/v1/renders", body, "Idempotency-Key: " + std::string(256, 'k') + "\r\n")), "400 malformed-request");
    ASSERT_TRUE(daemon->service().renders.begin_key("", "\"k2\""));
    EXPECT_EQ(problem_of(post("/v1/renders", body, "Idempotency-Key: \"k2\"\r\n")), "409 idempotency-in-progress");
    EXPECT_EQ(json_of(ask("GET", "/v1/renders"))["items"].size(), 1u);
}

TEST_F(RendersTest, an_equal_render_is_answered_from_the_first) {
    start();
    const std::string s = scene();
    const json body = {{"scene", s}, {"samples", 8}, {"resolution", {32, 32}}};
    const std::string wait = "Prefer: wait=60\r\nAccept: image/x-exr\r\n";
    const auto a = post("/v1/renders", body, wait);
    ASSERT_EQ(a.status, 200) << a.body;
    EXPECT_EQ(a.headers.count("alder-cache"), 0u);
    json renamed = body;
    renamed["labels"] = {{"other", "label"}};
    renamed["priority"] = 3;
    const auto b = post("/v1/renders", renamed, wait);
    EXPECT_EQ(b.headers.at("alder-cache"), "hit");
    EXPECT_EQ(b.headers.at("etag"), a.headers.at("etag"));
    EXPECT_EQ(b.body, a.body);
    EXPECT_NE(b.headers.at("location"), a.headers.at("location"));
    EXPECT_EQ(ask("DELETE", a.headers.at("location")).status, 204);
    EXPECT_EQ(ask("GET", b.headers.at("location") + "/outputs/frame.exr").body, a.body) << "each has its own name for the file";
    const auto fresh = post("/v1/renders", body, wait + "Cache-Control: no-cache\r\n");
    EXPECT_EQ(fresh.headers.count("alder-cache"), 0u);
    EXPECT_EQ(fresh.body, a.body) << "rendered again: the same file";
    json seeded = body;
    seeded["seed"] = 9;
    EXPECT_NE(post("/v1/renders", seeded, wait).headers.at("etag"), a.headers.at("etag"));
}

TEST_F(RendersTest, frames_overrides_and_cameras) {
    start();
    const std::string s = scene();
    const json plain = {{"scene", s}, {"samples", 4}, {"resolution", {24, 24}}};
    const json base = ended(submit(plain)["id"]);
    json body = plain;
    body["frames"] = "1-3";
    const json frames = ended(submit(body)["id"]);
    ASSERT_EQ(frames["outputs"].size(), 3u) << frames;
    EXPECT_EQ(frames["outputs"][2]["file"], "frame.0003.exr");
    EXPECT_NE(frames["outputs"][0]["digest"], frames["outputs"][1]["digest"]) << "noise of its own";
    body = plain;
    body["overrides"] = {{{"op", "replace"}, {"path", "/materials/red/nodes/s/params/diffuseColor"}, {"value", {0.0, 1.0, 0.0}}}};
    const json green = ended(submit(body)["id"]);
    EXPECT_NE(digest_of(green), digest_of(base));
    EXPECT_EQ(digest_of(ended(submit(plain, "Cache-Control: no-cache\r\n")["id"])), digest_of(base)) << "the scene itself is as it was";
    body["overrides"][0]["path"] = "/lights/sun/strength";
    body["overrides"][0]["value"] = 6;
    const json brighter = ended(submit(body)["id"]);
    EXPECT_NE(digest_of(brighter), digest_of(base));
    body["overrides"][0]["path"] = "/materials/red/nodes/q/params/x";
    EXPECT_EQ(problem_of(post("/v1/renders", body)), "422 settings-invalid");
    body["overrides"][0] = {{"op", "add"}, {"path", "/materials/red/nodes/s/params/diffuseColr"}, {"value", 1}};
    const auto wrong = post("/v1/renders", body);
    EXPECT_EQ(problem_of(wrong), "422 graph-invalid");
    EXPECT_EQ(json_of(wrong)["errors"][0]["suggest"], "diffuseColor");
    body = plain;
    body["camera"] = "near";
    EXPECT_NE(digest_of(ended(submit(body)["id"])), digest_of(base));
    body["camera"] = "nera";
    const auto lost = post("/v1/renders", body);
    EXPECT_EQ(json_of(lost)["errors"][0]["suggest"], "near") << lost.body;
}

TEST_F(RendersTest, lists_filters_and_pages) {
    start();
    const std::string s = scene();
    for (int i = 0; i < 5; ++i) submit({{"scene", s}, {"samples", 1}, {"resolution", {8, 8}}, {"seed", i + 1}, {"labels", {{"shot", i % 2 ? "odd" : "even"}}}});
    const json page = json_of(ask("GET", "/v1/renders?limit=2"));
    ASSERT_EQ(page["items"].size(), 2u);
    const json rest = json_of(ask("GET", "/v1/renders?limit=1000&cursor=" + page["next"].get<std::string>()));
    EXPECT_EQ(rest["items"].size(), 3u);
    EXPECT_TRUE(rest["next"].is_null());
    EXPECT_LT(rest["items"][0]["id"], page["items"][1]["id"]);
    EXPECT_EQ(json_of(ask("GET", "/v1/renders?label.shot=odd"))["items"].size(), 2u);
    EXPECT_EQ(json_of(ask("GET", "/v1/renders?state=paused"))["items"].size(), 0u);
    for (const char* bad : {"limit=0", "limit=x", "state=done", "cursor=1", "page=2"}) EXPECT_EQ(problem_of(ask("GET", std::string("/v1/renders?") + bad)), "400 malformed-request") << bad;
}

TEST_F(RendersTest, cancel_pause_resume_and_priorities) {
    start();
    const std::string s = scene();
    const json reference = ended(submit(long_render(s), "Cache-Control: no-cache\r\n")["id"]);
    const std::string id = submit(long_render(s), "Cache-Control: no-cache\r\n")["id"];
    until(id, [](const json& j) { return j["progress"]["samples"] > 0; });
    EXPECT_EQ(json_of(ask("GET", "/v1/renders?state=rendering"))["items"].size(), 1u);
    const json paused = json_of(ask("POST", "/v1/renders/" + id + "/pause"));
    EXPECT_EQ(paused["state"], "paused");
    EXPECT_TRUE(paused["reason"].is_null());
    // While it is paused another goes first, though it is worth less.
    EXPECT_EQ(ended(submit({{"scene", s}, {"samples", 1}, {"resolution", {8, 8}}, {"priority", 0}})["id"])["state"], "succeeded");
    EXPECT_EQ(json_of(ask("POST", "/v1/renders/" + id + "/resume"))["state"], "queued");
    const json done = ended(id);
    EXPECT_EQ(done["attempt"], 2);
    EXPECT_EQ(digest_of(done), digest_of(reference)) << "as if nothing had happened";
    EXPECT_NE(ask("GET", "/v1/renders/" + id + "/log").body.find("goes on after"), std::string::npos);
    EXPECT_EQ(problem_of(ask("POST", "/v1/renders/" + id + "/cancel")), "409 state-conflict");

    const std::string gone = submit(long_render(s, 1 << 20))["id"];
    until(gone, [](const json& j) { return j["state"] == "rendering"; });
    const auto start_of_cancel = std::chrono::steady_clock::now();
    EXPECT_EQ(json_of(ask("POST", "/v1/renders/" + gone + "/cancel"))["state"], "cancelled");
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start_of_cancel).count(), 2);
    EXPECT_EQ(json_of(ask("POST", "/v1/renders/" + gone + "/cancel"))["state"], "cancelled") << "twice is as once";
    EXPECT_EQ(problem_of(ask("POST", "/v1/renders/" + gone + "/resume")), "409 state-conflict");

    // A higher priority does not wait for what is running.
    const std::string slow = submit(long_render(s, 1 << 20))["id"];
    until(slow, [](const json& j) { return j["state"] == "rendering"; });
    EXPECT_EQ(ended(submit({{"scene", s}, {"samples", 1}, {"resolution", {8, 8}}, {"seed", 3}, {"priority", 90}})["id"])["state"], "succeeded");
    EXPECT_NE(read(slow)["state"], "succeeded");
    EXPECT_EQ(ask("DELETE", "/v1/renders/" + slow).status, 204) << "also while it runs";
    EXPECT_EQ(problem_of(ask("GET", "/v1/renders/" + slow)), "404 not-found");
}

TEST_F(RendersTest, more_samples_go_on_from_what_is_there) {
    start();
    const std::string s = scene();
    const std::string id = submit({{"scene", s}, {"samples", 100}, {"resolution", {32, 32}}})["id"];
    const json first = ended(id);
    const auto patch = [&](const json& body, const std::string& headers = {}) { return ask("PATCH", "/v1/renders/" + id, body.dump(), "Content-Type: application/merge-patch+json\r\n" + headers); };
    EXPECT_EQ(problem_of(patch({{"samples", 50}})), "422 settings-invalid");
    EXPECT_EQ(problem_of(patch({{"priority", 5}}, "If-Match: \"0\"\r\n")), "412 etag-mismatch");
    const json labelled = json_of(patch({{"labels", {{"a", "b"}}}, {"retain", 60}}));
    EXPECT_EQ(labelled["state"], "succeeded");
    EXPECT_EQ(labelled["labels"]["a"], "b");
    const auto raised = patch({{"samples", 200}});
    ASSERT_EQ(raised.status, 200) << raised.body;
    const json more = until(id, [](const json& j) { return j["state"] == "succeeded" && j["progress"]["samples"] == 200; });
    const json whole = ended(submit({{"scene", s}, {"samples", 200}, {"resolution", {32, 32}}}, "Cache-Control: no-cache\r\n")["id"]);
    EXPECT_EQ(digest_of(more), digest_of(whole)) << "the bits of a render of 200";
    EXPECT_NE(digest_of(more), digest_of(first));
    EXPECT_NE(ask("GET", "/v1/renders/" + id + "/log").body.find("goes on after 100 samples"), std::string::npos);
    std::filesystem::remove(folder + "/renders/" + id + "/checkpoint");
    EXPECT_EQ(problem_of(patch({{"samples", 300}})), "409 not-resumable");
}

TEST_F(RendersTest, a_killed_worker_costs_one_attempt) {
    start();
    const std::string s = scene();
    const json reference = ended(submit(long_render(s))["id"]);
    const std::string id = submit(long_render(s), "Cache-Control: no-cache\r\n")["id"];
    for (int kill = 0; kill < 3; ++kill) {
        // Each attempt gets beyond a checkpoint: that is what keeps three of them from failing the render.
        const json j = until(id, [&](const json& r) { return (r["attempt"] == kill + 1 && r["progress"]["samples"] > 300 * (kill + 1) && r["state"] == "rendering") || r["state"] == "succeeded"; });
        if (j["state"] == "succeeded") break;
        ::kill(worker(), kill == 1 ? SIGSEGV : SIGKILL);
    }
    const json done = ended(id);
    ASSERT_EQ(done["state"], "succeeded") << done;
    EXPECT_GE(done["attempt"].get<int>(), 2);
    EXPECT_EQ(digest_of(done), digest_of(reference));
    EXPECT_NE(ask("GET", "/v1/renders/" + id + "/log").body.find("the worker ended: signal 9"), std::string::npos);
}

TEST_F(RendersTest, three_crashes_without_progress_fail_it) {
    options.checkpoint_seconds = 1000;   // none: each attempt begins from nothing
    start();
    const std::string id = submit(long_render(scene(), 1 << 20))["id"];
    for (int attempt = 1; attempt <= 3; ++attempt) {
        until(id, [&](const json& j) { return j["attempt"] == attempt && j["state"] == "rendering"; });
        ::kill(worker(), SIGSEGV);
    }
    const json failed = ended(id);
    EXPECT_EQ(failed["state"], "failed");
    EXPECT_EQ(failed["problem"]["type"], "/problems/render-crashed") << failed;
    const std::string log = ask("GET", "/v1/renders/" + id + "/log").body;
    EXPECT_NE(log.find("backtrace"), std::string::npos) << log;
    EXPECT_EQ(ended(submit({{"scene", json_of(ask("GET", "/v1/renders/" + id))["scene"]["id"]}, {"samples", 1}, {"resolution", {8, 8}}})["id"])["state"], "succeeded") << "others are not affected";
}

TEST_F(RendersTest, a_stopped_daemon_goes_on_where_it_was) {
    start();
    const std::string s = scene();
    const json reference = ended(submit(long_render(s))["id"]);
    const std::string id = submit(long_render(s), "Cache-Control: no-cache\r\n")["id"];
    until(id, [](const json& j) { return j["progress"]["samples"] > 0; });
    const auto stopping = std::chrono::steady_clock::now();
    daemon.reset();
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - stopping).count(), 5);
    start();
    const json done = ended(id);
    EXPECT_EQ(done["attempt"], 2);
    EXPECT_EQ(digest_of(done), digest_of(reference));
    EXPECT_NE(ask("GET", "/v1/renders/" + id + "/log").body.find("goes on after"), std::string::npos);
}

TEST_F(RendersTest, waits_for_changes) {
    start();
    const std::string s = scene();
    const auto late = post("/v1/renders", long_render(s, 1 << 20), "Prefer: wait=1\r\nAccept: image/x-exr\r\n");
    EXPECT_EQ(late.status, 202) << late.body;
    const std::string id = json_of(late)["id"];
    const auto now = ask("GET", "/v1/renders/" + id);
    const auto changed = ask("GET", "/v1/renders/" + id, "", "If-None-Match: " + now.headers.at("etag") + "\r\nPrefer: wait=20\r\n");
    EXPECT_EQ(changed.status, 200);
    EXPECT_NE(changed.headers.at("etag"), now.headers.at("etag"));
    const json cancelled = json_of(ask("POST", "/v1/renders/" + id + "/cancel"));
    const auto still = ask("GET", "/v1/renders/" + id, "", "If-None-Match: " + cancelled["etag"].get<std::string>() + "\r\nPrefer: wait=1\r\n");
    EXPECT_EQ(still.status, 304);
    EXPECT_EQ(problem_of(post("/v1/renders", {{"scene", s}}, "Prefer: wait=3601\r\n")), "400 malformed-request");
}

TEST_F(RendersTest, events_tell_what_happens_until_the_end) {
    start();
    const std::string id = submit(long_render(scene(), 1024))["id"];
    test::RawClient c(daemon->port());
    c.send("GET /v1/renders/" + id + "/events HTTP/1.0\r\nHost: localhost\r\n\r\n");
    EXPECT_TRUE(c.ended(60)) << "the stream ends with the render";
    const std::string text = c.received();
    EXPECT_NE(text.find("text/event-stream"), std::string::npos) << text;
    EXPECT_NE(text.find("event: state\ndata: {"), std::string::npos) << text;
    EXPECT_NE(text.find("\"state\":\"succeeded\""), std::string::npos) << text;
    EXPECT_EQ(text.substr(text.rfind("event: ")), "event: end\ndata: {\"state\":\"succeeded\"}\n\n");
    EXPECT_EQ(problem_of(ask("GET", "/v1/renders/rnd_01m86ra8mqtfx7sqsppatcke7k/events")), "404 not-found");
}

TEST_F(RendersTest, limits_are_told_beforehand) {
    options.renders_queued = 2;
    options.worker_memory_mib = 2000;
    start();
    const std::string s = scene();
    const auto large = post("/v1/renders", {{"scene", s}, {"resolution", {16384, 16384}}});
    EXPECT_EQ(problem_of(large), "422 limit-exceeded");
    EXPECT_GT(json_of(large)["needed_bytes"], json_of(large)["limit"]);
    const std::string a = submit(long_render(s, 1 << 20))["id"], b = submit(long_render(s, 1 << 19))["id"];
    const auto full = post("/v1/renders", long_render(s));
    EXPECT_EQ(problem_of(full), "503 queue-full");
    EXPECT_EQ(full.headers.count("retry-after"), 1u);
    for (const auto& id : {a, b}) EXPECT_EQ(json_of(ask("POST", "/v1/renders/" + id + "/cancel"))["state"], "cancelled");
}

TEST_F(RendersTest, results_are_removed_when_their_time_is_over) {
    start();
    const std::string id = submit({{"scene", scene()}, {"samples", 1}, {"resolution", {8, 8}}, {"retain", 0}})["id"];
    ended(id);
    daemon.reset();   // a start looks at once
    start();
    const json expired = until(id, [](const json& j) { return j["expired"] == true; });
    EXPECT_TRUE(expired["outputs"].empty());
    EXPECT_EQ(problem_of(ask("GET", "/v1/renders/" + id + "/outputs/frame.exr")), "410 expired");
    EXPECT_FALSE(std::filesystem::exists(folder + "/renders/" + id + "/outputs"));
}

TEST_F(RendersTest, a_render_does_not_see_another_tokens) {
    std::filesystem::create_directories(folder);
    options.token_file = folder + "/tokens";
    std::ofstream(options.token_file) << "ann:read,render,edit:" << sha256_hex("a") << "\nbob:read,render:" << sha256_hex("b") << "\nroot:admin:" << sha256_hex("r") << "\n";
    start();
    const std::string ann = "Authorization: Bearer a\r\n", bob = "Authorization: Bearer b\r\n", root = "Authorization: Bearer r\r\n";
    const std::string s = json_of(post("/v1/scenes", document(), ann))["id"];
    const std::string id = json_of(post("/v1/renders", {{"scene", s}, {"samples", 1}, {"resolution", {8, 8}}}, ann))["id"];
    const std::string path = "/v1/renders/" + id;
    EXPECT_EQ(ask("GET", path, "", ann).status, 200);
    EXPECT_EQ(problem_of(ask("GET", path, "", bob)), "404 not-found");
    EXPECT_EQ(problem_of(ask("POST", path + "/cancel", "", bob)), "404 not-found");
    EXPECT_EQ(json_of(ask("GET", "/v1/renders", "", bob))["items"].size(), 0u);
    EXPECT_EQ(json_of(ask("GET", "/v1/renders", "", root))["items"].size(), 1u);
}

}  // namespace
}  // namespace alder
