// Magic Texture: swirling colours from sines of sums of the coordinates, fed back Depth times. Follows Cycles' SVM.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/texture/tex_magic.cpp"
#include "hwy/foreach_target.h"

#include "nodes/texture/texture_mapping-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

namespace tex_magic {
enum Parameter { kMapping, kDepth, kVector, kScale, kDistortion };
enum Channel { kDepthIn = 0, kVectorIn = 1, kScaleIn = 4, kDistortionIn = 5 };
constexpr float kTwoPi = 6.283185307179586f;
}  // namespace tex_magic

struct TexMagic {
    /// The three sines after `depth` rounds: each round replaces one of them by a function of all three.
    template <class F>
    static HWY_INLINE Vec3<F> swirl(Vec3<F> p, F scale, F distortion, int depth) {
        // Whole turns are taken off first: sines of large sums would be noise, and of infinite ones NaN.
        const F turn(tex_magic::kTwoPi);
        const F px = fmod(p.x, turn), py = fmod(p.y, turn), pz = fmod(p.z, turn);
        F x = sin((px + py + pz) * F(5) * scale);
        F y = cos((-px + py - pz) * F(5) * scale);
        F z = -cos((-px - py + pz) * F(5) * scale);
        if (depth > 0) {
            x = x * distortion, y = y * distortion, z = z * distortion;
            y = -cos(x - y + z) * distortion;
        }
        if (depth > 1) x = cos(x - y - z) * distortion;
        if (depth > 2) z = sin(-x - y - z) * distortion;
        if (depth > 3) x = -cos(-x + y - z) * distortion;
        if (depth > 4) y = -sin(-x + y + z) * distortion;
        if (depth > 5) y = -cos(-x + y + z) * distortion;
        if (depth > 6) x = cos(x + y + z) * distortion;
        if (depth > 7) z = sin(x + y - z) * distortion;
        if (depth > 8) x = -cos(-x - y + z) * distortion;
        if (depth > 9) y = -sin(x - y + z) * distortion;
        return {x, y, z};
    }
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        using namespace tex_magic;
        const F distortion = k.f(kDistortionIn);
        const Vec3<F> s = swirl(mapped_vector(k, kVectorIn), k.f(kScaleIn), distortion, k.statics().e(kDepth));
        const F divisor = select(distortion != F(0), distortion * F(2), F(1));
        const Vec3<F> color = Vec3<F>(F(0.5)) - s / divisor;
        k.set(0, color);
        k.set(3, (color.x + color.y + color.z) * F(1.0f / 3.0f));
    }
};
template <class F>
void tex_magic_kernel(const Call<F>& c) { c.template each<TexMagic>(); }
ALDER_KERNEL(tex_magic_kernel)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(tex_magic_kernel)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeTexMagic";
    n.aliases = {"magic_texture"};
    n.system = System::Cycles;
    n.category = "texture";
    n.summary = "swirling colours";
    n.help = "Sines of sums of the coordinates, each fed into the next Depth times. Deep and strongly distorted patterns turn chaotic: "
             "every round multiplies the rounding of the one before.";
    n.params = {
        texture_mapping_param(),
        i("turbulence_depth", 2).limit(0, 10).range(0, 10).no_link().alias("depth").doc("rounds of feedback"),
        vector("Vector", 0, 0, 0).unlinked(Global::Generated).doc("where the pattern is read; unlinked: generated coordinates"),
        f("Scale", 5).range(-1000, 1000).doc("frequency"),
        f("Distortion", 1).range(-1000, 1000).doc("strength of the feedback"),
        color_mapping_param(),
    };
    n.outputs = {{"Color", Type::Color}, {"Fac", Type::Float}};
    n.kernel = tex_magic_kernel_kernel();
    n.cost_ns = 30;
    n.prepare = prepare_texture_mapping;
    return n;
}
}  // namespace alder
#endif
