// alLayer: two surfaces blended by a mix; at either end only one of them is evaluated.
// alshaders specification, section 8.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/surface/al_layer.cpp"
#include "hwy/foreach_target.h"

#include "graph/lowering.h"
#include "nodes/kernel-inl.h"
#include "nodes/surface/al_params.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// The mix as weights: exactly 0 or 1 near the ends, where the other layer is not evaluated; not limited between and beyond.
template <class F>
HWY_INLINE F al_layer_weight(F mix) {
    return select(mix >= F(1 - 1e-5), F(1), select(mix <= F(1e-5), F(0), mix));
}

struct AlLayerUpper {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, al_layer_weight(k.f(0))); }
};
struct AlLayerLower {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, F(1) - al_layer_weight(k.f(0))); }
};
template <class F>
void al_layer_upper(const Call<F>& c) { c.template each<AlLayerUpper>(); }
template <class F>
void al_layer_lower(const Call<F>& c) { c.template each<AlLayerLower>(); }
ALDER_KERNEL(al_layer_upper)
ALDER_KERNEL(al_layer_lower)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(al_layer_upper)
ALDER_KERNEL_EXPORT(al_layer_lower)

namespace al_layer {
using namespace al;

inline constexpr std::array kFirst{
    closure("layer1", "", "Layer 1", "surface seen where mix is 0; a colour is light emitted"),
    closure("layer2", "", "Layer 2", "surface seen where mix is 1; a colour is light emitted"),
    f("mix", 0, "", "Mix", "0 is layer 1 alone, 1 layer 2 alone; not limited beyond that"),
    choice("debug", "off|layer1|layer2|mixer", "off", "", "Debug", "shows one layer alone, or mix as emission"),
};
inline constexpr std::array kLast{
    b("standardCompatibleAOVs", false, "AOVs", "Write standard AOVs only", "only off is available: every light path has its AOV").fixed(),
    b("aiEnableMatte", false, "", "", "for exporters; no effect").fixed(),
    color("aiMatteColor", 0, 0, 0, "", "", "for exporters; no effect").fixed(),
    f("aiMatteColorA", 0, "", "", "for exporters; no effect").fixed(),
};
inline constexpr auto kRows = concat(kFirst, aov_params(), kLast);
static_assert(kRows.size() == 68);
constexpr int kLayer1 = index_of(kRows, "layer1"), kLayer2 = index_of(kRows, "layer2"), kMix = index_of(kRows, "mix");
constexpr int kDebug = index_of(kRows, "debug"), kStandardAovs = index_of(kRows, "standardCompatibleAOVs");

void lower(Lowering& l, int) {
    switch (l.statics().e(kDebug)) {
        case 1: return l.pass_closure(kLayer1, {});
        case 2: return l.pass_closure(kLayer2, {});
        case 3: return l.emit(l.convert(l.input(kMix), Type::Color));
        default: break;
    }
    const ValueRef mix[] = {l.input(kMix)};
    l.pass_closure(kLayer1, l.op("alLayer lower", al_layer_lower_kernel(), mix, Type::Float));
    l.pass_closure(kLayer2, l.op("alLayer upper", al_layer_upper_kernel(), mix, Type::Float));
}

void check(const Statics& s, const std::vector<const double*>&, std::vector<std::string>& errors) {
    if (s.e(kStandardAovs)) errors.push_back("standardCompatibleAOVs: false: every light path has its AOV");
}
}  // namespace al_layer

ALDER_NODE {
    NodeType n;
    n.name = "alLayer";
    n.system = System::AlShaders;
    n.category = "surface-layer";
    n.summary = "blend of two surface results with their AOVs";
    n.help = "The lobes of both layers, weighted by 1 - mix and mix, so that light is sampled once for both. Near 0 and 1 (within "
             "0.00001) the other layer is not evaluated. AOVs that the layers carry are blended alike.";
    for (const AlParam& row : al_layer::kRows) n.params.push_back(al::make_param(row));
    n.outputs = {{"out", Type::Closure}};
    n.lower = al_layer::lower;
    n.check = al_layer::check;
    return n;
}
}  // namespace alder
#endif
