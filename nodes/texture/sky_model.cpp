// Sky models. Preetham, Shirley, Smits, "A Practical Analytic Model for Daylight", SIGGRAPH 1999, appendix A.2; Hosek, Wilkie, "An
// Analytic Model for Full Spectral Sky-Dome Radiance", SIGGRAPH 2012; Nishita et al., "Display of the Earth Taking into Account
// Atmospheric Scattering", SIGGRAPH 1993, with ozone, spectrally, as Blender 4.5 sets it up (21 wavelengths, 32 steps).
// 32-bit arithmetic in Blender's order: heights are small differences of large radii, and their rounding shows in the result.
#include "nodes/texture/sky_model.h"

#include <algorithm>
#include <cmath>
#include <list>
#include <mutex>

#include "nodes/num/vec.h"
#include "nodes/texture/sky_hosek_data.h"

namespace alder {
namespace {

constexpr float kPi = 3.141592653589793f, kHalfPi = 1.5707963267948966f, kTwoPi = 6.283185307179586f;

float perez(const float* shape, float theta, float gamma) {
    const float c = std::cos(gamma);
    return (1.0f + shape[0] * std::exp(shape[1] / std::cos(theta))) * (1.0f + shape[2] * std::exp(shape[3] * gamma) + shape[4] * c * c);
}
float zenith_angle(const float direction[3]) { return std::acos(std::clamp(direction[2], -1.0f, 1.0f)); }

/// The quintic Bezier curve of Hosek and Wilkie through six control points `stride` apart, at t.
double quintic(const double* points, int stride, double t) {
    constexpr int kBinomial[6] = {1, 5, 10, 10, 5, 1};
    double sum = 0;
    for (int i = 0; i < 6; ++i) sum += kBinomial[i] * std::pow(1 - t, 5 - i) * std::pow(t, i) * points[i * stride];
    return sum;
}

// ---- the atmosphere ---------------------------------------------------------------------------------------------------
constexpr float kRayleighScaleM = 8e3f, kMieScaleM = 1.2e3f;   // heights over which the densities fall to 1/e
constexpr float kMieScattering = 2e-5f, kMieExtinction = 1.11f * kMieScattering;  // per metre at sea level
constexpr float kMieG = 0.76f, kMieG2 = kMieG * kMieG;         // asymmetry
constexpr float kEarthRadiusM = 6360e3f, kAtmosphereRadiusM = 6420e3f;
constexpr int kSteps = 32;
constexpr int kWavelengths = 21;
constexpr float kWavelengthStepNm = 20.0f;                     // 380 to 780 nm
// Per wavelength: irradiance at the top of the atmosphere (W m^-2 nm^-1), Rayleigh scattering and ozone absorption (m^-1), CIE 1931.
struct Band {
    float irradiance, rayleigh, ozone, xyz[3];
};
constexpr Band kBands[kWavelengths] = {
    {1.45756829855592995315f, 0.00005424820087636473f, 0.00000000325126849861f, {0.00136800000f, 0.00003900000f, 0.00645000100f}},
    {1.56596305559738380175f, 0.00004418549866505454f, 0.00000000585395365047f, {0.01431000000f, 0.00039600000f, 0.06785001000f}},
    {1.65148449067670455293f, 0.00003635151910165377f, 0.00000001977191155085f, {0.13438000000f, 0.00400000000f, 0.64560000000f}},
    {1.71496242737209314555f, 0.00003017929012024763f, 0.00000007309568762914f, {0.34828000000f, 0.02300000000f, 1.74706000000f}},
    {1.75797983805020541226f, 0.00002526320226989157f, 0.00000020084561514287f, {0.29080000000f, 0.06000000000f, 1.66920000000f}},
    {1.78256407885924539336f, 0.00002130859310621843f, 0.00000040383958096161f, {0.09564000000f, 0.13902000000f, 0.81295010000f}},
    {1.79095108475838560302f, 0.00001809838025320633f, 0.00000063551335912363f, {0.00490000000f, 0.32300000000f, 0.27200000000f}},
    {1.78541550133410664714f, 0.00001547057129129042f, 0.00000096707041180970f, {0.06327000000f, 0.71000000000f, 0.07824999000f}},
    {1.76815554864306845317f, 0.00001330284977336850f, 0.00000154797400424410f, {0.29040000000f, 0.95400000000f, 0.02030000000f}},
    {1.74122069647250410362f, 0.00001150184784075764f, 0.00000209038647223331f, {0.59450000000f, 0.99500000000f, 0.00390000000f}},
    {1.70647127164943679389f, 0.00000999557429990163f, 0.00000246128056164565f, {0.91630000000f, 0.87000000000f, 0.00165000100f}},
    {1.66556087452739887134f, 0.00000872799973630707f, 0.00000273551299461512f, {1.06220000000f, 0.63100000000f, 0.00080000000f}},
    {1.61993437242451854274f, 0.00000765513700977967f, 0.00000215125863128643f, {0.85444990000f, 0.38100000000f, 0.00019000000f}},
    {1.57083597368892080581f, 0.00000674217203751443f, 0.00000159051840791988f, {0.44790000000f, 0.17500000000f, 0.00002000000f}},
    {1.51932335059305478886f, 0.00000596134125832052f, 0.00000112356197979857f, {0.16490000000f, 0.06100000000f, 0.00000000000f}},
    {1.46628494965214395407f, 0.00000529034598065810f, 0.00000073527551487574f, {0.04677000000f, 0.01700000000f, 0.00000000000f}},
    {1.41245852740172450623f, 0.00000471115687557433f, 0.00000046450130357806f, {0.01135916000f, 0.00410200000f, 0.00000000000f}},
    {1.35844961970384092709f, 0.00000420910481110487f, 0.00000033096079921048f, {0.00289932700f, 0.00104700000f, 0.00000000000f}},
    {1.30474913844739281998f, 0.00000377218381260133f, 0.00000022512612292678f, {0.00069007860f, 0.00024920000f, 0.00000000000f}},
    {1.25174963272610817455f, 0.00000339051255477280f, 0.00000014879129266490f, {0.00016615050f, 0.00006000000f, 0.00000000000f}},
    {1.19975998755420620867f, 0.00000305591531679811f, 0.00000016828623364192f, {0.00004150994f, 0.00001499000f, 0.00000000000f}},
};

Vec3f direction_of(float latitude, float longitude) {
    return {std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude), std::sin(latitude)};
}
/// Relative densities of air, dust and ozone at a height in metres.
Vec3f densities(float height) {
    float ozone = 0;
    if (height >= 10000.0f && height < 25000.0f) ozone = 1.0f / 15000.0f * height - 2.0f / 3.0f;
    else if (height >= 25000 && height < 40000) ozone = -(1.0f / 15000.0f * height - 8.0f / 3.0f);
    return {std::exp(-height / kRayleighScaleM), std::exp(-height / kMieScaleM), ozone};
}
bool meets_earth(Vec3f p, Vec3f d) {
    if (d.z >= 0) return false;
    const float b = 2.0f * dot(d, p), c = dot(p, p) - kEarthRadiusM * kEarthRadiusM;
    return b * b - 4.0f * c >= 0;
}
/// Length of the ray from p to the top of the atmosphere.
float length_to_top(Vec3f p, Vec3f d) {
    const float b = 2.0f * dot(d, p), c = dot(p, p) - kAtmosphereRadiusM * kAtmosphereRadiusM;
    const float t = (-b + std::sqrt(b * b - 4.0f * c)) / 2.0f;
    const Vec3f end(p.x + d.x * t, p.y + d.y * t, p.z + d.z * t);
    return length(p - end);
}
/// Densities integrated from p to the top of the atmosphere. They fall about exponentially, so a Gauss-Laguerre rule of 8 points
/// serves, its last point still within the atmosphere: nodes x/25 and weights w e^x / 25 of the standard rule.
Vec3f optical_depth(Vec3f p, Vec3f d) {
    constexpr float kNodes[8] = {0.006811185292f, 0.03614807107f, 0.09004346519f, 0.1706680068f,
                                 0.2818362161f,   0.4303406404f,  0.6296271457f,  0.9145252695f};
    constexpr float kWeights[8] = {0.01750893642f, 0.04135477391f, 0.06678839063f, 0.09507698807f,
                                   0.1283416365f,  0.1707430204f,  0.2327233347f,  0.3562490486f};
    const float distance = length_to_top(p, d);
    const Vec3f ray = d * distance;
    Vec3f sum(0.0f);
    for (int i = 0; i < 8; ++i) sum += densities(length(p + ray * kNodes[i]) - kEarthRadiusM) * kWeights[i];
    return sum * distance;
}
Vec3f xyz_of(const float (&spectrum)[kWavelengths]) {
    Vec3f xyz(0.0f);
    for (int i = 0; i < kWavelengths; ++i)
        for (int c = 0; c < 3; ++c) xyz[c] += kBands[i].xyz[c] * spectrum[i];
    return xyz * kWavelengthStepNm;
}
/// Light scattered once into the ray from `p` along d.
Vec3f single_scattering(Vec3f p, Vec3f d, Vec3f sun, Vec3f density_scale) {
    const float step = length_to_top(p, d) / kSteps;
    const Vec3f segment = d * step;
    const float mu = dot(d, sun), mu2 = mu * mu;
    const float phase_air = 3.0f / (16.0f * kPi) * (1.0f + mu2);
    const float phase_dust = (3.0f * (1.0f - kMieG2) * (1.0f + mu2)) / (8.0f * kPi * (2.0f + kMieG2) * std::pow(1.0f + kMieG2 - 2.0f * kMieG * mu, 1.5f));
    Vec3f depth(0.0f);
    float spectrum[kWavelengths] = {};
    p = p + segment * 0.5f;
    for (int i = 0; i < kSteps; ++i) {
        const Vec3f density = density_scale * densities(length(p) - kEarthRadiusM);
        depth += density * step;
        if (!meets_earth(p, sun)) {
            const Vec3f total = depth + density_scale * optical_depth(p, sun);
            for (int w = 0; w < kWavelengths; ++w) {
                const Band& band = kBands[w];
                const float attenuation = std::exp(-(total.x * band.rayleigh + total.y * kMieExtinction + total.z * band.ozone));
                const float scattered = phase_air * (density.x * band.rayleigh) + phase_dust * (density.y * kMieScattering);
                spectrum[w] += attenuation * scattered * band.irradiance * step;
            }
        }
        p += segment;
    }
    return xyz_of(spectrum);
}

std::vector<float> compute_atmosphere(const AtmosphereSettings& s) {
    std::vector<float> table(static_cast<size_t>(kAtmosphereWidth) * kAtmosphereHeight * 3);
    const Vec3f viewer(0, 0, kEarthRadiusM + s.altitude_m), sun = direction_of(s.sun_elevation, 0.0f), scale(s.air, s.dust, s.ozone);
    constexpr float kHalfRow = kHalfPi / kAtmosphereHeight / 2.0f, kColumn = kTwoPi / kAtmosphereWidth;
    for (int y = 0; y < kAtmosphereHeight; ++y) {
        const float v = static_cast<float>(y) / kAtmosphereHeight;
        const float latitude = (kHalfPi + kHalfRow) * (v * v);
        float* const row = table.data() + static_cast<size_t>(y) * kAtmosphereWidth * 3;
        for (int x = 0; x < kAtmosphereWidth / 2; ++x) {
            const Vec3f xyz = single_scattering(viewer, direction_of(latitude, kColumn * static_cast<float>(x) - kPi), sun, scale);
            for (int c = 0; c < 3; ++c) row[x * 3 + c] = row[(kAtmosphereWidth - 1 - x) * 3 + c] = xyz[c];
        }
    }
    return table;
}

}  // namespace

