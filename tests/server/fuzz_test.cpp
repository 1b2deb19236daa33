// Every parser that a client's bytes reach, on mutated inputs: nothing may crash, hang or read out of bounds. Under
// ./dev sanitize asan the sanitizers look on. ALDER_FUZZ_SECONDS=600 runs each so long instead of a few hundred inputs.
//
// Inputs come from one seed, so a finding comes again; the input at work lies in a file named in the message of the test's
// folder (alder_fuzz_TARGET) when the process dies.
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

#include <gtest/gtest.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include "graph/json_text.h"
#include "nodes/texture/image_store.h"
#include "render/evaluate.h"
#include "render/image/exr.h"
#include "render/image/view.h"
#include "render/import/scene_document.h"
#include "server/errors.h"
#include "server/http/connection.h"
#include "server/http/head.h"
#include "server/jobs/settings.h"
#include "server/live/live_store.h"

namespace alder {
namespace {

using Bytes = std::string;
using Random = std::mt19937_64;

Bytes file_bytes(const std::string& name) {
    std::ifstream file(std::string(ALDER_SOURCE_DIR) + "/" + name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Bits flipped, bytes set to telling values, pieces copied, removed, moved in from another seed.
Bytes mutate(Bytes b, const Bytes& other, Random& random) {
    static constexpr unsigned char kTelling[] = {0, 1, 0x7F, 0x80, 0xFF, '"', '\\', '{', '}', '[', ']', ',', ':', '-', '0', '9', 'e', '\r', '\n', '%'};
    const auto below = [&](size_t n) { return n ? random() % n : 0; };
    for (size_t k = 1 + below(8); k > 0; --k) {
        if (b.empty()) b = "x";
        const size_t at = below(b.size()), length = 1 + below(std::min<size_t>(b.size() - at, 64));
        switch (below(7)) {
            case 0: b[at] = static_cast<char>(b[at] ^ (1 << below(8))); break;
            case 1: b[at] = static_cast<char>(kTelling[below(sizeof kTelling)]); break;
            case 2: b.erase(at, length); break;
            case 3: b.insert(at, b.substr(below(b.size()), length)); break;
            case 4: b.insert(at, other.substr(below(other.size()), length)); break;
            case 5: for (size_t i = 0; i < 4 && at + i < b.size(); ++i) b[at + i] = static_cast<char>(random()); break;
            default: b.resize(below(3) ? b.size() : at); break;
        }
        if (b.size() > (1 << 20)) b.resize(1 << 20);
    }
    return b;
}

/// A value somewhere inside replaced by another kind of value: what stays JSON gets further than broken bytes do.
void mutate_value(nlohmann::json& j, Random& random, int depth = 0) {
    static const std::vector<nlohmann::json> kValues = {nullptr, true, -1, 0, 1, 3, 2147483648LL, -1e308, 1e38, 1e-320, 0.5, "", "s", "nan", "../x", "sha256:", nlohmann::json::array(), nlohmann::json::object(),
                                                        {0, 0, 0}, {1, 2, 3, 4}, {{"node", "s"}}, {{"attribute", "x"}}, {{"node", "a"}, {"output", "b"}}};
    if (depth > 0 && random() % 4 == 0) {
        j = kValues[random() % kValues.size()];
    } else if (j.is_structured() && !j.empty()) {
        auto it = j.begin();
        std::advance(it, random() % j.size());
        if (random() % 8 == 0) j.erase(it);
        else if (random() % 8 == 0 && j.is_object()) j["renamed"] = nlohmann::json(*it);
        else mutate_value(*it, random, depth + 1);
    } else {
        j = kValues[random() % kValues.size()];
    }
}

class FuzzTest : public ::testing::Test {
  protected:
    std::string current;   ///< the file of the input at work: its length, then its bytes
    char* shown = nullptr;
    ~FuzzTest() override {
        if (shown) munmap(shown, kShownBytes);
        std::filesystem::remove(current);
    }
    static constexpr size_t kShownBytes = 8 << 20;
    /// Mapped, not written: a process that dies leaves it behind, and it costs no system call.
    void map_file() {
        const int fd = ::open(current.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
        ASSERT_GE(fd, 0);
        ASSERT_EQ(ftruncate(fd, kShownBytes), 0);
        shown = static_cast<char*>(mmap(nullptr, kShownBytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0));
        ::close(fd);
        ASSERT_NE(static_cast<void*>(shown), MAP_FAILED);
    }
    void show(const Bytes& input) const {
        const uint64_t length = std::min<uint64_t>(input.size(), kShownBytes - sizeof(uint64_t));
        std::memcpy(shown, &length, sizeof length);
        std::memcpy(shown + sizeof length, input.data(), length);
    }

    template <class F>
    void run(const char* target, const std::vector<Bytes>& seeds, int inputs, F&& take) {
        ASSERT_FALSE(seeds.empty());
        for (const Bytes& seed : seeds) ASSERT_FALSE(seed.empty()) << target << ": a seed is missing";
        const char* seconds = std::getenv("ALDER_FUZZ_SECONDS");
        const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds ? std::atof(seconds) : 0);
        current = ::testing::TempDir() + "alder_fuzz_" + target + "_" + std::to_string(getpid());
        if (shown) munmap(shown, kShownBytes);
        map_file();
        Random random(20240607);
        for (const Bytes& seed : seeds) take(seed);
        for (int i = 0; seconds ? std::chrono::steady_clock::now() < end : i < inputs; ++i) {
            const Bytes& seed = seeds[random() % seeds.size()];
            Bytes input;
            const auto json = random() % 3 ? nlohmann::json::parse(seed, nullptr, false) : nlohmann::json(nlohmann::json::value_t::discarded);
            if (json.is_discarded()) {
                input = mutate(seed, seeds[random() % seeds.size()], random);
            } else {
                nlohmann::json changed = json;
                for (size_t k = 1 + random() % 4; k > 0; --k) mutate_value(changed, random);
                input = changed.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
            }
            show(input);
            take(input);
        }
    }
    /// Strict parsing as requests have it; nothing where it is refused.
    static std::optional<nlohmann::json> parsed(const Bytes& text) {
        Diagnostics d;
        return parse_json(text, JsonLimits{}, d);
    }
};

const char* const kScene = R"({"alder_scene":1,"cameras":{"cam":{"look_at":{"from":[0,-5,1],"to":[0,0,1]},"fov_degrees":40}},
 "materials":{"m":{"version":1,"nodes":{"s":{"type":"alSurface","params":{"diffuseColor":[0.8,0.3,0.1]}}},"outputs":{"surface":{"node":"s"}}}},
 "meshes":{"t":{"positions":[[-1,0,0],[1,0,0],[0,0,2]],"triangles":[[0,1,2]],"uv":[[0,0],[1,0],[0,1]]}},
 "instances":{"a":{"mesh":"t","material":"m","transform":[1,0,0,0,0,1,0,0,0,0,1,0]}},"lights":{"l":{"type":"point","strength":3,"transform":[1,0,0,0,0,1,0,0,0,0,1,3]}},
 "settings":{"resolution":[8,8],"samples":1}})";

TEST_F(FuzzTest, http_heads) {
    const std::vector<Bytes> seeds = {"GET /v1/nodes?view=summary&a=%20b HTTP/1.1\r\nHost: localhost:7420\r\nAccept: image/png;q=0.5, */*\r\n\r\n",
                                      "POST /v1/renders HTTP/1.1\r\nHost: [::1]:1\r\nContent-Length: 12\r\nPrefer: wait=3\r\nExpect: 100-continue\r\n\r\n",
                                      "PUT http://localhost/v1/assets/sha256:00 HTTP/1.0\r\nTransfer-Encoding: chunked\r\nRange: bytes=1-2\r\n\r\n"};
    run("head", seeds, 20000, [](const Bytes& input) {
        const http::Limits limits;
        const auto progress = http::head_progress(input, limits);
        EXPECT_LE(progress.end, input.size());
        http::Head head;
        if (progress.end > 0 && !progress.fault) http::parse_head(std::string_view(input).substr(0, progress.end), limits, head);
        std::string out;
        http::percent_decode(input, true, out);
    });
}

TEST_F(FuzzTest, http_requests_with_bodies) {
    const std::vector<Bytes> seeds = {
        "POST / HTTP/1.1\r\nHost: h\r\nContent-Length: 5\r\n\r\nhelloGET / HTTP/1.1\r\nHost: h\r\n\r\n",
        "POST / HTTP/1.1\r\nHost: h\r\nTransfer-Encoding: chunked\r\n\r\n5;x=y\r\nhello\r\n10\r\n0123456789abcdef\r\n0\r\nTrailer: 1\r\n\r\nGET / HTTP/1.1\r\n\r\n",
        "PUT / HTTP/1.1\r\nHost: h\r\nExpect: 100-continue\r\nContent-Length: 3\r\n\r\nabc"};
    http::Limits limits;
    limits.idle_seconds = limits.head_seconds = limits.body_grace_seconds = 0.2;   // the peer has closed: nothing is waited for
    run("http", seeds, 3000, [&](const Bytes& input) {
        int pair[2];
        ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair), 0);
        (void)!::write(pair[0], input.data(), std::min<size_t>(input.size(), 100000));
        ::shutdown(pair[0], SHUT_WR);
        constexpr uint64_t kMost = 1 << 16;
        {
            http::Connection connection(pair[1], limits);
            for (int i = 0; i < 8; ++i) {
                http::Head head;
                std::optional<http::Fault> fault;
                if (!connection.next(head, fault)) break;
                connection.present(head, fault.has_value());
                connection.allow_body(kMost);
                char piece[1000];
                uint64_t total = 0;
                for (ssize_t n; (n = connection.read(piece, sizeof piece)) > 0;) total += static_cast<uint64_t>(n);
                EXPECT_LE(total, kMost + 100) << "with the head that the library is shown";
                if (fault || !connection.body_finished()) break;
            }
        }
        ::close(pair[0]);
        ::close(pair[1]);
    });
}

