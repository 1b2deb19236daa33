// Gradient Texture: a ramp from 0 to 1 along an axis, a diagonal, around an axis or out of a sphere. Follows Cycles' SVM.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/texture/tex_gradient.cpp"
#include "hwy/foreach_target.h"

#include "nodes/texture/texture_mapping-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

namespace tex_gradient {
enum Parameter { kMapping, kType, kVector };
enum Type { kLinear, kQuadratic, kEasing, kDiagonal, kSpherical, kQuadraticSphere, kRadial };
constexpr float kTwoPi = 6.283185307179586f;
}  // namespace tex_gradient

struct TexGradient {
    template <class F>
    static HWY_INLINE F value(int type, Vec3<F> p) {
        using namespace tex_gradient;
        switch (type) {
            case kLinear: return p.x;
            case kQuadratic: return sqr(max(F(0), p.x));
            case kEasing: {
                const F r = min(max(F(0), p.x), F(1)), t = r * r;
                return F(3) * t - F(2) * t * r;
            }
            case kDiagonal: return (p.x + p.y) * F(0.5);
            case kRadial: return atan2(p.y, p.x) / F(kTwoPi) + F(0.5);
            default: {
                // A little less than 1, so that points of the unit sphere give 0 and not the rounding of their length.
                const F r = max(F(0), F(0.999999f) - length(p));
                return type == kQuadraticSphere ? r * r : r;
            }
        }
    }
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F v = value(k.statics().e(tex_gradient::kType), mapped_vector(k, 0));
        const F fac = min(max(F(0), v), F(1));  // NaN gives 0
        k.set(0, Vec3<F>(fac));
        k.set(3, fac);
    }
};
template <class F>
void tex_gradient_kernel(const Call<F>& c) { c.template each<TexGradient>(); }
ALDER_KERNEL(tex_gradient_kernel)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(tex_gradient_kernel)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeTexGradient";
    n.aliases = {"gradient_texture"};
    n.system = System::Cycles;
    n.category = "texture";
    n.summary = "a ramp from 0 to 1";
    n.help = "Linear, Quadratic and Easing run along x, Diagonal along x + y, Radial around z, the spheres fall from 1 in the middle to 0 at distance 1.";
    n.params = {
        texture_mapping_param(),
        choice("gradient_type",
               {{"LINEAR", "Linear", "linear"}, {"QUADRATIC", "Quadratic", "quadratic"}, {"EASING", "Easing", "easing"},
                {"DIAGONAL", "Diagonal", "diagonal"}, {"SPHERICAL", "Spherical", "spherical"},
                {"QUADRATIC_SPHERE", "Quadratic Sphere", "quadratic_sphere"}, {"RADIAL", "Radial", "radial"}},
               "LINEAR").doc("shape of the ramp"),
        vector("Vector", 0, 0, 0).unlinked(Global::Generated).doc("where the ramp is read; unlinked: generated coordinates"),
        color_mapping_param(),
    };
    n.outputs = {{"Color", Type::Color}, {"Fac", Type::Float}};
    n.kernel = tex_gradient_kernel_kernel();
    n.cost_ns = 2;
    n.prepare = prepare_texture_mapping;
    return n;
}
}  // namespace alder
#endif
