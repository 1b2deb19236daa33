// Camera Data: the shading point seen from the camera, its depth and distance (Blender's node).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/input/camera_data.cpp"
#include "hwy/foreach_target.h"

#include "nodes/input/space-inl.h"
#include "nodes/math/finite-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Channels: P 0, columns of world to camera 3 ... 11, translation 12.
struct CameraData {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> v = matrix3(k, 3).apply(k.v(0)) + k.v(12);
        k.set(0, normalize_any(v));
        k.set(3, v.z);
        k.set(4, length_of_any(v));
    }
};
template <class F>
void camera_data(const Call<F>& c) { c.template each<CameraData>(); }
ALDER_KERNEL(camera_data)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(camera_data)

ALDER_NODE {
    NodeType n;
    n.name = "ShaderNodeCameraData";
    n.category = "Input";
    n.summary = "direction, depth and distance of the shading point from the camera";
    n.help = "In camera space, depth positive.";
    n.aliases = {"camera_info"};
    n.outputs = {{"View Vector", Type::Vector}, {"View Z Depth", Type::Float}, {"View Distance", Type::Float}};
    n.globals = {Global::P, Global::WorldToCameraX, Global::WorldToCameraY, Global::WorldToCameraZ, Global::WorldToCameraT};
    n.kernel = camera_data_kernel();
    n.cost_ns = 3;
    return n;
}
}  // namespace alder
#endif
