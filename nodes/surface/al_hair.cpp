// alHair: the highlights of a strand (R, TT, TRT, glints), and Kajiya and Kay's diffuse or dual scattering below them.
// alshaders specification, section 7. The lobes' mathematics: render/closure/hair_al.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/surface/al_hair.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/math/al_color-inl.h"
#include "nodes/noise/cell_hash-inl.h"
#include "nodes/surface/al_hair_params.h"

#ifndef ALDER_NODES_SURFACE_AL_HAIR_LISTS
#define ALDER_NODES_SURFACE_AL_HAIR_LISTS
namespace alder::al_hair {
enum Lobe : int { kR, kTrt, kGlint, kTt, kDiffuse, kGlobal, kTransparent, kMarschnerLobes };
enum EnergyLobe : int { kEnergyR, kEnergyTrt, kEnergyBeyond, kEnergyTt, kEnergyTransparent, kEnergyLobes };
enum GlobalAt : int { kI = kGlobalsAt, kN = kI + 3, kDpdv = kN + 3, kFibreTangent = kDpdv + 3, kIsStrand = kFibreTangent + 3,
                      kRandom = kIsStrand + 1, kH = kRandom + 1, kDiffuseDepth = kH + 1 };
inline constexpr double kRadians = 0.017453292519943295;
}  // namespace alder::al_hair
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

namespace alh = alder::al_hair;

template <class F>
HWY_INLINE Vec3<F> al_hair_color(const Lanes<F>& k, int strength, int color) { return k.v(color) * k.f(strength); }

/// Within 0 to 1, so that neither the hair nor what shows through it turns negative.
template <class F>
HWY_INLINE Vec3<F> al_hair_opacity(const Lanes<F>& k) {
    const Vec3<F> o = k.v(alh::channel("opacity"));
    return {saturate(o.x), saturate(o.y), saturate(o.z)};
}

/// The strand as this point sees it: 7.1 and 7.2.
template <class F>
struct AlHairPoint {
    F cn;
    Vec3<F> cv, tangent, color, absorption;
    F shift[3], width[3];  ///< R, TT, TRT

    HWY_INLINE explicit AlHairPoint(const Lanes<F>& k) {
        using alh::channel;
        // Strands are told apart by their random number: as a whole number it is the curve_id of the original.
        const Mask<F> strand = k.f(alh::kIsStrand) != F(0);
        const F id = floor(k.f(alh::kRandom) * F(16777216));
        cn = select(strand, cell_noise2(id, F(0)), F(0.5));
        cv = select(strand, vcell_noise3(Vec3<F>(id + F(17), F(0), F(0))) * F(2) - Vec3<F>(F(1)), Vec3<F>(F(0)));
        const Vec3<F> along = select(strand, k.v(alh::kFibreTangent), k.v(alh::kDpdv)) + cv * (k.f(channel("randomTangent")) * F(0.3));
        const F l = length(along);
        tangent = select(l > F(0), along / select(l > F(0), l, F(1)), Vec3<F>(F(0), F(0), F(1)));

        const F melanin = saturate(k.f(channel("melanin")) + k.f(channel("randomMelanin")) * cv.z);
        const F m = max(F(33) * sqr(melanin), F(0.01));
        Vec3<F> dye = k.v(channel("dyeColor"));
        for (int c = 0; c < 3; ++c) dye[c] = saturate(dye[c]);
        const F hue = k.f(channel("randomHue")) * F(0.1), saturation = k.f(channel("randomSaturation"));
        Vec3<F> hsv = al_rgb_to_hsv(dye);
        hsv.x += cv.x * hue;
        hsv.y = saturate(hsv.y + cv.y * saturation);
        dye = select((hue != F(0)) | (saturation != F(0)), al_hsv_to_rgb(hsv), dye);
        const Vec3<F> base(exp(m * F(-0.187)), exp(m * F(-0.4)), exp(m * F(-1.05)));
        color = base * dye;
        for (int c = 0; c < 3; ++c) absorption[c] = -log(max(color[c], F(1e-4)));

        const F shift0 = k.f(channel("specularShift")) * F(-alh::kRadians), width0 = k.f(channel("specularWidth")) * F(alh::kRadians);
        shift[0] = shift0 + k.f(channel("specular1Shift")) * F(alh::kRadians);
        shift[1] = F(-0.5) * shift0 + k.f(channel("transmissionShift")) * F(alh::kRadians);
        shift[2] = F(-1.5) * shift0 + k.f(channel("specular2Shift")) * F(alh::kRadians);
        width[0] = width0 * k.f(channel("specular1WidthScale"));
        width[1] = F(0.5) * width0 * k.f(channel("transmissionWidthScale"));
        width[2] = F(2) * width0 * k.f(channel("specular2WidthScale"));
    }
};