FormulaSky preetham_sky(const float sun[3], float t) {
    FormulaSky s;
    const float theta = s.sun_theta = zenith_angle(sun);
    s.sun_phi = std::atan2(sun[0], sun[1]);
    const float theta2 = theta * theta, theta3 = theta2 * theta, t2 = t * t;
    const float chi = (4.0f / 9.0f - t / 120.0f) * (kPi - 2.0f * theta);
    // Luminance of the zenith in kcd/m², brought to the scale of a renderer, and its chromaticity.
    s.radiance[0] = ((4.0453f * t - 4.9710f) * std::tan(chi) - 0.2155f * t + 2.4192f) * 0.06f;
    s.radiance[1] = (0.00166f * theta3 - 0.00375f * theta2 + 0.00209f * theta) * t2 +
                    (-0.02903f * theta3 + 0.06377f * theta2 - 0.03202f * theta + 0.00394f) * t +
                    (0.11693f * theta3 - 0.21196f * theta2 + 0.06052f * theta + 0.25886f);
    s.radiance[2] = (0.00275f * theta3 - 0.00610f * theta2 + 0.00317f * theta) * t2 +
                    (-0.04214f * theta3 + 0.08970f * theta2 - 0.04153f * theta + 0.00516f) * t +
                    (0.15346f * theta3 - 0.26756f * theta2 + 0.06670f * theta + 0.26688f);
    // Distribution of Y, x, y: a ... e as linear functions of turbidity.
    constexpr float kSlope[3][5] = {{0.1787f, -0.3554f, -0.0227f, 0.1206f, -0.0670f},
                                    {-0.0193f, -0.0665f, -0.0004f, -0.0641f, -0.0033f},
                                    {-0.0167f, -0.0950f, -0.0079f, -0.0441f, -0.0109f}};
    constexpr float kOffset[3][5] = {{-1.4630f, 0.4275f, 5.3251f, -2.5771f, 0.3703f},
                                     {-0.2592f, 0.0008f, 0.2125f, -0.8989f, 0.0452f},
                                     {-0.2608f, 0.0092f, 0.2102f, -1.6537f, 0.0529f}};
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < 5; ++i) s.shape[c][i] = kSlope[c][i] * t + kOffset[c][i];
        s.radiance[c] /= perez(s.shape[c], 0, theta);
    }
    return s;
}

