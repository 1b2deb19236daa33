// Image Texture: an image file at texture coordinates, laid flat, on a sphere, a tube, or projected from the sides of a box.
// Follows Cycles' SVM.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/texture/tex_image.cpp"
#include "hwy/foreach_target.h"

#include "nodes/texture/image_lookup-inl.h"
#include "nodes/texture/prepared_image.h"
#include "nodes/texture/texture_mapping-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

namespace tex_image {
enum Parameter { kImage, kMapping, kProjection, kInterpolation, kBlend, kExtension, kVector };
enum Projection { kFlat, kBox, kSphere, kTube };
// The last three are used where textures are filtered: Vector at the next pixels in x and y, and 1.
enum Channel { kBlendIn = 0, kVectorIn = 1, kNormalIn = 4, kObjectXIn = 7, kObjectYIn = 10, kObjectZIn = 13, kVectorXIn = 16, kVectorYIn = 19, kFilterIn = 22 };
enum Out { kColorOut = 0, kAlphaOut = 3 };
constexpr int kFilterGlobal = 4;  ///< the first of the globals in whose place the filter's values come
constexpr float kPi = 3.141592653589793f;

template <class F>
struct Uv {
    F u, v;
    HWY_INLINE Uv(F x, F y) : u(x), v(y) {}
};
/// Longitude and latitude of a point about the middle of the unit cube.
template <class F>
HWY_INLINE Uv<F> on_sphere(Vec3<F> p) {
    const F squared = dot(p, p);
    const Mask<F> somewhere = squared > F(0);
    const F longitude = F(0.5f) - atan2(p.x, p.y) * F(0.5f / kPi);
    const F cosine = p.z / sqrt(select(somewhere, squared, F(1)));
    const F latitude = F(1) - acos(clamp(cosine, F(-1), F(1))) * F(1.0f / kPi);
    const Mask<F> on_axis = (p.x == F(0)) & (p.y == F(0));
    return {select(somewhere & (!on_axis), longitude, F(0)), select(somewhere, latitude, F(0))};
}
template <class F>
HWY_INLINE Uv<F> on_tube(Vec3<F> p) {
    const F radius = sqrt(p.x * p.x + p.y * p.y);
    const Mask<F> off_axis = radius > F(0);
    const F r = select(off_axis, radius, F(1));
    return {select(off_axis, (F(1) - atan2(p.x / r, p.y / r) / F(kPi)) * F(0.5f), F(0)), select(off_axis, (p.z + F(1)) * F(0.5f), F(0))};
}

/// How much of each side of the box a normal (object space) sees. The absolute normal, its components summing to 1, is a point in a
/// triangle: near a corner one side shows, near an edge two are blended, in the middle three.
template <class F>
HWY_INLINE Vec3<F> box_weights(Vec3<F> n, F blend) {
    n = {abs(n.x), abs(n.y), abs(n.z)};
    const F sum = n.x + n.y + n.z;
    n = n / sum;
    const F zero(0), one(1), limit = F(0.5f) * (one + blend), edge = one - limit;
    const F xy = n.x + n.y, yz = n.y + n.z, xz = n.x + n.z;
    const Mask<F> x_only = (n.x > limit * xy) & (n.x > limit * xz);
    const Mask<F> y_only = (n.y > limit * xy) & (n.y > limit * yz);
    const Mask<F> z_only = (n.z > limit * xz) & (n.z > limit * yz);
    const Mask<F> blends = blend > zero;
    const F width = select(blends, blend, one), start = F(0.5f) * (one - blend);
    const F x_of_xy = saturate((n.x / xy - start) / width), y_of_yz = saturate((n.y / yz - start) / width),
            x_of_xz = saturate((n.x / xz - start) / width);
    const F a = F(2) - limit, b = limit - one, c = select(blends, F(2) * limit - one, one);
    Vec3<F> w = select<F>(blends, {(a * n.x + b) / c, (a * n.y + b) / c, (a * n.z + b) / c}, {one, zero, zero});
    w = select<F>(blends & (n.y < edge * xz), {x_of_xz, zero, one - x_of_xz}, w);
    w = select<F>(blends & (n.x < edge * yz), {zero, y_of_yz, one - y_of_yz}, w);
    w = select<F>(blends & (n.z < edge * xy), {x_of_xy, one - x_of_xy, zero}, w);
    w = select<F>(z_only, {zero, zero, one}, w);
    w = select<F>(y_only, {zero, one, zero}, w);
    return select<F>(x_only, {one, zero, zero}, w);
}
}  // namespace tex_image

