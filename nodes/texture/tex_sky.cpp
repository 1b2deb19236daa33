// Sky Texture: the colour of a clear sky in a direction, by the models of Preetham, Hosek-Wilkie, or Nishita with the sun's disc.
// Follows Cycles' SVM of Blender 4.5; what is computed once for a sun is in sky_model.cpp.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/texture/tex_sky.cpp"
#include "hwy/foreach_target.h"

#include "nodes/color/spectrum_tables.h"
#include "nodes/math/cycles-inl.h"
#include "nodes/texture/sky_model.h"
#include "nodes/texture/texture_mapping-inl.h"

#ifndef ALDER_TEX_SKY_PREPARED
#define ALDER_TEX_SKY_PREPARED
namespace alder {
struct PreparedSky : PreparedTexture {
    FormulaSky formula;
    // Nishita:
    std::shared_ptr<const std::vector<float>> table;
    SunDisc disc{};
    float sun_elevation = 0, sun_rotation = 0, sun_diameter = 0, sun_intensity = 0;
    float sun_direction[3] = {};
};
}  // namespace alder
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

namespace tex_sky {
enum Parameter {
    kMapping, kType, kSunDirection, kTurbidity, kGroundAlbedo, kSunDisc, kSunSize, kSunIntensity, kSunElevation, kSunRotation,
    kAltitude, kAir, kDust, kOzone, kVector
};
enum Model { kPreetham, kHosek, kNishita };
constexpr float kPi = 3.141592653589793f, kHalfPi = 1.5707963267948966f, kTwoPi = 6.283185307179586f;

template <class F>
HWY_INLINE Vec3<F> clamped_rgb(Vec3<F> xyz) {
    Vec3<F> rgb;
    for (int c = 0; c < 3; ++c)
        rgb[c] = second_max(F(kXyzToRgb[c][0]) * xyz.x + F(kXyzToRgb[c][1]) * xyz.y + F(kXyzToRgb[c][2]) * xyz.z, F(0));
    return rgb;
}

/// Direction (channel 0) to the angle from the zenith, kept off the horizon, and the angle to the sun.
template <class F>
HWY_INLINE void angles(const FormulaSky& sky, Vec3<F> d, F& theta, F& gamma) {
    const F t = safe_acos(d.z), phi = F(kHalfPi) - atan2(d.y, d.x);
    const F sun(sky.sun_theta);
    gamma = safe_acos(sin(t) * sin(sun) * cos(F(sky.sun_phi) - phi) + cos(t) * cos(sun));
    theta = second_min(t, F(kHalfPi - 0.001f));
}
/// Preetham et al., equation 3.
template <class F>
HWY_INLINE F perez(const float* s, F cos_theta, F gamma, F cos_gamma) {
    return (F(1) + F(s[0]) * exp(F(s[1]) / cos_theta)) * (F(1) + F(s[2]) * exp(F(s[3]) * gamma) + F(s[4]) * cos_gamma * cos_gamma);
}
/// Hosek and Wilkie, equation 8.
template <class F>
HWY_INLINE F hosek(const float* s, F cos_theta, F gamma, F cos_gamma) {
    const F rayleigh = cos_gamma * cos_gamma;
    const F base = F(1) + F(s[8]) * F(s[8]) - F(2) * F(s[8]) * cos_gamma;
    const F mie = (F(1) + rayleigh) / (base * sqrt(base));
    return (F(1) + F(s[0]) * exp(F(s[1]) / (cos_theta + F(0.01f)))) *
           (F(s[2]) + F(s[3]) * exp(F(s[4]) * gamma) + F(s[5]) * rayleigh + F(s[6]) * mie + F(s[7]) * sqrt(cos_theta));
}

/// Bilinear between the texel centres of the atmosphere's table, clamped at its borders; u, v in 0 ... 1.
template <class F>
HWY_INLINE Vec3<F> atmosphere_at(const float* table, F u, F v) {
    using I = Int<F>;
    const F x = u * F(kAtmosphereWidth) - F(0.5), y = v * F(kAtmosphereHeight) - F(0.5);
    const F fx = floor(x), fy = floor(y), tx = x - fx, ty = y - fy;
    const I ix = to_int(fx), iy = to_int(fy);
    const I last_x(kAtmosphereWidth - 1), last_y(kAtmosphereHeight - 1);
    const I x0 = min(max(ix, I(0)), last_x), x1 = min(max(ix + I(1), I(0)), last_x);
    const I y0 = shl<9>(min(max(iy, I(0)), last_y)), y1 = shl<9>(min(max(iy + I(1), I(0)), last_y));
    static_assert(kAtmosphereWidth == 512);
    const I corner[4] = {y0 + x0, y0 + x1, y1 + x0, y1 + x1};
    const F weight[4] = {(F(1) - ty) * (F(1) - tx), (F(1) - ty) * tx, ty * (F(1) - tx), ty * tx};
    Vec3<F> sum(F(0));
    for (int k = 0; k < 4; ++k) {
        const I at = corner[k] + corner[k] + corner[k];
        for (int c = 0; c < 3; ++c) sum[c] = sum[c] + weight[k] * gather<F>(table + c, at);
    }
    return sum;
}
}  // namespace tex_sky