FormulaSky hosek_sky(const float sun[3], float turbidity, float ground_albedo) {
    FormulaSky s;
    s.sun_theta = std::clamp(zenith_angle(sun), 0.0f, kHalfPi);
    s.sun_phi = std::atan2(sun[0], sun[1]);
    turbidity = std::clamp(turbidity, 1.0f, 10.0f);
    const double elevation = kHalfPi - s.sun_theta;
    const double t = std::pow(elevation / 1.5707963267948966, 1.0 / 3.0);
    const int low = std::min(static_cast<int>(turbidity), 10) - 1, high = std::min(low + 1, 9);
    const double between = static_cast<double>(turbidity) - (low + 1), albedo = ground_albedo;
    const double weight[2][2] = {{(1 - albedo) * (1 - between), (1 - albedo) * between}, {albedo * (1 - between), albedo * between}};
    for (int c = 0; c < 3; ++c) {
        double radiance = 0, shape[9] = {};
        for (int a = 0; a < 2; ++a) {
            for (int h = 0; h < 2; ++h) {
                const int at = h ? high : low;
                radiance += weight[a][h] * quintic(kHosekRadiance[c][a][at], 1, t);
                for (int i = 0; i < 9; ++i) shape[i] += weight[a][h] * quintic(&kHosekShape[c][a][at][0][i], 9, t);
            }
        }
        s.radiance[c] = static_cast<float>(radiance);
        for (int i = 0; i < 9; ++i) s.shape[c][i] = static_cast<float>(shape[i]);
    }
    return s;
}