template <bool kFiltered>
struct TexImage {
    template <class F>
    static HWY_INLINE Rgba<F> at(const Lanes<F>& k, F u, F v, const UvSteps<F>& steps) {
        using namespace tex_image;
        const auto* const prepared = static_cast<const PreparedImage*>(k.statics().prepared.get());
        const StoredImage* const image = prepared ? prepared->image.get() : nullptr;
        const int interpolation = k.statics().e(kInterpolation), extension = k.statics().e(kExtension);
        // As in Cycles, colour stays multiplied by alpha unless Alpha is used as well.
        if constexpr (kFiltered) return lookup_image_filtered(image, u, v, steps, interpolation, extension, k.wants(kAlphaOut));
        else return lookup_image(image, u, v, interpolation, extension, k.wants(kAlphaOut));
    }
    template <class F>
    static HWY_INLINE tex_image::Uv<F> projected(const Lanes<F>& k, int channel) {
        using namespace tex_image;
        const Vec3<F> p = mapped_vector(k, channel);
        const int projection = k.statics().e(kProjection);
        if (projection != kSphere && projection != kTube) return {p.x, p.y};
        const Vec3<F> centred = (p - Vec3<F>(F(0.5f))) * F(2);
        return projection == kSphere ? on_sphere(centred) : on_tube(centred);
    }
    /// The way from a to b around a cylinder's seam.
    template <class F>
    static HWY_INLINE F step(F a, F b, bool closed) {
        const F d = b - a;
        return closed ? d - floor(d + F(0.5f)) : d;
    }
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        using namespace tex_image;
        const Uv<F> uv = projected(k, kVectorIn);
        UvSteps<F> steps;
        if constexpr (kFiltered) {
            const Uv<F> x = projected(k, kVectorXIn), y = projected(k, kVectorYIn);
            const bool closed = k.statics().e(kProjection) != kFlat;
            steps.dudx = step(uv.u, x.u, closed), steps.dvdx = x.v - uv.v;
            steps.dudy = step(uv.u, y.u, closed), steps.dvdy = y.v - uv.v;
        }
        const Rgba<F> r = at(k, uv.u, uv.v, steps);
        k.set(kColorOut, r.rgb);
        k.set(kAlphaOut, r.a);
    }
};
template <bool kFiltered>
struct TexImageBox {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        using namespace tex_image;
        const Vec3<F> p = mapped_vector(k, kVectorIn), normal = k.v(kNormalIn);
        // To object space: with the transposed matrix, as normals go.
        const Vec3<F> n = safe_normalize(Vec3<F>(dot(k.v(kObjectXIn), normal), dot(k.v(kObjectYIn), normal), dot(k.v(kObjectZIn), normal)));
        const Vec3<F> weight = box_weights(n, k.f(kBlendIn));
        // Turned so that no side shows the image mirrored.
        const F us[3] = {select(n.x < F(0), F(1) - p.y, p.y), select(n.y > F(0), F(1) - p.x, p.x), select(n.z > F(0), F(1) - p.y, p.y)};
        const F vs[3] = {p.z, p.z, p.x};
        Vec3<F> dx, dy;
        if constexpr (kFiltered) dx = mapped_vector(k, kVectorXIn) - p, dy = mapped_vector(k, kVectorYIn) - p;
        Rgba<F> sum(Vec3<F>(F(0)), F(0));
        for (int side = 0; side < 3; ++side) {
            const Mask<F> seen = weight[side] > F(0);
            if (!any(seen)) continue;
            UvSteps<F> steps;  // their length counts, not their sign
            if constexpr (kFiltered) {
                steps.dudx = side == 1 ? dx.x : dx.y, steps.dudy = side == 1 ? dy.x : dy.y;
                steps.dvdx = side == 2 ? dx.x : dx.z, steps.dvdy = side == 2 ? dy.x : dy.z;
            }
            const Rgba<F> r = TexImage<kFiltered>::at(k, us[side], vs[side], steps);
            sum.rgb = select<F>(seen, sum.rgb + r.rgb * weight[side], sum.rgb);
            sum.a = select(seen, sum.a + r.a * weight[side], sum.a);
        }
        k.set(kColorOut, sum.rgb);
        k.set(kAlphaOut, sum.a);
    }
};
template <bool kFiltered, class F>
HWY_INLINE void tex_image_projected(const Call<F>& c) {
    if (c.statics().e(tex_image::kProjection) == tex_image::kBox) return c.template each<TexImageBox<kFiltered>>();
    return c.template each<TexImage<kFiltered>>();
}
template <class F>
void tex_image_kernel(const Call<F>& c) {
    if (c.call.in[tex_image::kFilterIn].p[0] != 0) return tex_image_projected<true>(c);
    return tex_image_projected<false>(c);
}
ALDER_KERNEL(tex_image_kernel)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "graph/lowering.h"

