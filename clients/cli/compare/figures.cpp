// Figures of error between two images.
#include "clients/cli/compare/figures.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "clients/cli/compare/flip.h"
#include "graph/diagnostic.h"
#include "nodes/schema.h"
#include "render/image/view.h"

namespace alder::cli {
namespace {

nlohmann::json number(const std::optional<double>& x) {
    if (!x) return nullptr;
    if (std::isnan(*x)) return "nan";
    if (std::isinf(*x)) return *x > 0 ? "inf" : "-inf";
    return *x;
}

bool ends_with(const std::string& text, const std::string& end) { return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0; }

/// The layer of that name, or the only one called PREFIX.NAME.
const Layer* layer_called(const Image& image, const std::string& name) {
    const Layer* found = nullptr;
    for (const Layer& l : image.layers) {
        if (l.name == name) return &l;
        if (ends_with(l.name, "." + name)) {
            if (found) return nullptr;
            found = &l;
        }
    }
    return found;
}

bool finite(const LayerView& view, size_t i) {
    return std::all_of(view.planes.begin(), view.planes.end(), [i](const auto* p) { return std::isfinite((*p)[i]); });
}

bool same_bits(const LayerView& a, const LayerView& b) {
    if (a.all.size() != b.all.size()) return false;
    for (size_t c = 0; c < a.all.size(); ++c)
        if (std::memcmp(a.all[c]->data(), b.all[c]->data(), a.all[c]->size() * sizeof(float)) != 0) return false;
    return true;
}

void set_means(const LayerView& x, const LayerView& r, const Image& image, const CompareOptions& o, Figures& f) {
    const size_t pixels = x.planes[0]->size(), channels = x.planes.size();
    std::vector<double> relative;
    relative.reserve(pixels);
    f.mean.assign(channels, 0);
    f.reference_mean.assign(channels, 0);
    double square = 0, worst = -1;
    for (size_t i = 0; i < pixels; ++i) {
        const bool fx = finite(x, i), fr = finite(r, i);
        f.nonfinite += !fx;
        f.reference_nonfinite += !fr;
        if (!fx || !fr) continue;
        double sum = 0;
        for (size_t c = 0; c < channels; ++c) {
            const double a = (*x.planes[c])[i], b = (*r.planes[c])[i], d = a - b;
            square += d * d;
            sum += d * d / (b * b + o.epsilon);
            f.mean[c] += a;
            f.reference_mean[c] += b;
            if (std::abs(d) > worst) {
                worst = std::abs(d);
                f.worst_x = image.crop_x + static_cast<int>(i % size_t(image.width));
                f.worst_y = image.crop_y + static_cast<int>(i / size_t(image.width));
            }
        }
        relative.push_back(sum / static_cast<double>(channels));
    }
    if (relative.empty()) return;
    const double n = static_cast<double>(relative.size());
    std::sort(relative.begin(), relative.end());
    const size_t kept = relative.size() - static_cast<size_t>(std::floor(n * o.trim));
    double all = 0, trimmed = 0;
    for (size_t i = 0; i < relative.size(); ++i) {
        all += relative[i];
        if (i < kept) trimmed += relative[i];
    }
    f.rmse = std::sqrt(square / (n * static_cast<double>(channels)));
    f.relmse = all / n;
    f.relmse_trimmed = trimmed / static_cast<double>(kept);
    f.max_abs = worst;
    double a = 0, b = 0;
    for (size_t c = 0; c < channels; ++c) {
        a += f.mean[c];
        b += f.reference_mean[c];
        f.mean[c] /= n;
        f.reference_mean[c] /= n;
    }
    if (b != 0) f.bias = a / b - 1;
}

}  // namespace

const std::vector<std::string>& figure_names() {
    static const std::vector<std::string> names{"rmse", "relmse", "relmse_trimmed", "flip", "max_abs", "bias", "nonfinite", "exact", "sigma"};
    return names;
}

std::optional<double> Figures::value(const std::string& figure) const {
    if (figure == "rmse") return rmse;
    if (figure == "relmse") return relmse;
    if (figure == "relmse_trimmed") return relmse_trimmed;
    if (figure == "flip") return flip;
    if (figure == "max_abs") return max_abs;
    if (figure == "bias") return bias;
    if (figure == "nonfinite") return static_cast<double>(nonfinite);
    if (figure == "exact") return exact ? 1 : 0;
    if (figure == "sigma") return sigma;
    return std::nullopt;
}

nlohmann::json Figures::json() const {
    return {{"layer", layer}, {"rmse", number(rmse)}, {"relmse", number(relmse)}, {"relmse_trimmed", number(relmse_trimmed)}, {"flip", number(flip)},
            {"max_abs", number(max_abs)}, {"max_abs_at", {worst_x, worst_y}}, {"bias", number(bias)}, {"nonfinite", nonfinite},
            {"ref_nonfinite", reference_nonfinite}, {"exact", exact}, {"sigma", number(sigma)}, {"mean", mean}, {"ref_mean", reference_mean}};
}

LayerView find_layer(const Image& image, const std::string& name, std::string& error) {
    LayerView view;
    const Layer* layer = name == "beauty" ? image.find("") : layer_called(image, name);
    if (!layer && name == "beauty") layer = layer_called(image, "Combined");
    std::string channel;
    if (!layer) {
        const size_t dot = name.rfind('.');
        if (dot != std::string::npos) {
            const std::string base = name.substr(0, dot);
            layer = base == "beauty" ? image.find("") : layer_called(image, base);
            channel = name.substr(dot + 1);
            if (layer && std::find(layer->channels.begin(), layer->channels.end(), channel) == layer->channels.end()) layer = nullptr;
        }
    }
    if (!layer) {
        std::vector<std::string> names{"beauty"};
        for (const Layer& l : image.layers)
            if (!l.name.empty()) names.push_back(l.name);
        const std::string near = nearest_name(name, names);
        error = fmt::format("has no layer '{}'{}", name, near.empty() || near == name ? "" : fmt::format("; did you mean '{}'?", near));
        return view;
    }
    view.single_precision = layer->data;
    for (size_t c = 0; c < layer->planes.size(); ++c) {
        if (!channel.empty() && layer->channels[c] != channel) continue;
        view.all.push_back(&layer->planes[c]);
        if (!channel.empty() || layer->channels[c] != "A") view.planes.push_back(&layer->planes[c]);
    }
    if (view.planes.empty()) view.planes = view.all;
    return view;
}

std::optional<Figures> compare_layer(const Image& test, const Image& reference, const std::string& layer, const CompareOptions& options,
                                     std::string& error, std::vector<float>* map) {
    if (test.width != reference.width || test.height != reference.height) {
        error = fmt::format("sizes differ: {} x {} against {} x {}", test.width, test.height, reference.width, reference.height);
        return std::nullopt;
    }
    std::string why;
    const LayerView x = find_layer(test, layer, why);
    if (x.planes.empty()) {
        error = "the test image " + why;
        return std::nullopt;
    }
    const LayerView r = find_layer(reference, layer, why);
    if (r.planes.empty()) {
        error = "the reference " + why;
        return std::nullopt;
    }
    if (x.planes.size() != r.planes.size()) {
        error = fmt::format("layer '{}' has {} channels against {}", layer, x.planes.size(), r.planes.size());
        return std::nullopt;
    }
    Figures f;
    f.layer = layer;
    set_means(x, r, test, options, f);
    f.exact = same_bits(x, r);
    if (layer == "beauty")
        f.sigma = noise_sigma(test, reference, f.no_sigma);
    else
        f.no_sigma = "only the beauty has variances";
    const bool color = x.planes.size() == 3;
    std::vector<float> flip;
    if (options.flip && color) {
        flip = hdr_flip({x.planes[0], x.planes[1], x.planes[2]}, {r.planes[0], r.planes[1], r.planes[2]}, test.width, test.height);
        double sum = 0;
        for (const float v : flip) sum += v;
        f.flip = flip.empty() ? 0 : sum / static_cast<double>(flip.size());
    }
    if (map) {
        if (!flip.empty()) {
            *map = std::move(flip);
        } else {
            map->assign(x.planes[0]->size(), 0);
            for (size_t c = 0; c < x.planes.size(); ++c)
                for (size_t i = 0; i < map->size(); ++i) {
                    const float a = (*x.planes[c])[i], b = (*r.planes[c])[i], d = std::abs(a - b) / (std::abs(b) + 0.1f);
                    (*map)[i] = std::max((*map)[i], std::isfinite(d) ? d : 1.f);
                }
        }
    }
    return f;
}

std::optional<Limit> limit_from_json(const std::string& figure, const nlohmann::json& value, std::string& error) {
    const auto& names = figure_names();
    if (std::find(names.begin(), names.end(), figure) == names.end()) {
        const std::string near = nearest_name(figure, names);
        error = fmt::format("'{}' is no figure{}", figure, near.empty() ? fmt::format("; there are {}", fmt::join(names, ", ")) : fmt::format("; did you mean '{}'?", near));
        return std::nullopt;
    }
    if (figure == "exact") {
        if (value == nlohmann::json(true)) return Limit{figure, 1};
        error = "'exact' takes true: leave it out where images may differ";
        return std::nullopt;
    }
    if (!value.is_number() || !(value.get<double>() >= 0)) {
        error = fmt::format("the limit of '{}' is a number from 0, found {}", figure, value.dump());
        return std::nullopt;
    }
    return Limit{figure, value.get<double>()};
}

std::string check_limit(const Figures& f, const Limit& limit) {
    const auto value = f.value(limit.figure);
    const std::string worst = f.max_abs ? fmt::format("; worst pixel ({}, {}), off by {:.4g}", f.worst_x, f.worst_y, *f.max_abs) : "";
    if (limit.figure == "exact") return f.exact ? "" : fmt::format("{}: not the same bits{}", f.layer, worst);
    if (!value) return fmt::format("{}: {} could not be computed{}", f.layer, limit.figure, limit.figure == "sigma" ? ": " + f.no_sigma : "");
    const double figure = limit.figure == "bias" ? std::abs(*value) : *value;
    if (figure <= limit.value) return {};
    return fmt::format("{}: {} {:.6g} is above the limit {:g}{}", f.layer, limit.figure, *value, limit.value, worst);
}

std::vector<uint8_t> heat_map_png(const std::vector<float>& map, int width, int height, float range, std::string& error) {
    // Black, red at a third, yellow at two thirds, white: each value of the map is one channel's ramp.
    Image image{.width = width, .height = height, .full_width = width, .full_height = height};
    Layer layer{"", {"R", "G", "B"}, false, std::vector<std::vector<float>>(3, std::vector<float>(map.size()))};
    for (size_t i = 0; i < map.size(); ++i) {
        const float t = std::isfinite(map[i]) ? std::clamp(map[i] / range, 0.f, 1.f) * 3 : 3.f;
        for (int c = 0; c < 3; ++c) layer.planes[size_t(c)][i] = std::clamp(t - static_cast<float>(c), 0.f, 1.f);
    }
    image.layers.push_back(std::move(layer));
    View view;
    view.transform = ViewTransform::Linear;
    return encode_png(image, view, error);
}

}  // namespace alder::cli
