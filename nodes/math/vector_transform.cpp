// Vector Transform: a point, direction or normal from world, object or camera space to another (Blender's node).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/math/vector_transform.cpp"
#include "hwy/foreach_target.h"

#include "nodes/input/space-inl.h"
#include "nodes/math/finite-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

// Steps: vector 0, columns of a matrix 3 ... 11, its translation 12. Normals take the matrix of the opposite step, transposed.
struct StepPoint {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, matrix3(k, 3).apply(k.v(0)) + k.v(12)); }
};
struct StepDirection {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, matrix3(k, 3).apply(k.v(0))); }
};
struct StepNormal {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, normalize_any(matrix3(k, 3).transposed(k.v(0)))); }
};
struct StepNormalSafe {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, safe_normalize_any(matrix3(k, 3).transposed(k.v(0)))); }
};
// The same through the inverse of the matrix.
struct BackPoint {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, finite_or_limit(matrix3(k, 3).inverse().apply(k.v(0) - k.v(12)))); }
};
struct BackDirection {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, finite_or_limit(matrix3(k, 3).inverse().apply(k.v(0)))); }
};
struct BackNormal {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, normalize_any(finite_or_limit(matrix3(k, 3).inverse().transposed(k.v(0))))); }
};
#define ALDER_STEP(name, Body)                                \
    template <class F>                                        \
    void name(const Call<F>& c) { c.template each<Body>(); }  \
    ALDER_KERNEL(name)
ALDER_STEP(step_point, StepPoint)
ALDER_STEP(step_direction, StepDirection)
ALDER_STEP(step_normal, StepNormal)
ALDER_STEP(step_normal_safe, StepNormalSafe)
ALDER_STEP(back_point, BackPoint)
ALDER_STEP(back_direction, BackDirection)
ALDER_STEP(back_normal, BackNormal)
#undef ALDER_STEP

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "graph/lowering.h"

namespace alder {
ALDER_KERNEL_EXPORT(step_point)
ALDER_KERNEL_EXPORT(step_direction)
ALDER_KERNEL_EXPORT(step_normal)
ALDER_KERNEL_EXPORT(step_normal_safe)
ALDER_KERNEL_EXPORT(back_point)
ALDER_KERNEL_EXPORT(back_direction)
ALDER_KERNEL_EXPORT(back_normal)

enum { kVector, kVectorType, kFrom, kTo };
enum { kPoint, kDirection, kNormal };
enum { kWorld, kObject, kCamera };

static ValueRef step(Lowering& l, const char* name, const Kernel& kernel, ValueRef v, Global first_column, bool with_translation) {
    std::vector<ValueRef> operands{v};
    for (int i = 0; i < (with_translation ? 4 : 3); ++i) operands.push_back(l.global(static_cast<Global>(static_cast<int>(first_column) + i)));
    return l.op(name, kernel, operands, Type::Vector);
}
static ValueRef world_to_object(Lowering& l, int type, ValueRef v) {
    if (type == kPoint) return step(l, "step_point", step_point_kernel(), v, Global::WorldToObjectX, true);
    if (type == kDirection) return step(l, "step_direction", step_direction_kernel(), v, Global::WorldToObjectX, false);
    return step(l, "step_normal_safe", step_normal_safe_kernel(), v, Global::ObjectToWorldX, false);
}
static ValueRef object_to_world(Lowering& l, int type, ValueRef v) {
    if (type == kPoint) return step(l, "step_point", step_point_kernel(), v, Global::ObjectToWorldX, true);
    if (type == kDirection) return step(l, "step_direction", step_direction_kernel(), v, Global::ObjectToWorldX, false);
    return step(l, "step_normal", step_normal_kernel(), v, Global::WorldToObjectX, false);
}
static ValueRef world_to_camera(Lowering& l, int type, ValueRef v) {
    if (type == kPoint) return step(l, "step_point", step_point_kernel(), v, Global::WorldToCameraX, true);
    if (type == kDirection) return step(l, "step_direction", step_direction_kernel(), v, Global::WorldToCameraX, false);
    return step(l, "back_normal", back_normal_kernel(), v, Global::WorldToCameraX, false);
}
static ValueRef camera_to_world(Lowering& l, int type, ValueRef v) {
    if (type == kPoint) return step(l, "back_point", back_point_kernel(), v, Global::WorldToCameraX, true);
    if (type == kDirection) return step(l, "back_direction", back_direction_kernel(), v, Global::WorldToCameraX, false);
    return step(l, "step_normal", step_normal_kernel(), v, Global::WorldToCameraX, false);
}

static void lower_vector_transform(Lowering& l, int) {
    const Statics& s = l.statics();
    const int type = s.e(kVectorType), from = s.e(kFrom), to = s.e(kTo);
    ValueRef v = l.input(kVector);
    if (from == to) return l.result(v);  // not even normals are normalised
    if (from == kObject) v = object_to_world(l, type, v);
    if (from == kCamera) v = camera_to_world(l, type, v);
    if (to == kObject) v = world_to_object(l, type, v);
    if (to == kCamera) v = world_to_camera(l, type, v);
    l.result(v);
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeVectorTransform";
    n.category = "Vector";
    n.summary = "a point, direction or normal from one space to another";
    n.help = "Camera space has depth positive. Normals are normalised where the spaces differ.";
    n.aliases = {"vector_transform"};
    const std::vector<Item> spaces{{"WORLD", "World", "world"}, {"OBJECT", "Object", "object"}, {"CAMERA", "Camera", "camera"}};
    n.params.push_back(vector("Vector", 0.5, 0.5, 0.5).range(-10000, 10000));
    n.params.push_back(choice("vector_type", std::vector<Item>{{"POINT", "Point", "point"}, {"VECTOR", "Vector", "vector"}, {"NORMAL", "Normal", "normal"}}, "VECTOR").alias("transform_type"));
    n.params.push_back(choice("convert_from", spaces, "WORLD"));
    n.params.push_back(choice("convert_to", spaces, "OBJECT"));
    n.outputs = {{"Vector", Type::Vector}};
    n.cost_ns = 3;
    n.lower = lower_vector_transform;
    return n;
}
}  // namespace alder
#endif
