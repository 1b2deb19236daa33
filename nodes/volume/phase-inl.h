// Phase functions as volume nodes emit them: how each setting becomes one or two lobes. Their values: render/closure/phase.h.
#if defined(ALDER_NODES_VOLUME_PHASE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_VOLUME_PHASE_INL_H_
#undef ALDER_NODES_VOLUME_PHASE_INL_H_
#else
#define ALDER_NODES_VOLUME_PHASE_INL_H_
#endif

#include "nodes/surface/closure-inl.h"
#include "nodes/volume/phase_params.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Mie scattering of water droplets: a Henyey–Greenstein lobe of anisotropy g_hg and a Draine lobe, the latter's share being w.
/// Jendersie and d'Eon, "An Approximate Mie Scattering Function for Fog and Cloud Rendering", SIGGRAPH 2023 Talks: the fits for
/// four ranges of the diameter, in micrometres.
template <class F>
struct MieLobes {
    F g_hg, g_draine, alpha, w;

    static HWY_INLINE MieLobes large(F d) {  // 5 and more
        return {exp(F(-0.0990567) / (d - F(1.67154))), exp(F(-2.20679) / (d + F(3.91029)) - F(0.428934)),
                exp(F(3.62489) - F(8.29288) / (d + F(5.52825))), exp(F(-0.599085) / (d - F(0.641583)) - F(0.665888))};
    }
    static HWY_INLINE MieLobes middle(F d) {  // 1.5 to 5
        const F l = log(d), ll = log(l);
        return {F(0.0604931) * ll + F(0.940256), F(0.500411) - F(0.081287) / (tan(l) - F(2) * l + F(1.27551)),
                F(7.30354) * l + F(6.31675), F(0.026914) * (l - cos(F(5.68947) * (ll - F(0.0292149)))) + F(0.3764)};
    }
    static HWY_INLINE MieLobes small(F d) {  // 0.1 to 1.5
        const F l = log(d);
        const F inner = (l - F(0.238604)) * (l + F(1.00667)) / (F(0.507522) - F(0.15677) * l);
        return {F(0.862) - F(0.143) * l * l, F(0.379685) * cos(F(1.19692) * cos(inner) + F(1.37932) * l + F(0.0625835)) + F(0.344213), F(250),
                F(0.146209) * cos(F(3.38707) * l + F(2.11193)) + F(0.316072) + F(0.0778917) * l};
    }
    static HWY_INLINE MieLobes tiny(F d) {  // below 0.1
        return {F(13.8) * d * d, F(1.1456) * d * sin(F(9.29044) * d), F(250), F(0.252977) - F(312.983) * pow(d, F(4.3))};
    }
    static HWY_INLINE MieLobes choose(Mask<F> m, MieLobes a, MieLobes b) {
        return {select(m, a.g_hg, b.g_hg), select(m, a.g_draine, b.g_draine), select(m, a.alpha, b.alpha), select(m, a.w, b.w)};
    }
    static HWY_INLINE MieLobes of(F diameter) {
        const F d = select(diameter > F(0), min(diameter, F(1e6)), F(0));  // NaN is the least, too
        MieLobes r = large(max(d, F(5)));
        if (any(d < F(5))) r = choose(d < F(5), middle(min(max(d, F(1.5)), F(5))), r);
        if (any(d < F(1.5))) r = choose(d < F(1.5), small(min(max(d, F(0.1)), F(1.5))), r);
        if (any(d <= F(0.1))) r = choose(d <= F(0.1), tiny(min(d, F(0.1))), r);
        r.w = saturate(r.w);
        return r;
    }
};

/// First channels of the parameters that phase functions read.
struct PhaseChannels {
    int anisotropy, ior, backscatter, alpha, diameter;
};

/// Writes the phase lobes, of which the first is lobe `first`. kPhase: PhaseSetting.
template <PhaseSetting kPhase, class F>
HWY_INLINE void emit_phase(const Lanes<F>& k, int first, Vec3<F> scattering, const PhaseChannels& at) {
    const LobeOut<F> out(k, first);
    const Vec3<F> none(F(0));
    out.normal(none);
    if constexpr (kPhase == PhaseSetting::Mie) {
        const MieLobes<F> mie = MieLobes<F>::of(k.f(at.diameter));
        const LobeOut<F> draine(k, first + 1);
        out.weight(scattering * (F(1) - mie.w));
        out.param(0, mie.g_hg);
        draine.weight(scattering * mie.w);
        draine.normal(none);
        draine.param(0, mie.g_draine);
        draine.param(1, mie.alpha);
        return;
    }
    out.weight(scattering);
    if constexpr (kPhase == PhaseSetting::HenyeyGreenstein || kPhase == PhaseSetting::Draine) out.param(0, k.f(at.anisotropy));
    if constexpr (kPhase == PhaseSetting::Draine) out.param(1, k.f(at.alpha));
    if constexpr (kPhase == PhaseSetting::FournierForand) {
        out.param(0, k.f(at.backscatter));
        out.param(1, k.f(at.ior));
    }
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
