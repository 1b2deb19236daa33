// Diffuse-type BSDFs of Cycles: Diffuse (Lambert or Oren–Nayar with energy compensation), Translucent, Sheen, Toon.
// Sheen: Zeltner et al. 2022 (Microfiber), Ashikhmin et al. 2000 (Ashikhmin).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/surface/diffuse.cpp"
#include "hwy/foreach_target.h"

#include "nodes/surface/closure-inl.h"
#include "nodes/surface/cycles_params.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct DiffuseBsdf {  // Color 0, Roughness 3, Normal 4, Weight 7; N 8
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const LobeOut<F> out(k, 0);
        const Vec3<F> color = k.v(0);
        out.weight(allocate(color));
        out.normal(socket_normal(k.v(4), k.v(8)));
        if (out.spec.smooth) return;
        out.param(0, saturate(k.f(3)));
        out.param(1, saturate(color));
    }
};
template <class F>
void diffuse_bsdf(const Call<F>& c) { c.template each<DiffuseBsdf>(); }
ALDER_KERNEL(diffuse_bsdf)

struct TranslucentBsdf {  // Color 0, Normal 3, Weight 6; N 7, Ng 10, I 13
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const LobeOut<F> out(k, 0);
        out.weight(allocate(k.v(0)));
        out.normal(reflecting_normal(socket_normal(k.v(3), k.v(7)), k.v(10), k.v(13)));
    }
};
template <class F>
void translucent_bsdf(const Call<F>& c) { c.template each<TranslucentBsdf>(); }
ALDER_KERNEL(translucent_bsdf)

struct MicrofiberSheen {  // Color 0, Roughness 3, Normal 4, Weight 7; N 8, I 11
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const LobeOut<F> out(k, 0);
        const Vec3<F> n = socket_normal(k.v(4), k.v(8));
        const SheenFit<F> fit(dot(n, k.v(11)), saturate(k.f(3)));
        out.weight(allocate(k.v(0)) * fit.albedo);
        out.normal(n);
        out.param(0, fit.a);
        out.param(1, fit.b);
    }
};
struct AshikhminSheen {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const LobeOut<F> out(k, 0);
        out.weight(allocate(k.v(0)));
        out.normal(socket_normal(k.v(4), k.v(8)));
        out.param(0, max(saturate(k.f(3)), F(0.01)));
    }
};
template <class F>
void sheen_bsdf(const Call<F>& c) {
    if (c.statics().lobes[0].kind == LobeKind::SheenAshikhmin) return c.template each<AshikhminSheen>();
    c.template each<MicrofiberSheen>();
}
ALDER_KERNEL(sheen_bsdf)

struct ToonBsdf {  // Color 0, Size 3, Smooth 4, Normal 5, Weight 8; N 9
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F quarter_turn = F(1.57079632679489662);
        const LobeOut<F> out(k, 0);
        out.weight(allocate(k.v(0)));
        out.normal(socket_normal(k.v(5), k.v(9)));
        out.param(0, clamp(k.f(3), F(1e-5), F(1)) * quarter_turn);
        out.param(1, saturate(k.f(4)) * quarter_turn);
    }
};
template <class F>
void toon_bsdf(const Call<F>& c) { c.template each<ToonBsdf>(); }
ALDER_KERNEL(toon_bsdf)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(diffuse_bsdf)
ALDER_KERNEL_EXPORT(translucent_bsdf)
ALDER_KERNEL_EXPORT(sheen_bsdf)
ALDER_KERNEL_EXPORT(toon_bsdf)

static bool all_but_weight(const Statics& s, int p) { return s.type->params[p].name != "Weight"; }

ALDER_NODE {
    using namespace param;
    NodeType n = cycles_bsdf_node("ShaderNodeBsdfDiffuse", "diffuse_bsdf", "matte surface: Lambert, or Oren–Nayar where rough");
    n.help = "Roughness follows Oren and Nayar in Fujii's form, with the light of several bounces put back.";
    n.params = {color("Color", 0.8, 0.8, 0.8), f("Roughness", 0).range(0, 1), normal_socket(), weight_socket()};
    n.globals = {Global::N};
    n.kernel = diffuse_bsdf_kernel();
    n.uses = all_but_weight;
    n.lobes = [](const Statics& s) -> std::vector<LobeSpec> {
        return {{.kind = LobeKind::Diffuse, .cycles_normal = true, .smooth = s.is_zero(1), .gates = {0}}};
    };
    return n;
}

ALDER_NODE {
    using namespace param;
    NodeType n = cycles_bsdf_node("ShaderNodeBsdfTranslucent", "translucent_bsdf", "matte transmission, as of a sheet of paper");
    n.params = {color("Color", 0.8, 0.8, 0.8), normal_socket(), weight_socket()};
    n.globals = {Global::N, Global::Ng, Global::I};
    n.kernel = translucent_bsdf_kernel();
    n.uses = all_but_weight;
    n.lobes = [](const Statics&) -> std::vector<LobeSpec> {
        return {{.kind = LobeKind::Translucent, .label = LobeLabel::Backlight, .cycles_normal = true, .gates = {0}}};
    };
    return n;
}

ALDER_NODE {
    using namespace param;
    NodeType n = cycles_bsdf_node("ShaderNodeBsdfSheen", "sheen_bsdf", "cloth-like reflection at grazing angles");
    n.aliases.push_back("ShaderNodeBsdfVelvet");
    n.params = {color("Color", 0.8, 0.8, 0.8), f("Roughness", 0.5).range(0, 1), normal_socket(), weight_socket(),
                choice("distribution", {{"ASHIKHMIN", "Ashikhmin", "ashikhmin"}, {"MICROFIBER", "Microfiber", "microfiber"}},
                       "MICROFIBER")};
    n.globals = {Global::N, Global::I};
    n.kernel = sheen_bsdf_kernel();
    n.uses = all_but_weight;
    n.lobes = [](const Statics& s) -> std::vector<LobeSpec> {
        if (s.e(4) == 0) return {{.kind = LobeKind::SheenAshikhmin, .gates = {0}}};
        return {{.kind = LobeKind::SheenMicrofiber, .cycles_normal = true, .gates = {0}}};
    };
    return n;
}

ALDER_NODE {
    using namespace param;
    NodeType n = cycles_bsdf_node("ShaderNodeBsdfToon", "toon_bsdf", "diffuse or glossy light in a hard or soft-edged disc");
    n.params = {color("Color", 0.8, 0.8, 0.8), f("Size", 0.5).range(0, 1), f("Smooth", 0).range(0, 1), normal_socket(),
                weight_socket(),
                choice("component", {{"DIFFUSE", "Diffuse", "diffuse"}, {"GLOSSY", "Glossy", "glossy"}}, "DIFFUSE")};
    n.globals = {Global::N};
    n.kernel = toon_bsdf_kernel();
    n.uses = all_but_weight;
    n.lobes = [](const Statics& s) -> std::vector<LobeSpec> {
        if (s.e(5) == 1) return {{.kind = LobeKind::ToonGlossy, .label = LobeLabel::Specular, .gates = {0}}};
        return {{.kind = LobeKind::ToonDiffuse, .cycles_normal = true, .gates = {0}}};
    };
    return n;
}
}  // namespace alder
#endif
