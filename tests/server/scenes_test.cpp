// Scenes and whole frames: documents and containers in, revisions and ETags, edits of one material, waiting renders.
#include <algorithm>
#include <fstream>

#include "render/image/exr.h"
#include "render/import/scene_document.h"
#include "server/digest.h"
#include "tests/server/daemon_fixture.h"

namespace alder {
namespace {

using nlohmann::json;

class ScenesTest : public test::DaemonTest {
  protected:
    static json document() {
        return {{"alder_scene", 1},
                {"cameras", {{"cam", {{"look_at", {{"from", {0, -5, 1}}, {"to", {0, 0, 1}}}}, {"fov_degrees", 40}}}}},
                {"materials", {{"red", surface_graph()}, {"a/b", surface_graph(0.5)}}},
                {"meshes", {{"tri", {{"positions", {{-1, 0, 0}, {1, 0, 0}, {0, 0, 2}}}, {"triangles", {{0, 1, 2}}}}}}},
                {"instances", {{"a", {{"mesh", "tri"}, {"material", "red"}}}}},
                {"lights", {{"sun", {{"type", "sun"}, {"strength", 3}}}}}};
    }
    std::string create() {
        const auto a = post("/v1/scenes", document());
        EXPECT_EQ(a.status, 201) << a.body;
        return a.status == 201 ? json_of(a)["id"].get<std::string>() : "";
    }
    test::Answer render(const json& body, const std::string& headers = "Prefer: wait=60\r\nAccept: image/x-exr\r\n") { return post("/v1/renders", body, headers); }
    test::Answer put(const std::string& path, const json& body, const std::string& headers) { return ask("PUT", path, body.dump(), "Content-Type: application/json\r\n" + headers); }
};

TEST_F(ScenesTest, create_read_delete) {
    start();
    const auto made = post("/v1/scenes", document());
    ASSERT_EQ(made.status, 201) << made.body;
    const json scene = json_of(made);
    const std::string id = scene["id"];
    EXPECT_EQ(id.substr(0, 4), "scn_");
    EXPECT_EQ(made.headers.at("location"), "/v1/scenes/" + id);
    EXPECT_EQ(scene["statistics"]["triangles"], 1);
    const auto got = ask("GET", "/v1/scenes/" + id);
    EXPECT_EQ(got.status, 200);
    EXPECT_EQ(got.headers.at("etag"), made.headers.at("etag"));
    EXPECT_EQ(ask("GET", "/v1/scenes/" + id, "", "If-None-Match: " + made.headers.at("etag") + "\r\n").status, 304);
    EXPECT_EQ(ask("DELETE", "/v1/scenes/" + id).status, 204);
    EXPECT_EQ(problem_of(ask("GET", "/v1/scenes/" + id)), "404 not-found");
    for (const char* bad : {"scn_x", "..", "scn_../../../../../../../../etc", "rnd_01m86ra8mqtfx7sqsppatcke7k"}) EXPECT_GE(ask("GET", std::string("/v1/scenes/") + bad).status, 400) << bad;
}

TEST_F(ScenesTest, faults_have_their_place) {
    start();
    json d = document();
    d["materials"]["red"]["nodes"]["s"]["params"]["diffuseColr"] = 1;
    d["instances"]["a"]["mesh"] = "trii";
    const auto a = post("/v1/scenes", d);
    EXPECT_EQ(problem_of(a), "422 scene-invalid");
    std::set<std::string> pointers;
    for (const auto& e : errors_of(a)) pointers.insert(e["pointer"]);
    EXPECT_TRUE(pointers.count("/materials/red/nodes/s/params/diffuseColr")) << a.body;
    EXPECT_TRUE(pointers.count("/instances/a/mesh")) << a.body;
    EXPECT_EQ(problem_of(post("/v1/scenes", json::array())), "422 request-invalid");
    EXPECT_EQ(problem_of(post("/v1/scenes", {{"container", "sha256:12"}})), "422 request-invalid");
    const std::string absent = "sha256:" + std::string(64, '0');
    const auto missing = post("/v1/scenes", {{"container", absent}});
    EXPECT_EQ(problem_of(missing), "422 asset-missing");
    EXPECT_EQ(json_of(missing)["missing"], json::array({absent}));
}

TEST_F(ScenesTest, a_container_is_an_asset_until_its_scene_goes) {
    start();
    Diagnostics d;
    const auto scene = scene_from_json(document(), {}, d);
    ASSERT_TRUE(scene) << d.errors.front().line();
    std::string error;
    ASSERT_TRUE(write_scene(folder + "/shot.alder", *scene, error)) << error;
    std::ifstream file(folder + "/shot.alder", std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    const std::string name = "sha256:" + sha256_hex(bytes);
    ASSERT_EQ(ask("PUT", "/v1/assets/" + name, bytes).status, 201);
    const auto made = post("/v1/scenes", {{"container", name}});
    ASSERT_EQ(made.status, 201) << made.body;
    const std::string id = json_of(made)["id"];
    const auto refused = ask("DELETE", "/v1/assets/" + name);
    EXPECT_EQ(problem_of(refused), "409 in-use");
    EXPECT_EQ(json_of(refused)["scene"], id);
    EXPECT_EQ(render({{"scene", id}, {"samples", 1}, {"resolution", {16, 16}}}).status, 200);
    ask("DELETE", "/v1/scenes/" + id);
    EXPECT_EQ(ask("DELETE", "/v1/assets/" + name).status, 204);

    ASSERT_EQ(ask("PUT", "/v1/assets/sha256:" + sha256_hex("rubbish"), "rubbish").status, 201);
    const auto rubbish = post("/v1/scenes", {{"container", "sha256:" + sha256_hex("rubbish")}});
    EXPECT_EQ(problem_of(rubbish), "422 scene-invalid");
    EXPECT_EQ(rubbish.body.find(folder), std::string::npos) << "no path of this machine: " << rubbish.body;
}

TEST_F(ScenesTest, edits_of_a_material_need_the_current_tag) {
    start();
    const std::string id = create(), path = "/v1/scenes/" + id + "/materials/red";
    const auto got = ask("GET", path);
    ASSERT_EQ(got.status, 200);
    EXPECT_EQ(json_of(got)["nodes"]["s"]["params"]["specular1Roughness"], 0.3);
    EXPECT_EQ(json_of(ask("GET", "/v1/scenes/" + id + "/materials/a%2Fb"))["nodes"]["s"]["params"]["specular1Roughness"], 0.5);
    EXPECT_EQ(problem_of(ask("GET", "/v1/scenes/" + id + "/materials/blue")), "404 not-found");
    const std::string etag = got.headers.at("etag");

    const json next = surface_graph(0.7);
    EXPECT_EQ(problem_of(put(path, next, "")), "428 if-match-required");
    const auto stale = put(path, next, "If-Match: \"stale\"\r\n");
    EXPECT_EQ(problem_of(stale), "412 etag-mismatch");
    EXPECT_EQ(json_of(stale)["etag"], etag);
    const auto edited = put(path, next, "If-Match: " + etag + "\r\n");
    ASSERT_EQ(edited.status, 200) << edited.body;
    EXPECT_EQ(json_of(edited)["changed"], json::array({"materials/red"}));
    EXPECT_EQ(json_of(edited)["rebuild"], "shading");
    EXPECT_EQ(json_of(edited)["scene"]["revision"], 2);
    EXPECT_NE(edited.headers.at("etag"), etag);
    EXPECT_EQ(put(path, next, "If-Match: " + etag + "\r\n").status, 412) << "the old tag is gone";
    const auto same = put(path, next, "If-Match: *\r\n");
    EXPECT_EQ(json_of(same)["rebuild"], "none");
    json wrong = next;
    wrong["nodes"]["s"]["params"]["nonsense"] = 1;
    EXPECT_EQ(problem_of(put(path, wrong, "If-Match: *\r\n")), "422 graph-invalid");
    EXPECT_EQ(json_of(ask("GET", path))["nodes"]["s"]["params"]["specular1Roughness"], 0.7) << "and the scene stays as it was";
    json shining = next;
    shining["nodes"]["s"]["params"]["emissionStrength"] = 2;
    EXPECT_EQ(json_of(put(path, shining, "If-Match: *\r\n"))["rebuild"], "lights");
}

TEST_F(ScenesTest, edits_survive_a_restart) {
    start();
    const std::string id = create(), path = "/v1/scenes/" + id + "/materials/red";
    const auto edited = put(path, surface_graph(0.9), "If-Match: *\r\n");
    ASSERT_EQ(edited.status, 200) << edited.body;
    const auto before = render({{"scene", id}, {"samples", 2}, {"resolution", {16, 16}}});
    daemon.reset();
    start();
    const auto got = ask("GET", path);
    ASSERT_EQ(got.status, 200) << got.body;
    EXPECT_EQ(json_of(got)["nodes"]["s"]["params"]["specular1Roughness"], 0.9);
    EXPECT_EQ(got.headers.at("etag"), edited.headers.at("etag"));
    EXPECT_EQ(render({{"scene", id}, {"samples", 2}, {"resolution", {16, 16}}}).body, before.body) << "built from new or edited: the same pixels";
}

TEST_F(ScenesTest, two_editors_cannot_both_win) {
    start();
    const std::string id = create(), path = "/v1/scenes/" + id + "/materials/red";
    const std::string etag = ask("GET", path).headers.at("etag");
    std::atomic<int> won{0}, lost{0};
    std::vector<std::thread> threads;
    for (int i = 0; i < 6; ++i)
        threads.emplace_back([&, i] {
            const int status = put(path, surface_graph(0.31 + 0.01 * i), "If-Match: " + etag + "\r\n").status;
            won += status == 200;
            lost += status == 412;
        });
    for (auto& t : threads) t.join();
    EXPECT_EQ(won, 1);
    EXPECT_EQ(lost, 5);
}

TEST_F(ScenesTest, a_whole_frame_in_one_request) {
    start();
    const std::string id = create();
    const auto a = render({{"scene", id}, {"samples", 4}, {"resolution", {32, 24}}, {"aovs", {"shading", "data"}}});
    ASSERT_EQ(a.status, 200) << a.body;
    EXPECT_EQ(a.headers.at("content-type"), "image/x-exr");
    EXPECT_EQ(a.headers.at("preference-applied"), "wait=60");
    EXPECT_EQ(a.headers.at("alder-samples"), "4");
    std::string error;
    const auto image = decode_exr({reinterpret_cast<const uint8_t*>(a.body.data()), a.body.size()}, error);
    ASSERT_TRUE(image) << error;
    EXPECT_EQ(image->width, 32);
    EXPECT_TRUE(image->find("direct_diffuse"));
    EXPECT_TRUE(image->find("Z"));
    const auto crop = render({{"scene", id}, {"samples", 4}, {"resolution", {32, 24}}, {"crop", {8, 4, 20, 12}}});
    ASSERT_EQ(crop.status, 200) << crop.body;
    const auto part = decode_exr({reinterpret_cast<const uint8_t*>(crop.body.data()), crop.body.size()}, error);
    ASSERT_TRUE(part) << error;
    EXPECT_EQ(part->width, 12);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 12; ++x) ASSERT_EQ(part->find("")->planes[0][y * 12 + x], image->find("")->planes[0][(y + 4) * 32 + x + 8]) << x << "," << y;
}

TEST_F(ScenesTest, renders_that_cannot_be_had_say_so) {
    start();
    const std::string id = create();
    EXPECT_EQ(problem_of(render({{"scene", "scn_01m86ra8mqtfx7sqsppatcke7k"}})), "404 not-found");
    const auto a = render({{"scene", id}, {"frames", "1-"}, {"farm", "slurm"}, {"smaples", 3}, {"crop", {4, 4, 4, 8}}, {"stop", {{"eror", 0.1}}}});
    EXPECT_EQ(problem_of(a), "422 settings-invalid");
    EXPECT_EQ(json_of(a)["errors"].size(), 5u) << a.body;
    EXPECT_EQ(problem_of(render({{"scene", id}, {"resolution", {32, 32}}, {"crop", {0, 0, 64, 64}}})), "422 settings-invalid");
}

TEST_F(ScenesTest, a_scene_is_a_stage_too) {
    start();
    const std::string id = create();
    const json request = {{"graph", surface_graph(0.8)}, {"stage", id}, {"assign_to", "red"}, {"size", 24}, {"samples", 2}};
    const auto a = post("/v1/preview", request, "Accept: image/x-exr\r\n");
    ASSERT_EQ(a.status, 200) << a.body;
    json other = request;
    other["assign_to"] = "rad";
    const auto wrong = post("/v1/preview", other);
    EXPECT_EQ(problem_of(wrong), "422 settings-invalid");
    EXPECT_EQ(json_of(wrong)["errors"][0]["suggest"], "red");
    other.erase("assign_to");
    EXPECT_EQ(problem_of(post("/v1/preview", other)), "422 settings-invalid");
    put("/v1/scenes/" + id + "/materials/red", surface_graph(0.1), "If-Match: *\r\n");
    EXPECT_NE(post("/v1/preview", request, "Accept: image/x-exr\r\n").headers.at("etag"), a.headers.at("etag")) << "another revision, another tag";
}

}  // namespace
}  // namespace alder
