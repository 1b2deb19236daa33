// The HTML report of a suite.
#include "clients/cli/ci/report.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "clients/cli/compare/junit.h"
#include "render/image/view.h"

namespace alder::cli {
namespace {

constexpr const char* kHead = R"html(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<style>
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em; color: #222; background: #fafafa }
h1 { font-size: 1.4em } h2 { font-size: 1.1em; margin: 2em 0 .3em } h3 { font-size: 1em; margin: 1em 0 .3em }
.good { color: #1a7f37 } .bad { color: #c0271d } .note { color: #666 }
table { border-collapse: collapse; margin: .5em 0 } td, th { padding: .15em .8em .15em 0; text-align: left }
td.n { text-align: right; font-variant-numeric: tabular-nums } tr.over td { color: #c0271d; font-weight: 600 }
.pictures { display: flex; flex-wrap: wrap; gap: 1em } figure { margin: 0 } figcaption { color: #666; font-size: .85em }
img { max-width: 30em; image-rendering: pixelated; background: #000; display: block }
.flip { position: relative } .flip img + img { position: absolute; inset: 0; opacity: 0 } .flip:hover img + img { opacity: 1 }
@media (prefers-color-scheme: dark) { body { color: #ddd; background: #181818 } .good { color: #4cc26b } .bad, tr.over td { color: #ff7b6e } }
</style>
)html";

std::string number(const std::string& figure, const Figures& f) {
    if (figure == "exact") return f.exact ? "yes" : "no";
    const auto value = f.value(figure);
    return value ? fmt::format("{:.6g}", *value) : "–";
}

std::string layer_html(const LayerResult& l) {
    std::string html = fmt::format("<h3>{} <span class=\"{}\">{}</span></h3>\n", xml_text(l.layer), l.failure.empty() ? "good" : "bad", l.failure.empty() ? "within limits" : "differs");
    if (!l.failure.empty()) html += "<p class=\"bad\">" + xml_text(l.failure) + "</p>\n";
    html += "<div class=\"pictures\">\n";
    const auto picture = [](const std::string& file, const char* caption) {
        return file.empty() ? std::string() : fmt::format("<figure><img src=\"{0}\" alt=\"{1}\"><figcaption>{1}</figcaption></figure>\n", xml_text(file), caption);
    };
    html += picture(l.reference, "reference") + picture(l.test, "result");
    if (!l.test.empty() && !l.reference.empty())
        html += fmt::format("<figure><div class=\"flip\"><img src=\"{}\" alt=\"reference\"><img src=\"{}\" alt=\"result\"></div><figcaption>point here: reference becomes result</figcaption></figure>\n",
                            xml_text(l.reference), xml_text(l.test));
    html += picture(l.map, "where they differ") + "</div>\n";
    if (!l.figures) return html;
    html += "<table><tr><th>figure</th><th>value</th><th>limit</th></tr>\n";
    for (const std::string& name : figure_names()) {
        const auto limit = std::find_if(l.limits.begin(), l.limits.end(), [&](const Limit& x) { return x.figure == name; });
        const bool limited = limit != l.limits.end();
        const bool over = limited && !check_limit(*l.figures, *limit).empty();
        html += fmt::format("<tr{}><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>\n", over ? " class=\"over\"" : "", name, number(name, *l.figures),
                            !limited ? "" : name == "exact" ? "yes" : fmt::format("{:g}", limit->value));
    }
    if (l.figures->max_abs) html += fmt::format("<tr><td>worst pixel</td><td class=\"n\">{}, {}</td><td></td></tr>\n", l.figures->worst_x, l.figures->worst_y);
    return html + "</table>\n";
}

}  // namespace

bool CaseResult::good() const {
    return error.empty() && std::all_of(layers.begin(), layers.end(), [](const LayerResult& l) { return l.failure.empty(); });
}

std::string report_html(const std::string& suite, const std::vector<CaseResult>& cases) {
    const auto good = std::count_if(cases.begin(), cases.end(), [](const CaseResult& c) { return c.good(); });
    std::string html = std::string(kHead) + "<title>" + xml_text(suite) + "</title></head><body>\n";
    html += fmt::format("<h1>{}: <span class=\"{}\">{} of {} good</span></h1>\n<p class=\"note\">alder {}</p>\n<ul>\n", xml_text(suite), good == std::ssize(cases) ? "good" : "bad", good, cases.size(), ALDER_VERSION);
    for (size_t i = 0; i < cases.size(); ++i)
        html += fmt::format("<li><a href=\"#case{}\">{}</a> <span class=\"{}\">{}</span></li>\n", i, xml_text(cases[i].name), cases[i].good() ? "good" : "bad",
                            cases[i].good() ? "good" : cases[i].error.empty() ? "differs" : "error");
    html += "</ul>\n";
    for (size_t i = 0; i < cases.size(); ++i) {
        const CaseResult& c = cases[i];
        html += fmt::format("<h2 id=\"case{}\">{}</h2>\n<p class=\"note\">{}, {} samples, {:.2f} s; reference {}{}</p>\n", i, xml_text(c.name), xml_text(c.scene), c.samples, c.seconds,
                            xml_text(c.reference), c.updated ? " (updated by this run)" : "");
        if (!c.error.empty()) html += "<p class=\"bad\">" + xml_text(c.error) + "</p>\n";
        for (const LayerResult& l : c.layers) html += layer_html(l);
    }
    return html + "</body></html>\n";
}

std::vector<uint8_t> layer_png(const Image& image, const std::string& layer, std::string& error) {
    const LayerView view = find_layer(image, layer, error);
    if (view.planes.empty()) return {};
    const bool color = layer == "beauty" || (view.planes.size() == 3 && image.find(layer) && image.find(layer)->channels[0] == "R");
    float scale = 1;
    if (!color) {
        float largest = 0;
        for (const auto* plane : view.planes)
            for (const float v : *plane)
                if (std::isfinite(v) && std::abs(v) < 1e9f) largest = std::max(largest, std::abs(v));   // depth of nothing is 1e10
        scale = largest > 0 ? 1 / largest : 1;
    }
    Image out{.width = image.width, .height = image.height, .full_width = image.width, .full_height = image.height};
    Layer rgb{"", {"R", "G", "B"}, false, {}};
    for (size_t c = 0; c < 3; ++c) {
        rgb.planes.push_back(*view.planes[std::min(c, view.planes.size() - 1)]);
        if (view.planes.size() == 2 && c == 2) std::fill(rgb.planes[2].begin(), rgb.planes[2].end(), 0.f);
        for (float& v : rgb.planes[c]) v = color ? v : std::abs(v) * scale;
    }
    out.layers.push_back(std::move(rgb));
    View how;
    how.transform = color ? ViewTransform::Srgb : ViewTransform::Linear;
    return encode_png(out, how, error);
}

}  // namespace alder::cli
