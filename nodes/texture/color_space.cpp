// Colour spaces of image files. Matrices are computed from chromaticities: SMPTE RP 177, "Derivation of Basic Television Color
// Equations", 1993; adaptation of white by Bradford, Lam 1985.
#include "nodes/texture/color_space.h"

#include <cmath>

namespace alder {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;
using Vector = std::array<double, 3>;

Matrix multiply(const Matrix& a, const Matrix& b) {
    Matrix m{};
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            for (int k = 0; k < 3; ++k) m[i][j] += a[i][k] * b[k][j];
        }
    }
    return m;
}
Vector multiply(const Matrix& a, const Vector& v) {
    Vector r{};
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) r[i] += a[i][k] * v[k];
    }
    return r;
}
Matrix inverse(const Matrix& m) {
    Matrix r{};
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            const int a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
            r[i][j] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
        }
    }
    const double determinant = m[0][0] * r[0][0] + m[0][1] * r[1][0] + m[0][2] * r[2][0];
    for (auto& row : r) {
        for (double& v : row) v /= determinant;
    }
    return r;
}

struct Chromaticity {
    double x, y;
};
constexpr Chromaticity kD65{0.3127, 0.3290}, kD60{0.32168, 0.33767}, kE{1.0 / 3, 1.0 / 3};  // ITU-R BT.709; ACES (TB-2018-001)

Vector xyz_of(Chromaticity c) { return {c.x / c.y, 1, (1 - c.x - c.y) / c.y}; }

