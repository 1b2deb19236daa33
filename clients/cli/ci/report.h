// The HTML report of a suite: reference, result, difference and figures of each case, one file with pictures beside it.
#pragma once
#include <string>
#include <vector>

#include "clients/cli/compare/figures.h"

namespace alder::cli {

struct LayerResult {
    std::string layer;
    std::optional<Figures> figures;
    std::vector<Limit> limits;
    std::string failure;              ///< empty: within the limits
    std::string test, reference, map; ///< file names of PNGs in the report's folder; may be empty
};
struct CaseResult {
    std::string name, scene, reference, image;
    double seconds = 0, render_seconds = 0;
    int samples = 0;
    std::string error;                ///< it did not finish, or could not be compared
    bool updated = false;
    std::vector<LayerResult> layers;
    bool good() const;
};

/// A page that needs no network and no script.
std::string report_html(const std::string& suite, const std::vector<CaseResult>& cases);

/// A layer as a picture: colours by the sRGB curve, data scaled to its largest value. Empty and a reason otherwise.
std::vector<uint8_t> layer_png(const Image& image, const std::string& layer, std::string& error);

}  // namespace alder::cli
