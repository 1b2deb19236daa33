// alFlake: normals of small flakes, one to a cell of cellular noise, tilted at random. alshaders specification, section 4.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/noise/al_flake.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/noise/cellular-inl.h"
#include "nodes/noise/flake-inl.h"

#ifndef ALDER_NODES_NOISE_AL_FLAKE_
#define ALDER_NODES_NOISE_AL_FLAKE_
namespace alder {
enum AlFlakeParam { kAmount, kSize, kDivergence, kP, kSpace };
}  // namespace alder
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Channels: amount 0, size 1, divergence 2, P 3; globals Nf 6, dPdu 9.
template <bool world>
struct AlFlake {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F size = k.f(1);
        const Mask<F> sized = size != F(0);
        const Int<F> id = cellular<1>(k.v(3) / select(sized, size, F(1)), F(1)).id[0];
        const Vec3<F> r = flake_normal(id, select(sized, k.f(0), F(0)), k.f(2));
        k.set(0, world ? to_shading_frame(r, k.v(6), k.v(9)) : r * F(0.5) + Vec3<F>(F(0.5)));
    }
};
template <class F>
void al_flake(const Call<F>& c) {
    if (c.statics().e(kSpace) == 1) return c.template each<AlFlake<true>>();
    c.template each<AlFlake<false>>();
}
ALDER_KERNEL(al_flake)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(al_flake)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alFlake";
    n.system = System::AlShaders;
    n.category = "pattern";
    n.summary = "normals of random flakes, for metallic paint";
    n.help = "Each cell of cellular noise has a flake or not and tilts it at random. tangent: the normal in the tangent frame, moved from -1 ... 1 to "
             "0 ... 1; world: in world space. Tilted normals are not of unit length, as in the original: who uses them normalises. "
             "Size 0 gives no flakes, where the original divided by zero. The places and shapes of the cells are ours: Arnold's cellular "
             "noise is not public; what follows from a cell's number is the original's.";
    n.params = {f("amount", 0.7).range(0, 1).doc("share of the cells that hold a flake"),
                f("size", 0.01).range(0, 1).doc("edge of a cell"),
                f("divergence", 0.5).range(0, 1).doc("how far flakes tilt"),
                vector("P", 0, 0, 0).unlinked(Global::P).doc("point to evaluate at; unlinked: the world position"),
                choice("space", {"tangent", "world"}, "tangent").doc("frame of the result")};
    n.outputs = {{"out", Type::Vector}};
    n.globals = {Global::Nf, Global::Dpdu};
    n.kernel = al_flake_kernel();
    n.cost_ns = 80;
    n.uses_global = [](const Statics& s, int) { return s.e(kSpace) == 1; };
    return n;
}
}  // namespace alder
#endif
