// Voronoi Texture in 4 dimensions: the kernel alone; the node is in tex_voronoi.cpp.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/texture/tex_voronoi_4d.cpp"
#include "hwy/foreach_target.h"

#include "nodes/texture/tex_voronoi-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {
template <class F>
void tex_voronoi_4d(const Call<F>& c) { tex_voronoi_dimension<4>(c); }
ALDER_KERNEL(tex_voronoi_4d)
}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(tex_voronoi_4d)
Kernel tex_voronoi_4d() { return tex_voronoi_4d_kernel(); }
}  // namespace alder
#endif