TEST_F(FuzzTest, patches) {
    const std::vector<Bytes> seeds = {R"({"document":{"a":{"b":[1,2,3]},"c":"d"},"patch":[{"op":"replace","path":"/a/b/1","value":7},{"op":"move","from":"/c","path":"/a/e"},{"op":"copy","from":"/a","path":"/x"}]})",
                                      R"({"document":{"nodes":{"s":{"params":{"x":1}}}},"patch":{"nodes":{"s":{"params":{"x":null,"y":[1]}}}}})"};
    run("patch", seeds, 5000, [](const Bytes& input) {
        const auto json = parsed(input);
        if (!json || !json->is_object() || !json->contains("patch")) return;
        const nlohmann::json document = json->value("document", nlohmann::json());
        http::Request request;
        for (const char* type : {"application/merge-patch+json", "application/json-patch+json"}) {
            request.headers = {{"content-type", type}};
            try {
                live::patched(request, document, (*json)["patch"]);
            } catch (const Problem& p) {
                EXPECT_TRUE(find_error(p.type)) << p.type;
            }
        }
    });
}

/// Textures as they are uploaded: whatever they hold, they are pictures or a fault.
TEST_F(FuzzTest, image_files) {
    Image image;
    image.width = image.full_width = 7;
    image.height = image.full_height = 5;
    image.layers.push_back({"", {"R", "G", "B", "A"}, false, std::vector<std::vector<float>>(4, std::vector<float>(35, 0.4f))});
    std::string error;
    std::vector<std::pair<const char*, Bytes>> seeds;
    const auto add = [&](const char* extension, const std::vector<uint8_t>& bytes) {
        ASSERT_FALSE(bytes.empty()) << extension << error;
        seeds.emplace_back(extension, Bytes(bytes.begin(), bytes.end()));
    };
    add(".png", encode_png(image, View{}, error));
    add(".jpg", encode_jpeg(image, View{}, error));
    add(".exr", encode_exr(image, {}, error));
    Bytes hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n";
    for (int row = 0; row < 4; ++row) {   // run lengths: one row of runs, of literals
        hdr += Bytes("\2\2\0\10", 4);
        for (int c = 0; c < 4; ++c) hdr += row % 2 ? Bytes("\x88\x40", 2) : Bytes("\x08\1\2\3\4\5\6\7\x08", 9);
    }
    seeds.emplace_back(".hdr", hdr);
    for (const auto& [extension, seed] : seeds) {
        const std::string stem = ::testing::TempDir() + "alder_fuzz_image_" + std::to_string(getpid()) + "_";
        int count = 0;
        run(extension + 1, {seed}, 300, [&, extension = extension](const Bytes& input) {
            const std::string path = stem + std::to_string(count++) + extension;   // a name of its own: files are found again by name
            std::ofstream(path, std::ios::binary) << input;
            const auto stored = ImageStore::shared().open({path, "", AlphaMode::Straight});
            ASSERT_TRUE(stored);
            EXPECT_TRUE(stored->readable() || !stored->fault.empty()) << path;
            EXPECT_LE(stored->width, StoredImage::kLargestSide);
            std::filesystem::remove(path);
        });
        std::filesystem::remove(current);
    }
}