std::shared_ptr<const std::vector<float>> atmosphere_table(const AtmosphereSettings& settings) {
    using Table = std::shared_ptr<const std::vector<float>>;
    static std::mutex mutex;
    static std::list<std::pair<AtmosphereSettings, Table>> kept;  // most recently used first; 786 KB each
    constexpr size_t kMost = 8;
    std::lock_guard lock(mutex);
    for (auto it = kept.begin(); it != kept.end(); ++it) {
        if (it->first == settings) {
            kept.splice(kept.begin(), kept, it);
            return it->second;
        }
    }
    kept.emplace_front(settings, std::make_shared<const std::vector<float>>(compute_atmosphere(settings)));
    if (kept.size() > kMost) kept.pop_back();
    return kept.front().second;
}

SunDisc sun_disc(const AtmosphereSettings& s, float diameter) {
    const float half = diameter / 2.0f, solid_angle = kTwoPi * (1.0f - std::cos(half));
    SunDisc disc{};
    for (int end = 0; end < 2; ++end) {
        const float elevation = std::max(s.sun_elevation + (end ? half : -half), 0.0f);
        const Vec3f depth = optical_depth({0, 0, kEarthRadiusM + s.altitude_m}, direction_of(elevation, 0.0f));
        float spectrum[kWavelengths];
        for (int w = 0; w < kWavelengths; ++w) {
            const float extinction = kBands[w].rayleigh * depth.x * s.air + kMieExtinction * depth.y * s.dust;
            spectrum[w] = kBands[w].irradiance * std::exp(-extinction) / solid_angle;
        }
        const Vec3f xyz = xyz_of(spectrum);
        for (int c = 0; c < 3; ++c) (end ? disc.top : disc.bottom)[c] = xyz[c];
    }
    return disc;
}

void normalize_sun_position(float& elevation, float& rotation) {
    elevation = std::fmod(elevation, kTwoPi);
    if (std::fabs(elevation) >= kPi) elevation -= std::copysign(2.0f, elevation) * kPi;
    if (elevation >= kHalfPi || elevation <= -kHalfPi) {
        elevation = std::copysign(kPi, elevation) - elevation;
        rotation += kPi;
    }
    rotation = std::fmod(rotation, kTwoPi);
    if (rotation < 0) rotation += kTwoPi;
    rotation = kTwoPi - rotation;
}

}  // namespace alder
