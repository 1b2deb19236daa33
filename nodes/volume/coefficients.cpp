// Volume Absorption, Volume Scatter and Volume Coefficients: what a medium absorbs, scatters and emits per unit length (Blender).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/volume/coefficients.cpp"
#include "hwy/foreach_target.h"

#include "nodes/volume/phase-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct VolumeAbsorption {  // Color 0, Density 3
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const LobeOut<F> out(k, 0);
        out.weight(max0(Vec3<F>(F(1)) - k.v(0)) * max(k.f(3), F(0)));
        out.normal(Vec3<F>(F(0)));
    }
};
template <class F>
void volume_absorption(const Call<F>& c) { c.template each<VolumeAbsorption>(); }
ALDER_KERNEL(volume_absorption)

template <PhaseSetting kPhase>
struct VolumeScatter {  // Color 0, Density 3, phase sockets from 4
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        emit_phase<kPhase>(k, 0, max0(k.v(0)) * max(k.f(3), F(0)), {4, 5, 6, 7, 8});
    }
};
template <class F>
void volume_scatter(const Call<F>& c) {
    switch (static_cast<PhaseSetting>(c.statics().e(0))) {
        case PhaseSetting::HenyeyGreenstein: return c.template each<VolumeScatter<PhaseSetting::HenyeyGreenstein>>();
        case PhaseSetting::FournierForand: return c.template each<VolumeScatter<PhaseSetting::FournierForand>>();
        case PhaseSetting::Draine: return c.template each<VolumeScatter<PhaseSetting::Draine>>();
        case PhaseSetting::Rayleigh: return c.template each<VolumeScatter<PhaseSetting::Rayleigh>>();
        case PhaseSetting::Mie: return c.template each<VolumeScatter<PhaseSetting::Mie>>();
    }
}
ALDER_KERNEL(volume_scatter)

template <PhaseSetting kPhase>
struct VolumeCoefficients {  // Absorption 0, Scatter 3, phase sockets from 6, Emission 11
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> none(F(0));
        const LobeOut<F> absorption(k, 0), emission(k, 1);
        absorption.weight(max0(k.v(0)));
        absorption.normal(none);
        emission.weight(k.v(11));
        emission.normal(none);
        emit_phase<kPhase>(k, 2, max0(k.v(3)), {6, 7, 8, 9, 10});
    }
};
template <class F>
void volume_coefficients(const Call<F>& c) {
    switch (static_cast<PhaseSetting>(c.statics().e(0))) {
        case PhaseSetting::HenyeyGreenstein: return c.template each<VolumeCoefficients<PhaseSetting::HenyeyGreenstein>>();
        case PhaseSetting::FournierForand: return c.template each<VolumeCoefficients<PhaseSetting::FournierForand>>();
        case PhaseSetting::Draine: return c.template each<VolumeCoefficients<PhaseSetting::Draine>>();
        case PhaseSetting::Rayleigh: return c.template each<VolumeCoefficients<PhaseSetting::Rayleigh>>();
        case PhaseSetting::Mie: return c.template each<VolumeCoefficients<PhaseSetting::Mie>>();
    }
}
ALDER_KERNEL(volume_coefficients)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "nodes/surface/cycles_params.h"

namespace alder {
ALDER_KERNEL_EXPORT(volume_absorption)
ALDER_KERNEL_EXPORT(volume_scatter)
ALDER_KERNEL_EXPORT(volume_coefficients)

static NodeType volume_node(const char* name, const char* alias, const char* summary) {
    NodeType n = cycles_bsdf_node(name, alias, summary, "Volume");
    n.category = "volume";
    n.help = "Densities are per unit length, in world space.";
    return n;
}
static bool volume_node_uses(const Statics& s, int p) {
    const Param& param = s.type->params[p];
    return param.name != "Weight" && phase_uses(static_cast<PhaseSetting>(s.e(0)), param.name);
}

ALDER_NODE {
    using namespace param;
    NodeType n = volume_node("ShaderNodeVolumeAbsorption", "absorption_volume", "absorbs light on its way");
    n.params = {color("Color", 0.8, 0.8, 0.8).doc("what is left of light: white absorbs nothing"),
                f("Density", 1).range(0, 1000).doc("absorption is this times 1 - Color"), weight_socket()};
    n.kernel = volume_absorption_kernel();
    n.cost_ns = 1;
    n.uses = [](const Statics&, int p) { return p != 2; };
    n.lobes = [](const Statics&) -> std::vector<LobeSpec> {
        return {{.kind = LobeKind::Absorption, .label = LobeLabel::Volume, .gates = {1}}};
    };
    return n;
}
ALDER_NODE {
    using namespace param;
    NodeType n = volume_node("ShaderNodeVolumeScatter", "scatter_volume", "scatters light on its way");
    n.params = {phase_choice(), color("Color", 0.8, 0.8, 0.8), f("Density", 1).range(0, 1000).doc("scattering is this times Color")};
    add_phase_sockets(n.params);
    n.params.push_back(weight_socket());
    n.kernel = volume_scatter_kernel();
    n.cost_ns = 5;
    n.uses = volume_node_uses;
    n.lobes = [](const Statics& s) { return phase_lobes(static_cast<PhaseSetting>(s.e(0)), {1, 2}); };
    return n;
}
ALDER_NODE {
    using namespace param;
    NodeType n = volume_node("ShaderNodeVolumeCoefficients", "volume_coefficients", "absorbs, scatters and emits as the coefficients say");
    n.params = {phase_choice(), vector("Absorption Coefficients", 1, 1, 1).range(0, 1000), vector("Scatter Coefficients", 1, 1, 1).range(0, 1000)};
    add_phase_sockets(n.params);
    n.params.push_back(vector("Emission Coefficients", 0, 0, 0).range(0, 1000).doc("radiance per unit length"));
    n.params.push_back(weight_socket());
    n.kernel = volume_coefficients_kernel();
    n.cost_ns = 5;
    n.uses = volume_node_uses;
    n.lobes = [](const Statics& s) {
        std::vector<LobeSpec> l = {{.kind = LobeKind::Absorption, .label = LobeLabel::Volume, .gates = {1}},
                                   {.kind = LobeKind::Emission, .label = LobeLabel::Volume, .gates = {8}}};
        for (LobeSpec& p : phase_lobes(static_cast<PhaseSetting>(s.e(0)), {2})) l.push_back(std::move(p));
        return l;
    };
    return n;
}
}  // namespace alder
#endif
