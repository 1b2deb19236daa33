// Streams of a live render: events, pictures for an <img>, whole EXRs, tiles.
#include "server/live/live_streams.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "render/image/exr.h"
#include "server/errors.h"
#include "server/service.h"

namespace alder::live {
namespace {

constexpr double kLookSeconds = 1;      // how often a stream with nothing to send looks whether its client is still there
constexpr double kCommentSeconds = 10;
constexpr std::string_view kBoundary = "alder-part-7c1e5d0b";

std::string joined(const std::vector<std::string>& names) { return fmt::format("{}", fmt::join(names, ", ")); }

/// Sends each picture that the client has time for. `send` gets the picture and the number of the one before; it returns false
/// to end.
http::Response frame_stream(Service& s, http::Request& request, const std::shared_ptr<LiveEntry>& entry, std::string type,
                            std::function<bool(const http::StreamWriter&, const Frame&, uint64_t before)> send,
                            std::function<void(const http::StreamWriter&)> at_end) {
    const auto counted = std::make_shared<LiveStore::Stream>(s.live);
    const auto reader = std::make_shared<LiveRender::Reader>(entry->render);
    http::Response r;
    r.stream_type = std::move(type);
    r.set("Cache-Control", "no-store");
    r.set("X-Accel-Buffering", "no");
    r.stream = [entry, counted, reader, gone = request.client_gone, send = std::move(send), at_end = std::move(at_end), &s](const http::StreamWriter& write) {
        uint64_t seen = 0;
        while (!gone()) {
            const auto frame = entry->render->next_frame(seen, kLookSeconds);
            if (!frame) {
                if (!entry->render->closed()) continue;
                if (at_end) at_end(write);
                return;
            }
            if (seen > 0 && frame->number > seen + 1) s.metrics.count("alder_stream_images_dropped", {}, static_cast<double>(frame->number - seen - 1));
            if (!send(write, *frame, seen)) return;
            seen = frame->number;
        }
    };
    return r;
}

std::string event_text(const std::string& epoch, const Event& e) {
    return fmt::format("id: {}.{}\nevent: {}\ndata: {}\n\n", epoch, e.number, e.type, e.data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

/// Throws settings-invalid where a name is neither a group nor recorded.
std::string exr_bytes(const Frame& frame, const std::vector<std::string>& aovs) {
    std::string error;
    const auto bytes = encode_exr(frame.image(aovs), {}, error);
    if (bytes.empty()) throw Problem{"settings-invalid", error};
    return {bytes.begin(), bytes.end()};
}

uint16_t half_bits(float value) {
    const uint32_t f = std::bit_cast<uint32_t>(value), sign = (f >> 16) & 0x8000;
    const int exponent = static_cast<int>((f >> 23) & 0xFF) - 127;
    if (exponent == 128) return static_cast<uint16_t>(sign | 0x7C00 | ((f & 0x7FFFFF) ? 0x200 : 0));
    const float a = std::abs(value);
    if (a >= 65520.f) return static_cast<uint16_t>(sign | 0x7C00);
    if (a < 6.103515625e-5f) return static_cast<uint16_t>(sign | static_cast<uint32_t>(std::nearbyint(a * 16777216.f)));   // subnormal: units of 2^-24
    const uint32_t rounded = (f & 0x7FFFFFFF) + 0xFFF + ((f >> 13) & 1);   // to nearest, ties to even
    return static_cast<uint16_t>(sign | ((rounded - (112u << 23)) >> 13));
}

}  // namespace

View query_view(Query& q) {
    View v;
    if (const std::string* layer = q.find("aov"); layer && *layer != "beauty" && *layer != "rgba") v.layer = *layer;
    v.exposure = static_cast<float>(q.number("exposure", 0, -64, 64));
    v.quality = static_cast<int>(q.integer("quality", 90, 1, 100));
    v.transform = *view_transform_from_name(q.choice("transform", "srgb", {"srgb", "linear", "filmic-none"}));
    return v;
}

std::string encode_frame(const Frame& frame, const std::string& type, const View& view, int side) {
    const auto fits = frame.film->aovs().names();
    if (!view.layer.empty() && std::find(fits.begin(), fits.end(), view.layer) == fits.end())
        throw Problem{"settings-invalid", fmt::format("the render has no layer '{}'; it has {}", view.layer.substr(0, 64), joined(fits))};
    const double scale = side > 0 ? std::min(1.0, double(side) / std::max(frame.width, frame.height)) : 1.0;
    const Image image = enlarged(frame.image({view.layer.empty() ? "rgba" : view.layer}), std::max(1, static_cast<int>(frame.width * scale)),
                                 std::max(1, static_cast<int>(frame.height * scale)));
    std::string error;
    const auto bytes = type == "image/png" ? encode_png(image, view, error) : encode_jpeg(image, view, error);
    if (bytes.empty()) throw Problem{"settings-invalid", error};
    return {bytes.begin(), bytes.end()};
}

http::Response events_stream(Service& s, http::Request& request, const std::shared_ptr<LiveEntry>& entry) {
    Query(request).finish();
    const auto counted = std::make_shared<LiveStore::Stream>(s.live);
    const auto reader = std::make_shared<LiveRender::Reader>(entry->render);
    std::optional<uint64_t> after;
    if (const std::string* last = request.header("last-event-id")) {
        const std::string& epoch = s.live.epoch();
        uint64_t number = 0;
        if (last->size() > epoch.size() && last->compare(0, epoch.size(), epoch) == 0 && (*last)[epoch.size()] == '.') {
            const char *begin = last->data() + epoch.size() + 1, *end = last->data() + last->size();
            if (const auto [p, code] = std::from_chars(begin, end, number); code == std::errc() && p == end && number <= entry->render->state_event().number) after = number;
        }
    }
    http::Response r;
    r.stream_type = "text/event-stream";
    r.set("Cache-Control", "no-store");
    r.set("X-Accel-Buffering", "no");
    r.stream = [entry, counted, reader, after, gone = request.client_gone, &s](const http::StreamWriter& write) {
        std::string text = "retry: 1000\n\n";
        uint64_t seen = after.value_or(0);
        if (!after) {
            const Event state = entry->render->state_event();
            text += event_text(s.live.epoch(), state);
            seen = state.number;
        }
        if (!write(text)) return;
        double silent = 0;
        while (!gone()) {
            const auto events = entry->render->next_events(seen, kLookSeconds);
            if (events.empty()) {
                if (entry->render->closed()) return;
                if ((silent += kLookSeconds) < kCommentSeconds) continue;
                silent = 0;
                if (!write(": still here\n\n")) return;
                continue;
            }
            silent = 0;
            text.clear();
            for (const Event& e : events) text += event_text(s.live.epoch(), e);
            seen = events.back().number;
            if (!write(text) || events.back().type == "end") return;
        }
    };
    return r;
}

namespace {
struct PreviewStream {
    View view;
    int side;
    std::string type;
};
PreviewStream read_preview_stream(Query& q) {
    const View view = query_view(q);
    const auto side = q.integer("size", 0, 1, 16384);
    return {view, static_cast<int>(side), "image/" + q.choice("type", "jpeg", {"jpeg", "png"})};
}
}  // namespace

http::Response preview_stream(Service& s, http::Request& request, const std::shared_ptr<LiveEntry>& entry) {
    Query q(request);
    const auto [view, side, type] = read_preview_stream(q);
    q.finish();
    const std::string key = fmt::format("{}|{}|{}|{}|{}|{}", type, view.layer, view.exposure, static_cast<int>(view.transform), view.quality, side);
    const auto send = [=, view = view, side = side, type = type](const http::StreamWriter& write, const Frame& frame, uint64_t before) {
        std::shared_ptr<const std::string> bytes;
        try {
            bytes = frame.encoded(key, [&] { return encode_frame(frame, type, view, side); });
        } catch (const Problem&) {
            return true;   // a layer that is not recorded any more, or not yet
        }
        // The boundary comes right after a picture: a browser shows it when it has seen its end.
        std::string head = before == 0 ? fmt::format("--{}\r\n", kBoundary) : "";
        const auto edits = entry->render->edits_between(before, frame.number);
        head += fmt::format("Content-Type: {}\r\nContent-Length: {}\r\nAlder-Samples: {}\r\nAlder-Divisor: {}\r\nAlder-Image: {}\r\n{}\r\n", type, bytes->size(), frame.samples(),
                            frame.divisor, frame.number, edits.empty() ? "" : "Alder-Edits: " + joined(edits) + "\r\n");
        return write(head + *bytes + fmt::format("\r\n--{}\r\n", kBoundary));
    };
    return frame_stream(s, request, entry, fmt::format("multipart/x-mixed-replace; boundary={}", kBoundary), send, {});
}

namespace {
struct ExrStream {
    std::vector<std::string> aovs;
    double every_seconds = 0;
    uint64_t every_samples = 0;
};
ExrStream read_exr_stream(Query& q) {
    ExrStream r{q.list("aovs")};
    const std::string* at = q.find("at", {{"type", "string"}, {"pattern", "^(pow2|(seconds:)?[0-9]+(\\.[0-9]+)?)$"}});
    if (!at || *at == "pow2") return r;
    const bool seconds = at->rfind("seconds:", 0) == 0;
    double n = 0;
    const char* begin = at->data() + (seconds ? 8 : 0);
    const auto [end, code] = std::from_chars(begin, at->data() + at->size(), n, std::chars_format::fixed);
    if (code != std::errc() || end != at->data() + at->size() || !(n > 0 && n <= 1e6)) throw Problem{"malformed-request", "the query member 'at' is pow2, a number of samples, or seconds:S"};
    if (seconds) r.every_seconds = n;
    else r.every_samples = static_cast<uint64_t>(std::max(n, 1.0));
    return r;
}
}  // namespace

http::Response exr_stream(Service& s, http::Request& request, const std::shared_ptr<LiveEntry>& entry) {
    Query q(request);
    const auto [aovs, every_seconds, every_samples] = read_exr_stream(q);
    q.finish();
    struct Progress {
        uint64_t version = 0, next = 1;
        std::chrono::steady_clock::time_point last{};
    };
    const auto progress = std::make_shared<Progress>();
    const uint64_t most = static_cast<uint64_t>(entry->render->settings().max_samples);
    const auto part = [aovs = aovs](const http::StreamWriter& write, const Frame& frame, bool final) {
        std::string bytes;
        try {
            bytes = exr_bytes(frame, aovs);
        } catch (const Problem&) {
            return false;
        }
        return write(fmt::format("--{}\r\nContent-Type: image/x-exr\r\nContent-Length: {}\r\nAlder-Samples: {}\r\nAlder-Final: {}\r\n\r\n", kBoundary, bytes.size(), frame.samples(), final) + bytes + "\r\n");
    };
    const auto send = [=, every_seconds = every_seconds, every_samples = every_samples](const http::StreamWriter& write, const Frame& frame, uint64_t) {
        if (frame.divisor > 1) return true;   // files are of the full resolution
        const auto now = std::chrono::steady_clock::now();
        if (frame.version != progress->version) *progress = {frame.version, 1, {}};
        const bool final = frame.samples() >= most;
        if (every_seconds > 0 ? !final && now - progress->last < std::chrono::duration<double>(every_seconds) : !final && frame.samples() < progress->next) return true;
        progress->last = now;
        progress->next = every_samples > 0 ? (frame.samples() / every_samples + 1) * every_samples : std::bit_ceil(frame.samples() + 1);
        return part(write, frame, final);
    };
    const auto at_end = [](const http::StreamWriter& write) { write(fmt::format("--{}--\r\n", kBoundary)); };
    return frame_stream(s, request, entry, fmt::format("multipart/mixed; boundary={}", kBoundary), send, at_end);
}

namespace {
struct TileStream {
    std::vector<std::string> aovs;
    bool half;
};
TileStream read_tile_stream(Query& q) {
    auto aovs = q.list("aovs");
    return {std::move(aovs), q.choice("type", "half", {"half", "float"}) == "half"};
}
}  // namespace

http::Response tile_stream(Service& s, http::Request& request, const std::shared_ptr<LiveEntry>& entry) {
    Query q(request);
    const auto [aovs, half] = read_tile_stream(q);
    q.finish();
    const auto send = [=, aovs = aovs, half = half](const http::StreamWriter& write, const Frame& frame, uint64_t before) {
        constexpr int kTile = 128;
        const Image im = frame.image(aovs.empty() ? std::vector<std::string>{"rgba"} : aovs);
        nlohmann::json layers = nlohmann::json::array();
        for (const Layer& l : im.layers) layers.push_back({{"name", l.name.empty() ? "rgba" : l.name}, {"channels", l.channels}});
        const auto edits = entry->render->edits_between(before, frame.number);
        for (int y0 = 0; y0 < im.height; y0 += kTile)
            for (int x0 = 0; x0 < im.width; x0 += kTile) {
                const int w = std::min(kTile, im.width - x0), h = std::min(kTile, im.height - y0);
                const std::string head = nlohmann::json{{"x", x0}, {"y", y0}, {"w", w}, {"h", h}, {"level", std::countr_zero(static_cast<unsigned>(frame.divisor))},
                                                        {"width", im.width}, {"height", im.height}, {"samples", frame.samples()}, {"pass", frame.number},
                                                        {"type", half ? "half" : "float"}, {"layers", layers}, {"edits", edits}}.dump();
                std::string pixels;
                for (const Layer& l : im.layers)
                    for (const auto& plane : l.planes)
                        for (int y = 0; y < h; ++y)
                            for (int x = 0; x < w; ++x) {
                                const float value = plane[size_t(y0 + y) * im.width + x0 + x];
                                const uint16_t small = half ? half_bits(value) : uint16_t{0};
                                if (half) pixels.append(reinterpret_cast<const char*>(&small), sizeof small);
                                else pixels.append(reinterpret_cast<const char*>(&value), sizeof value);
                            }
                const uint32_t lengths[2] = {static_cast<uint32_t>(head.size()), static_cast<uint32_t>(pixels.size())};
                std::string out = "ALDT";
                out.append(reinterpret_cast<const char*>(lengths), sizeof lengths);
                if (!write(out + head + pixels)) return false;
            }
        return true;
    };
    return frame_stream(s, request, entry, "application/vnd.alder.tiles", send, {});
}

}  // namespace alder::live

namespace alder {
void describe_preview_stream_query(Query& q) { live::read_preview_stream(q); }
void describe_exr_stream_query(Query& q) { live::read_exr_stream(q); }
void describe_tile_stream_query(Query& q) { live::read_tile_stream(q); }
}  // namespace alder
