// Progressive renders: any sequence of advances, pauses, cancels, saves and loads gives the bits of one undisturbed render.
#include "render/progressive.h"

#include <gtest/gtest.h>

#include <sstream>

#include "scene_kit.h"

namespace alder::testing {
namespace {

SceneKit lit_sphere() {
    SceneKit kit;
    kit.add(sphere_mesh(0.3f, 8, true), kit.add_material(diffuse(0.8f, 0.5f, 0.3f)));
    kit.add(floor_quad(2, -0.3f), kit.add_material(surface_graph("ShaderNodeBsdfGlossy", {{"Roughness", 0.3}})));
    kit.scene.world.graph = noise_world(0.7f);
    kit.add_light(LightKind::Point, 20, translation(1, 1, 3));
    return kit;
}

RenderRequest request(int samples) {
    RenderRequest r;
    r.samples = samples;
    r.aovs = {"shading", "data", "quality", "half_b", "light_groups", "id_object"};
    return r;
}

void expect_same(const Image& a, const Image& b, const std::string& what) {
    ASSERT_EQ(a.layers.size(), b.layers.size()) << what;
    EXPECT_EQ(a.attributes, b.attributes) << what;
    for (size_t l = 0; l < a.layers.size(); ++l) {
        EXPECT_EQ(a.layers[l].name, b.layers[l].name) << what;
        for (size_t c = 0; c < a.layers[l].planes.size(); ++c)
            EXPECT_TRUE(a.layers[l].planes[c] == b.layers[l].planes[c]) << what << ": layer \"" << a.layers[l].name << "\" channel " << c;
    }
}

TEST(Progressive, any_advances_give_the_bits_of_one_render) {
    const auto prepared = lit_sphere().prepare();
    for (const auto& [offset, advances] : std::vector<std::pair<uint64_t, std::vector<int>>>{
             {0, {1}}, {0, {1, 1, 2, 4, 8}}, {0, {5, 11, 16, 3}}, {0, {1, 15, 16, 32, 64}}, {0, {7, 30, 50, 41}}, {5, {3, 40, 9}}, {24, {8, 8, 100}}}) {
        int total = 0;
        for (const int n : advances) total += n;
        RenderRequest r = request(total);
        r.sample_offset = offset;
        RenderStats stats;
        const Image whole = render(*prepared, r, stats);
        ProgressiveRender film(prepared, r);
        for (const int n : advances) {
            film.image();  // looking does not disturb
            ASSERT_TRUE(film.advance(n));
        }
        expect_same(whole, film.image(), std::to_string(total) + " samples from " + std::to_string(offset));
        EXPECT_EQ(film.samples(), uint64_t(total));
        EXPECT_EQ(film.stats().camera_rays, stats.camera_rays);
        EXPECT_EQ(film.stats().node_evaluations, stats.node_evaluations);
        EXPECT_EQ(film.estimated_error(), stats.estimated_error);
    }
}

TEST(Progressive, saved_and_loaded_at_any_point_it_goes_on_as_if_nothing_had_been) {
    const auto prepared = lit_sphere().prepare();
    const RenderRequest r = request(90);
    RenderStats stats;
    const Image whole = render(*prepared, r, stats);
    for (const int at : {0, 1, 13, 16, 48, 50, 89}) {
        std::stringstream file;
        {
            ProgressiveRender first(prepared, r);
            ASSERT_TRUE(first.advance(at));
            first.save(file);
        }
        ProgressiveRender second(prepared, r);
        std::string why;
        ASSERT_TRUE(second.load(file, why)) << "at " << at << ": " << why;
        EXPECT_EQ(second.samples(), uint64_t(at));
        ASSERT_TRUE(second.advance(90 - at));
        expect_same(whole, second.image(), "saved at " + std::to_string(at));
        EXPECT_EQ(second.stats().shadow_rays, stats.shadow_rays);
    }
}

TEST(Progressive, a_cancelled_pass_leaves_no_trace) {
    const auto prepared = lit_sphere().prepare();
    std::atomic<bool> cancel{false};
    RenderRequest r = request(64);
    RenderStats stats;
    const Image whole = render(*prepared, r, stats);
    r.cancel = &cancel;
    ProgressiveRender film(prepared, r);
    for (const auto& [samples, after] : std::vector<std::pair<int, double>>{{1, 0.3}, {9, 0.5}, {16, 0.2}, {48, 0.9}}) {
        const uint64_t before = film.samples();
        EXPECT_FALSE(film.advance(samples, [&](double f) { if (f > after) cancel = true; }));
        EXPECT_LT(film.samples(), before + samples);
        EXPECT_FALSE(film.advance(samples)) << "the flag is still set";
        cancel = false;
        EXPECT_TRUE(film.advance(3));
    }
    ASSERT_TRUE(film.advance(64 - film.samples()));
    expect_same(whole, film.image(), "after cancels");
}

TEST(Progressive, damaged_or_foreign_checkpoints_are_refused_and_change_nothing) {
    const auto prepared = lit_sphere().prepare();
    ProgressiveRender film(prepared, request(64));
    ASSERT_TRUE(film.advance(19));
    std::stringstream file;
    film.save(file);
    const std::string bytes = file.str();
    const Image before = film.image();
    const auto refused = [&](ProgressiveRender& to, const std::string& from) {
        std::istringstream in(from);
        std::string why;
        const bool taken = to.load(in, why);
        EXPECT_EQ(taken, why.empty());
        return !taken;
    };
    for (size_t cut = 0; cut < bytes.size(); cut += 1 + bytes.size() / 97) EXPECT_TRUE(refused(film, bytes.substr(0, cut))) << cut << " bytes of it";
    for (size_t at = 0; at < bytes.size(); at += 1 + bytes.size() / 211) {
        std::string flipped = bytes;
        flipped[at] ^= 0x10;
        EXPECT_TRUE(refused(film, flipped)) << "byte " << at;
    }
    expect_same(before, film.image(), "after refusals");
    RenderRequest other = request(64);
    other.seed = 77;
    ProgressiveRender seeded(prepared, other);
    EXPECT_TRUE(refused(seeded, bytes));
    other = request(64);
    other.aovs.pop_back();
    ProgressiveRender fewer(prepared, other);
    EXPECT_TRUE(refused(fewer, bytes));
    EXPECT_FALSE(refused(film, bytes));
}

TEST(Progressive, a_picture_has_the_layers_asked_for) {
    const auto prepared = lit_sphere().prepare();
    ProgressiveRender film(prepared, request(4));
    EXPECT_EQ(film.image().find("")->planes[0][0], 0.f) << "black before the first sample";
    ASSERT_TRUE(film.advance(4));
    const Image some = film.image({"data", "direct_diffuse"});
    EXPECT_TRUE(some.find("") && some.find("N") && some.find("Z") && some.find("direct_diffuse"));
    EXPECT_FALSE(some.find("emission"));
    const auto picture = film.picture();
    ASSERT_TRUE(film.advance(4));
    EXPECT_EQ(picture->samples(), 4u) << "a picture stays as it was";
}

TEST(Progressive, a_deadline_ends_an_advance_but_never_the_first_image) {
    const auto prepared = lit_sphere().prepare();
    ProgressiveRender film(prepared, request(1 << 20));
    film.set_deadline(ProgressiveRender::Clock::now());
    EXPECT_TRUE(film.advance(1));
    EXPECT_FALSE(film.advance(1));
    film.set_deadline(std::nullopt);
    EXPECT_TRUE(film.advance(1));
}

}  // namespace
}  // namespace alder::testing
