// Colour spaces of image files: what their numbers mean, and the way to linear Rec.709, in which everything is rendered.
// Names are those of Blender's configuration, with the common other spellings. What has a formula is here; spaces made of tables
// (Filmic sRGB, AgX Base sRGB, a studio's own) come from an OpenColorIO configuration (image_load.cpp).
#pragma once
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace alder {

struct ColorSpace {
    enum class Curve { Linear, Srgb, Gamma24, FilmicLog, AgxLog };
    Curve curve = Curve::Linear;
    bool is_data = false;                                            ///< not a colour: alpha does not multiply, nothing is converted
    bool same_primaries = true;                                      ///< Rec.709 primaries: no matrix
    std::array<std::array<double, 3>, 3> to_rec709{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

    bool is_linear_rec709() const { return curve == Curve::Linear && same_primaries; }
    bool is_srgb() const { return curve == Curve::Srgb && same_primaries; }
    /// One colour to linear Rec.709.
    void to_linear_rec709(float (&rgb)[3]) const;
};

/// By name; empty where it is not known.
std::optional<ColorSpace> find_color_space(std::string_view name);
/// The names to show when one is not known; with all other spellings where `all`.
std::vector<std::string> color_space_names(bool all = false);

}  // namespace alder
