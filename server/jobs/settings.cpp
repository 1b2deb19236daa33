// Settings of a render: the body of POST /v1/renders.
#include "server/jobs/settings.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "render/aov.h"
#include "server/members.h"

namespace alder::jobs {
namespace {

constexpr int kSideMost = 16384;
constexpr int64_t kPixelsMost = int64_t{1} << 28;
constexpr size_t kFramesMost = 10000, kOverridesMost = 10000, kLabelsMost = 64;
constexpr double kRetainMost = 3650.0 * 86400;

template <size_t N>
bool read_numbers(Members& m, const std::string& name, std::array<int64_t, N>& out, int64_t low, int64_t high) {
    const auto* value = m.find(name, {{"type", "array"}, {"items", {{"type", "integer"}, {"minimum", low}, {"maximum", high}}}, {"minItems", N}, {"maxItems", N}});
    if (!value) return false;
    bool fits = value->is_array() && value->size() == N;
    for (size_t i = 0; fits && i < N; ++i) fits = whole_number((*value)[i], low, high, out[i]);
    if (!fits) m.fault(name, "wrong-type", brief(*value), fmt::format("an array of {} whole numbers from {} to {}", N, low, high));
    return fits;
}

/// One integer conversion (%d, %4d, %04d) at most, and nothing that could leave the folder.
bool is_output_name(const std::string& name) {
    if (name.empty() || name.size() > 200 || name[0] == '.') return false;
    int conversions = 0;
    for (size_t i = 0; i < name.size(); ++i) {
        const char c = name[i];
        if (c == '%') {
            size_t k = i + 1;
            while (k < name.size() && std::isdigit(static_cast<unsigned char>(name[k]))) ++k;
            if (k - i > 3 || k == name.size() || name[k] != 'd' || ++conversions > 1) return false;
            i = k;
        } else if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '_' && c != '-') {
            return false;
        }
    }
    return true;
}

size_t code_points(const std::string& utf8) {
    return static_cast<size_t>(std::count_if(utf8.begin(), utf8.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

void read_output(Members& o, JobSettings& s) {
    std::string pixel, compression, parts, naming;
    if (o.choice("pixel_type", pixel, {"half", "float"})) s.exr.all_float = pixel == "float";
    if (o.choice("compression", compression, {"none", "zip", "zips", "piz", "rle"}))
        s.exr.compression = compression == "none" ? ExrOptions::Compression::None : compression == "zips" ? ExrOptions::Compression::Zips
                          : compression == "piz" ? ExrOptions::Compression::Piz : compression == "rle" ? ExrOptions::Compression::Rle : ExrOptions::Compression::Zip;
    o.choice("parts", parts, {"single"});
    o.choice("naming", naming, {"alder"});
    if (const auto* name = o.find("name", {{"type", "string"}, {"pattern", "^[A-Za-z0-9_%-][A-Za-z0-9._%-]{0,199}$"}})) {
        if (name->is_string() && is_output_name(*name)) s.name = *name;
        else o.fault("name", "wrong-value", brief(*name), "a file name of letters, digits, '.', '_', '-' that does not begin with '.', at most 200 long, with %04d for the frame");
    }
    o.finish(s.lenient);
}

void read_time(Members& m, JobSettings& s) {
    std::string range;
    int64_t frame = 0;
    const bool has_frame = m.integer("frame", frame, -1000000, 1000000);
    if (m.text("frames", range)) {
        s.frames = parse_frames(range, kFramesMost);
        s.has_frames = true;
        if (s.frames.empty()) {
            m.fault("frames", "wrong-value", brief(range), fmt::format("frames as in \"1-48\" or \"1-9x2,20\", at most {}", kFramesMost));
            s.frames = {0};
        }
        if (has_frame) m.fault("frame", "conflict", std::to_string(frame), "either frame or frames");
    } else if (has_frame) {
        s.frames = {static_cast<int>(frame)};
        s.has_frames = true;
    }
}

void read_overrides(Members& m, JobSettings& s) {
    const nlohmann::json text = {{"type", "string"}};
    const auto* value = m.find("overrides", {{"type", "array"}, {"maxItems", kOverridesMost},
        {"items", {{"type", "object"}, {"required", {"op", "path"}}, {"properties", {{"op", {{"type", "string"}, {"enum", {"replace", "add", "remove"}}}}, {"path", text}, {"value", nlohmann::json::object()}}}}}});
    if (!value) return;
    if (!value->is_array() || value->size() > kOverridesMost) return m.fault("overrides", "wrong-type", brief(*value), "an array of operations of RFC 6902");
    for (const auto& op : *value) {
        const bool fits = op.is_object() && op.contains("op") && op["op"].is_string() && op.contains("path") && op["path"].is_string();
        const std::string name = fits ? op["op"].get<std::string>() : "";
        if (fits && (name == "remove" || ((name == "replace" || name == "add") && op.contains("value")))) continue;
        m.fault("overrides", "wrong-value", brief(op), R"({"op": "replace" | "add" | "remove", "path": "/materials/...", "value": ...})");
        return;
    }
    if (!value->empty()) s.overrides = *value;
}

}  // namespace

std::vector<int> parse_frames(const std::string& text, size_t most) {
    std::vector<int> out;
    const char* at = text.data();
    const char* const end = at + text.size();
    const auto number = [&](int& value, int low, int high) {
        const auto [next, error] = std::from_chars(at, end, value);
        if (error != std::errc() || value < low || value > high) return false;
        at = next;
        return true;
    };
    for (;;) {
        int first = 0, last = 0, step = 1;
        if (!number(first, -1000000, 1000000)) return {};
        last = first;
        if (at != end && *at == '-') {
            ++at;
            if (!number(last, first, 1000000)) return {};
            if (at != end && *at == 'x') {
                ++at;
                if (!number(step, 1, 1000000)) return {};
            }
        }
        if (static_cast<size_t>((last - first) / step) >= most || out.size() > most) return {};
        for (int f = first; f <= last; f += step) out.push_back(f);
        if (at == end) break;
        if (*at++ != ',') return {};
    }
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out.size() <= most ? out : std::vector<int>{};
}

void read_labels(Members& m, nlohmann::json& out) {
    const auto* value = m.find("labels", {{"type", "object"}, {"maxProperties", kLabelsMost}, {"propertyNames", {{"minLength", 1}, {"maxLength", 64}}},
                                          {"additionalProperties", {{"type", "string"}, {"maxLength", 256}}}});
    if (!value) return;
    bool fits = value->is_object() && value->size() <= kLabelsMost;
    if (fits)
        for (const auto& [name, label] : value->items())
            fits = fits && code_points(name) >= 1 && code_points(name) <= 64 && label.is_string() && code_points(label.get_ref<const std::string&>()) <= 256;
    if (fits) out = *value;
    else m.fault("labels", "wrong-type", brief(*value), fmt::format("at most {} strings by name", kLabelsMost));
}

void read_settings(Members& m, JobSettings& s) {
    if (const auto* scene = m.require("scene", "the id of a scene", {{"type", "string"}})) {
        if (scene->is_string()) s.scene = *scene;
        else m.fault("scene", "wrong-type", brief(*scene), "a string");
    }
    m.boolean("lenient", s.lenient);
    m.boolean("strict", s.strict);
    m.boolean("cancel_on_disconnect", s.cancel_on_disconnect);
    std::string mode;
    m.choice("mode", mode, {"final"});   // live renders take another way long before this
    m.text("camera", s.camera);
    std::array<int64_t, 2> resolution{};
    if (read_numbers(m, "resolution", resolution, 1, kSideMost)) {
        s.render.width = static_cast<int>(resolution[0]);
        s.render.height = static_cast<int>(resolution[1]);
        if (resolution[0] * resolution[1] > kPixelsMost) m.fault("resolution", "limit-exceeded", fmt::format("{} pixels", resolution[0] * resolution[1]), fmt::format("at most {}", kPixelsMost));
    }
    std::array<int64_t, 4> crop{};
    if (read_numbers(m, "crop", crop, 0, kSideMost)) {
        std::copy(crop.begin(), crop.end(), s.render.crop);
        if (crop[0] >= crop[2] || crop[1] >= crop[3]) m.fault("crop", "out-of-range", "an empty rectangle", "[x0, y0, x1, y1] with x0 < x1 and y0 < y1");
    }
    int64_t samples = 0, seed = 0, min_samples = 0;
    if (m.integer("samples", samples, 1, 1 << 20)) s.render.samples = static_cast<int>(samples);
    if (m.integer("seed", seed, 0, UINT32_MAX)) s.render.seed = static_cast<uint32_t>(seed);
    m.object("stop", [&](Members& limits) {
        limits.number("error", s.render.target_error, 1e-6, 10);
        limits.number("seconds", s.render.seconds, 0.001, 1e7);
        if (limits.integer("min_samples", min_samples, 0, 1 << 20)) s.min_samples = static_cast<int>(min_samples);
        limits.finish(s.lenient);
    });
    m.texts("aovs", s.render.aovs, 1024);
    std::string groups;
    if (m.choice("light_groups", groups, {"all"})) s.render.aovs.push_back("light_groups");
    m.object("output", [&](Members& o) { read_output(o, s); });
    read_time(m, s);
    read_overrides(m, s);
    m.integer("priority", s.priority, 0, 100);
    m.number("retain", s.retain, 0, kRetainMost);
    read_labels(m, s.labels);
    if (const auto* value = m.find("reproducible", {{"type", "boolean"}, {"enum", {true}}}); value && *value != true)
        m.fault("reproducible", "unsupported", brief(*value), "true: files never hold times, hosts or paths");
    for (const char* later : {"cryptomatte", "farm"})
        if (const auto* value = m.find(later, {{"type", "null"}})) m.fault(later, "unsupported", brief(*value), "nothing: not available in this version");
    m.finish(s.lenient);
    if (s.name.empty()) s.name = s.has_frames ? "frame.%04d" : "frame";
    if (s.frames.size() > 1 && s.name.find('%') == std::string::npos) s.name += ".%04d";
}

JobSettings read_settings(const nlohmann::json& body, Diagnostics& d) {
    JobSettings s;
    Members m(body, "", d);
    read_settings(m, s);
    return s;
}

std::string JobSettings::file_name(int frame) const {
    const size_t at = name.find('%');
    std::string out = name;
    if (at != std::string::npos) {
        const size_t end = name.find('d', at);
        const std::string digits = name.substr(at + 1, end - at - 1);
        const int width = digits.empty() ? 0 : std::stoi(digits);
        const std::string number = !digits.empty() && digits[0] == '0' ? fmt::format("{:0{}}", frame, width) : std::to_string(frame);
        out = name.substr(0, at) + number + name.substr(end + 1);
    }
    return out.ends_with(".exr") ? out : out + ".exr";
}

uint32_t JobSettings::frame_seed(int frame, uint32_t scene_seed) const {
    const uint32_t base = render.seed != 0 ? render.seed : scene_seed;
    if (!has_frames) return base;
    // Two rounds of the 32-bit finaliser of MurmurHash3: neighbouring frames share no bits.
    uint32_t h = base * 0x9E3779B1u + static_cast<uint32_t>(frame);
    for (int i = 0; i < 2; ++i) {
        h ^= h >> 16;
        h *= 0x85EBCA6Bu;
        h ^= h >> 13;
        h *= 0xC2B2AE35u;
        h ^= h >> 16;
    }
    return h ? h : 1;   // 0 would mean the scene's
}

uint64_t film_bytes(const JobSettings& s, int width, int height, const std::vector<std::string>& graph_aovs) {
    if (s.render.crop[2] > s.render.crop[0]) {
        width = s.render.crop[2] - s.render.crop[0];
        height = s.render.crop[3] - s.render.crop[1];
    }
    const AovPlan plan(expand_aovs(s.render.aovs, graph_aovs), {});
    // The film holds a node for each set bit of the number of leaves, but merges as it grows: four rows a pixel at the worst
    // moment (two nodes, the pass, their total), and the layers of the image once.
    return static_cast<uint64_t>(width) * static_cast<uint64_t>(height) * (static_cast<uint64_t>(plan.film_row()) * 5 + graph_aovs.size() * 15) * sizeof(float);
}

}  // namespace alder::jobs
