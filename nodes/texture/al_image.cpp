// alImage: an image file at the surface's texture coordinates, with a frame number in its name. alshaders specification, section 5.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/texture/al_image.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/texture/al_texture.h"
#include "nodes/texture/image_lookup-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Channels: frame 0; uv 1.
struct AlImage {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const StoredImage* const image = opened_image(k.statics());
        if (!image || !image->readable()) return k.set(0, Vec3<F>(F(1), F(0), F(0)));
        const F u = k.f(1), v = k.f(2);
        k.set(0, lookup_image(image, select(isfinite(u), u, F(0)), select(isfinite(v), v, F(0)), kInterpolateLinear, kExtendRepeat, false).rgb);
    }
};
template <class F>
void al_image(const Call<F>& c) { c.template each<AlImage>(); }
ALDER_KERNEL(al_image)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(al_image)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alImage";
    n.system = System::AlShaders;
    n.category = "texture";
    n.summary = "an image file, its name with a frame number";
    n.help = "The image at the active UV map, repeated; its alpha is dropped. The first #### of the file name becomes the frame in four digits, padded with "
             "zeros (the original wrote the number unpadded). An image that cannot be read is red.";
    n.params = {image("filename").doc("the file; the first #### in its name stands for the frame"), i("frame", 0).no_link().doc("frame number")};
    n.outputs = {{"out", Type::Color}};
    n.globals = {Global::Uv};
    n.kernel = al_image_kernel();
    n.cost_ns = 30;
    n.foldable = false;
    n.uses = [](const Statics&, int param) { return param == 0; };
    n.prepare = [](const Statics& s, std::vector<std::string>& errors) { return open_al_texture(s, 0, errors); };
    return n;
}
}  // namespace alder
#endif
