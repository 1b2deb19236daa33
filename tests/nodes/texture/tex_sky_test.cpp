// Sky models: symmetries, limits and the sun's position; values come from the reference tables.
#include "nodes/texture/sky_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "graph/material.h"

namespace alder {
namespace {

TEST(Sky, sun_position_beyond_the_zenith_is_on_the_other_side) {
    float elevation = 2.0f, rotation = 0.5f;
    normalize_sun_position(elevation, rotation);
    EXPECT_NEAR(elevation, M_PI - 2.0, 1e-6);
    EXPECT_NEAR(rotation, 2 * M_PI - (0.5 + M_PI), 1e-5);
    elevation = -7.0f, rotation = -1.0f;
    normalize_sun_position(elevation, rotation);
    EXPECT_NEAR(elevation, 2 * M_PI - 7, 1e-5);
    EXPECT_NEAR(rotation, 1.0, 1e-5);
}
TEST(Sky, more_air_makes_the_zenith_brighter_and_the_sun_redder) {
    AtmosphereSettings thin, thick;
    thin.sun_elevation = thick.sun_elevation = 0.3f;
    thin.altitude_m = thick.altitude_m = 1;
    thick.air = 2;
    const size_t zenith = (static_cast<size_t>(kAtmosphereHeight - 1) * kAtmosphereWidth) * 3 + 1;
    EXPECT_GT((*atmosphere_table(thick))[zenith], 1.3f * (*atmosphere_table(thin))[zenith]);
    const SunDisc a = sun_disc(thin, 0.01f), b = sun_disc(thick, 0.01f);
    EXPECT_LT(b.top[2] / b.top[0], a.top[2] / a.top[0]);
    EXPECT_LT(a.bottom[1], a.top[1]) << "the lower limb shines through more air";
}
TEST(Sky, tables_are_symmetric_about_the_sun_and_kept) {
    AtmosphereSettings s;
    s.sun_elevation = 0.1f;
    s.altitude_m = 500;
    const auto t = atmosphere_table(s);
    for (int y = 0; y < kAtmosphereHeight; y += 9)
        for (int x = 0; x < kAtmosphereWidth / 2; x += 17)
            EXPECT_EQ((*t)[(static_cast<size_t>(y) * kAtmosphereWidth + x) * 3], (*t)[(static_cast<size_t>(y) * kAtmosphereWidth + kAtmosphereWidth - 1 - x) * 3]);
    EXPECT_EQ(atmosphere_table(s), t);
}
TEST(Sky, hosek_interpolates_between_whole_turbidities) {
    const float sun[3] = {0, 0.6f, 0.8f};
    const FormulaSky a = hosek_sky(sun, 3, 0.2f), b = hosek_sky(sun, 4, 0.2f), c = hosek_sky(sun, 3.5f, 0.2f), top = hosek_sky(sun, 10, 1), above = hosek_sky(sun, 99, 1);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(c.radiance[i], 0.5f * (a.radiance[i] + b.radiance[i]), 1e-5f);
    EXPECT_EQ(top.radiance[0], above.radiance[0]);
    EXPECT_EQ(hosek_sky(sun, -5, 0).radiance[0], hosek_sky(sun, 1, 0).radiance[0]);
}
TEST(Sky, an_edit_of_a_fixed_number_compiles_again) {
    Diagnostics d;
    const nlohmann::json doc = {{"nodes", {{"n", {{"type", "ShaderNodeTexSky"}, {"params", {{"sky_type", "PREETHAM"}, {"Vector", {0, 0.6, 0.8}}}}}}}}};
    const auto m = build_material(doc, {}, d);
    ASSERT_TRUE(m);
    const auto value = [&](const Material& material) {
        const auto p = material.program({.outputs = {"n"}}, d);
        const EvalContext context;
        Executor<float> x(context, true);
        x.run(*p, 1, {});
        return x.channel(p->outputs()[0].register_first).p[0];
    };
    const auto hazy = m->with_param("/nodes/n/params/turbidity", 6.0, d);
    ASSERT_TRUE(hazy);
    EXPECT_GT(std::fabs(value(*hazy) - value(*m)), 0.01f);
}

}  // namespace
}  // namespace alder
