// Live renders: edits reach pictures with their tokens, streams have the form they promise, re-mixes trace no ray.
#include "render/image/exr.h"
#include "tests/server/daemon_fixture.h"

namespace alder {
namespace {

using nlohmann::json;

class LiveTest : public test::DaemonTest {
  protected:
    std::string live;

    void begin(json extra = json::object()) {
        start();
        json body = {{"mode", "live"}, {"graph", surface_graph()}, {"stage", "sphere"}, {"resolution", {48, 32}}, {"max_samples", 4}};
        body.update(extra);
        const auto a = post("/v1/renders", body);
        ASSERT_EQ(a.status, 201) << a.body;
        live = json_of(a)["id"];
        EXPECT_EQ(a.headers.at("location"), "/v1/renders/" + live);
    }
    std::string at(const std::string& what = {}) const { return "/v1/renders/" + live + what; }
    test::Answer patch(const std::string& path, const json& body, const std::string& headers = {}) {
        return ask("PATCH", path, body.dump(), "Content-Type: application/json\r\n" + headers);
    }
    json document() { return json_of(ask("GET", at())); }
    /// Waits until all samples of the newest edit are there.
    bool finished() {
        for (int i = 0; i < 1200; ++i) {
            const json d = document();
            if (d["progress"]["up_to_date"] == true && d["progress"]["samples"] == d["progress"]["max_samples"] && d["progress"]["divisor"] == 1) return true;
            usleep(50000);
        }
        return false;
    }
    Image snapshot(const std::string& query = {}) {
        const auto a = ask("GET", at("/snapshot.exr" + query));
        std::string error;
        const auto image = decode_exr({reinterpret_cast<const uint8_t*>(a.body.data()), a.body.size()}, error);
        EXPECT_TRUE(image) << a.status << " " << a.body.substr(0, 300) << error;
        return image ? *image : Image{};
    }
    /// What arrives of a stream until `wanted` has.
    std::string stream_until(const std::string& path, const std::string& wanted, const std::string& headers = {}) {
        test::RawClient client(daemon->port());
        client.send("GET " + path + " HTTP/1.1\r\nHost: localhost\r\n" + headers + "\r\n");
        return client.receive_until(wanted, 60);
    }
};

TEST_F(LiveTest, the_picture_is_the_one_that_a_preview_gives) {
    begin();
    ASSERT_TRUE(finished()) << document();
    const auto preview = post("/v1/preview", {{"graph", surface_graph()}, {"stage", "sphere"}, {"size", {48, 32}}, {"samples", 4}}, "Accept: image/x-exr\r\n");
    ASSERT_EQ(preview.status, 200);
    std::string error;
    const auto expected = decode_exr({reinterpret_cast<const uint8_t*>(preview.body.data()), preview.body.size()}, error);
    const Image got = snapshot();
    ASSERT_TRUE(expected && got.find(""));
    EXPECT_EQ(got.find("")->planes, expected->find("")->planes);
}

TEST_F(LiveTest, an_edit_is_answered_with_what_it_cost_and_shows_with_its_token) {
    begin();
    ASSERT_TRUE(finished());
    const Image before = snapshot();
    EXPECT_EQ(problem_of(patch(at("/graph"), {{"nodes", {{"s", {{"params", {{"diffuseColor", {0, 0, 1}}}}}}}}})), "428 if-match-required");
    const auto a = patch(at("/graph"), {{"nodes", {{"s", {{"params", {{"diffuseColor", {0, 0, 1}}}}}}}}}, "If-Match: *\r\nAlder-Edit-Id: blue-1\r\n");
    ASSERT_EQ(a.status, 200) << a.body;
    const json answer = json_of(a);
    EXPECT_EQ(answer["rebuild"], "shading");
    EXPECT_EQ(answer["reused"]["geometry"], true);
    EXPECT_EQ(answer["reused"]["lights"], true);
    EXPECT_EQ(answer["reused"]["materials_compiled"], 1);
    EXPECT_EQ(a.headers.at("alder-edit-id"), "blue-1");
    EXPECT_NE(stream_until(at("/preview.mjpg"), "Alder-Edits: blue-1").find("Alder-Edits: blue-1"), std::string::npos);
    ASSERT_TRUE(finished());
    EXPECT_NE(snapshot().find("")->planes, before.find("")->planes);
    // One that cannot be compiled changes nothing.
    const std::string etag = ask("GET", at("/graph")).headers.at("etag");
    EXPECT_EQ(problem_of(patch(at("/graph"), {{"nodes", {{"s", {{"params", {{"diffuseColour", 1}}}}}}}}, "If-Match: *\r\n")), "422 graph-invalid");
    EXPECT_EQ(ask("GET", at("/graph")).headers.at("etag"), etag);
    EXPECT_EQ(problem_of(patch(at("/graph"), json::object(), "If-Match: \"old\"\r\n")), "412 etag-mismatch");
    const json operations = json::array({{{"op", "replace"}, {"path", "/nodes/s/params/specular1Roughness"}, {"value", 0.7}}});
    EXPECT_EQ(ask("PATCH", at("/graph"), operations.dump(), "Content-Type: application/json-patch+json\r\nIf-Match: " + etag + "\r\n").status, 200);
    EXPECT_EQ(json_of(ask("GET", at("/graph")))["nodes"]["s"]["params"]["specular1Roughness"], 0.7);
}

TEST_F(LiveTest, light_groups_are_mixed_without_a_ray) {
    begin();
    ASSERT_TRUE(finished());
    const Image before = snapshot();
    const json rays = json_of(ask("GET", at("/stats")))["rays"];
    const auto a = patch(at(), {{"mix", {{"key", {{"intensity", 0}}}, {"3", {{"color", {2, 1, 0.5}}}}}}}, "Alder-Edit-Id: m\r\n");
    ASSERT_EQ(a.status, 200) << a.body;
    EXPECT_EQ(json_of(a)["remixed"], true);
    EXPECT_EQ(json_of(a)["rebuild"], "none");
    const Image after = snapshot();
    EXPECT_EQ(json_of(ask("GET", at("/stats")))["rays"], rays);
    const float weights[3] = {2, 1, 0.5f};
    double worst = 0;
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < after.find("")->planes[c].size(); ++i) {
            const auto group = [&](const char* name) { return before.find(name)->planes[c][i]; };
            const double expected = group("light_group_default") + group("light_group_2") + weights[c] * group("light_group_3");
            worst = std::max(worst, std::abs(after.find("")->planes[c][i] - expected) / (0.01 + expected));
        }
    EXPECT_LT(worst, 5e-3) << "files are half precision";
    EXPECT_EQ(problem_of(patch(at(), {{"mix", {{"nothing", {{"intensity", 1}}}}}})), "422 settings-invalid");
    EXPECT_EQ(problem_of(patch(at(), {{"mix", {{"1", {{"intensity", -1}}}}}})), "422 settings-invalid");
}

TEST_F(LiveTest, events_begin_with_everything_and_go_on_after_a_reconnect) {
    begin();
    ASSERT_TRUE(finished());
    const std::string first = stream_until(at("/events"), "event: state");
    EXPECT_NE(first.find("text/event-stream"), std::string::npos) << first;
    EXPECT_NE(first.find("\"max_samples\":4"), std::string::npos);
    const size_t id = first.find("id: ") + 4;
    const std::string last = first.substr(id, first.find('\n', id) - id);
    patch(at("/graph"), {{"nodes", {{"s", {{"params", {{"specular1Roughness", 0.9}}}}}}}}, "If-Match: *\r\nAlder-Edit-Id: again\r\n");
    const std::string next = stream_until(at("/events"), "\"again\"", "Last-Event-ID: " + last + "\r\n");
    EXPECT_NE(next.find("\"again\""), std::string::npos);
    const std::string cancelled = [&] {
        test::RawClient client(daemon->port());
        client.send("GET " + at("/events") + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
        client.receive_until("event: state", 10);
        EXPECT_EQ(ask("POST", at("/cancel")).status, 200);
        return client.receive_until("event: end", 10);
    }();
    EXPECT_NE(cancelled.find("event: end"), std::string::npos);
    EXPECT_EQ(document()["state"], "cancelled");
    EXPECT_EQ(ask("DELETE", at()).status, 204);
    EXPECT_EQ(problem_of(ask("GET", at())), "404 not-found");
}

TEST_F(LiveTest, files_tiles_and_pixels) {
    begin({{"aovs", {"N", "id_object", "id_material"}}});
    ASSERT_TRUE(finished());
    EXPECT_NE(stream_until(at("/stream?aovs=N"), "Alder-Final: true").find("image/x-exr"), std::string::npos);
    EXPECT_NE(stream_until(at("/tiles?type=float"), "ALDT").find("ALDT"), std::string::npos);
    const json p = json_of(ask("GET", at("/pixel?x=24&y=16")));
    EXPECT_EQ(p["material"], "subject") << p;
    EXPECT_EQ(p["layers"]["N"].size(), 3u);
    EXPECT_EQ(problem_of(ask("GET", at("/pixel?x=48&y=0"))), "422 settings-invalid");
    EXPECT_EQ(problem_of(ask("GET", at("/pixel?x=1"))), "400 malformed-request");
    EXPECT_EQ(problem_of(ask("GET", at("/snapshot.png?aov=nope"))), "422 settings-invalid");
    EXPECT_EQ(ask("GET", at("/snapshot.png?aov=N")).headers.at("content-type"), "image/png");
    EXPECT_EQ(ask("GET", at("/snapshot.jpg")).headers.at("alder-samples"), "4");
}

TEST_F(LiveTest, a_scene_is_followed) {
    start();
    const auto made = post("/v1/scenes", {{"alder_scene", 1},
                                          {"cameras", {{"cam", {{"look_at", {{"from", {0, -5, 1}}, {"to", {0, 0, 1}}}}, {"fov_degrees", 40}}}}},
                                          {"materials", {{"red", surface_graph()}}},
                                          {"meshes", {{"tri", {{"positions", {{-1, 0, 0}, {1, 0, 0}, {0, 0, 2}}}, {"triangles", {{0, 1, 2}}}}}}},
                                          {"instances", {{"a", {{"mesh", "tri"}, {"material", "red"}}}}},
                                          {"lights", {{"sun", {{"type", "sun"}, {"strength", 3}}}}}});
    ASSERT_EQ(made.status, 201) << made.body;
    const std::string scene = json_of(made)["id"];
    const auto a = post("/v1/renders", {{"mode", "live"}, {"scene", scene}, {"resolution", {16, 16}}, {"max_samples", 2}});
    ASSERT_EQ(a.status, 201) << a.body;
    live = json_of(a)["id"];
    const auto edit = patch("/v1/scenes/" + scene + "/materials/red", {{"nodes", {{"s", {{"params", {{"diffuseColor", {0, 1, 0}}}}}}}}}, "If-Match: *\r\nAlder-Edit-Id: green\r\n");
    ASSERT_EQ(edit.status, 200) << edit.body;
    EXPECT_EQ(json_of(edit)["reused"]["geometry"], true);
    EXPECT_NE(stream_until(at("/preview.mjpg"), "green").find("green"), std::string::npos);
    EXPECT_EQ(document()["scene"]["revision"], json_of(edit)["scene"]["etag"]);
    EXPECT_EQ(problem_of(ask("GET", at("/graph"))), "404 not-found");
}

TEST_F(LiveTest, requests_that_make_no_sense_are_refused) {
    start();
    for (const auto& [body, problem] : std::vector<std::pair<json, std::string>>{
             {{{"mode", "live"}}, "422 settings-invalid"},
             {{{"mode", "live"}, {"graph", surface_graph()}, {"scene", "scn_x"}}, "422 settings-invalid"},
             {{{"mode", "live"}, {"graph", surface_graph()}, {"stage", "moon"}}, "422 settings-invalid"},
             {{{"mode", "live"}, {"graph", surface_graph()}, {"resolution", {0, 9}}}, "422 settings-invalid"},
             {{{"mode", "live"}, {"graph", {{"nodes", 3}}}}, "422 graph-invalid"},
             {{{"mode", "live"}, {"scene", "scn_x"}}, "404 not-found"}})
        EXPECT_EQ(problem_of(post("/v1/renders", body)), problem) << body;
    EXPECT_EQ(problem_of(ask("GET", "/v1/renders/rnd_00000000000000000000000000/events")), "404 not-found");
}

TEST_F(LiveTest, the_daemon_stops_while_streams_are_open) {
    begin();
    test::RawClient events(daemon->port()), pictures(daemon->port());
    events.send("GET " + at("/events") + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
    pictures.send("GET " + at("/preview.mjpg") + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
    events.receive_until("event: state", 10);
    EXPECT_TRUE(daemon->stop());
}

TEST_F(LiveTest, the_description_names_the_routes) {
    start();
    const json api = json_of(ask("GET", "/v1/openapi.json"));
    EXPECT_EQ(api["openapi"], "3.1.0");
    EXPECT_TRUE(api["paths"].contains("/v1/renders/{id}/events"));
}

}  // namespace
}  // namespace alder
