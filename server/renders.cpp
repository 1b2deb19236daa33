// POST /v1/renders with "Prefer: wait=N": a whole frame within one request. Renders that outlive their request are not there
// yet, and every answer says so.
#include <chrono>

#include <fmt/format.h>

#include "render/programs.h"
#include "server/negotiate.h"
#include "server/picture.h"
#include "server/routes.h"
#include "server/service.h"

namespace alder {
namespace {

constexpr double kWaitMost = 3600;
constexpr int kSideMost = 16384;
constexpr int64_t kPixelsMost = int64_t{1} << 28;

struct FrameRequest {
    std::string scene;
    RenderRequest render;
    ExrOptions exr;
    bool lenient = false, strict = false;
};

template <size_t N>
bool read_numbers(Members& m, const std::string& name, std::array<int64_t, N>& out, int64_t low, int64_t high) {
    const auto* value = m.find(name);
    if (!value) return false;
    bool fits = value->is_array() && value->size() == N;
    for (size_t i = 0; fits && i < N; ++i) {
        fits = (*value)[i].is_number_integer() && (*value)[i].template get<int64_t>() >= low && (*value)[i].template get<int64_t>() <= high;
        if (fits) out[i] = (*value)[i].template get<int64_t>();
    }
    if (!fits) m.fault(name, "wrong-type", brief(*value), fmt::format("an array of {} whole numbers from {} to {}", N, low, high));
    return fits;
}

FrameRequest read_frame(const nlohmann::json& body, Diagnostics& d) {
    FrameRequest f;
    Members m(body, "", d);
    if (m.require("scene", "the id of a scene")) m.text("scene", f.scene);
    m.boolean("lenient", f.lenient);
    m.boolean("strict", f.strict);
    std::string mode = "final";
    if (m.choice("mode", mode, {"final", "live"}) && mode == "live") m.fault("mode", "unsupported", "\"live\"", "\"final\": live renders are not available in this version");
    std::array<int64_t, 2> resolution{};
    if (read_numbers(m, "resolution", resolution, 1, kSideMost)) {
        f.render.width = static_cast<int>(resolution[0]);
        f.render.height = static_cast<int>(resolution[1]);
        if (resolution[0] * resolution[1] > kPixelsMost) m.fault("resolution", "limit-exceeded", fmt::format("{} pixels", resolution[0] * resolution[1]), fmt::format("at most {}", kPixelsMost));
    }
    std::array<int64_t, 4> crop{};
    if (read_numbers(m, "crop", crop, 0, kSideMost)) {
        std::copy(crop.begin(), crop.end(), f.render.crop);
        if (crop[0] >= crop[2] || crop[1] >= crop[3]) m.fault("crop", "out-of-range", "an empty rectangle", "[x0, y0, x1, y1] with x0 < x1 and y0 < y1");
    }
    int64_t samples = 0, seed = 0;
    if (m.integer("samples", samples, 1, 1 << 20)) f.render.samples = static_cast<int>(samples);
    if (m.integer("seed", seed, 0, UINT32_MAX)) f.render.seed = static_cast<uint32_t>(seed);
    if (const auto* stop = m.find("stop")) {
        Members limits(*stop, "/stop", d);
        limits.number("error", f.render.target_error, 1e-6, 10);
        limits.number("seconds", f.render.seconds, 0.001, kWaitMost);
        limits.finish(f.lenient);
    }
    m.texts("aovs", f.render.aovs, 1024);
    std::string groups;
    if (m.choice("light_groups", groups, {"all"})) f.render.aovs.push_back("light_groups");
    if (const auto* output = m.find("output")) {
        Members o(*output, "/output", d);
        std::string pixel, compression, parts;
        if (o.choice("pixel_type", pixel, {"half", "float"})) f.exr.all_float = pixel == "float";
        if (o.choice("compression", compression, {"none", "zip", "zips", "piz", "rle"}))
            f.exr.compression = compression == "none" ? ExrOptions::Compression::None : compression == "zips" ? ExrOptions::Compression::Zips
                              : compression == "piz" ? ExrOptions::Compression::Piz : compression == "rle" ? ExrOptions::Compression::Rle : ExrOptions::Compression::Zip;
        o.choice("parts", parts, {"single"});
        o.finish(f.lenient);
    }
    bool ignored = false;   // nothing outlives the request, so that is how it is anyway
    m.boolean("cancel_on_disconnect", ignored);
    for (const char* later : {"camera", "frame", "frames", "priority", "labels", "retain", "overrides", "cryptomatte", "reproducible", "farm"})
        if (const auto* value = m.find(later)) m.fault(later, "unsupported", brief(*value), "nothing: not available in this version");
    m.finish(f.lenient);
    return f;
}

Problem not_available(std::string detail) { return {"not-available", std::move(detail)}; }

}  // namespace

http::Response post_renders(Service& s, http::Request& request) {
    const auto start = std::chrono::steady_clock::now();
    const auto since = [](std::chrono::steady_clock::time_point t) { return std::chrono::duration<double>(std::chrono::steady_clock::now() - t).count(); };
    const std::string type = best_type(request, {"image/x-exr", "image/png", "image/jpeg", "application/json"});
    const nlohmann::json body = s.read_json(request);
    Diagnostics d;
    FrameRequest f = read_frame(body, d);
    if (!d.ok()) throw problem_from("settings-invalid", d);
    const auto wait = preferred_wait(request);
    if (!wait) throw not_available("renders that outlive their request are not available in this version: send 'Prefer: wait=N' (seconds, at most 3600)");
    if (*wait > kWaitMost || *wait < 1) throw Problem{"malformed-request", "Prefer: wait is from 1 to 3600 seconds"};
    const auto scene = s.scenes.get(f.scene);
    f.render.threads = s.engine.threads();
    Timings timings;
    timings.parse = since(start);

    http::Response response;
    const auto queued = std::chrono::steady_clock::now();
    bool out_of_time = true;   // until the work has ended by itself
    const auto too_late = [&] {
        return not_available(fmt::format("the render did not finish within {:g} s and was dropped: renders that outlive their request are not available in this version", *wait));
    };
    try {
        s.run(s.render_lane, request, *wait, [&](const std::atomic<bool>& cancel) {
            timings.queue = since(queued);
            const auto building = std::chrono::steady_clock::now();
            const auto loaded = s.scenes.load(s.engine, s.assets, *scene, d);
            timings.build = since(building);
            if (f.strict) require_files(*loaded->scene, d);
            if (!d.ok()) throw problem_from("scene-invalid", d);
            const int width = f.render.width ? f.render.width : loaded->scene->settings.width;
            const int height = f.render.height ? f.render.height : loaded->scene->settings.height;
            if (f.render.crop[2] > width || f.render.crop[3] > height) {
                d.errors.push_back({"/crop", "out-of-range", fmt::format("{} x {}", f.render.crop[2], f.render.crop[3]), fmt::format("a rectangle inside {} x {}", width, height), {}});
                throw problem_from("settings-invalid", d);
            }
            f.render.cancel = &cancel;
            RenderStats stats;
            const auto rendering = std::chrono::steady_clock::now();
            const Image image = render(*loaded->prepared, f.render, stats);
            timings.render = since(rendering);
            if (cancel) throw Problem{"cancelled", "the client hung up, or the daemon is stopping"};
            if (f.strict) require_files(*loaded->scene, d);   // a file may break off in the middle
            if (!d.ok()) throw problem_from("scene-invalid", d);
            response = picture(image, type, View{}, stats, d, timings, f.exr);
            s.count_render(stats);
            out_of_time = false;
        });
    } catch (const Problem& p) {
        if (p.type == "cancelled" && since(queued) >= *wait && !request.client_gone()) throw too_late();
        throw;
    }
    if (out_of_time) throw too_late();   // its turn never came
    response.set("Preference-Applied", fmt::format("wait={:g}", *wait));
    return response;
}

}  // namespace alder