TEST_F(FuzzTest, graphs) {
    const std::vector<Bytes> seeds = {file_bytes("docs/examples/groups.graph.json"), file_bytes("docs/examples/weathered_paint.graph.json")};
    run("graph", seeds, 400, [](const Bytes& input) {
        const auto json = parsed(input);
        if (!json) return;
        Diagnostics d;
        const nlohmann::json& graph = json->is_object() && json->contains("graph") ? (*json)["graph"] : *json;
        const auto material = build_material(graph, MaterialOptions{}, d);
        EXPECT_EQ(material != nullptr, d.ok());
        if (material) material->program({.surface = LobeFilter::Surface}, d);
    });
}

TEST_F(FuzzTest, evaluate_requests) {
    const std::vector<Bytes> seeds = {
        R"({"graph":{"version":1,"nodes":{"r":{"type":"alRemapFloat","params":{"input":{"attribute":"x"},"RMPcontrast":2}}},"outputs":{}},"points":{"count":3,"attributes":{"x":[0.25,0.5,0.75]}},"outputs":["r"]})",
        R"({"graph":{"nodes":{"n":{"type":"ShaderNodeTexNoise","params":{"Scale":5}},"m":{"type":"ShaderNodeMath","params":{"operation":"POWER","Value":{"node":"n","output":"Fac"}}}}},"points":{"count":2,"P":[[0,0,0],[1,2,3]]},"outputs":["m"]})"};
    run("evaluate", seeds, 400, [](const Bytes& input) {
        const auto json = parsed(input);
        if (!json) return;
        if (json->is_object() && json->value("points", nlohmann::json()).is_object()) {   // large is allowed, and slow
            const auto& points = (*json)["points"];
            if (points.contains("count") && points["count"].is_number() && points["count"].get<double>() > 1e5) return;
        }
        EvaluateOptions options;
        options.threads = 1;
        Diagnostics d;
        evaluate_request(*json, options, d);
    });
}

