// Texture Coordinate: the shading point in the coordinate systems that textures use (Blender's node).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/input/tex_coord.cpp"
#include "hwy/foreach_target.h"

#include "nodes/input/space-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Point 0, columns of an affine matrix 3 ... 14.
struct TransformPoint {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, matrix3(k, 3).apply(k.v(0)) + k.v(12)); }
};
/// World normal 0, columns of the object's matrix 3 ... 11: the normal in object space.
struct ObjectNormal {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, safe_normalize(matrix3(k, 3).transposed(k.v(0)))); }
};
/// Normal 0, direction to the viewer 3: the mirrored viewing direction, away from the surface.
struct ReflectView {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> n = k.v(0), view = k.v(3);
        k.set(0, F(2) * dot(n, view) * n - view);
    }
};
template <class F>
void transform_point(const Call<F>& c) { c.template each<TransformPoint>(); }
template <class F>
void object_normal(const Call<F>& c) { c.template each<ObjectNormal>(); }
template <class F>
void reflect_view(const Call<F>& c) { c.template each<ReflectView>(); }
ALDER_KERNEL(transform_point)
ALDER_KERNEL(object_normal)
ALDER_KERNEL(reflect_view)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "graph/lowering.h"
#include "nodes/num/vec.h"

namespace alder {
ALDER_KERNEL_EXPORT(transform_point)
ALDER_KERNEL_EXPORT(object_normal)
ALDER_KERNEL_EXPORT(reflect_view)

enum { kObject, kFromInstancer };
enum { kGenerated, kNormal, kUv, kObjectSpace, kCamera, kWindow, kReflection };

/// Columns of the inverse of a reference object's matrix.
using InverseColumns = std::array<Vec3d, 4>;
static std::optional<InverseColumns> reference_object(const std::string& json_text, std::vector<std::string>& errors) {
    const auto v = nlohmann::json::parse(json_text.empty() ? "null" : json_text, nullptr, false);
    if (v.is_null()) return std::nullopt;
    std::vector<double> m;
    const auto collect = [&m](const nlohmann::json& list) {
        for (const auto& e : list)
            if (e.is_number()) m.push_back(e.get<double>());
    };
    const auto& rows = v.is_object() && v.contains("object_to_world") ? v["object_to_world"] : v;
    if (rows.is_array()) {
        collect(rows);
        for (const auto& row : rows)
            if (row.is_array()) collect(row);
    }
    if (m.size() != 16) {
        errors.push_back("object: expected the reference object's matrix, 16 numbers row by row");
        return std::nullopt;
    }
    const Vec3d x{m[0], m[4], m[8]}, y{m[1], m[5], m[9]}, z{m[2], m[6], m[10]}, t{m[3], m[7], m[11]};
    const double det = dot(x, cross(y, z));
    if (det == 0 || !std::isfinite(det)) {
        errors.push_back("object: the matrix has no inverse");
        return std::nullopt;
    }
    const Vec3d r0 = cross(y, z) / det, r1 = cross(z, x) / det, r2 = cross(x, y) / det;
    return InverseColumns{Vec3d{r0.x, r1.x, r2.x}, Vec3d{r0.y, r1.y, r2.y}, Vec3d{r0.z, r1.z, r2.z}, Vec3d{-dot(r0, t), -dot(r1, t), -dot(r2, t)}};
}

static ValueRef object_coordinates(Lowering& l) {
    std::vector<std::string> errors;
    const auto inverse = reference_object(l.statics().text[kObject], errors);
    if (!inverse) return l.global(Global::Po);
    std::vector<ValueRef> operands{l.global(Global::P)};
    for (const Vec3d& c : *inverse) operands.push_back(l.constant(Type::Vector, c.x, c.y, c.z));
    return l.op("transform_point", transform_point_kernel(), operands, Type::Vector);
}

static void lower_tex_coord(Lowering& l, int output) {
    const bool instancer = l.statics().e(kFromInstancer) != 0;
    switch (output) {
        // What an instancer (vertex or face duplication) gives its instances comes as attributes; zero for other objects.
        case kGenerated: return l.result(instancer ? l.attribute("instancer_generated", Type::Vector) : l.global(Global::Generated));
        case kUv: return l.result(instancer ? l.attribute("instancer_uv", Type::Vector) : l.global(Global::Uv));
        case kNormal: {
            const ValueRef operands[] = {l.global(Global::N), l.global(Global::ObjectToWorldX), l.global(Global::ObjectToWorldY), l.global(Global::ObjectToWorldZ)};
            return l.result(l.op("object_normal", object_normal_kernel(), operands, Type::Vector));
        }
        case kObjectSpace: return l.result(object_coordinates(l));
        case kCamera: {
            const ValueRef operands[] = {l.global(Global::P), l.global(Global::WorldToCameraX), l.global(Global::WorldToCameraY),
                                         l.global(Global::WorldToCameraZ), l.global(Global::WorldToCameraT)};
            return l.result(l.op("transform_point", transform_point_kernel(), operands, Type::Vector));
        }
        case kWindow: return l.result(l.global(Global::Window));
        default: {
            const ValueRef operands[] = {l.global(Global::N), l.global(Global::I)};
            return l.result(l.op("reflect_view", reflect_view_kernel(), operands, Type::Vector));
        }
    }
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeTexCoord";
    n.category = "Input";
    n.summary = "the shading point in the coordinate systems that textures use";
    n.help = "Camera has depth positive. In world graphs Generated and Object are the direction of the ray.";
    n.aliases = {"texture_coordinate"};
    n.params.push_back(json("object").doc("matrix of the object whose space Object uses: 16 numbers row by row; null is the own object"));
    n.params.push_back(b("from_instancer", false).no_link().doc("Generated and UV of the instancer (vertex and face instancing)").alias("from_dupli"));
    for (const char* o : {"Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection"}) n.outputs.push_back({o, Type::Vector});
    n.cost_ns = 1;
    n.check = [](const Statics& s, const std::vector<const double*>&, std::vector<std::string>& errors) { reference_object(s.text[kObject], errors); };
    n.lower = lower_tex_coord;
    return n;
}
}  // namespace alder
#endif
