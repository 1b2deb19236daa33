// alTriplanar: an image projected along the three axes, blended by the normal, in a regular tiling or scattered over cells.
// alshaders specification, section 5.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/texture/al_triplanar.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/texture/al_texture.h"
#include "nodes/texture/triplanar-inl.h"

#ifndef ALDER_NODES_TEXTURE_AL_TRIPLANAR_
#define ALDER_NODES_TEXTURE_AL_TRIPLANAR_
namespace alder::al_triplanar {
enum Parameter {
    kInput, kSpace, kNormal, kTiling, kFrequency, kTexture, kBlendSoftness, kCellSoftness, kScaleX, kOffsetX = kScaleX + 3, kRotX = kOffsetX + 3,
    kRotJitterX = kRotX + 3, kMipMapBias = kRotJitterX + 3
};
enum Space { kWorld, kObject, kPref };
}  // namespace alder::al_triplanar
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// The image read as projections ask for it. Places that are not finite count as 0. With a bias, from the mip level of the pixel's
/// footprint and as many levels above or below; without one at full resolution, filtered by the samples of a pixel.
template <class F>
struct TriplanarRead {
    const StoredImage* image;
    F bias;
    HWY_INLINE Rgba<F> operator()(const Projected<F>& at) const {
        const F u = select(isfinite(at.u), at.u, F(0)), v = select(isfinite(at.v), at.v, F(0));
        if (!any(bias != F(0))) return lookup_image(image, u, v, kInterpolateLinear, kExtendRepeat, true);
        const F size = exp2(clamp(bias, F(-30), F(30)));
        UvSteps<F> steps;
        steps.dudx = at.dudx * size, steps.dvdx = at.dvdx * size, steps.dudy = at.dudy * size, steps.dvdy = at.dvdy * size;
        return lookup_image_filtered(image, u, v, steps, kInterpolateLinear, kExtendRepeat, true);
    }
};
template <int kCells>
struct TriplanarCells {
    template <class F>
    HWY_INLINE Cellular<kCells, F> operator()(F u, F v) const { return cellular<kCells>(Vec3<F>(u, v, F(0)), F(1)); }
};

/// Channels: input 0, frequency 3, blendSoftness 4, cellSoftness 5, scale 6, offset 9, rot 12, rotjitter 15, mipMapBias 18; from
/// lower_triplanar P 19, N 22, dPdx 25, dPdy 28 and, in Pref, its steps 31, 34 and whether it is there 37.
struct AlTriplanar {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        using namespace al_triplanar;
        Vec3<F> n = k.v(22), dpdx = k.v(25), dpdy = k.v(28);
        if (k.statics().e(kSpace) == kPref) {
            const Mask<F> there = k.f(37) > F(0);
            const Vec3<F> across = cross(k.v(31), k.v(34));
            const F size = length(across);
            n = select<F>(there & (size > F(0)), across / select(size > F(0), size, F(1)), n);
            dpdx = select<F>(there, k.v(31), dpdx), dpdy = select<F>(there, k.v(34), dpdy);
        }
        const F frequency = k.f(3), one(1);
        Triplanar<F> t;
        t.p = k.v(19) * frequency;
        t.dpdx = dpdx * frequency, t.dpdy = dpdy * frequency;
        t.scale = {one / k.f(6), one / k.f(7), one / k.f(8)};
        t.offset = k.v(9), t.degrees = k.v(12), t.jitter = k.v(15);
        t.cell_softness = saturate(k.f(5));
        const Vec3<F> weight = triplanar_weights(n, k.f(4));
        const StoredImage* const image = opened_image(k.statics());
        Rgba<F> r;
        if (!image || !image->readable()) {
            const Mask<F> looked = weight.x + weight.y + weight.z > F(0);
            r = {{select(looked, one, F(0)), F(0), F(0)}, select(looked, one, F(0))};   // opaque red, as in the original
        } else if (k.statics().e(kTiling) == 0) {
            r = triplanar_regular(t, weight, TriplanarRead<F>{image, k.f(18)});
        } else {
            const Mask<F> soft = t.cell_softness > F(0);
            if (any(soft)) r = triplanar_cells<3>(t, weight, TriplanarCells<3>(), TriplanarRead<F>{image, k.f(18)});
            if (!all(soft)) {
                const Rgba<F> hard = triplanar_cells<1>(t, weight, TriplanarCells<1>(), TriplanarRead<F>{image, k.f(18)});
                if (any(soft)) r = {select<F>(soft, r.rgb, hard.rgb), select(soft, r.a, hard.a)};
                else r = hard;
            }
        }
        k.set(0, lerp(k.v(0), r.rgb, r.a));
    }
};
template <class F>
void al_triplanar_kernel(const Call<F>& c) { c.template each<AlTriplanar>(); }
ALDER_KERNEL(al_triplanar_kernel)

