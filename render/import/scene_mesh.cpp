// Scene documents: meshes.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "render/geometry/mesh_build.h"
#include "render/import/scene_parts.h"

namespace alder {

using nlohmann::json;

namespace {

static_assert(sizeof(Vec3f) == 12 && sizeof(std::array<float, 2>) == 8 && sizeof(std::array<uint32_t, 3>) == 12);

/// Numbers read as one row become elements of a struct of the same layout.
template <class T, class Number>
std::vector<T> pack(const std::vector<Number>& numbers) {
    std::vector<T> out(numbers.size() * sizeof(Number) / sizeof(T));
    if (!out.empty()) std::memcpy(static_cast<void*>(out.data()), numbers.data(), out.size() * sizeof(T));
    return out;
}

size_t domain_count(const Mesh& m, Domain domain) {
    switch (domain) {
        case Domain::Point: return m.positions.size();
        case Domain::Corner: return m.triangles.size() * 3;
        case Domain::Face: return m.triangles.size();
        case Domain::Mesh: return 1;
    }
    return 0;
}

class MeshReading {
  public:
    MeshReading(SceneReading& s, JsonReader& r, Mesh& m) : s_(s), r_(r), m_(m) {}

    void topology() {
        std::vector<float> positions;
        std::vector<uint32_t> indices;
        if (const json* j = r_.required("positions", "the points, three numbers each")) {
            s_.arrays.floats(*j, r_.pointer_to("positions"), 3, SIZE_MAX, positions);
        }
        m_.positions = pack<Vec3f>(positions);
        if (const json* j = r_.required("triangles", "three indices of points for each triangle")) {
            s_.arrays.indices(*j, r_.pointer_to("triangles"), 3, SIZE_MAX, m_.positions.size(), indices);
        }
        m_.triangles = pack<std::array<uint32_t, 3>>(indices);
    }

    void shading() {
        m_.vertex_normals = vectors("normals", m_.positions.size());
        m_.corner_normals = vectors("corner_normals", corners());
        m_.tangents = vectors("tangents", corners());
        if (const json* j = r_.member("tangent_signs")) s_.arrays.floats(*j, r_.pointer_to("tangent_signs"), 1, corners(), m_.tangent_signs);
        if (m_.tangents.empty() != m_.tangent_signs.empty()) {
            add_error(s_.d, r_.pointer(), "missing-member", m_.tangents.empty() ? "only tangent_signs" : "only tangents", "both or neither");
        }
        if (const json* j = r_.member("uv")) {
            std::vector<float> uv;
            s_.arrays.floats(*j, r_.pointer_to("uv"), 2, corners(), uv);
            m_.uv = pack<std::array<float, 2>>(uv);
        }
        smooth();
        if (const json* j = r_.member("face_material")) {
            s_.arrays.indices(*j, r_.pointer_to("face_material"), 1, m_.triangles.size(), s_.options.limits.materials, m_.face_material);
        }
    }

    void attributes(const json& j, const std::string& pointer) {
        JsonReader all = s_.object(j, pointer);
        if (!all.ok()) return;
        for (const auto& [name, value] : j.items()) {
            JsonReader a = s_.object(value, pointer + "/" + pointer_token(name));
            if (!a.ok()) continue;
            Attribute out;
            out.name = name;
            int domain = 0;
            a.choice("domain", kDomainNames, domain);
            out.domain = Domain(domain);
            a.integer("channels", out.channels, 1, 4);
            if (const json* values = a.required("values", "the attribute's numbers")) {
                s_.arrays.floats(*values, a.pointer_to("values"), out.channels, domain_count(m_, out.domain), out.values);
            }
            a.finish();
            m_.attributes.push_back(std::move(out));
        }
    }

    void bounds(const json& j, const std::string& pointer) {
        std::vector<float> v;
        if (s_.arrays.floats(j, pointer, 3, 2, v)) m_.generated_bounds = {Vec3f(v[0], v[1], v[2]), Vec3f(v[3], v[4], v[5])};
    }

  private:
    size_t corners() const { return m_.triangles.size() * 3; }

    std::vector<Vec3f> vectors(const char* key, size_t count) {
        std::vector<float> v;
        if (const json* j = r_.member(key)) s_.arrays.floats(*j, r_.pointer_to(key), 3, count, v);
        return pack<Vec3f>(v);
    }

    void smooth() {
        const json* j = r_.member("smooth");
        if (!j) return;
        if (j->is_boolean()) {
            if (!j->get<bool>()) m_.smooth.assign(m_.triangles.size(), 0);
            return;
        }
        std::vector<uint32_t> flags;
        if (s_.arrays.indices(*j, r_.pointer_to("smooth"), 1, m_.triangles.size(), 2, flags)) m_.smooth.assign(flags.begin(), flags.end());
    }

    SceneReading& s_;
    JsonReader& r_;
    Mesh& m_;
};

}  // namespace

std::shared_ptr<const Mesh> read_mesh(SceneReading& s, const std::string& name, const json& j, const std::string& pointer, uint32_t& slots) {
    const size_t faults = s.d.errors.size();
    JsonReader r = s.object(j, pointer);
    if (!r.ok()) return nullptr;
    auto mesh = std::make_shared<Mesh>();
    mesh->name = name;
    MeshReading reading(s, r, *mesh);
    reading.topology();
    if (s.d.errors.size() == faults) {   // counts of everything else follow from these
        reading.shading();
        if (const json* a = r.member("attributes")) reading.attributes(*a, r.pointer_to("attributes"));
        if (const json* b = r.member("generated_bounds")) reading.bounds(*b, r.pointer_to("generated_bounds"));
        s.unsupported(r, "motion", "deformation motion is not rendered yet");
        r.finish();
    }
    if (s.d.errors.size() != faults) return nullptr;
    slots = 1;
    for (uint32_t m : mesh->face_material) slots = std::max(slots, m + 1);
    fill_derived(*mesh);
    return mesh;
}

}  // namespace alder
