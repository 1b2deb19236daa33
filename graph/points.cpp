// Shading points of an evaluation request: reading the `points` object.
#include "graph/points.h"

#include <cmath>
#include <numbers>

#include "graph/points_impl.h"

namespace alder {
namespace {

using nlohmann::json;

/// Fields that are no global by themselves: others follow from them.
struct ExtraField {
    const char* name;
    int channels;
};
constexpr ExtraField kExtraFields[] = {{"u", 1}, {"v", 1}, {"Rl", 1}, {"Rt", 1}, {"triangle", 1}, {"barycentric", 2}};

class Parser {
  public:
    Parser(const PointOptions& options, Diagnostics& d) : options_(options), d_(d) {}

    void points(const json& v, const std::string& at, PointData& out) {
        if (!v.is_object()) return fault(at, "wrong-type", v.type_name(), "an object");
        if (!v.contains("count")) return fault(at + "/count", "missing", "nothing", "the number of points");
        const json& n = v["count"];
        if (!n.is_number_integer() || n.get<double>() < 0) return fault(at + "/count", "wrong-type", n.dump(), "a whole number, 0 or more");
        if (n.get<double>() > kMaxPoints) return fault(at + "/count", "limit", n.dump(), "at most " + std::to_string(kMaxPoints) + " points");
        out.count = n.get<uint32_t>();
        for (const auto& [key, value] : v.items()) {
            const std::string here = at + "/" + escape(key);
            if (key == "count" || key == "surface") continue;
            if (key == "attributes") attributes(value, here, out);
            else if (key == "object_to_world") matrix(value, here, out.object_to_world);
            else if (key == "world_to_camera") {
                out.camera.present = matrix(value, here, out.camera.from_world);
                out.camera.to_world = out.camera.from_world.inverse();
            } else named_field(key, value, here, out);
        }
        if (v.contains("surface")) surface(v["surface"], at + "/surface", out);
        out.world_to_object = out.object_to_world.inverse();
        if (!out.has_reference) out.reference_to_world = out.object_to_world;
        out.world_to_reference = out.reference_to_world.inverse();
        check_triangles(at, out);
    }

  private:
    void fault(const std::string& at, const char* code, std::string found, std::string expected, std::string suggest = {}) {
        if (d_.errors.size() >= kMaxDiagnostics) return;
        if (found.size() > 80) found = found.substr(0, 77) + "...";
        d_.errors.push_back({at, code, std::move(found), std::move(expected), std::move(suggest)});
    }
    static std::string escape(const std::string& key) {
        std::string out;
        for (const char c : key) c == '~' ? out += "~0" : c == '/' ? out += "~1" : out += c;
        return out;
    }
    static bool is_number(const json& v) {
        return v.is_number() || v.is_boolean() || (v.is_string() && (v == "nan" || v == "inf" || v == "-inf"));
    }
    static float number(const json& v) {
        if (v.is_boolean()) return v.get<bool>() ? 1.0f : 0.0f;
        if (v.is_number()) return static_cast<float>(v.get<double>());
        return v == "nan" ? NAN : v == "inf" ? INFINITY : -INFINITY;
    }