/// Where a lobe's channels go; writes nothing where nobody wants it.
template <class F>
struct AlHairOut {
    const Lanes<F>& k;
    int first;
    bool wanted;
    HWY_INLINE AlHairOut(const Lanes<F>& lanes, int lobe) : k(lanes), first(-1), wanted(false) {
        const Statics& s = k.statics();
        if (lobe >= static_cast<int>(s.lobe_offset.size())) return;
        first = s.lobe_offset[lobe];
        wanted = k.wants(first) || k.wants(first + 1) || k.wants(first + 2);
    }
    /// A lobe takes no light away: strengths and colours below 0 are 0.
    HWY_INLINE void lobe(Vec3<F> weight, Vec3<F> n, Vec3<F> tangent) const {
        k.set(first, {max(F(0), weight.x), max(F(0), weight.y), max(F(0), weight.z)});
        k.set(first + 3, n);
        k.set(first + 6, tangent);
    }
    HWY_INLINE void param(int i, F x) const { k.set(first + 9 + i, x); }
};

template <class F>
HWY_INLINE Vec3<F> al_hair_faded(Vec3<F> absorption, F by, F amount) {
    return {exp(absorption.x * by) * amount, exp(absorption.y * by) * amount, exp(absorption.z * by) * amount};
}

struct AlHairMarschner {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        using alh::channel;
        const AlHairPoint<F> p(k);
        const Vec3<F> n = k.v(alh::kN), opacity = al_hair_opacity(k);
        // Highlights are not seen by rays that a diffuse bounce sent.
        const Vec3<F> glossy = select(k.f(alh::kDiffuseDepth) > F(0), Vec3<F>(F(0)), opacity);
        const Vec3<F> trt = al_hair_faded(p.absorption, F(-1), F(0.3)) * al_hair_color(k, channel("specular2Strength"), channel("specular2Color")) * glossy;
        const AlHairOut<F> r(k, alh::kR), second(k, alh::kTrt), glint(k, alh::kGlint), tt(k, alh::kTt);
        if (r.wanted) {
            r.lobe(al_hair_color(k, channel("specular1Strength"), channel("specular1Color")) * glossy * F(0.05), n, p.tangent);
            r.param(0, p.shift[0]);
            r.param(1, p.width[0]);
        }
        if (second.wanted) {
            second.lobe(trt, n, p.tangent);
            second.param(0, p.shift[2]);
            second.param(1, p.width[2]);
        }
        if (glint.wanted) {
            glint.lobe(trt * k.f(channel("glintStrength")), n, p.tangent);
            glint.param(0, p.shift[2]);
            glint.param(1, p.width[2]);
            glint.param(2, k.f(channel("glintRolloff")) * F(alh::kRadians));
            glint.param(3, p.cn * F(6.28318530717958648));
        }
        if (tt.wanted) {
            tt.lobe(al_hair_faded(p.absorption, F(-0.5), F(0.8)) * al_hair_color(k, channel("transmissionStrength"), channel("transmissionColor")) * glossy,
                    n, p.tangent);
            tt.param(0, p.shift[1]);
            tt.param(1, p.width[1]);
            tt.param(2, k.f(channel("transmissionRolloff")) * F(alh::kRadians));
        }
        const Vec3<F> diffuse = al_hair_color(k, channel("diffuseStrength"), channel("diffuseColor")) * opacity;
        const AlHairOut<F> local(k, alh::kDiffuse);
        if (k.statics().e(alh::index("diffuseScatteringMode")) == 0) {
            if (local.wanted) local.lobe(diffuse * p.color, n, p.tangent);
        } else {
            const F forward = k.f(channel("diffuseForward")), back = k.f(channel("diffuseBack")), most = max_component(diffuse);
            const Mask<F> on = (forward * most > F(1e-5)) & (back * most > F(1e-5));
            for (const int lobe : {int{alh::kDiffuse}, int{alh::kGlobal}}) {
                const AlHairOut<F> out(k, lobe);
                if (!out.wanted) continue;
                out.lobe(select(on, diffuse, Vec3<F>(F(0))), n, p.tangent);
                for (int c = 0; c < 3; ++c) out.param(c, p.color[c]);
                out.param(3, forward);
                out.param(4, back);
                // The tables are of the fibre as configured, without the scales and shifts of the point.
                out.param(5, k.f(channel("specularShift")) * F(-alh::kRadians));
                out.param(6, k.f(channel("specularWidth")) * F(alh::kRadians));
                out.param(7, k.f(channel("transmissionRolloff")) * F(alh::kRadians));
                out.param(8, k.f(channel("glintRolloff")) * F(alh::kRadians));
            }
        }
        const AlHairOut<F> clear(k, k.statics().e(alh::index("diffuseScatteringMode")) == 0 ? alh::kGlobal : alh::kTransparent);
        if (clear.wanted) {
            k.set(clear.first, Vec3<F>(F(1)) - opacity);
            k.set(clear.first + 3, n);
        }
    }
};

