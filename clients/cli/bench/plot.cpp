// A plot of error against time as SVG.
#include "clients/cli/bench/plot.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "clients/cli/compare/junit.h"

namespace alder::cli {
namespace {

constexpr double kWidth = 760, kHeight = 480, kLeft = 80, kRight = 190, kTop = 46, kBottom = 56;
// Okabe and Ito's colours, which people with any colour vision tell apart.
constexpr const char* kColors[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"};

/// Whole decades around the values.
struct Axis {
    double low = 0, high = 1, from, to;
    Axis(double pixel_from, double pixel_to) : from(pixel_from), to(pixel_to) {}
    void fit(double smallest, double largest) {
        low = std::floor(std::log10(smallest) - 1e-9);
        high = std::max(low + 1, std::ceil(std::log10(largest) + 1e-9));
    }
    double at(double value) const { return from + (std::log10(value) - low) / (high - low) * (to - from); }
};

bool shown(const PlotPoint& p) { return std::isfinite(p.x) && std::isfinite(p.y) && p.x > 0 && p.y > 0; }

}  // namespace

std::string log_log_svg(const std::string& title, const std::string& x_label, const std::string& y_label, const std::vector<PlotSeries>& series) {
    Axis x(kLeft, kWidth - kRight), y(kHeight - kBottom, kTop);
    double low_x = 1e300, high_x = 0, low_y = 1e300, high_y = 0;
    for (const PlotSeries& s : series)
        for (const PlotPoint& p : s.points)
            if (shown(p)) {
                low_x = std::min(low_x, p.x), high_x = std::max(high_x, p.x);
                low_y = std::min(low_y, p.y), high_y = std::max(high_y, p.y);
            }
    if (high_x > 0) {
        x.fit(low_x, high_x);
        y.fit(low_y, high_y);
    }
    std::string svg = fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" font-family=\"sans-serif\" font-size=\"12\">\n"
                                  "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n<text x=\"{2}\" y=\"24\" font-size=\"15\">{3}</text>\n",
                                  kWidth, kHeight, kLeft, xml_text(title));
    const auto decade_lines = [&](const Axis& axis, bool vertical) {
        for (int d = static_cast<int>(axis.low); d <= static_cast<int>(axis.high); ++d)
            for (int m = 1; m < 10; ++m) {
                const double v = m * std::pow(10.0, d);
                if (v > std::pow(10.0, axis.high) * (1 + 1e-9)) break;
                const double at = axis.at(v);
                const char* color = m == 1 ? "#bbb" : "#eee";
                if (vertical)
                    svg += fmt::format("<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\" stroke=\"{3}\"/>\n", at, kTop, kHeight - kBottom, color);
                else
                    svg += fmt::format("<line y1=\"{0:.1f}\" y2=\"{0:.1f}\" x1=\"{1}\" x2=\"{2}\" stroke=\"{3}\"/>\n", at, kLeft, kWidth - kRight, color);
                if (m != 1) continue;
                if (vertical)
                    svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{:g}</text>\n", at, kHeight - kBottom + 18, v);
                else
                    svg += fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{:g}</text>\n", kLeft - 8, at + 4, v);
            }
    };
    decade_lines(x, true);
    decade_lines(y, false);
    svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n", (kLeft + kWidth - kRight) / 2, kHeight - 14, xml_text(x_label));
    svg += fmt::format("<text transform=\"translate(18 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n", (kTop + kHeight - kBottom) / 2, xml_text(y_label));
    for (size_t i = 0; i < series.size(); ++i) {
        const char* color = kColors[i % std::size(kColors)];
        std::string line;
        for (const PlotPoint& p : series[i].points)
            if (shown(p)) line += fmt::format("{}{:.1f},{:.1f}", line.empty() ? "" : " ", x.at(p.x), y.at(p.y));
        svg += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>\n", line, color);
        for (const PlotPoint& p : series[i].points)
            if (shown(p))
                svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\" fill=\"{}\"><title>{}</title></circle>\n", x.at(p.x), y.at(p.y), color, xml_text(series[i].name + ", " + p.label));
        const double row = kTop + 14 + 20 * static_cast<double>(i);
        svg += fmt::format("<rect x=\"{}\" y=\"{:.1f}\" width=\"14\" height=\"4\" fill=\"{}\"/><text x=\"{}\" y=\"{:.1f}\">{}</text>\n", kWidth - kRight + 14, row - 5, color, kWidth - kRight + 34, row,
                           xml_text(series[i].name));
    }
    return svg + "</svg>\n";
}

}  // namespace alder::cli
