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

class MeshReading : public ShapeReading {
  public:
    using ShapeReading::ShapeReading;

    void topology() {
        std::vector<uint32_t> indices;
        positions();
        if (const json* j = r_.required("triangles", "three indices of points for each triangle")) {
            s_.arrays.indices(*j, r_.pointer_to("triangles"), 3, SIZE_MAX, m_.positions.size(), indices);
        }
        m_.triangles = pack<std::array<uint32_t, 3>>(indices);
    }

    void shading() {
        m_.vertex_normals = vectors(r_, "normals", m_.positions.size());
        m_.corner_normals = vectors(r_, "corner_normals", corners());
        m_.tangents = vectors(r_, "tangents", corners());
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

  private:
    size_t corners() const { return m_.triangles.size() * 3; }

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
        reading.extras();
        r.finish();
    }
    if (s.d.errors.size() != faults) return nullptr;
    slots = 1;
    for (uint32_t m : mesh->face_material) slots = std::max(slots, m + 1);
    fill_derived(*mesh);
    return mesh;
}

}  // namespace alder
