// Pictures: rendered images as bytes of the type a client asked for, with what it may want to know about them.
#pragma once
#include <string>

#include <nlohmann/json.hpp>

#include "render/image/exr.h"
#include "render/image/view.h"
#include "render/render.h"
#include "server/http/message.h"
#include "server/members.h"

namespace alder {

/// PNG first: what a browser or a curl without -H wants.
inline const std::vector<std::string> kPictureTypes{"image/png", "image/jpeg", "image/x-exr", "application/json"};

/// {"exposure": 0, "transform": "srgb", "layer": "", "quality": 90}
void read_view(Members& m, View& view);

/// Wall seconds of the parts of one request, for Server-Timing and JSON.
struct Timings {
    double parse = 0, compile = 0, build = 0, queue = 0, render = 0, encode = 0;
    std::string header() const;
    nlohmann::json json() const;
};

nlohmann::json stats_json(const RenderStats& stats);

/// Encodes; throws settings-invalid where the image has no such layer. For application/json: statistics and layer names.
http::Response picture(const Image& image, const std::string& type, const View& view, const RenderStats& stats,
                       const Diagnostics& d, Timings timings, const ExrOptions& exr = {});

}  // namespace alder
