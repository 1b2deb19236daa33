// Figures of error between two images: what `alder diff` and `alder ci` print and hold against limits.
//
//   rmse            sqrt(mean((x - r)^2))
//   relmse          mean((x - r)^2 / (r^2 + 0.01)), over channels and pixels
//   relmse_trimmed  the same without the worst 0.1 % of the pixels
//   flip            mean of the HDR-FLIP map (three channels only)
//   max_abs         largest |x - r|
//   bias            mean(x) / mean(r) - 1
//   nonfinite       pixels of the test image with a NaN or an infinity
//   exact           same bits in all channels
//   sigma           the difference in units of the two images' own noise; see noise_sigma()
//
// Pixels that are not finite in either image are left out of every mean.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "render/image/image.h"

namespace alder::cli {

struct Figures {
    std::string layer;
    std::optional<double> rmse, relmse, relmse_trimmed, flip, max_abs, bias, sigma;
    uint64_t nonfinite = 0, reference_nonfinite = 0;
    bool exact = false;
    int worst_x = 0, worst_y = 0;               ///< where max_abs is
    std::vector<double> mean, reference_mean;   ///< by channel
    std::string no_sigma;                       ///< why there is none

    std::optional<double> value(const std::string& figure) const;
    nlohmann::json json() const;
};

/// The names above, in this order.
const std::vector<std::string>& figure_names();

/// Channels of a layer that two images are compared in. "beauty" is the picture ("Combined" in files of Blender); other names
/// are layers, or a channel of one ("beauty.A", "P.X"). Empty and a reason where the image has none.
struct LayerView {
    std::vector<const std::vector<float>*> planes;   ///< colour without alpha
    std::vector<const std::vector<float>*> all;
    bool single_precision = true;
};
LayerView find_layer(const Image& image, const std::string& name, std::string& error);

struct CompareOptions {
    bool flip = true;
    double epsilon = 0.01, trim = 0.001;
};
/// Nothing and a reason where sizes differ or a layer is missing. `map`, if not null, takes what the heat map shows: FLIP where
/// there is one, else |x - r| / (|r| + 0.1).
std::optional<Figures> compare_layer(const Image& test, const Image& reference, const std::string& layer, const CompareOptions& options,
                                     std::string& error, std::vector<float>* map = nullptr);

/// How improbable the difference is if both images are noisy estimates of the same picture, as a number of standard deviations.
///
/// From layers `variance` (of the mean) of both. Differences are added over squares of 16 pixels and divided by the root of their
/// added variances, so that noise averages out and bias does not; the figure is the largest, over the channels, of the image's
/// own z, of the excess of the squares' z^2 over what chance gives, and of the worst square with its number discounted. Two
/// renders with different seeds stay below 4; a change of the picture goes far beyond, however noisy a pixel is.
std::optional<double> noise_sigma(const Image& test, const Image& reference, std::string& why_not);

/// A limit on a figure: "relmse_trimmed" <= 1e-4, |bias| <= 0.01, exact = true.
struct Limit {
    std::string figure;
    double value = 0;   ///< of `exact`: 1
};
/// Nothing and a reason for a name or value that is none.
std::optional<Limit> limit_from_json(const std::string& figure, const nlohmann::json& value, std::string& error);
/// Empty, or what passed the limit: figure, limit and worst pixel.
std::string check_limit(const Figures& figures, const Limit& limit);

/// The map as a PNG, black over red and yellow to white. `range`: the value that is white.
std::vector<uint8_t> heat_map_png(const std::vector<float>& map, int width, int height, float range, std::string& error);

}  // namespace alder::cli
