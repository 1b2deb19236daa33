// alCurvature: how much the surface bulges or caves in around the point, by a sphere fitted to probes. alshaders specification, 3.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/input/al_curvature.cpp"
#include "hwy/foreach_target.h"

#include "nodes/input/scene_query-inl.h"
#include "nodes/math/remap-inl.h"
#include "nodes/math/remap_params.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Radius 0, colours 1 and 4, remap 7..18, surface 19.
struct AlCurvature {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        constexpr int kSurface = 19;
        alignas(64) float radius[kMostLanes<F>], curvature[kMostLanes<F>] = {}, found[kMostLanes<F>] = {};
        if (const SceneQuery* const scene = current_scene_query()) {
            const int samples = k.statics().e(1), side = samples < 1 ? 0 : samples < 10 ? samples : 10;
            store_floats(k.f(0), radius);
            PointLanes<F> lanes;
            lanes.load(k, kSurface);
            for (size_t lane = 0; lane < PointLanes<F>::count(k); ++lane) {
                const float view[3] = {-lanes.v[9][lane], -lanes.v[10][lane], -lanes.v[11][lane]};
                float value;
                if (!scene->curvature(lanes.point(lane), view, radius[lane], side, value)) continue;
                curvature[lane] = value;
                found[lane] = 1;
            }
        }
        const F sign = k.statics().e(0) != 0 ? F(-1) : F(1);
        const F value = max(load_floats<F>(curvature) * sign, F(0));
        const F x = select(load_floats<F>(found) != F(0), al_remap(k, 7, value), F(0));  // not remapped where nothing is found
        k.set(0, lerp(k.v(1), k.v(4), x));
    }
};
template <class F>
void al_curvature(const Call<F>& c) { c.template each<AlCurvature>(); }
ALDER_KERNEL(al_curvature)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "nodes/input/scene_query_operands.h"

namespace alder {
ALDER_KERNEL_EXPORT(al_curvature)

static void lower_curvature(Lowering& l, int) {
    std::vector<ValueRef> operands{l.input(2), l.input(4), l.input(5)};
    for (int i = 6; i < 18; ++i) operands.push_back(l.input(i));
    add_scene_operands(l, operands);
    l.result(l.op("al_curvature", al_curvature_kernel(), operands, Type::Color));
}
static void check_curvature(const Statics& s, const std::vector<const double*>&, std::vector<std::string>& errors) {
    if (!s.text[3].empty()) errors.push_back("traceSet: an empty string: trace sets are not available, probes see every object");
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alCurvature";
    n.system = System::AlShaders;
    n.category = "geometry";
    n.summary = "curvature of the surface, from probes";
    n.help = "Casts samples² probes (at most 100) along the view within sampleRadius, fits a sphere and mixes color1 and color2 by its curvature: "
             "positive bulges, negative caves in. Departures from the original: probes that miss are left out (there they repeat the last hit), "
             "points are not shifted by (10,10,10), which only costs digits, and a fit of one place has no curvature. color1 where there is no scene.";
    Param samples = i("samples", 3);
    samples.hard = true;
    n.params = {choice("mode", {"positive", "negative"}, "positive").doc("which side counts"),
                samples.limit(0, 65536).range(1, 10).no_link().doc("probes along each side of the square of probes"),
                f("sampleRadius", 1).doc("how far probes reach"),
                string("traceSet").doc("only empty is available: probes see every object"),
                color("color1", 0, 0, 0).doc("where the surface is flat"), color("color2", 1, 1, 1).doc("where the remapped curvature is 1")};
    add_remap_params(n.params);
    n.outputs = {{"out", Type::Color}};
    n.cost_ns = 3000;
    n.lower = lower_curvature;
    n.check = check_curvature;
    return n;
}
}  // namespace alder
#endif