    /// Reads one value or a list of `count`; lo..hi numbers a value. False after a fault.
    bool field(const json& v, const std::string& at, uint32_t count, int lo, int hi, PointField& out) {
        const std::string what = (lo == hi ? std::to_string(lo) : std::to_string(lo) + " to " + std::to_string(hi)) + (hi == 1 ? " number" : " numbers") +
                                 " or a list of " + std::to_string(count) + " such";
        if (is_number(v) && lo <= 1) {
            out.values = {number(v)};
            return true;
        }
        if (!v.is_array()) return fault(at, "wrong-type", v.dump(), what), false;
        bool flat = !v.empty() || count > 0;
        for (const json& e : v) flat = flat && is_number(e);
        const int size = static_cast<int>(std::min<size_t>(v.size(), 1000));
        // A flat list is one value where its length is that of a value, unless it can only be one number a point.
        if (flat && size >= lo && size <= hi && !(lo == 1 && v.size() == count)) {
            out.channels = size;
            for (const json& e : v) out.values.push_back(number(e));
            return true;
        }
        out.per_point = true;
        if (v.size() != count) return fault(at, "wrong-length", "a list of " + std::to_string(v.size()), what), false;
        if (flat && lo <= 1) {
            out.values.reserve(count);
            for (const json& e : v) out.values.push_back(number(e));
            return true;
        }
        for (size_t i = 0; i < v.size(); ++i) {
            const json& e = v[i];
            const int n = e.is_array() ? static_cast<int>(std::min<size_t>(e.size(), 1000)) : 1;
            bool good = e.is_array() ? true : is_number(e);
            if (e.is_array())
                for (const json& c : e) good = good && is_number(c);
            if (i == 0) out.channels = n;
            if (!good || n < lo || n > hi || n != out.channels)
                return fault(at + "/" + std::to_string(i), "wrong-type", e.dump(), lo == hi ? std::to_string(lo) + " numbers" : "as many numbers as the other points"), false;
            if (i == 0) out.values.reserve(v.size() * n);
            if (e.is_array()) for (const json& c : e) out.values.push_back(number(c));
            else out.values.push_back(number(e));
        }
        return true;
    }

    void named_field(const std::string& key, const json& v, const std::string& at, PointData& out) {
        int lo = 0, hi = 0;
        Global g;
        if (global_from_name(key, g)) {
            hi = channels(g);
            lo = g == Global::Uv || g == Global::Window ? 2 : hi;
        }
        for (const ExtraField& e : kExtraFields)
            if (key == e.name) lo = hi = e.channels;
        if (hi == 0) {
            std::vector<std::string> names{"count", "attributes", "surface", "object_to_world", "world_to_camera"};
            for (int k = 0; k < static_cast<int>(Global::kCount); ++k)
                if (const char* name = global_name(static_cast<Global>(k))) names.push_back(name);
            for (const ExtraField& e : kExtraFields) names.push_back(e.name);
            return fault(at, "unknown-field", key, "a shading global", nearest_name(key, names));
        }
        PointField f;
        if (field(v, at, out.count, lo, hi, f)) out.fields.emplace(key, std::move(f));
    }

    void attributes(const json& v, const std::string& at, PointData& out) {
        if (!v.is_object()) return fault(at, "wrong-type", v.type_name(), "an object of attributes");
        for (const auto& [key, value] : v.items()) {
            PointField f;
            if (field(value, at + "/" + escape(key), out.count, 1, 4, f)) out.attributes.emplace(key, std::move(f));
        }
    }

    bool matrix(const json& v, const std::string& at, PointMatrix& out) {
        std::vector<double> m;
        if (v.is_array())
            for (const json& row : v) {
                if (is_number(row)) m.push_back(number(row));
                else if (row.is_array())
                    for (const json& e : row)
                        if (is_number(e)) m.push_back(number(e));
            }
        bool good = m.size() == 16;
        for (const double x : m) good = good && std::isfinite(x);
        if (!good) return fault(at, "wrong-type", v.dump(), "16 finite numbers, row by row"), false;
        out.x = {m[0], m[4], m[8]};
        out.y = {m[1], m[5], m[9]};
        out.z = {m[2], m[6], m[10]};
        out.t = {m[3], m[7], m[11]};
        return true;
    }

