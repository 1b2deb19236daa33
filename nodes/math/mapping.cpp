// Mapping: moves, turns and scales a vector as a point, a texture, a direction or a normal (Blender's node).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/math/mapping.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/math/cycles-inl.h"
#include "nodes/math/finite-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct MapPoint {
    template <class F>
    static HWY_INLINE Vec3<F> eval(Vec3<F> v, Vec3<F> location, const Rotation<F>& r, Vec3<F> scale) { return r.apply(v * scale) + location; }
};
/// The inverse of Point; a zero scale gives 0.
struct MapTexture {
    template <class F>
    static HWY_INLINE Vec3<F> eval(Vec3<F> v, Vec3<F> location, const Rotation<F>& r, Vec3<F> scale) { return finite_or_limit(safe_divide(r.apply_inverse(v - location), scale)); }
};
struct MapVector {
    template <class F>
    static HWY_INLINE Vec3<F> eval(Vec3<F> v, Vec3<F>, const Rotation<F>& r, Vec3<F> scale) { return r.apply(v * scale); }
};
struct MapNormal {
    template <class F>
    static HWY_INLINE Vec3<F> eval(Vec3<F> v, Vec3<F>, const Rotation<F>& r, Vec3<F> scale) { return safe_normalize_any(r.apply(F(0.25) * finite_or_limit(safe_divide(v, scale)))); }
};
template <class Op>
struct MappingBody {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, Op::eval(k.v(0), k.v(3), Rotation<F>(k.v(6)), k.v(9))); }
};
template <class F>
void mapping(const Call<F>& c) {
    switch (c.statics().e(4)) {
        case 0: return c.template each<MappingBody<MapPoint>>();
        case 1: return c.template each<MappingBody<MapTexture>>();
        case 2: return c.template each<MappingBody<MapVector>>();
        default: return c.template each<MappingBody<MapNormal>>();
    }
}
ALDER_KERNEL(mapping)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(mapping)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeMapping";
    n.category = "Vector";
    n.summary = "moves, turns and scales a vector";
    n.help = "Rotation is in radians, Euler order XYZ. Texture is the inverse of Point; Normal divides by Scale and normalises.";
    n.aliases = {"mapping"};
    n.params.push_back(vector("Vector", 0, 0, 0));
    n.params.push_back(vector("Location", 0, 0, 0));
    n.params.push_back(vector("Rotation", 0, 0, 0).doc("radians"));
    n.params.push_back(vector("Scale", 1, 1, 1));
    n.params.push_back(choice("vector_type",
                              std::vector<Item>{{"POINT", "Point", "point"}, {"TEXTURE", "Texture", "texture"}, {"VECTOR", "Vector", "vector"}, {"NORMAL", "Normal", "normal"}},
                              "POINT").alias("mapping_type"));
    n.outputs = {{"Vector", Type::Vector}};
    n.kernel = mapping_kernel();
    n.cost_ns = 12;
    n.uses = [](const Statics& s, int param) { return param != 1 || s.e(4) <= 1; };
    return n;
}
}  // namespace alder
#endif