Matrix rgb_to_xyz(Chromaticity r, Chromaticity g, Chromaticity b, Chromaticity white) {
    const Vector columns[3] = {xyz_of(r), xyz_of(g), xyz_of(b)};
    Matrix m;
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) m[i][k] = columns[k][i];
    }
    const Vector scale = multiply(inverse(m), xyz_of(white));
    for (auto& row : m) {
        for (int k = 0; k < 3; ++k) row[k] *= scale[k];
    }
    return m;
}
Matrix adaptation(Chromaticity from, Chromaticity to) {
    const Matrix bradford{{{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}}};
    const Vector a = multiply(bradford, xyz_of(from)), b = multiply(bradford, xyz_of(to));
    Matrix scale{};
    for (int i = 0; i < 3; ++i) scale[i][i] = b[i] / a[i];
    return multiply(inverse(bradford), multiply(scale, bradford));
}
Matrix xyz_to_rec709() { return inverse(rgb_to_xyz({0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, kD65)); }

Matrix rec2020() { return multiply(xyz_to_rec709(), rgb_to_xyz({0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, kD65)); }
Matrix p3_d65() { return multiply(xyz_to_rec709(), rgb_to_xyz({0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, kD65)); }
Matrix aces_ap1() {
    return multiply(xyz_to_rec709(),
                    multiply(adaptation(kD60, kD65), rgb_to_xyz({0.713, 0.293}, {0.165, 0.830}, {0.128, 0.044}, kD60)));
}
Matrix aces_ap0() {
    return multiply(xyz_to_rec709(),
                    multiply(adaptation(kD60, kD65), rgb_to_xyz({0.7347, 0.2653}, {0.0, 1.0}, {0.0001, -0.0770}, kD60)));
}

/// FilmLight, E-Gamut to CIE XYZ (D65).
Matrix e_gamut() {
    return multiply(xyz_to_rec709(), Matrix{{{0.7053968501, 0.1640413283, 0.08101774865},
                                             {0.2801307241, 0.8202066415, -0.1003373656},
                                             {-0.1037815116, -0.07290725703, 1.265746519}}});
}
/// AgX in Blender's configuration pulls the primaries of Rec.2020 in before its logarithm; this takes them out again.
Matrix agx_outset() {
    return inverse(Matrix{{{0.856627153315983, 0.0951212405381588, 0.0482516061458583},
                           {0.137318972929847, 0.761241990602591, 0.101439036467562},
                           {0.11189821299995, 0.0767994186031903, 0.811302368396859}}});
}

struct Named {
    std::vector<std::string_view> names;  ///< Blender's first
    ColorSpace space;
};
ColorSpace make(ColorSpace::Curve curve, Matrix matrix) {
    ColorSpace s;
    s.curve = curve;
    s.same_primaries = false;
    s.to_rec709 = matrix;
    return s;
}
ColorSpace make(ColorSpace::Curve curve, bool is_data = false) {
    ColorSpace s;
    s.curve = curve;
    s.is_data = is_data;
    return s;
}
const std::vector<Named>& table() {
    using Curve = ColorSpace::Curve;
    static const std::vector<Named> spaces = {
        {{"sRGB", "srgb", "srgb_texture", "sRGB - Texture", "sRGB EOTF", "__builtin_srgb", "sRGB 2.2", "sRGB I-D65", "srgb_display",
          "srgb_rec709_scene", "sRGB - Display", "Utility - sRGB - Texture", "srgb_tx", "Input - Generic - sRGB - Texture"}, make(Curve::Srgb)},
        {{"Non-Color", "Non-Colour Data", "Generic Data", "Raw", "raw", "Utility - Raw", "data"}, make(Curve::Linear, true)},
        {{"Linear Rec.709", "Linear", "linear", "scene_linear", "lin_rec709", "lin_srgb", "Linear BT.709", "Utility - Linear - sRGB",
          "__builtin_raw", "Linear BT.709 I-D65", "Linear Tristimulus", "linrec709", "Utility - Linear - Rec.709", "Linear Rec.709 (sRGB)",
          "lin_rec709_srgb", "lin_rec709_scene", "CGI: Linear - Rec.709"}, make(Curve::Linear)},
        {{"Linear Rec.2020", "lin_rec2020", "Linear BT.2020", "Linear BT.2020 I-D65", "lin_rec2020_scene", "Utility - Linear - Rec.2020"},
         make(Curve::Linear, rec2020())},
        {{"Linear DCI-P3 D65", "lin_p3d65", "Linear P3-D65", "Linear DCI-P3 I-D65", "lin_p3d65_scene", "Utility - Linear - P3-D65", "Apple DCI-P3 D65"},
         make(Curve::Linear, p3_d65())},
        {{"Linear FilmLight E-Gamut", "Linear E-Gamut I-D65", "FilmLight: Linear - E-Gamut"}, make(Curve::Linear, e_gamut())},
        {{"Display P3", "srgb_displayp3", "Display P3 2.2", "Display P3 I-D65", "P3-D65 - Display", "p3_d65_display", "p3d65_display",
          "AppleP3 sRGB OETF"}, make(Curve::Srgb, p3_d65())},
        {{"ACEScg", "acescg", "lin_ap1", "ACES - ACEScg", "Linear ACEScg", "lin_ap1_scene", "ACEScg: Linear - AP1"}, make(Curve::Linear, aces_ap1())},
        {{"ACES2065-1", "aces2065_1", "lin_ap0", "ACES - ACES2065-1", "Linear ACES", "lin_ap0_scene", "ACES: Linear - AP0"},
         make(Curve::Linear, aces_ap0())},
        {{"Linear CIE-XYZ D65", "cie_xyz_d65", "XYZ", "CIE-XYZ-D65", "Linear CIE-XYZ I-D65", "lin_ciexyzd65_scene"}, make(Curve::Linear, xyz_to_rec709())},
        {{"Linear CIE-XYZ E", "FilmLight: Linear - XYZ", "Linear CIE-XYZ I-E"}, make(Curve::Linear, multiply(xyz_to_rec709(), adaptation(kE, kD65)))},
        {{"Rec.1886", "rec1886", "Rec.709", "BT.1886", "BT.1886 2.4", "BT.1886 EOTF", "BT.1886 I-D65", "Rec.1886 / Rec.709 Video - Display",
          "rec1886_rec709_video_display", "Rec.1886 Rec.709 - Display", "rec1886_rec709_display", "Rec1886: 2.4 Gamma - Rec.709"}, make(Curve::Gamma24)},
        {{"Rec.2020", "BT.2020", "BT.2020 2.4", "BT.2020 I-D65", "Rec.1886 / Rec.2020 Video - Display", "rec1886_rec2020_video_display",
          "Rec.1886 Rec.2020 - Display", "rec1886_rec2020_display", "Rec1886: 2.4 Gamma - Rec.2020"}, make(Curve::Gamma24, rec2020())},
        {{"Filmic Log"}, make(Curve::FilmicLog)},
        {{"AgX Log"}, make(Curve::AgxLog, multiply(rec2020(), agx_outset()))},
    };
    return spaces;
}

float linear_of(ColorSpace::Curve curve, float c) {
    switch (curve) {
        case ColorSpace::Curve::Srgb:  // IEC 61966-2-1
            return c < 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
        case ColorSpace::Curve::Gamma24: return c < 0 ? 0 : std::pow(c, 2.4f);  // ITU-R BT.1886, black 0
        // Blender's configuration: 0 ... 1 are so many stops about 1 (lg2 allocations).
        case ColorSpace::Curve::FilmicLog: return std::exp2(c * 16.5f - 12.473931188f);
        case ColorSpace::Curve::AgxLog: return std::exp2(c * 24.9999988117f - 12.47393f);
        default: return c;
    }
}

}  // namespace

void ColorSpace::to_linear_rec709(float (&rgb)[3]) const {
    if (is_data) return;
    const double linear[3] = {linear_of(curve, rgb[0]), linear_of(curve, rgb[1]), linear_of(curve, rgb[2])};
    for (int i = 0; i < 3; ++i) {
        rgb[i] = static_cast<float>(to_rec709[i][0] * linear[0] + to_rec709[i][1] * linear[1] + to_rec709[i][2] * linear[2]);
    }
}

std::optional<ColorSpace> find_color_space(std::string_view name) {
    for (const Named& n : table()) {
        for (const std::string_view candidate : n.names) {
            if (candidate == name) return n.space;
        }
    }
    return std::nullopt;
}
std::vector<std::string> color_space_names(bool all) {
    std::vector<std::string> names;
    for (const Named& n : table()) {
        names.emplace_back(n.names[0]);
        if (all) names.insert(names.end(), n.names.begin() + 1, n.names.end());
    }
    return names;
}

}  // namespace alder
