// A plot of error against time as SVG: both axes logarithmic, one line for each renderer or setting.
#pragma once
#include <string>
#include <vector>

namespace alder::cli {

struct PlotPoint {
    double x = 0, y = 0;
    std::string label;
};
struct PlotSeries {
    std::string name;
    std::vector<PlotPoint> points;
};
/// Points that a logarithm cannot show are left out.
std::string log_log_svg(const std::string& title, const std::string& x_label, const std::string& y_label, const std::vector<PlotSeries>& series);

}  // namespace alder::cli
