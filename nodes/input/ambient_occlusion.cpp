// Ambient Occlusion and Bevel: how much of a point's surroundings is open, and a normal rounded over nearby edges (Blender's nodes).
// Both cast rays into the scene, through nodes/input/scene_query.h; where there is no scene, everything is open and nothing rounded.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/input/ambient_occlusion.cpp"
#include "hwy/foreach_target.h"

#include "nodes/input/scene_query-inl.h"
#include "nodes/kernel-inl.h"
#include "nodes/math/cycles-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Distance 0, normal 1, surface 4.
struct AmbientOcclusion {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const SceneQuery* const scene = current_scene_query();
        if (!scene) return k.set(0, F(1));
        const int samples = k.statics().e(0);
        const bool inside = k.statics().e(1) != 0, only_local = k.statics().e(2) != 0;
        const Vec3<F> n = safe_normalize(k.v(1));
        alignas(64) float distance[kMostLanes<F>], normal[3][kMostLanes<F>], result[kMostLanes<F>] = {};
        store_floats(k.f(0), distance);
        for (int c = 0; c < 3; ++c) store_floats(inside ? -n[c] : n[c], normal[c]);
        PointLanes<F> lanes;
        lanes.load(k, 4);
        for (size_t lane = 0; lane < PointLanes<F>::count(k); ++lane) {
            const float about[3] = {normal[0][lane], normal[1][lane], normal[2][lane]};
            result[lane] = distance[lane] > 0 ? scene->unoccluded(lanes.point(lane), about, distance[lane], samples, only_local) : 1.0f;
        }
        k.set(0, load_floats<F>(result));
    }
};
/// Colour 0, openness 3.
struct Tinted {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, k.v(0) * k.f(3)); }
};
/// Radius 0, normal to bend 1, diffuse depth 4, width of the lobe that cast the ray 5, surface 6.
struct Bevel {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const SceneQuery* const scene = current_scene_query();
        const Vec3<F> n = k.v(12);
        Vec3<F> bent = n;
        if (scene) {
            alignas(64) float radius[kMostLanes<F>], result[3][kMostLanes<F>];
            // Rays blurred by a rough surface do not see the edge: as in Cycles, they take the plain normal. Its measure is a density
            // of directions below 8, which GGX's peak 1/(4 pi alpha^2) falls under at alpha 0.1.
            store_floats(select((k.f(4) > F(0)) | (k.f(5) > F(0.1f)), F(0), k.f(0)), radius);
            PointLanes<F> lanes;
            lanes.load(k, 6);
            for (int c = 0; c < 3; ++c) store_floats(n[c], result[c]);
            for (size_t lane = 0; lane < PointLanes<F>::count(k); ++lane) {
                if (!(radius[lane] > 0)) continue;
                float r[3];
                scene->bevel(lanes.point(lane), radius[lane], k.statics().e(0), r);
                for (int c = 0; c < 3; ++c) result[c][lane] = r[c];
            }
            bent = Vec3<F>(load_floats<F>(result[0]), load_floats<F>(result[1]), load_floats<F>(result[2]));
        }
        // A normal that comes in, from a bump say, keeps its difference from the shading normal.
        k.set(0, k.statics().linked[2] ? safe_normalize(k.v(1) + (bent - n)) : bent);
    }
};
template <class F>
void ambient_occlusion(const Call<F>& c) { c.template each<AmbientOcclusion>(); }
template <class F>
void tinted(const Call<F>& c) { c.template each<Tinted>(); }
template <class F>
void bevel(const Call<F>& c) { c.template each<Bevel>(); }
ALDER_KERNEL(ambient_occlusion)
ALDER_KERNEL(tinted)
ALDER_KERNEL(bevel)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "nodes/input/scene_query_operands.h"

namespace alder {
ALDER_KERNEL_EXPORT(ambient_occlusion)
ALDER_KERNEL_EXPORT(tinted)
ALDER_KERNEL_EXPORT(bevel)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeAmbientOcclusion";
    n.aliases = {"ambient_occlusion"};
    n.category = "Input";
    n.summary = "how much of the hemisphere around the point is open";
    n.help = "Casts Samples rays, weighted by the cosine, and counts those that meet nothing within Distance. 1 where there is no scene.";
    Param samples = i("samples", 16);
    samples.hard = true;
    n.params = {
        samples.limit(1, 65536).range(1, 128).no_link().doc("rays per evaluation"),
        b("inside").no_link().doc("looks into the object instead: thin parts are dark"),
        b("only_local").no_link().doc("only the object itself occludes"),
        color("Color", 1, 1, 1).doc("multiplied by the openness"),
        f("Distance", 1).range(0, 1000).doc("how far the rays go"),
        vector("Normal", 0, 0, 0).unlinked(Global::N).doc("middle of the hemisphere; unlinked: the shading normal"),
    };
    n.outputs = {{"Color", Type::Color}, {"AO", Type::Float}};
    n.cost_ns = 3000;
    n.lower = [](Lowering& l, int output) {
        std::vector<ValueRef> operands{l.input(4), l.input(5)};
        add_scene_operands(l, operands);
        const ValueRef open = l.op("ambient_occlusion", ambient_occlusion_kernel(), operands, Type::Float);
        if (output == 1) return l.result(open);
        const ValueRef tint[] = {l.input(3), open};
        l.result(l.op("tinted", tinted_kernel(), tint, Type::Color));
    };
    return n;
}
ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeBevel";
    n.aliases = {"bevel"};
    n.category = "Input";
    n.summary = "a normal that rounds the edges of the object";
    n.help = "Averages the normals of the object's surface within Radius. Rays from rough or diffuse bounces see the plain normal. The shading normal "
             "where there is no scene.";
    Param samples = i("samples", 4);
    samples.hard = true;
    n.params = {
        samples.limit(1, 65536).range(2, 16).no_link().doc("probes per evaluation"),
        f("Radius", 0.0500000007).range(0, 10).doc("how far the rounding reaches"),
        vector("Normal", 0, 0, 0).unlinked(Global::N).doc("a normal to be bent along; unlinked: the shading normal"),
    };
    n.outputs = {{"Normal", Type::Vector}};
    n.cost_ns = 3000;
    n.lower = [](Lowering& l, int) {
        std::vector<ValueRef> operands{l.input(1), l.input(2), l.global(Global::DiffuseDepth), l.global(Global::PreviousAlpha)};
        add_scene_operands(l, operands);
        l.result(l.op("bevel", bevel_kernel(), operands, Type::Vector));
    };
    return n;
}
}  // namespace alder
#endif