/// A normal to object space: with the transposed matrix. Of unit length.
struct NormalToObject {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> n = k.v(0);
        k.set(0, safe_normalize(Vec3<F>(dot(k.v(3), n), dot(k.v(6), n), dot(k.v(9), n))));
    }
};
template <class F>
void normal_to_object(const Call<F>& c) { c.template each<NormalToObject>(); }
ALDER_KERNEL(normal_to_object)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "graph/lowering.h"

namespace alder {
ALDER_KERNEL_EXPORT(al_triplanar_kernel)
ALDER_KERNEL_EXPORT(normal_to_object)

static void lower_triplanar(Lowering& l, int) {
    using namespace al_triplanar;
    const Statics& s = l.statics();
    std::vector<ValueRef> operands;
    for (int i = 0; i < static_cast<int>(s.type->params.size()); ++i) {
        const Type type = s.type->params[i].type;
        if (channels(type) > 0) operands.push_back(s.type->uses(s, i) ? l.input(i) : l.constant(type, 0));
    }
    constexpr Global kNormals[] = {Global::Ngu, Global::Nu, Global::Ns};
    const ValueRef normal = l.global(kNormals[s.e(kNormal)]);
    const int space = s.e(kSpace);
    if (space == kWorld) {
        operands.insert(operands.end(), {l.global(Global::P), normal, l.global(Global::Dpdx), l.global(Global::Dpdy)});
    } else {
        const ValueRef turn[] = {normal, l.global(Global::ObjectToWorldX), l.global(Global::ObjectToWorldY), l.global(Global::ObjectToWorldZ)};
        ValueRef p = l.global(Global::Po);
        if (space == kPref) p = l.attribute_or("Pref", Type::Vector, p);
        operands.insert(operands.end(), {p, l.op("normal_to_object", normal_to_object_kernel(), turn, Type::Vector), l.global(Global::Dpodx), l.global(Global::Dpody)});
    }
    if (space == kPref)
        operands.insert(operands.end(), {l.attribute("Pref:dx", Type::Vector), l.attribute("Pref:dy", Type::Vector), l.attribute("Pref.exists", Type::Float)});
    l.result(l.call(operands, 0));
}
static bool triplanar_uses(const Statics& s, int param) {
    using namespace al_triplanar;
    return s.e(kTiling) == 1 || (param != kCellSoftness && !(param >= kRotJitterX && param < kRotJitterX + 3));
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alTriplanar";
    n.system = System::AlShaders;
    n.category = "texture";
    n.summary = "an image projected along three axes";
    n.help = "The image seen along x, y and z, blended by the normal; over `input` where it is transparent. regular repeats it; cellnoise shows a turned "
             "copy in each cell. Image coordinates are mirrored in v, as in the original, and places that are not finite count as 0. Steps of the "
             "coordinates from pixel to pixel follow frequency, rotation and the cells, which the original left out. An image that cannot be read is "
             "opaque red. Normals are of unit length in object space. The cells are ours: Arnold's cellular noise is not public.";
    n.params = {color("input", 0, 0, 0).doc("what shows through the image's transparency"),
                choice("space", {"world", "object", "Pref"}, "world").doc("coordinates that are projected; Pref is the attribute of that name, object space where it is missing"),
                choice("normal", {"Geometric", "Smooth", "SmoothNoBump"}, "Geometric").doc("normal that blends the projections; Pref has its own"),
                choice("tiling", {"regular", "cellnoise"}, "regular").doc("how each projection is filled"),
                f("frequency", 1).range(0, 10).doc("multiplies the point: images a unit at scale 1"),
                image("texture").doc("the image file"),
                f("blendSoftness", 0.1).range(0, 1).in("Blending").doc("how far the projections run into each other"),
                f("cellSoftness", 0.1).range(0, 1).in("Blending").doc("cellnoise: how far the cells run into each other")};
    const char* axes[3] = {"x", "y", "z"};
    for (const char* a : axes) n.params.push_back(f(std::string("scale") + a, 1).range(0, 10).in("Positioning").doc("size of the image seen along this axis"));
    for (const char* a : axes) n.params.push_back(f(std::string("offset") + a, 0).range(-10, 10).in("Positioning").doc("shift of the image"));
    for (const char* a : axes) n.params.push_back(f(std::string("rot") + a, 0).range(0, 360).in("Positioning").doc("turn of the image, in degrees"));
    for (const char* a : axes) n.params.push_back(f(std::string("rotjitter") + a, 1).range(0, 1).in("Positioning").doc("cellnoise: share of a turn that is random"));
    n.params.push_back(i("mipMapBias", 0).no_link().doc("mip levels coarser (above 0) or finer than the pixel asks for; at 0 the image is read at its full resolution and the samples of a pixel filter it"));
    n.outputs = {{"out", Type::Color}};
    n.kernel = al_triplanar_kernel_kernel();
    n.cost_ns = 150;
    n.foldable = false;
    n.uses = triplanar_uses;
    n.prepare = [](const Statics& s, std::vector<std::string>& errors) { return open_al_texture(s, al_triplanar::kTexture, errors); };
    n.lower = lower_triplanar;
    return n;
}
}  // namespace alder
#endif