TEST_F(FuzzTest, scene_documents) {
    run("scene", {kScene}, 400, [](const Bytes& input) {
        const auto json = parsed(input);
        if (!json) return;
        Diagnostics d;
        const auto scene = scene_from_json(*json, {}, d);
        EXPECT_TRUE(scene || !d.ok());
    });
}

TEST_F(FuzzTest, gltf_files) {
    const std::vector<Bytes> seeds = {file_bytes("docs/examples/triangle.glb"), file_bytes("tests/data/gltf_sample.glb")};
    const std::string path = ::testing::TempDir() + "alder_fuzz_" + std::to_string(getpid()) + ".glb";
    run("gltf", seeds, 400, [&](const Bytes& input) {
        std::ofstream(path, std::ios::binary) << input;
        Diagnostics d;
        SceneLoadOptions options;
        options.limits.array_bytes = 64 << 20;
        const auto scene = load_scene(path, options, d);
        EXPECT_TRUE(scene || !d.ok());
    });
    std::filesystem::remove(path);
}

TEST_F(FuzzTest, alder_containers) {
    Diagnostics d;
    std::string error;
    const std::string path = ::testing::TempDir() + "alder_fuzz_" + std::to_string(getpid()) + ".alder";
    const auto scene = scene_from_json(nlohmann::json::parse(kScene), {}, d);
    ASSERT_TRUE(scene) << (d.errors.empty() ? "" : d.errors[0].line());
    ASSERT_TRUE(write_scene(path, *scene, error)) << error;
    std::ifstream file(path, std::ios::binary);
    const Bytes seed{std::istreambuf_iterator<char>(file), {}};
    run("container", {seed}, 400, [&](const Bytes& input) {
        std::ofstream(path, std::ios::binary) << input;
        Diagnostics faults;
        SceneLoadOptions options;
        options.limits.array_bytes = 64 << 20;
        const auto again = load_scene(path, options, faults);
        EXPECT_TRUE(again || !faults.ok());
    });
    std::filesystem::remove(path);
}