template <bool kIsPreetham>
struct SkyFormula {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        using namespace tex_sky;
        const FormulaSky& sky = static_cast<const PreparedSky*>(k.statics().prepared.get())->formula;
        F theta, gamma;
        angles(sky, mapped_vector(k, 0), theta, gamma);
        const F ct = cos(theta), cg = cos(gamma);
        F v[3];
        for (int c = 0; c < 3; ++c)
            v[c] = F(sky.radiance[c]) * (kIsPreetham ? perez(sky.shape[c], ct, gamma, cg) : hosek(sky.shape[c], ct, gamma, cg));
        if constexpr (kIsPreetham) {
            const F Y = v[0], x = v[1], y = v[2];
            const Mask<F> grey = y == F(0);
            const F X = select(grey, F(0), x / y * Y), Z = select(grey | (Y == F(0)), F(0), (F(1) - x - y) / y * Y);
            k.set(0, clamped_rgb(Vec3<F>(X, Y, Z)));
        } else {
            k.set(0, clamped_rgb(Vec3<F>(v[0], v[1], v[2])) * F(kTwoPi / 683));  // 683 lm/W
        }
    }
};

struct SkyAtmosphere {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        using namespace tex_sky;
        const auto& sky = *static_cast<const PreparedSky*>(k.statics().prepared.get());
        const Vec3<F> d = mapped_vector(k, 0);
        const F elevation = F(kHalfPi) - safe_acos(d.z), phi = atan2(d.y, d.x);
        const Mask<F> above = d.z >= F(0);
        const F u = fract((-phi - F(kHalfPi) + F(sky.sun_rotation)) / F(kTwoPi));
        const F v = select(above, sqrt(second_max(elevation / F(kHalfPi), F(0))), F(-0.5));
        Vec3<F> xyz = atmosphere_at(sky.table->data(), u, v);
        // Below the horizon its colour fades to black.
        F fade = F(1) + d.z * F(2.5);
        fade = fade * fade * fade;
        fade = select(d.z < F(-0.4f), F(0), fade);
        xyz = select<F>(above, xyz, select<F>(d.z < F(-0.4f), Vec3<F>(F(0)), xyz * fade));
        if (sky.sun_diameter > 0) {
            const Vec3<F> sun(F(sky.sun_direction[0]), F(sky.sun_direction[1]), F(sky.sun_direction[2]));
            const F half(sky.sun_diameter * 0.5f);
            const F angle = F(2) * atan2(length(d - sun), length(d + sun));  // precise for small angles
            const Mask<F> inside = above & (angle < half);
            if (any(inside)) {
                const float top = sky.sun_elevation + sky.sun_diameter * 0.5f;
                const F y = sky.sun_elevation - sky.sun_diameter * 0.5f > 0
                                ? (elevation - F(sky.sun_elevation)) / F(sky.sun_diameter) + F(0.5)
                                : elevation / F(top > 0 ? top : 1.0f);
                const F ratio = angle / half;
                const F limb = F(1) - F(0.6f) * (F(1) - sqrt(second_max(F(1) - ratio * ratio, F(0))));  // limb darkening
                Vec3<F> disc;
                for (int c = 0; c < 3; ++c)
                    disc[c] = (F(sky.disc.bottom[c]) + y * F(sky.disc.top[c] - sky.disc.bottom[c])) * F(sky.sun_intensity) * limb;
                xyz = select<F>(inside, disc, xyz);
            }
        }
        k.set(0, clamped_rgb(xyz));
    }
};
template <class F>
void tex_sky_kernel(const Call<F>& c) {
    switch (c.statics().e(tex_sky::kType)) {
        case tex_sky::kPreetham: return c.template each<SkyFormula<true>>();
        case tex_sky::kHosek: return c.template each<SkyFormula<false>>();
        default: return c.template each<SkyAtmosphere>();
    }
}
ALDER_KERNEL(tex_sky_kernel)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "graph/lowering.h"

