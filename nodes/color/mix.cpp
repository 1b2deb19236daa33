// Mix and Mix (Legacy): blends two numbers, vectors or colours by a factor, colours in one of 19 modes (Blender's nodes).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/color/mix.cpp"
#include "hwy/foreach_target.h"

#include "nodes/color/blend_modes.h"
#include "nodes/color/color-inl.h"
#include "nodes/kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

// Channels of ShaderNodeMix: Factor_Float 0, Factor_Vector 1, A_Float 4, B_Float 5, A_Vector 6, B_Vector 9, A_Color 12, B_Color 15.
// An input that the factor switches off may not have been evaluated and hold anything: it is replaced before it is used.

// Clamping is asked of the statics in the loop and not made a template parameter: 19 modes times four variants are slow to compile
// and the branch costs nothing measurable.

template <class F>
HWY_INLINE F mix_factor(F t, bool clamped) { return clamped ? cycles_saturate(t) : t; }

/// Numbers and vectors: a (1 - t) + b t.
template <class F>
HWY_INLINE F mix_number(F a, F b, F t, bool clamped) {
    const F layer = select(t == F(0), a, b);
    const F base = clamped ? select(t >= F(1), b, a) : a;
    return base * (F(1) - t) + layer * t;
}
template <class Op, class F>
HWY_INLINE Vec3<F> mix_color(Vec3<F> a, Vec3<F> b, F t, bool clamped) {
    const Vec3<F> layer = select<F>(t == F(0), a, b);
    if constexpr (std::is_same_v<Op, BlendMix>)
        if (clamped) return Op::mix(select<F>(t >= F(1), b, a), layer, t);
    return Op::mix(a, layer, t);
}

enum MixParam { kDataType = 10, kFactorMode, kBlendType, kClampFactor, kClampResult };

struct MixFloat {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const bool clamped = k.statics().e(kClampFactor) != 0;
        k.set(0, mix_number(k.f(4), k.f(5), mix_factor(k.f(0), clamped), clamped));
    }
};
struct MixVector {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const bool clamped = k.statics().e(kClampFactor) != 0;
        const F t = mix_factor(k.f(0), clamped);
        for (int i = 0; i < 3; ++i) k.set(1 + i, mix_number(k.f(6 + i), k.f(9 + i), t, clamped));
    }
};
struct MixVectorNonUniform {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        for (int i = 0; i < 3; ++i) {
            const F t = mix_factor(k.f(1 + i), k.statics().e(kClampFactor) != 0);
            k.set(1 + i, k.f(6 + i) * (F(1) - t) + k.f(9 + i) * t);
        }
    }
};
template <class Op>
struct MixColor {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const bool clamped = k.statics().e(kClampFactor) != 0;
        const Vec3<F> c = mix_color<Op>(k.v(12), k.v(15), mix_factor(k.f(0), clamped), clamped);
        k.set(4, k.statics().e(kClampResult) ? cycles_saturate(c) : c);
    }
};
template <class Op>
struct MixRgb {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> c = mix_color<Op>(k.v(1), k.v(4), cycles_saturate(k.f(0)), true);
        k.set(0, k.statics().e(4) ? cycles_saturate(c) : c);
    }
};
template <int first, int count>
struct Zero {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        for (int i = 0; i < count; ++i) k.set(first + i, F(0));
    }
};

template <class F>
void mix_color_dispatch(const Call<F>& c) {
    int index = 0;
    const int mode = c.statics().e(kBlendType);
#define X(ID, label, cycles, Op) \
    if (mode == index++) return c.template each<MixColor<Op>>();
    ALDER_BLEND_MODES(X)
#undef X
}
template <class F>
void mix_node(const Call<F>& c) {
    switch (c.statics().e(kDataType)) {
        case 0:
            c.template each<Zero<1, 6>>();
            return c.template each<MixFloat>();
        case 1:
            c.template each<Zero<0, 1>>();
            c.template each<Zero<4, 3>>();
            return c.statics().e(kFactorMode) ? c.template each<MixVectorNonUniform>() : c.template each<MixVector>();
        case 2:
            c.template each<Zero<0, 4>>();
            return mix_color_dispatch(c);
        default: return c.template each<Zero<0, 7>>();  // refused by check()
    }
}
ALDER_KERNEL(mix_node)