TEST_F(FuzzTest, exr_files) {
    Image image;
    image.width = image.full_width = 5;
    image.height = image.full_height = 4;
    image.layers.push_back({"", {"R", "G", "B", "A"}, false, std::vector<std::vector<float>>(4, std::vector<float>(20, 0.5f))});
    image.layers.push_back({"Z", {""}, true, std::vector<std::vector<float>>(1, std::vector<float>(20, 3.f))});
    std::vector<Bytes> seeds;
    for (const auto compression : {ExrOptions::Compression::None, ExrOptions::Compression::Zip, ExrOptions::Compression::Piz, ExrOptions::Compression::Rle}) {
        std::string error;
        const auto bytes = encode_exr(image, {false, compression}, error);
        ASSERT_FALSE(bytes.empty()) << error;
        seeds.emplace_back(bytes.begin(), bytes.end());
    }
    run("exr", seeds, 1000, [](const Bytes& input) {
        std::string error;
        ExrLimits limits;
        limits.bytes = 64 << 20;
        const auto back = decode_exr({reinterpret_cast<const uint8_t*>(input.data()), input.size()}, error, limits);
        EXPECT_TRUE(back || !error.empty());
    });
}

TEST_F(FuzzTest, render_settings) {
    const std::vector<Bytes> seeds = {R"({"scene":"scn_x","camera":"c","frames":"1-9x2,20","resolution":[1920,1080],"crop":[0,0,9,9],"samples":16,"stop":{"error":0.1,"seconds":5,"min_samples":4},
        "seed":3,"aovs":["shading"],"light_groups":"all","output":{"name":"a.%04d","pixel_type":"half","compression":"zip"},"overrides":[{"op":"replace","path":"/materials/a","value":1}],
        "priority":50,"labels":{"a":"b"},"retain":60,"reproducible":true})"};
    run("settings", seeds, 5000, [](const Bytes& input) {
        const auto json = parsed(input);
        if (!json) return;
        Diagnostics d;
        const auto settings = jobs::read_settings(*json, d);
        ASSERT_FALSE(settings.frames.empty());
        EXPECT_EQ(settings.file_name(settings.frames.back()).find('/'), std::string::npos);
    });
}

}  // namespace
}  // namespace alder