namespace alder {
ALDER_KERNEL_EXPORT(tex_sky_kernel)
namespace p = HWY_NAMESPACE::tex_sky;

/// Whether the node looks along the ray and has no Vector: the sun's disc is one of the world.
static bool takes_ray(const Statics& s) { return s.e(p::kType) == p::kNishita && s.e(p::kSunDisc); }

static std::shared_ptr<const Prepared> prepare_sky(const Statics& s, std::vector<std::string>& errors) {
    auto sky = std::make_shared<PreparedSky>();
    sky->mapping = parse_texture_mapping(s.text[p::kMapping], errors);
    const auto number = [&](int param) { return std::strtof(s.text[param].c_str(), nullptr); };
    float sun[3] = {};
    const char* at = s.text[p::kSunDirection].c_str();
    for (float& c : sun) {
        char* end = nullptr;
        c = std::strtof(at, &end);
        at = end;
    }
    switch (s.e(p::kType)) {
        case p::kPreetham: sky->formula = preetham_sky(sun, number(p::kTurbidity)); break;
        case p::kHosek: sky->formula = hosek_sky(sun, number(p::kTurbidity), number(p::kGroundAlbedo)); break;
        default: {
            sky->sun_elevation = number(p::kSunElevation);
            sky->sun_rotation = number(p::kSunRotation);
            normalize_sun_position(sky->sun_elevation, sky->sun_rotation);
            AtmosphereSettings a;
            a.sun_elevation = sky->sun_elevation;
            a.altitude_m = std::clamp(number(p::kAltitude), 1.0f, 59999.0f);  // less loses digits, more is space
            a.air = number(p::kAir);
            a.dust = number(p::kDust);
            a.ozone = number(p::kOzone);
            sky->table = atmosphere_table(a);
            if (s.e(p::kSunDisc)) {
                sky->sun_diameter = std::max(number(p::kSunSize), 0.0005f);
                sky->sun_intensity = number(p::kSunIntensity);
                sky->disc = sun_disc(a, sky->sun_diameter);
            }
            const float theta = sky->sun_elevation - p::kHalfPi, phi = sky->sun_rotation - p::kHalfPi;
            sky->sun_direction[0] = std::sin(theta) * std::cos(phi);
            sky->sun_direction[1] = std::sin(theta) * std::sin(phi);
            sky->sun_direction[2] = std::cos(theta);
        }
    }
    return sky;
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeTexSky";
    n.aliases = {"sky_texture"};
    n.system = System::Cycles;
    n.category = "texture";
    n.summary = "the colour of a clear sky by direction, with or without the sun's disc";
    n.help = "Preetham and Hosek-Wilkie: formulas in the sun's direction and the turbidity of the air. Nishita: light scattered once in the Earth's "
             "atmosphere of air, dust and ozone; with Sun Disc the node has no Vector and looks along the ray.";
    n.params = {
        texture_mapping_param(),
        choice("sky_type", {{"PREETHAM", "Preetham", "preetham"}, {"HOSEK_WILKIE", "Hosek / Wilkie", "hosek_wilkie"}, {"NISHITA", "Nishita", "nishita_improved"}},
               "NISHITA").doc("the model"),
        vector("sun_direction", 0, 0, 1).no_link().doc("towards the sun, unit length (Preetham, Hosek / Wilkie)"),
        f("turbidity", 2.20000005).range(1, 10).no_link().doc("haze: 1 is pure air, 10 much dust (Preetham, Hosek / Wilkie)"),
        f("ground_albedo", 0.300000012).range(0, 1).no_link().doc("how bright the ground lights the sky (Hosek / Wilkie)"),
        b("sun_disc", true).no_link().doc("whether the sun itself is there (Nishita)"),
        f("sun_size", 0.00951204449).range(0, 1.57079637).no_link().doc("diameter of the sun, radians"),
        f("sun_intensity", 1).range(0, 1000).no_link().doc("multiplies the radiance of the sun's disc"),
        f("sun_elevation", 0.261799395).range(-3.2, 3.2).no_link().doc("angle of the sun above the horizon, radians"),
        f("sun_rotation", 0).range(-6.3, 6.3).no_link().doc("turns the sun about the zenith, radians"),
        f("altitude", 0).range(0, 60000).no_link().doc("height of the viewer above the sea, metres"),
        f("air_density", 1).range(0, 10).no_link().doc("density of the air, 1 as on Earth"),
        f("dust_density", 1).range(0, 10).no_link().doc("density of dust and water droplets"),
        f("ozone_density", 1).range(0, 10).no_link().doc("density of ozone: makes the sky bluer"),
        vector("Vector", 0, 0, 0).unlinked(Global::Generated).doc("the direction; unlinked: generated coordinates, in a world the ray's direction"),
        color_mapping_param(),
    };
    n.outputs = {{"Color", Type::Color}};
    n.cost_ns = 60;
    n.uses = [](const Statics& s, int param) {
        const bool nishita = s.e(p::kType) == p::kNishita;
        if (param == p::kVector) return !takes_ray(s);
        if (param == p::kSunSize || param == p::kSunIntensity) return takes_ray(s);
        if (param == p::kGroundAlbedo) return s.e(p::kType) == p::kHosek;
        if (param == p::kSunDirection || param == p::kTurbidity) return !nishita;
        if (param >= p::kSunDisc && param <= p::kOzone) return nishita;
        return true;
    };
    n.prepare = prepare_sky;
    n.lower = [](Lowering& l, int) {
        const ValueRef direction = takes_ray(l.statics()) ? l.global(Global::Generated) : l.input(p::kVector);
        l.result(l.op("tex_sky", tex_sky_kernel_kernel(), std::span(&direction, 1), Type::Color));
    };
    return n;
}
}  // namespace alder
#endif
