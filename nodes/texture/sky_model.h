// The three sky models of the Sky Texture, as far as they are computed once for a sun: what a lookup by direction then needs.
#pragma once
#include <memory>
#include <vector>

namespace alder {

/// Sky as a closed formula of the angles to zenith and sun (Preetham, Hosek-Wilkie). Three components: Y, x, y of CIE xyY
/// (Preetham) or X, Y, Z (Hosek-Wilkie).
struct FormulaSky {
    float sun_phi = 0, sun_theta = 0;  ///< azimuth from +Y towards +X, angle to the zenith; radians
    float radiance[3] = {};
    float shape[3][9] = {};
};
FormulaSky preetham_sky(const float sun_direction[3], float turbidity);
FormulaSky hosek_sky(const float sun_direction[3], float turbidity, float ground_albedo);

/// Single scattering in the Earth's atmosphere, as a table over longitude and (upper half) latitude. CIE XYZ.
struct AtmosphereSettings {
    float sun_elevation = 0;  ///< radians, within +-pi/2
    float altitude_m = 0;     ///< of the viewer
    float air = 1, dust = 1, ozone = 1;  ///< densities relative to the Earth's
    bool operator==(const AtmosphereSettings&) const = default;
};
inline constexpr int kAtmosphereWidth = 512, kAtmosphereHeight = 128;
/// width * height * 3 numbers, rows from the horizon to the zenith, denser near the horizon (angle over pi/2 = (row/height)^2).
/// The sun stands at longitude 0, in the middle of a row. Takes about 0.3 s; the last few are kept. Thread safe.
std::shared_ptr<const std::vector<float>> atmosphere_table(const AtmosphereSettings& settings);

/// Radiance of the lowest and the highest point of the sun's disc, CIE XYZ.
struct SunDisc {
    float bottom[3], top[3];
};
SunDisc sun_disc(const AtmosphereSettings& settings, float diameter_rad);

/// Elevation brought to +-pi/2 (beyond the zenith the sun is seen on the other side), rotation to the angle used for lookups.
void normalize_sun_position(float& elevation_rad, float& rotation_rad);

}  // namespace alder
