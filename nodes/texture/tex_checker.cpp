// Checker Texture: two colours in alternating cubes of side 1/Scale.
// Follows Cycles in pulling the coordinates a hair towards zero, so that faces that lie on a cube's side do not flicker.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/texture/tex_checker.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/texture/texture_mapping-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct TexChecker {
    /// Parity of the cell that holds x: 0 or 1, for any x (a large float is an even integer).
    template <class F>
    static HWY_INLINE F parity(F x) {
        const F cell = floor((x + F(0.000001f)) * F(0.999999f));
        return cell - F(2) * floor(cell * F(0.5));
    }
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> p = mapped_vector(k, 0) * k.f(9);
        const F x = parity(p.x), y = parity(p.y), z = parity(p.z);
        const Mask<F> first = ((x == y) & (z == F(1))) | ((x != y) & (z == F(0)));
        k.set(0, select(first, k.v(3), k.v(6)));
        k.set(3, select(first, F(1), F(0)));
    }
};
template <class F>
void tex_checker(const Call<F>& c) { c.template each<TexChecker>(); }
ALDER_KERNEL(tex_checker)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(tex_checker)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeTexChecker";
    n.aliases = {"checker_texture"};
    n.system = System::Cycles;
    n.category = "texture";
    n.summary = "two colours in alternating cubes";
    n.params = {
        texture_mapping_param(),
        vector("Vector", 0, 0, 0).unlinked(Global::Generated).doc("where the pattern is read"),
        color("Color1", 0.8, 0.8, 0.8).doc("first colour"),
        color("Color2", 0.2, 0.2, 0.2).doc("second colour"),
        f("Scale", 5).range(-1000, 1000).doc("cubes per unit"),
        color_mapping_param(),
    };
    n.outputs = {{"Color", Type::Color}, {"Fac", Type::Float}};
    n.kernel = tex_checker_kernel();
    n.cost_ns = 1;
    n.prepare = prepare_texture_mapping;
    return n;
}
}  // namespace alder
#endif