struct AlHairEnergy {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        using alh::channel;
        const AlHairPoint<F> p(k);
        const Vec3<F> n = k.v(alh::kN), opacity = al_hair_opacity(k);
        const F h = clamp(k.f(alh::kH), F(-1), F(1));
        // The logistic whose standard deviation is the rolloff.
        const F scale = max(k.f(channel("transmissionRolloff")), F(0.1)) * F(alh::kRadians * 0.55132889542179209);
        const Vec3<F> tint[3] = {al_hair_color(k, channel("specular1Strength"), channel("specular1Color")),
                                 al_hair_color(k, channel("transmissionStrength"), channel("transmissionColor")),
                                 al_hair_color(k, channel("specular2Strength"), channel("specular2Color"))};
        constexpr int kLobe[4] = {alh::kEnergyR, alh::kEnergyTt, alh::kEnergyTrt, alh::kEnergyBeyond};
        for (int order = 0; order < 4; ++order) {
            const AlHairOut<F> out(k, kLobe[order]);
            if (!out.wanted) continue;
            const int like = min_int(order, 2);
            out.lobe(tint[like] * opacity, n, p.tangent);
            // The absorption is that of a whole crossing of a fibre of radius one half; the lobe counts from its axis.
            for (int c = 0; c < 3; ++c) out.param(c, p.absorption[c] * F(0.25));
            // A Gaussian of the half angle is twice as wide in theta_i.
            out.param(3, F(4) * sqr(p.width[like]));
            out.param(4, scale);
            // The peak: theta_i = -theta_o + 2 shift.
            out.param(5, order == 3 ? F(0) : F(-2) * p.shift[like]);
            out.param(6, F(1.55));
            out.param(7, h);
        }
        const AlHairOut<F> clear(k, alh::kEnergyTransparent);
        if (clear.wanted) {
            k.set(clear.first, Vec3<F>(F(1)) - opacity);
            k.set(clear.first + 3, n);
        }
    }
    static HWY_INLINE int min_int(int a, int b) { return a < b ? a : b; }
};
template <class F>
void al_hair(const Call<F>& c) {
    if (c.statics().e(alh::index("fibreModel")) == 0) c.template each<AlHairMarschner>();
    else c.template each<AlHairEnergy>();
}
ALDER_KERNEL(al_hair)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(al_hair)

