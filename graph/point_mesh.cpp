// Meshes of evaluation requests: reading oracle-mesh/1 and interpolating over its triangles.
#include "graph/point_mesh.h"

#include <zlib.h>

#include <filesystem>
#include <list>
#include <mutex>

namespace alder {
namespace {

using json = nlohmann::ordered_json;  // keeps the order of a file: its first UV map and colour are the active ones
constexpr size_t kMaxMeshBytes = size_t{1} << 30;
constexpr size_t kMeshesKept = 4;

/// Thrown and caught in this file only: a mesh is read by many small steps, each of which may meet a fault.
struct MeshFault {
    std::string text;
};

double number(const json& v, const char* what) {
    if (v.is_number()) return static_cast<float>(v.get<double>());
    if (v.is_boolean()) return v.get<bool>() ? 1 : 0;
    throw MeshFault{std::string(what) + ": expected a number"};
}

const json& member(const json& mesh, const char* key) {
    const auto it = mesh.find(key);
    if (it == mesh.end()) throw MeshFault{std::string(key) + " is missing"};
    return *it;
}

const json& array_of(const json& v, const char* what) {
    if (!v.is_array()) throw MeshFault{std::string(what) + ": expected an array"};
    return v;
}

Vec3d vec3(const json& v, const char* what) {
    if (!v.is_array() || v.size() != 3) throw MeshFault{std::string(what) + ": expected three numbers"};
    return {number(v[0], what), number(v[1], what), number(v[2], what)};
}

std::vector<Vec3d> vec3_list(const json& v, const char* what) {
    std::vector<Vec3d> out;
    out.reserve(array_of(v, what).size());
    for (const json& e : v) out.push_back(vec3(e, what));
    return out;
}

PointMesh::Attribute attribute_values(const json& values, PointMesh::Domain domain, size_t expected, const char* what) {
    PointMesh::Attribute a;
    a.domain = domain;
    if (array_of(values, what).size() != expected)
        throw MeshFault{std::string(what) + ": " + std::to_string(values.size()) + " values, expected " + std::to_string(expected)};
    if (values.empty()) return a;
    a.channels = values[0].is_array() ? static_cast<int>(values[0].size()) : 1;
    if (a.channels < 1 || a.channels > 4) throw MeshFault{std::string(what) + ": expected 1 to 4 numbers a value"};
    a.values.reserve(values.size() * a.channels);
    for (const json& v : values) {
        if (!v.is_array() && a.channels == 1) {
            a.values.push_back(static_cast<float>(number(v, what)));
            continue;
        }
        if (!v.is_array() || static_cast<int>(v.size()) != a.channels) throw MeshFault{std::string(what) + ": values of different sizes"};
        for (const json& c : v) a.values.push_back(static_cast<float>(number(c, what)));
    }
    return a;
}

void read_topology(const json& mesh, PointMesh& out) {
    out.positions = vec3_list(member(mesh, "positions"), "positions");
    if (mesh.contains("vertex_normals")) {
        out.vertex_normals = vec3_list(mesh["vertex_normals"], "vertex_normals");
        if (out.vertex_normals.size() != out.positions.size()) throw MeshFault{"vertex_normals: expected one per position"};
    }
    const json& triangles = array_of(member(mesh, "triangles"), "triangles");
    out.triangles.reserve(triangles.size());
    for (const json& t : triangles) {
        if (!t.is_array() || t.size() != 3) throw MeshFault{"triangles: expected three indices"};
        std::array<uint32_t, 3> corners;
        for (int k = 0; k < 3; ++k) {
            if (!t[k].is_number_integer() || t[k].get<int64_t>() < 0 || t[k].get<uint64_t>() >= out.positions.size())
                throw MeshFault{"triangles: an index is outside positions"};
            corners[k] = t[k].get<uint32_t>();
        }
        out.triangles.push_back(corners);
    }
    if (mesh.contains("smooth")) {
        for (const json& s : array_of(mesh["smooth"], "smooth")) out.smooth.push_back(number(s, "smooth") != 0);
        if (out.smooth.size() != out.triangles.size()) throw MeshFault{"smooth: expected one per triangle"};
    }
}

void read_attributes(const json& mesh, PointMesh& out) {
    const size_t corners = 3 * out.triangles.size();
    if (const auto it = mesh.find("attributes"); it != mesh.end()) {
        if (!it->is_object()) throw MeshFault{"attributes: expected an object"};
        for (const auto& [name, a] : it->items()) {
            const std::string domain = a.is_object() ? a.value("domain", std::string("POINT")) : "";
            if (domain != "POINT" && domain != "FACE" && domain != "CORNER")
                throw MeshFault{"attributes: domain of \"" + name + "\": expected POINT, FACE or CORNER"};
            const auto d = domain == "POINT" ? PointMesh::Domain::Point : domain == "FACE" ? PointMesh::Domain::Face : PointMesh::Domain::Corner;
            const size_t n = domain == "POINT" ? out.positions.size() : domain == "FACE" ? out.triangles.size() : corners;
            out.attributes[name] = attribute_values(member(a, "values"), d, n, "attributes");
            const std::string type = a.value("data_type", std::string());
            if (out.active_color.empty() && (type == "FLOAT_COLOR" || type == "BYTE_COLOR")) out.active_color = name;
        }
    }
    if (const auto it = mesh.find("uv"); it != mesh.end()) {
        if (!it->is_object()) throw MeshFault{"uv: expected an object of UV maps"};
        for (const auto& [name, map] : it->items()) {
            out.attributes[name] = attribute_values(map, PointMesh::Domain::Corner, corners, "uv");
            if (out.attributes[name].channels < 2) throw MeshFault{"uv: expected two numbers a corner"};
        }
        if (!it->empty()) out.active_uv = it->begin().key();
    }
    if (mesh.contains("active_uv") && mesh["active_uv"].is_string()) out.active_uv = mesh["active_uv"].get<std::string>();
}

std::string read_maybe_gzip(const std::string& path) {
    gzFile f = gzopen(path.c_str(), "rb");
    if (!f) throw MeshFault{"cannot be opened"};
    std::string text;
    std::vector<char> block(size_t{1} << 18);
    int got = 0;
    while ((got = gzread(f, block.data(), static_cast<unsigned>(block.size()))) > 0 && text.size() <= kMaxMeshBytes)
        text.append(block.data(), static_cast<size_t>(got));
    gzclose(f);
    if (got < 0) throw MeshFault{"is damaged"};
    if (text.size() > kMaxMeshBytes) throw MeshFault{"is larger than 1 GiB"};
    return text;
}

struct Kept {
    std::string path;
    std::filesystem::file_time_type time;
    std::shared_ptr<const PointMesh> mesh;
};
std::mutex kept_mutex;
std::list<Kept> kept;  // most recently used first

}  // namespace

const PointMesh::Attribute* PointMesh::find(const std::string& name) const {
    const auto it = attributes.find(name);
    return it == attributes.end() ? nullptr : &it->second;
}

std::array<double, 4> PointMesh::interpolate(const Attribute& a, uint32_t t, double w0, double w1) const {
    const double weight[3] = {w0, w1, 1 - w0 - w1};
    std::array<double, 4> out{0, 0, 0, 1};
    for (int c = 0; c < a.channels; ++c) {
        if (a.domain == Domain::Face) {
            out[c] = a.values[size_t{t} * a.channels + c];
            continue;
        }
        double sum = 0;
        for (int k = 0; k < 3; ++k) {
            const size_t element = a.domain == Domain::Point ? triangles[t][k] : size_t{3} * t + k;
            sum += weight[k] * a.values[element * a.channels + c];
        }
        out[c] = sum;
    }
    return out;
}

namespace {
std::shared_ptr<const PointMesh> parse_mesh(const json& mesh, std::string& error) {
    try {
        if (!mesh.is_object()) throw MeshFault{"expected an object in oracle-mesh/1 form"};
        const auto out = std::make_shared<PointMesh>();
        read_topology(mesh, *out);
        read_attributes(mesh, *out);
        if (mesh.contains("texspace_location")) out->texspace_location = vec3(mesh["texspace_location"], "texspace_location");
        if (mesh.contains("texspace_size")) out->texspace_size = vec3(mesh["texspace_size"], "texspace_size");
        return out;
    } catch (const MeshFault& fault) {
        error = fault.text;
    } catch (const json::exception& fault) {
        error = fault.what();
    }
    return nullptr;
}
}  // namespace

std::shared_ptr<const PointMesh> parse_point_mesh(const nlohmann::json& mesh, std::string& error) { return parse_mesh(mesh, error); }

std::shared_ptr<const PointMesh> load_point_mesh(const std::string& path, std::string& error) {
    std::error_code ec;
    const auto time = std::filesystem::last_write_time(path, ec);
    if (ec) {
        error = "cannot be opened";
        return nullptr;
    }
    {
        const std::lock_guard lock(kept_mutex);
        for (auto it = kept.begin(); it != kept.end(); ++it)
            if (it->path == path && it->time == time) {
                kept.splice(kept.begin(), kept, it);
                return it->mesh;
            }
    }
    try {
        const json document = json::parse(read_maybe_gzip(path), nullptr, false);
        if (document.is_discarded()) throw MeshFault{"is not JSON"};
        auto mesh = parse_mesh(document, error);
        if (!mesh) return nullptr;
        const std::lock_guard lock(kept_mutex);
        kept.push_front({path, time, mesh});
        if (kept.size() > kMeshesKept) kept.pop_back();
        return mesh;
    } catch (const MeshFault& fault) {
        error = fault.text;
    }
    return nullptr;
}

}  // namespace alder
