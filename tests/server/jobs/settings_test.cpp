// Settings of renders: frames, file names, seeds, and every fault at its place.
#include "server/jobs/settings.h"

#include <set>

#include <gtest/gtest.h>

namespace alder::jobs {
namespace {

using nlohmann::json;

TEST(JobSettings, frames) {
    EXPECT_EQ(parse_frames("7", 10), (std::vector<int>{7}));
    EXPECT_EQ(parse_frames("1-3", 10), (std::vector<int>{1, 2, 3}));
    EXPECT_EQ(parse_frames("1-9x4,2,-1-1", 10), (std::vector<int>{-1, 0, 1, 2, 5, 9}));
    for (const char* bad : {"", "a", "1-", "3-1", "1,,2", "1-5x0", "1-5x", "1 2", "1-11", "99999999999999", "1-1000000", ",1", "1,"})
        EXPECT_TRUE(parse_frames(bad, 10).empty()) << bad;
}

TEST(JobSettings, file_names) {
    const auto named = [](const char* name, const char* frames) {
        Diagnostics d;
        json body = {{"scene", "s"}, {"output", {{"name", name}}}};
        if (frames) body["frames"] = frames;
        const JobSettings s = read_settings(body, d);
        EXPECT_TRUE(d.ok()) << name;
        return s.file_name(s.frames.back());
    };
    EXPECT_EQ(named("shot.%04d", "1-12"), "shot.0012.exr");
    EXPECT_EQ(named("shot%d_x.exr", "12"), "shot12_x.exr");
    EXPECT_EQ(named("shot", "1-2"), "shot.0002.exr") << "two frames need two names";
    EXPECT_EQ(named("shot", nullptr), "shot.exr");
    for (const char* bad : {"../x", ".x", "a/b", "%s", "%04d%04d", "%", "a\nb", "%12345d", ""}) {
        Diagnostics d;
        read_settings({{"scene", "s"}, {"output", {{"name", bad}}}}, d);
        ASSERT_EQ(d.errors.size(), 1u) << bad;
        EXPECT_EQ(d.errors[0].pointer, "/output/name");
    }
}

TEST(JobSettings, every_frame_has_its_seed) {
    Diagnostics d;
    const JobSettings one = read_settings({{"scene", "s"}, {"seed", 5}}, d);
    EXPECT_EQ(one.frame_seed(0, 1), 5u) << "without frames: as alder render has it";
    const JobSettings many = read_settings({{"scene", "s"}, {"frames", "1-1000"}}, d);
    std::set<uint32_t> seeds;
    for (const int f : many.frames) seeds.insert(many.frame_seed(f, 3));
    EXPECT_EQ(seeds.size(), 1000u);
    EXPECT_EQ(seeds.count(0), 0u);
}

TEST(JobSettings, all_faults_at_once) {
    Diagnostics d;
    read_settings({{"scene", 1}, {"frame", 1}, {"frames", "1"}, {"priority", 101}, {"labels", {{"a", 1}}}, {"overrides", {{{"op", "move"}}}}, {"farm", "x"}, {"stop", {{"error", 0}}}, {"retain", -1}}, d);
    std::set<std::string> places;
    for (const auto& e : d.errors) places.insert(e.pointer);
    EXPECT_EQ(places, (std::set<std::string>{"/scene", "/frame", "/priority", "/labels", "/overrides", "/farm", "/stop/error", "/retain"}));
}

TEST(JobSettings, memory_grows_with_pixels_and_layers) {
    Diagnostics d;
    const JobSettings plain = read_settings({{"scene", "s"}}, d), rich = read_settings({{"scene", "s"}, {"aovs", {"shading", "data"}}}, d);
    const uint64_t a = film_bytes(plain, 100, 100, {}), b = film_bytes(plain, 200, 100, {}), c = film_bytes(rich, 100, 100, {});
    EXPECT_EQ(b, 2 * a);
    EXPECT_GT(c, 3 * a);
    EXPECT_GE(a, 100u * 100u * 4u * sizeof(float));
}

}  // namespace
}  // namespace alder::jobs