    void surface(const json& v, const std::string& at, PointData& out) {
        if (!v.is_object()) return fault(at, "wrong-type", v.type_name(), "an object");
        if (v.contains("object_to_world")) matrix(v["object_to_world"], at + "/object_to_world", out.object_to_world);
        if (v.contains("reference_object_to_world"))
            out.has_reference = matrix(v["reference_object_to_world"], at + "/reference_object_to_world", out.reference_to_world);
        PointMatrix blender;
        if (v.contains("camera_to_world") && matrix(v["camera_to_world"], at + "/camera_to_world", blender)) {
            blender.z = -blender.z;  // Blender's camera looks along -Z, Cycles' camera space has depth positive
            out.camera.present = true;
            out.camera.to_world = blender;
            out.camera.from_world = blender.inverse();
        }
        if (v.contains("camera")) camera(v["camera"], at + "/camera", out.camera);
        if (v.contains("ray")) {
            if (v["ray"].is_string()) out.ray = v["ray"].get<std::string>();
            else fault(at + "/ray", "wrong-type", v["ray"].dump(), "a kind of ray, as \"camera\"");
        }
        for (const char* key : {"triangle", "barycentric"})
            if (v.contains(key) && !out.field(key)) named_field(key, v[key], at + "/" + key, out);
        custom_properties(v, at, "object_custom_properties", "object:", out);
        custom_properties(v, at, "scene_custom_properties", "view_layer:", out);
        std::string error;
        if (v.contains("mesh") && v["mesh"].is_object()) {
            out.mesh = parse_point_mesh(v["mesh"], error);
            if (!out.mesh) fault(at + "/mesh", "wrong-mesh", error, "a mesh in oracle-mesh/1 form");
        } else if (v.contains("mesh_file")) {
            mesh_file(v["mesh_file"], at + "/mesh_file", out);
        }
    }

    /// Properties of the object or the scene are attributes with a prefix, the same for all points.
    void custom_properties(const json& v, const std::string& at, const char* key, const char* prefix, PointData& out) {
        if (!v.contains(key) || !v[key].is_object()) return;
        for (const auto& [name, value] : v[key].items()) {
            PointField f;
            const std::string here = at + "/" + key + "/" + escape(name);
            if (!field(value, here, 0, 1, 4, f)) continue;
            if (f.values.empty()) fault(here, "wrong-type", value.dump(), "1 to 4 numbers");
            else out.attributes.emplace(prefix + name, std::move(f));
        }
    }

    void mesh_file(const json& v, const std::string& at, PointData& out) {
        if (!v.is_string()) return fault(at, "wrong-type", v.dump(), "a file name");
        const std::string name = v.get<std::string>();
        std::string error;
        const std::string path = options_.resolve_file ? options_.resolve_file(name, error) : std::string();
        if (path.empty()) return fault(at, "file-refused", name, error.empty() ? "files may not be read here" : error);
        out.mesh = load_point_mesh(path, error);
        if (!out.mesh) fault(at, "wrong-mesh", name + " " + error, "a mesh in oracle-mesh/1 form");
    }

    void camera(const json& v, const std::string& at, PointCamera& out) {
        if (!v.is_object()) return fault(at, "wrong-type", v.type_name(), "an object");
        const auto positive = [&](const char* key, double otherwise) {
            if (!v.contains(key) || v[key].is_null()) return otherwise;
            if (v[key].is_number() && v[key].get<double>() > 0) return double{number(v[key])};
            fault(at + "/" + key, "wrong-type", v[key].dump(), "a number above 0");
            return otherwise;
        };
        if (v.contains("resolution")) {
            const json& r = v["resolution"];
            if (r.is_array() && r.size() == 2 && r[0].is_number() && r[1].is_number() && r[0].get<double>() >= 1 && r[1].get<double>() >= 1) {
                out.width_pixels = r[0].get<double>();
                out.height_pixels = r[1].get<double>();
            } else {
                fault(at + "/resolution", "wrong-type", r.dump(), "width and height in pixels");
            }
        }
        const std::string type = v.contains("type") && v["type"].is_string() ? v["type"].get<std::string>() : "PERSP";
        if (type != "PERSP" && type != "ORTHO") return fault(at + "/type", "unsupported", type, "PERSP or ORTHO");
        out.orthographic = type == "ORTHO";
        out.has_view = true;
        out.pixel_footprint = positive("pixel_footprint", -1);
        out.clip_start = positive("clip_start", 0.1);
        // angle_x is the horizontal angle; ortho_scale spans the longer side.
        const double aspect = out.width_pixels / out.height_pixels;
        if (out.orthographic) {
            const double scale = positive("ortho_scale", 6);
            out.half_width = 0.5 * scale * std::min(1.0, aspect);
        } else {
            const double angle_rad = std::min(positive("angle_x", 0.6911112), std::numbers::pi - 1e-4);
            out.half_width = std::tan(0.5 * angle_rad);
        }
        out.half_height = out.half_width / aspect;
    }