template <class F>
void mix_rgb(const Call<F>& c) {
    int index = 0;
    const int mode = c.statics().e(3);
#define X(ID, label, cycles, Op) \
    if (mode == index++) return c.template each<MixRgb<Op>>();
    ALDER_BLEND_MODES(X)
#undef X
}
ALDER_KERNEL(mix_rgb)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(mix_node)
ALDER_KERNEL_EXPORT(mix_rgb)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeMix";
    n.category = "Converter";
    n.summary = "blends two numbers, vectors or colours by a factor";
    n.help = "With a clamped factor B is not evaluated where the factor is 0, nor A, in the Mix mode, where it is 1.";
    n.params.push_back(f("Factor_Float", 0.5).range(0, 1));
    n.params.push_back(vector("Factor_Vector", 0.5, 0.5, 0.5).range(0, 1));
    n.params.push_back(f("A_Float", 0).range(-10000, 10000));
    n.params.push_back(f("B_Float", 0).range(-10000, 10000));
    n.params.push_back(vector("A_Vector", 0, 0, 0));
    n.params.push_back(vector("B_Vector", 0, 0, 0));
    n.params.push_back(color("A_Color", 0.5, 0.5, 0.5));
    n.params.push_back(color("B_Color", 0.5, 0.5, 0.5));
    n.params.push_back(vector("A_Rotation", 0, 0, 0).doc("not available in shaders"));
    n.params.push_back(vector("B_Rotation", 0, 0, 0).doc("not available in shaders"));
    n.params.push_back(choice("data_type", std::vector<Item>{{"FLOAT", "Float", ""}, {"VECTOR", "Vector", ""}, {"RGBA", "Color", ""}, {"ROTATION", "Rotation", ""}}, "FLOAT"));
    n.params.push_back(choice("factor_mode", std::vector<Item>{{"UNIFORM", "Uniform", ""}, {"NON_UNIFORM", "Non-Uniform", ""}}, "UNIFORM"));
    n.params.push_back(blend_type_param());
    n.params.push_back(b("clamp_factor", true).no_link());
    n.params.push_back(b("clamp_result", false).no_link());
    n.outputs = {{"Result_Float", Type::Float}, {"Result_Vector", Type::Vector}, {"Result_Color", Type::Color}};
    n.kernel = mix_node_kernel();
    n.cost_ns = 3;
    n.uses = [](const Statics& s, int param) {
        const int type = s.e(10);
        const bool non_uniform = type == 1 && s.e(11) == 1;
        switch (param) {
            case 0: return type != 3 && !non_uniform;
            case 1: return non_uniform;
            case 2: case 3: return type == 0;
            case 4: case 5: return type == 1;
            case 6: case 7: return type == 2;
            case 8: case 9: return false;
            case 11: return type == 1;
            case 12: case 14: return type == 2;
            default: return true;
        }
    };
    n.lazy = [](const Statics& s) {
        std::vector<LazyRule> rules;
        const int type = s.e(10);
        if (type > 2 || (type == 1 && s.e(11) == 1)) return rules;
        const int a = 2 + 2 * type, layer = a + 1;
        const bool clamped = s.e(13) != 0;
        rules.push_back({layer, 0, clamped ? LazyRule::NeededIfPositive : LazyRule::NeededIfNonZero});
        if (clamped && (type != 2 || s.e(12) == 0)) rules.push_back({a, 0, LazyRule::NeededIfBelowOne});
        return rules;
    };
    n.check = [](const Statics& s, const std::vector<const double*>&, std::vector<std::string>& errors) {
        if (s.e(10) == 3) errors.push_back("data_type: rotations are not available in shaders");
    };
    return n;
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeMixRGB";
    n.category = "Color";
    n.summary = "blends two colours by a factor (older form of Mix)";
    n.help = "The factor is limited to 0 ... 1. use_alpha has no effect.";
    n.aliases = {"mix"};
    n.params.push_back(f("Fac", 0.5).range(0, 1));
    n.params.push_back(color("Color1", 0.5, 0.5, 0.5));
    n.params.push_back(color("Color2", 0.5, 0.5, 0.5));
    n.params.push_back(blend_type_param().alias("mix_type"));
    n.params.push_back(b("use_clamp", false).no_link().doc("limit the result to 0 ... 1"));
    n.params.push_back(b("use_alpha", false).no_link().doc("no effect"));
    n.outputs = {{"Color", Type::Color}};
    n.kernel = mix_rgb_kernel();
    n.cost_ns = 3;
    n.uses = [](const Statics&, int param) { return param != 5; };
    n.lazy = [](const Statics& s) {
        std::vector<LazyRule> rules{{2, 0, LazyRule::NeededIfPositive}};
        if (s.e(3) == 0) rules.push_back({1, 0, LazyRule::NeededIfBelowOne});
        return rules;
    };
    return n;
}
}  // namespace alder
#endif
