// Environment Texture: an image of all directions, as longitude and latitude or as photographed in a mirror ball. Follows Cycles' SVM.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/texture/tex_environment.cpp"
#include "hwy/foreach_target.h"

#include "nodes/texture/image_lookup-inl.h"
#include "nodes/texture/prepared_image.h"
#include "nodes/texture/texture_mapping-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

namespace tex_environment {
enum Parameter { kImage, kMapping, kProjection, kInterpolation, kVector };
enum Channel { kVectorIn = 0 };
constexpr float kPi = 3.141592653589793f;
}  // namespace tex_environment

struct TexEnvironment {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        using namespace tex_environment;
        Vec3<F> d = safe_normalize(mapped_vector(k, kVectorIn));
        F u, v;
        if (k.statics().e(kProjection) == 0) {
            // The zero vector has no direction: Cycles looks at (0, 0).
            const F l = length(d);
            const Mask<F> direction = (d.x != F(0)) | (d.y != F(0)) | (d.z != F(0));
            u = select(direction, (atan2(d.y, d.x) - F(kPi)) / F(-2 * kPi), F(0));
            v = select(direction, (acos(d.z / select(direction, l, F(1))) - F(kPi)) / F(-kPi), F(0));
        } else {
            d.y = d.y - F(1);
            const F half = F(2) * sqrt(max(F(-0.5f) * d.y, F(0)));
            const F divisor = select(half > F(0), half, F(1));
            u = F(0.5f) * (d.x / divisor + F(1));
            v = F(0.5f) * (d.z / divisor + F(1));
        }
        const auto* const prepared = static_cast<const PreparedImage*>(k.statics().prepared.get());
        const Rgba<F> r = lookup_image(prepared ? prepared->image.get() : nullptr, u, v, k.statics().e(kInterpolation), kExtendRepeat, false);
        k.set(0, r.rgb);
    }
};
template <class F>
void tex_environment_kernel(const Call<F>& c) { c.template each<TexEnvironment>(); }
ALDER_KERNEL(tex_environment_kernel)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(tex_environment_kernel)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeTexEnvironment";
    n.aliases = {"environment_texture"};
    n.system = System::Cycles;
    n.category = "texture";
    n.summary = "an image of the surroundings, by direction";
    n.help = "Equirectangular: longitude across, latitude upwards, +X in the middle of the image. "
             "Mirror ball: the sphere as a camera that looks along +Y sees it. An image that is missing is magenta.";
    n.params = {
        image("image").alias("filename").doc("the file: {\"file\" or \"asset\", \"colorspace\", \"alpha_mode\"}"),
        texture_mapping_param(),
        choice("projection", {{"EQUIRECTANGULAR", "Equirectangular", "equirectangular"}, {"MIRROR_BALL", "Mirror Ball", "mirror_ball"}},
               "EQUIRECTANGULAR").doc("how the image holds the directions"),
        choice("interpolation",
               {{"Linear", "Linear", "linear"}, {"Closest", "Closest", "closest"}, {"Cubic", "Cubic", "cubic"}, {"Smart", "Smart", "smart"}}, "Linear")
            .doc("between texels; Smart is Cubic"),
        vector("Vector", 0, 0, 0).unlinked(Global::P).doc("the direction looked up; unlinked: the position, in a world the ray's direction"),
        color_mapping_param(), image_user_param(),
    };
    n.outputs = {{"Color", Type::Color}};
    n.kernel = tex_environment_kernel_kernel();
    n.cost_ns = 40;
    n.prepare = prepare_image_texture;
    return n;
}
}  // namespace alder
#endif