    void check_triangles(const std::string& at, PointData& out) {
        if (!out.on_mesh()) return;
        for (const float t : out.field("triangle")->values)
            if (!(t >= 0) || t >= static_cast<double>(out.mesh->triangles.size()) || t != std::floor(t))
                return fault(at + "/triangle", "out-of-range", std::to_string(t), "an index below " + std::to_string(out.mesh->triangles.size()));
    }

    const PointOptions& options_;
    Diagnostics& d_;
};

/// Number `c` of `wanted` from a stored value of `have` numbers: 1 spreads; 3 and 4 to one is the mean of the colour, 2 to one the
/// first (as Cycles' Attribute node); a missing third is 0, a missing alpha 1.
double convert(const std::array<double, 4>& v, int have, int wanted, int c) {
    if (wanted == 1) return have <= 2 ? v[0] : (v[0] + v[1] + v[2]) / 3;
    if (c == 3) return have == 4 ? v[3] : 1;
    return have == 1 ? v[0] : c < have ? v[c] : 0;
}

}  // namespace

std::optional<PointSet> PointSet::parse(const json& points, const std::string& domain, const std::string& pointer_prefix, const PointOptions& options, Diagnostics& d) {
    const size_t faults_before = d.errors.size();
    const auto data = std::make_shared<PointData>();
    data->world = domain == "world";
    if (!domain.empty() && domain != "surface" && domain != "world")
        d.errors.push_back({"/domain", "unknown-domain", domain, "surface or world", ""});
    Parser(options, d).points(points, pointer_prefix, *data);
    if (d.errors.size() != faults_before) return std::nullopt;
    PointSet set;
    set.data_ = data;
    return set;
}

uint32_t PointSet::count() const { return data_->count; }
std::shared_ptr<const PointMesh> PointSet::mesh() const { return data_->world ? nullptr : data_->mesh; }
std::array<double, 12> PointSet::object_to_world() const {
    const PointMatrix& m = data_->object_to_world;
    return {m.x.x, m.y.x, m.z.x, m.t.x, m.x.y, m.y.y, m.z.y, m.t.y, m.x.z, m.y.z, m.z.z, m.t.z};
}

namespace {

/// A stored attribute by name: the request's own, then the mesh's. `read` gives point i as four numbers.
struct FoundAttribute {
    int channels = 0;  ///< 0: there is none
    bool per_point = false;
    std::function<std::array<double, 4>(uint32_t)> read;
};
FoundAttribute find_attribute(const PointData& s, const std::string& name) {
    if (const auto it = s.attributes.find(name); it != s.attributes.end()) {
        const PointField& f = it->second;
        return {f.channels, f.per_point, [&f](uint32_t i) {
                    std::array<double, 4> v{};
                    for (int c = 0; c < f.channels; ++c) v[c] = f.at(i, c);
                    return v;
                }};
    }
    const bool tangent = name.ends_with(".tangent"), sign = name.ends_with(".tangent_sign");
    if (tangent && (s.field("tangent_object") || name == s.active_uv() + ".tangent"))
        return {3, s.varies(), [&s](uint32_t i) { const Vec3d t = s.value(Global::TangentObject, i); return std::array<double, 4>{t.x, t.y, t.z, 1}; }};
    if (sign && (s.field("tangent_sign") || name == s.active_uv() + ".tangent_sign"))
        return {1, s.varies(), [&s](uint32_t i) { return std::array<double, 4>{s.scalar(Global::TangentSign, i)}; }};
    if (!s.on_mesh()) return {};
    const PointMesh::Attribute* const a = s.mesh->find(name.empty() ? s.mesh->active_color : name);
    if (!a) return {};
    return {a->channels, true, [&s, a](uint32_t i) {
                const auto* b = s.field("barycentric");
                return s.mesh->interpolate(*a, static_cast<uint32_t>(s.field("triangle")->at(i, 0)), b->at(i, 0), b->at(i, 1));
            }};
}

template <class Set>
void append_attribute(const PointData& s, const ProgramInput& in, const Set& set) {
    FoundAttribute found = find_attribute(s, in.attribute);
    if (found.channels > 0) {
        return set(found.per_point ? s.count : 1, [&](uint32_t i) {
            const auto v = found.read(i);
            std::array<double, 4> out{};
            for (int c = 0; c < in.channels && c < 4; ++c) out[c] = convert(v, found.channels, in.channels, c);
            return out;
        });
    }
    // Names that the attribute nodes make: nodes/input/attribute.cpp.
    for (const std::string suffix : {".alpha", ".exists"}) {
        if (!in.attribute.ends_with(suffix)) continue;
        found = find_attribute(s, in.attribute.substr(0, in.attribute.size() - suffix.size()));
        const bool alpha = suffix == ".alpha";
        if (alpha && found.channels == 4) return set(found.per_point ? s.count : 1, [&](uint32_t i) { return std::array<double, 4>{found.read(i)[3]}; });
        return set(1, [&](uint32_t) { return std::array<double, 4>{alpha || found.channels > 0 ? 1.0 : 0.0}; });
    }
    set(1, [](uint32_t) { return std::array<double, 4>{}; });
}

}  // namespace

void PointSet::append(const ProgramInput& in, std::vector<ChannelValues>& channels) const {
    const PointData& s = *data_;
    const size_t first = channels.size();
    channels.resize(first + in.channels);
    const auto set = [&](uint32_t n, auto&& value_of) {
        for (int c = 0; c < in.channels; ++c) {
            channels[first + c].uniform = n <= 1;
            channels[first + c].values.resize(n);
        }
        for (uint32_t i = 0; i < n; ++i) {
            const auto v = value_of(i);
            for (int c = 0; c < in.channels; ++c) channels[first + c].values[i] = v[c];
        }
    };
    if (in.is_attribute) return append_attribute(s, in, set);
    const bool matrix = in.global >= Global::ObjectToWorldX && in.global <= Global::WorldToCameraT;
    const uint32_t n = matrix || !s.varies() ? 1 : s.count;
    if (in.channels == 1) set(n, [&](uint32_t i) { return std::array<double, 1>{s.scalar(in.global, i)}; });
    else set(n, [&](uint32_t i) { return s.value(in.global, i); });
    // One number for all points is worth finding: the executor then computes what follows from it once.
    for (int c = 0; c < in.channels; ++c) {
        ChannelValues& ch = channels[first + c];
        bool same = !ch.values.empty();
        for (size_t i = 1; i < ch.values.size() && same; ++i) same = ch.values[i] == ch.values[0];
        if (same) {
            ch.values.resize(1);
            ch.uniform = true;
        }
    }
}

void PointSet::fill(const ProgramInput& in, std::vector<std::vector<double>>& channels, std::vector<bool>& uniform) const {
    std::vector<ChannelValues> list;
    append(in, list);
    for (auto& c : list) {
        channels.push_back(std::move(c.values));
        uniform.push_back(c.uniform);
    }
}

bool PointSet::has_attribute(const std::string& name) const { return find_attribute(*data_, name).channels > 0; }

}  // namespace alder
