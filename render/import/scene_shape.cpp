// Scene documents: what meshes, curves and point clouds have in common; curves and point clouds themselves.
#include <algorithm>
#include <span>

#include "render/geometry/mesh_build.h"
#include "render/import/scene_parts.h"

namespace alder {

using nlohmann::json;

namespace {

constexpr float kDefaultRadius = 0.005f;   // Cycles' for curves without radii

size_t domain_count(const Mesh& m, Domain domain) {
    switch (domain) {
        case Domain::Point: return m.positions.size();
        case Domain::Corner: return m.triangles.size() * 3;
        case Domain::Face: return m.triangles.size();
        case Domain::Mesh: return 1;
        case Domain::Curve: return m.curve_first.empty() ? 0 : m.curve_first.size() - 1;
    }
    return 0;
}

bool has_domain(Shape shape, Domain domain) {
    if (domain == Domain::Point || domain == Domain::Mesh) return true;
    return domain == Domain::Curve ? shape == Shape::Curves : shape == Shape::Triangles;
}

void read_radii(SceneReading& s, JsonReader& r, Mesh& m) {
    if (const json* j = r.member("radii")) s.arrays.floats(*j, r.pointer_to("radii"), 1, m.positions.size(), m.radii);
    else m.radii.assign(m.positions.size(), kDefaultRadius);
}

}  // namespace

std::vector<Vec3f> ShapeReading::vectors(JsonReader& r, const char* key, size_t count) {
    std::vector<float> v;
    if (const json* j = r.member(key)) s_.arrays.floats(*j, r.pointer_to(key), 3, count, v);
    std::vector<Vec3f> out(v.size() / 3);
    for (size_t i = 0; i < out.size(); ++i) out[i] = {v[3 * i], v[3 * i + 1], v[3 * i + 2]};
    return out;
}

void ShapeReading::positions() {
    if (r_.required("positions", "the points, three numbers each")) m_.positions = vectors(r_, "positions", SIZE_MAX);
}

void ShapeReading::extras() {
    if (const json* a = r_.member("attributes")) attributes(*a, r_.pointer_to("attributes"));
    if (const json* b = r_.member("generated_bounds")) {
        std::vector<float> v;
        if (s_.arrays.floats(*b, r_.pointer_to("generated_bounds"), 3, 2, v)) m_.generated_bounds = {Vec3f(v[0], v[1], v[2]), Vec3f(v[3], v[4], v[5])};
    }
    if (const json* j = r_.member("motion"); j && !j->is_null()) motion(*j, r_.pointer_to("motion"));
}

void ShapeReading::attributes(const json& j, const std::string& pointer) {
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
        if (!has_domain(m_.shape, out.domain)) {
            add_error(s_.d, a.pointer_to("domain"), "wrong-value", kDomainNames[domain], m_.shape == Shape::Curves ? "point, curve or mesh" : "point or mesh");
            continue;
        }
        a.integer("channels", out.channels, 1, 4);
        if (const json* values = a.required("values", "the attribute's numbers")) {
            s_.arrays.floats(*values, a.pointer_to("values"), out.channels, domain_count(m_, out.domain), out.values);
        }
        a.finish();
        m_.attributes.push_back(std::move(out));
    }
}

/// The shape at equally spaced times from the shutter's opening to its closing.
void ShapeReading::motion(const json& j, const std::string& pointer) {
    JsonReader r = s_.object(j, pointer);
    if (!r.ok()) return;
    int steps = 0;
    if (r.required("steps", "how many times")) r.integer("steps", steps, 2, kMostMotionSteps);
    const size_t count = size_t(steps) * m_.positions.size();
    if (steps > 0 && r.required("positions", "the points at each time")) m_.motion_positions = vectors(r, "positions", count);
    if (m_.shape == Shape::Triangles) {
        m_.motion_normals = vectors(r, "normals", count);
    } else if (const json* radii = r.member("radii")) {
        s_.arrays.floats(*radii, r.pointer_to("radii"), 1, count, m_.motion_radii);
    }
    r.finish();
    if (m_.motion_positions.size() != count || count == 0) return;
    m_.motion_steps = steps;
    const bool flat = !m_.smooth.empty() && std::none_of(m_.smooth.begin(), m_.smooth.end(), [](uint8_t x) { return x != 0; });
    if (m_.shape != Shape::Triangles || !m_.motion_normals.empty() || flat) return;
    for (int step = 0; step < steps; ++step) {
        const auto normals = compute_vertex_normals(std::span(m_.motion_positions).subspan(size_t(step) * m_.positions.size(), m_.positions.size()), m_.triangles);
        m_.motion_normals.insert(m_.motion_normals.end(), normals.begin(), normals.end());
    }
}

std::shared_ptr<const Mesh> read_curves(SceneReading& s, const std::string& name, const json& j, const std::string& pointer) {
    const size_t faults = s.d.errors.size();
    JsonReader r = s.object(j, pointer);
    if (!r.ok()) return nullptr;
    auto m = std::make_shared<Mesh>();
    m->name = name;
    m->shape = Shape::Curves;
    ShapeReading reading(s, r, *m);
    reading.positions();
    std::vector<uint32_t> counts;
    if (const json* c = r.required("counts", "how many points each curve has")) s.arrays.indices(*c, r.pointer_to("counts"), 1, SIZE_MAX, uint64_t(1) << 32, counts);
    if (s.d.errors.size() == faults) {
        uint64_t sum = 0;
        bool empty = false;
        m->curve_first.push_back(0);
        for (const uint32_t c : counts) {
            empty = empty || c == 0;
            sum += c;
            m->curve_first.push_back(uint32_t(std::min<uint64_t>(sum, ~uint32_t{0})));
        }
        if (sum != m->positions.size() || empty)
            add_error(s.d, r.pointer_to("counts"), "wrong-length", empty ? "a curve without points" : std::to_string(sum) + " points together",
                      empty ? "at least one point a curve" : std::to_string(m->positions.size()) + ", as many as positions");
    }
    if (s.d.errors.size() != faults) return nullptr;
    read_radii(s, r, *m);
    int form = 0;
    r.choice("form", kCurveFormNames, form);
    m->curve_form = CurveForm(form);
    r.integer("subdivisions", m->curve_subdivisions, 0, 15);
    m->curve_normals = reading.vectors(r, "normals", m->positions.size());
    reading.extras();
    r.finish();
    if (s.d.errors.size() != faults) return nullptr;
    fill_derived(*m);
    return m;
}

std::shared_ptr<const Mesh> read_points(SceneReading& s, const std::string& name, const json& j, const std::string& pointer) {
    const size_t faults = s.d.errors.size();
    JsonReader r = s.object(j, pointer);
    if (!r.ok()) return nullptr;
    auto m = std::make_shared<Mesh>();
    m->name = name;
    m->shape = Shape::Spheres;
    ShapeReading reading(s, r, *m);
    reading.positions();
    if (s.d.errors.size() != faults) return nullptr;
    read_radii(s, r, *m);
    reading.extras();
    r.finish();
    if (s.d.errors.size() != faults) return nullptr;
    fill_derived(*m);
    return m;
}

}  // namespace alder
