// Wireframe: 1 near the edges of the triangles, else 0 (Blender's node).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/input/wireframe.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Size 0, distance to the nearest edge 1; 0 there means that no edges are known. Each face draws half of the line.
template <bool pixels>
struct Wireframe {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        F width = k.f(0);
        if constexpr (pixels) {
            // A pixel on the surface, seen from the viewer: the steps without their part along the view. I 2, dPdx 5, dPdy 8.
            const Vec3<F> view = k.v(2), dx = k.v(5), dy = k.v(8);
            width = width * (length(dx - dot(dx, view) * view) + length(dy - dot(dy, view) * view)) * F(0.5);
        }
        const F distance = k.f(1);
        k.set(0, select((distance > F(0)) & (distance < abs(width) * F(0.5)), F(1), F(0)));
    }
};
template <class F>
void wireframe(const Call<F>& c) { c.template each<Wireframe<false>>(); }
template <class F>
void wireframe_pixels(const Call<F>& c) { c.template each<Wireframe<true>>(); }
ALDER_KERNEL(wireframe)
ALDER_KERNEL(wireframe_pixels)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "graph/lowering.h"

namespace alder {
ALDER_KERNEL_EXPORT(wireframe)
ALDER_KERNEL_EXPORT(wireframe_pixels)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeWireframe";
    n.category = "Input";
    n.summary = "1 near the edges of the triangles, else 0";
    n.aliases = {"wireframe"};
    n.params.push_back(f("Size", 0.01).range(0, 100).doc("width of the lines in scene units or pixels"));
    n.params.push_back(b("use_pixel_size", false).no_link());
    n.outputs = {{"Fac", Type::Float}};
    n.lower = [](Lowering& l, int) {
        std::vector<ValueRef> operands{l.input(0), l.global(Global::EdgeDistance)};
        if (!l.statics().e(1)) return l.result(l.op("wireframe", wireframe_kernel(), operands, Type::Float));
        for (Global g : {Global::I, Global::Dpdx, Global::Dpdy}) operands.push_back(l.global(g));
        l.result(l.op("wireframe_pixels", wireframe_pixels_kernel(), operands, Type::Float));
    };
    return n;
}
}  // namespace alder
#endif