namespace al_hair {
namespace {

bool is_energy(const Statics& s) { return s.e(index("fibreModel")) == 1; }

std::vector<LobeSpec> lobes(const Statics& s) {
    const int opacity = index("opacity");
    const int specular1[] = {index("specular1Strength"), index("specular1Color")};
    const int specular2[] = {index("specular2Strength"), index("specular2Color")};
    const int transmission[] = {index("transmissionStrength"), index("transmissionColor")};
    const auto gates = [&](const int* pair) { return std::vector<int>{pair[0], pair[1], opacity}; };
    std::vector<LobeSpec> l;
    const auto add = [&](LobeKind kind, LobeLabel label, std::vector<int> gate, int order = 0) {
        LobeSpec spec{kind, label};
        spec.order = static_cast<int8_t>(order);
        spec.gates = std::move(gate);
        l.push_back(spec);
    };
    if (is_energy(s)) {
        add(LobeKind::HairOrder, LobeLabel::Specular, gates(specular1), 0);
        add(LobeKind::HairOrder, LobeLabel::Specular2, gates(specular2), 2);
        add(LobeKind::HairOrder, LobeLabel::Specular2, gates(specular2), 3);
        add(LobeKind::HairOrder, LobeLabel::HairTransmission, gates(transmission), 1);
    } else {
        add(LobeKind::HairGlossy, LobeLabel::Specular, gates(specular1));
        add(LobeKind::HairGlossy, LobeLabel::Specular2, gates(specular2));
        add(LobeKind::HairGlint, LobeLabel::Glint, {specular2[0], specular2[1], index("glintStrength"), opacity});
        add(LobeKind::HairForward, LobeLabel::HairTransmission, gates(transmission));
        const std::vector<int> diffuse{index("diffuseStrength"), index("diffuseColor"), opacity};
        if (s.e(index("diffuseScatteringMode")) == 0) {
            add(LobeKind::HairKajiya, LobeLabel::Diffuse, diffuse);
        } else {
            add(LobeKind::HairDual, LobeLabel::Local, diffuse, 0);
            add(LobeKind::HairDual, LobeLabel::Global, diffuse, 1);
        }
    }
    if (!s.is_default(opacity)) add(LobeKind::Transparent, LobeLabel::Transparent, {});
    return l;
}

bool uses(const Statics& s, int param) {
    const std::string_view name = kRows[param].name;
    const bool energy = is_energy(s), dual = !energy && s.e(index("diffuseScatteringMode")) == 1;
    const auto starts = [&](std::string_view prefix) { return name.substr(0, prefix.size()) == prefix; };
    if (name == "diffuseForward" || name == "diffuseBack") return dual;
    if (name == "diffuseStrength" || name == "diffuseColor" || name == "diffuseScatteringMode") return !energy;
    if (name == "glintStrength" || name == "glintRolloff") return !energy;
    if (name == "diffuseIndirectStrength" || name == "glossyIndirectStrength" || name == "dualDepth") return false;
    if (starts("extraSamples") || starts("aov_") || starts("crypto_") || name == "uparam" || name == "vparam") return false;
    return true;
}

}  // namespace
}  // namespace al_hair

ALDER_NODE {
    NodeType n;
    n.name = "alHair";
    n.system = System::AlShaders;
    n.category = "hair";
    n.summary = "hair fibre lobes with dual scattering";
    n.help = "R, TT, TRT and glints of Ou et al. 2012 with the colour of melanin and dye. Kajiya and Kay's diffuse, or the light that other "
             "fibres scatter back after Zinke et al. 2008; light that reaches a strand through others comes from paths, as shadow rays do "
             "not count fibres. Strands differ by their random number. fibreModel replaces all of it by an energy-conserving model.";
    for (const AlParam& row : al_hair::kRows) n.params.push_back(al::make_param(row));
    n.outputs = {{"out", Type::Closure}};
    n.globals = {Global::I, Global::N, Global::Dpdv, Global::FibreTangent, Global::IsStrand, Global::FibreRandom, Global::FibreOffset, Global::DiffuseDepth};
    n.kernel = al_hair_kernel();
    n.cost_ns = 80;
    n.uses = al_hair::uses;
    n.lobes = al_hair::lobes;
    for (int id = 1; id <= 8; ++id) {
        const std::string digit = std::to_string(id);
        n.closure_aovs.push_back({"id_" + digit, n.param_index("id" + digit)});
    }
    return n;
}
}  // namespace alder
#endif
