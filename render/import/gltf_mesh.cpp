// glTF: meshes. The primitives of a mesh become one mesh with a material a face; Y up becomes Z up, uv start at the bottom.
#include <algorithm>
#include <cstring>

#include "render/import/gltf_parts.h"

namespace alder {

using nlohmann::json;

namespace {

constexpr int kMaxUvSets = 8;

/// Blender's Z up from glTF's Y up.
void turn(std::vector<float>& v, size_t step) {
    for (size_t i = 0; i + 2 < v.size(); i += step) {
        const float y = v[i + 1];
        v[i + 1] = -v[i + 2];
        v[i + 2] = y;
    }
}

/// Corners of triangles from a list, a strip or a fan.
std::vector<uint32_t> triangles_of(const std::vector<uint32_t>& index, int mode) {
    if (mode == 4) return {index.begin(), index.begin() + std::ptrdiff_t(index.size() / 3 * 3)};
    std::vector<uint32_t> out;
    for (size_t i = 2; i < index.size(); ++i) {
        const bool odd = mode == 5 && i % 2 == 1;
        const uint32_t a = mode == 5 ? index[i - 2] : index[0], b = index[i - 1], c = index[i];
        if (a == b || b == c || c == a) continue;   // strips are joined by triangles without an area
        out.insert(out.end(), {odd ? b : a, odd ? a : b, c});
    }
    return out;
}

}  // namespace

struct GltfMeshes::Build {
    std::vector<float> positions, normals;
    std::vector<uint32_t> triangles, face_material, smooth;
    std::vector<float> tangents, tangent_signs;   ///< per corner
    std::vector<float> uv[kMaxUvSets];            ///< per corner
    std::vector<float> color;                     ///< per point, 4 numbers
    bool any_normals = false, all_tangents = true, any_color = false;
    int uv_sets = 0;
};

json GltfMeshes::store(const void* data, size_t numbers, int channels, const char* type) {
    const size_t bytes = numbers * (std::strcmp(type, "u8") == 0 ? 1 : 4);
    while (buffer_.size() % 4 != 0) buffer_.push_back(0);
    const size_t offset = buffer_.size();
    buffer_.resize(offset + bytes);
    if (bytes > 0) std::memcpy(buffer_.data() + offset, data, bytes);
    return {{"buffer", "gltf"}, {"type", type}, {"offset", offset}, {"count", numbers / size_t(channels)}};
}

bool GltfMeshes::primitive(const json& j, const std::string& pointer, Build& b, Result& out) {
    const size_t faults = file_.d.errors.size();
    JsonReader r = file_.reader(j, pointer);
    int mode = 4, material = -1, indices = -1;
    r.integer("mode", mode, 0, 6);
    r.integer("material", material, 0, INT32_MAX);
    r.integer("indices", indices, 0, INT32_MAX);
    if (const json* e = r.member("extensions"); e && e->is_object() && e->contains("KHR_draco_mesh_compression")) {
        add_error(file_.d, r.pointer_to("extensions"), "unsupported", "KHR_draco_mesh_compression", "meshes that are not compressed");
    }
    const json* attributes = r.required("attributes", "an object with POSITION");
    if (!attributes || file_.d.errors.size() > faults) return false;
    if (mode < 4) {
        add_warning(file_.d, pointer, "unsupported", "points or lines", "triangles: this primitive is left out");
        return true;
    }
    if (const json* targets = r.member("targets"); targets && !targets->empty()) {
        add_warning(file_.d, r.pointer_to("targets"), "unsupported", "morph targets", "a mesh without: its base shape is used");
    }
    JsonReader a = file_.reader(*attributes, r.pointer_to("attributes"));
    const auto accessor = [&](const std::string& name) {
        int i = -1;
        a.integer(name.c_str(), i, 0, INT32_MAX);
        return i;
    };
    std::vector<float> p, n, t, color;
    const int position = accessor("POSITION");
    if (position < 0) {
        if (file_.d.errors.size() == faults) add_error(file_.d, a.pointer_to("POSITION"), "missing-member", "nothing", "positions");
        return false;
    }
    if (!file_.floats(position, a.pointer_to("POSITION"), 3, SIZE_MAX, p)) return false;
    const size_t points = p.size() / 3, first = b.positions.size() / 3;
    std::vector<uint32_t> index;
    if (indices >= 0) {
        if (!file_.indices(indices, r.pointer_to("indices"), points, index)) return false;
    } else {
        index.resize(points);
        for (size_t i = 0; i < points; ++i) index[i] = uint32_t(i);
    }
    const std::vector<uint32_t> corners = triangles_of(index, mode);
    if (first + points > UINT32_MAX / 4 || b.triangles.size() + corners.size() > UINT32_MAX / 2) {
        add_error(file_.d, pointer, "limit-exceeded", "a mesh of more than 2^30 points or corners", "smaller meshes");
        return false;
    }
    if (const int i = accessor("NORMAL"); i >= 0 && !file_.floats(i, a.pointer_to("NORMAL"), 3, points, n)) return false;
    if (const int i = accessor("TANGENT"); i >= 0 && !n.empty() && !file_.floats(i, a.pointer_to("TANGENT"), 4, points, t)) return false;
    if (const int i = accessor("COLOR_0"); i >= 0 && !file_.floats(i, a.pointer_to("COLOR_0"), 4, points, color, true)) return false;

    turn(p, 3);
    turn(n, 3);
    turn(t, 4);
    b.positions.insert(b.positions.end(), p.begin(), p.end());
    b.any_normals |= !n.empty();
    b.smooth.insert(b.smooth.end(), corners.size() / 3, n.empty() ? 0 : 1);   // without normals faces are flat (glTF 3.7.2.1)
    n.resize(points * 3, 0);
    b.normals.insert(b.normals.end(), n.begin(), n.end());
    b.any_color |= !color.empty();
    const bool tinted = !color.empty();
    color.resize(points * 4, 1);
    b.color.insert(b.color.end(), color.begin(), color.end());
    b.all_tangents &= !t.empty();
    for (const uint32_t c : corners) {
        b.triangles.push_back(uint32_t(first) + c);
        if (t.empty()) continue;
        b.tangents.insert(b.tangents.end(), t.begin() + std::ptrdiff_t(c) * 4, t.begin() + std::ptrdiff_t(c) * 4 + 3);
        b.tangent_signs.push_back(t[size_t(c) * 4 + 3] < 0 ? -1.0f : 1.0f);
    }
    for (int set = 0; set < kMaxUvSets; ++set) {
        const std::string name = "TEXCOORD_" + std::to_string(set);
        std::vector<float> uv;
        if (const int i = accessor(name); i >= 0 && !file_.floats(i, a.pointer_to(name), 2, points, uv)) return false;
        if (!uv.empty()) b.uv_sets = std::max(b.uv_sets, set + 1);
        for (const uint32_t c : corners) {   // v runs downwards in glTF
            b.uv[set].push_back(uv.empty() ? 0 : uv[size_t(c) * 2]);
            b.uv[set].push_back(uv.empty() ? 0 : 1 - uv[size_t(c) * 2 + 1]);
        }
    }
    const MaterialKey key{material, tinted};
    auto slot = std::find(out.materials.begin(), out.materials.end(), key);
    if (slot == out.materials.end()) slot = out.materials.insert(slot, key);
    b.face_material.insert(b.face_material.end(), corners.size() / 3, uint32_t(slot - out.materials.begin()));
    return file_.d.errors.size() == faults;
}

bool GltfMeshes::convert(int mesh_index, const std::string& referrer, Result& out) {
    const json* j = file_.element("meshes", mesh_index, referrer);
    if (!j) return false;
    const std::string pointer = "/meshes/" + std::to_string(mesh_index);
    JsonReader r = file_.reader(*j, pointer);
    const json* primitives = r.required("primitives", "an array of primitives");
    if (!primitives) return false;
    if (!primitives->is_array()) {
        add_error(file_.d, r.pointer_to("primitives"), "wrong-type", describe(*primitives), "an array of primitives");
        return false;
    }
    Build b;
    for (size_t i = 0; i < primitives->size(); ++i) {
        if (!primitive((*primitives)[i], r.pointer_to("primitives") + "/" + std::to_string(i), b, out)) return false;
    }
    if (b.triangles.empty()) return true;
    json& m = out.mesh;
    m["positions"] = store(b.positions.data(), b.positions.size(), 3, "f32");
    m["triangles"] = store(b.triangles.data(), b.triangles.size(), 3, "u32");
    if (b.any_normals) m["normals"] = store(b.normals.data(), b.normals.size(), 3, "f32");
    if (std::find(b.smooth.begin(), b.smooth.end(), 0u) != b.smooth.end()) m["smooth"] = store(b.smooth.data(), b.smooth.size(), 1, "u32");
    if (out.materials.size() > 1) m["face_material"] = store(b.face_material.data(), b.face_material.size(), 1, "u32");
    if (b.all_tangents) {
        m["tangents"] = store(b.tangents.data(), b.tangents.size(), 3, "f32");
        m["tangent_signs"] = store(b.tangent_signs.data(), b.tangent_signs.size(), 1, "f32");
    }
    for (int set = 0; set < b.uv_sets; ++set) {
        const json uv = store(b.uv[set].data(), b.uv[set].size(), 2, "f32");
        if (set == 0) m["uv"] = uv;
        m["attributes"][gltf_uv_name(set)] = {{"domain", "corner"}, {"channels", 2}, {"values", uv}};
    }
    if (b.any_color) {
        m["attributes"][kGltfColorAttribute] = {{"domain", "point"}, {"channels", 4}, {"values", store(b.color.data(), b.color.size(), 4, "f32")}};
    }
    out.bounds = {Vec3f(b.positions[0], b.positions[1], b.positions[2]), Vec3f(b.positions[0], b.positions[1], b.positions[2])};
    for (size_t i = 0; i < b.positions.size(); ++i) {
        float &lo = out.bounds[0][int(i % 3)], &hi = out.bounds[1][int(i % 3)];
        lo = std::min(lo, b.positions[i]);
        hi = std::max(hi, b.positions[i]);
    }
    return true;
}

}  // namespace alder
