// Voronoi Texture in 3 dimensions: the kernel alone; the node is in tex_voronoi.cpp.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/texture/tex_voronoi_3d.cpp"
#include "hwy/foreach_target.h"

#include "nodes/texture/tex_voronoi-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {
template <class F>
void tex_voronoi_3d(const Call<F>& c) { tex_voronoi_dimension<3>(c); }
ALDER_KERNEL(tex_voronoi_3d)
}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(tex_voronoi_3d)
Kernel tex_voronoi_3d() { return tex_voronoi_3d_kernel(); }
}  // namespace alder
#endif