namespace alder {
ALDER_KERNEL_EXPORT(tex_image_kernel)

/// With a filter: Vector is evaluated at the next pixels as well, through whatever graph it comes from.
static void lower_tex_image(Lowering& l, int output) {
    namespace p = HWY_NAMESPACE::tex_image;
    if (!l.filters_textures() || l.statics().e(p::kInterpolation) == HWY_NAMESPACE::kInterpolateClosest) return;
    const ValueRef one = l.constant(Type::Float, 1), none = l.constant(Type::Vector, 0);
    const bool box = l.statics().e(p::kProjection) == p::kBox;
    std::vector<ValueRef> globals;
    for (const Global g : {Global::N, Global::ObjectToWorldX, Global::ObjectToWorldY, Global::ObjectToWorldZ}) globals.push_back(box ? l.global(g) : none);
    globals.insert(globals.end(), {l.displaced_input(p::kVector, 1, one), l.displaced_input(p::kVector, 2, one), one});
    const ValueRef params[] = {l.input(p::kBlend), l.input(p::kVector)};
    l.result(l.call(params, globals, output));
}

ALDER_NODE {
    using namespace param;
    namespace p = HWY_NAMESPACE::tex_image;
    NodeType n;
    n.name = "ShaderNodeTexImage";
    n.aliases = {"image_texture"};
    n.system = System::Cycles;
    n.category = "texture";
    n.summary = "an image file";
    n.help = "The image at the coordinates x, y of Vector (0 to 1 is the whole image, upwards), or laid on a sphere, a tube or the sides of a box. "
             "Where Alpha is used, colours of STRAIGHT and PREMUL images are given without it; where it is not, multiplied by it. "
             "An image that is missing is magenta.";
    n.params = {
        image("image").alias("filename").doc("the file: {\"file\" or \"asset\", \"colorspace\": sRGB, Non-Color, Linear Rec.709, ..., "
                                             "\"alpha_mode\": STRAIGHT, PREMUL, CHANNEL_PACKED, NONE}"),
        texture_mapping_param(),
        choice("projection", {{"FLAT", "Flat", "flat"}, {"BOX", "Box", "box"}, {"SPHERE", "Sphere", "sphere"}, {"TUBE", "Tube", "tube"}}, "FLAT")
            .doc("how coordinates become places in the image"),
        choice("interpolation",
               {{"Linear", "Linear", "linear"}, {"Closest", "Closest", "closest"}, {"Cubic", "Cubic", "cubic"}, {"Smart", "Smart", "smart"}}, "Linear")
            .doc("between texels; Smart is Cubic"),
        f("projection_blend", 0).range(0, 1).no_link().doc("Box: how far the sides run into each other"),
        choice("extension",
               {{"REPEAT", "Repeat", "periodic"}, {"EXTEND", "Extend", "clamp"}, {"CLIP", "Clip", "black"}, {"MIRROR", "Mirror", "mirror"}}, "REPEAT")
            .doc("outside the image: again, its border, transparent black, mirrored"),
        vector("Vector", 0, 0, 0).unlinked(Global::Uv).doc("where the image is read; unlinked: the active UV map"),
        color_mapping_param(), image_user_param(),
    };
    n.outputs = {{"Color", Type::Color}, {"Alpha", Type::Float}};
    n.globals = {Global::N, Global::ObjectToWorldX, Global::ObjectToWorldY, Global::ObjectToWorldZ, Global::Dpdx, Global::Dpdy, Global::PixelFootprint};
    n.lower = lower_tex_image;
    n.kernel = tex_image_kernel_kernel();
    n.cost_ns = 30;
    n.uses = [](const Statics& s, int param) { return param != p::kBlend || s.e(p::kProjection) == p::kBox; };
    n.uses_global = [](const Statics& s, int i) { return i < p::kFilterGlobal && s.e(p::kProjection) == p::kBox; };
    n.prepare = prepare_image_texture;
    return n;
}
}  // namespace alder
#endif
