// Pictures: rendered images as bytes of the type a client asked for.
#include "server/picture.h"

#include <chrono>

#include <fmt/format.h>

#include "server/errors.h"
#include "server/service.h"

namespace alder {

void read_view(Members& m, View& view) {
    double exposure = 0;
    if (m.number("exposure", exposure, -64, 64)) view.exposure = static_cast<float>(exposure);
    std::string transform;
    if (m.choice("transform", transform, {"srgb", "linear", "filmic-none"})) view.transform = *view_transform_from_name(transform);
    m.text("layer", view.layer);
    m.boolean("alpha", view.alpha);
    int64_t quality = 0;
    if (m.integer("quality", quality, 1, 100)) view.quality = static_cast<int>(quality);
    m.finish(false);
}

std::string Timings::header() const {
    std::string out;
    for (const auto& [name, seconds] : {std::pair("queue", queue), {"parse", parse}, {"compile", compile}, {"build", build}, {"render", render}, {"encode", encode}})
        out += fmt::format("{}{};dur={:.3f}", out.empty() ? "" : ", ", name, seconds * 1e3);
    return out;
}
nlohmann::json Timings::json() const {
    return {{"queue", queue}, {"parse", parse}, {"compile", compile}, {"build", build}, {"render", render}, {"encode", encode}};
}

nlohmann::json stats_json(const RenderStats& s) {
    return {{"samples", s.samples},
            {"complete", s.complete},
            {"estimated_error", s.estimated_error},
            {"rays", {{"camera", s.camera_rays}, {"bounce", s.bounce_rays}, {"shadow", s.shadow_rays}, {"subsurface", s.subsurface_rays}}},
            {"shading_points", s.shading_points},
            {"medium_segments", s.medium_segments},
            {"medium_points", s.medium_points},
            {"media_ignored", s.media_ignored},
            {"node_evaluations", s.node_evaluations},
            {"node_evaluations_skipped", s.node_skipped},
            {"nonfinite_samples", s.nonfinite_samples},
            {"skipped", s.skipped}};
}

http::Response picture(const Image& image, const std::string& type, const View& view, const RenderStats& stats,
                       const Diagnostics& d, Timings timings, const ExrOptions& exr) {
    const auto start = std::chrono::steady_clock::now();
    const auto encoded = [&](std::vector<uint8_t> bytes, const std::string& error) {
        timings.encode = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        if (bytes.empty()) throw Problem{"settings-invalid", error};
        return http::Response::text(200, std::string(bytes.begin(), bytes.end()), type);
    };
    std::string error;
    http::Response r;
    if (type == "image/png") {
        r = encoded(encode_png(image, view, error), error);
    } else if (type == "image/jpeg") {
        r = encoded(encode_jpeg(image, view, error), error);
    } else if (type == "image/x-exr") {
        r = encoded(encode_exr(image, exr, error), error);
    } else {
        nlohmann::json layers = nlohmann::json::array();
        for (const Layer& layer : image.layers) layers.push_back(layer.name.empty() ? "rgba" : layer.name);
        r = json_response(200, {{"width", image.width}, {"height", image.height}, {"layers", std::move(layers)}, {"stats", stats_json(stats)},
                                {"timings", timings.json()}, {"warnings", to_json(d.warnings)}});
    }
    r.set("Alder-Samples", std::to_string(stats.samples));
    r.set("Alder-Warnings", std::to_string(d.warnings.size()));
    r.set("Server-Timing", timings.header());
    r.set("Vary", "Accept");
    return r;
}

}  // namespace alder
