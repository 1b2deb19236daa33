// IES Texture: how strongly a lamp shines in a direction, from a profile that its maker measured. Follows Cycles' SVM.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/texture/tex_ies.cpp"
#include "hwy/foreach_target.h"

#include "nodes/input/space-inl.h"
#include "nodes/math/cycles-inl.h"
#include "nodes/texture/ies_profile.h"
#include "nodes/texture/texture_mapping-inl.h"

#ifndef ALDER_TEX_IES_PREPARED
#define ALDER_TEX_IES_PREPARED
namespace alder {
struct PreparedIes : PreparedTexture {
    std::shared_ptr<const IesProfile> profile;  ///< null: none chosen
};
}  // namespace alder
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

namespace tex_ies {
enum Parameter { kMapping, kIes, kFilePath, kMode, kVector, kStrength };
enum Channel { kVectorIn = 0, kStrengthIn = 3 };
constexpr float kPi = 3.141592653589793f, kTwoPi = 6.283185307179586f;

/// Catmull-Rom spline from b (x = 0) to c (x = 1).
template <class F>
HWY_INLINE F cubic(F a, F b, F c, F d, F x) {
    return F(0.5) * (((d + F(3) * (b - c) - a) * x + (F(2) * a - F(5) * b + F(4) * c - d)) * x + (c - a)) * x + b;
}

/// The interval of `angles` that holds x and the position in it. bound[1 ... last] ascends.
template <class F>
HWY_INLINE void find(const std::vector<float>& angles, const std::vector<float>& bound, F x, Int<F>& index, F& fraction) {
    using I = Int<F>;
    const int last = static_cast<int>(angles.size()) - 1;
    I lo(0), hi(last > 1 ? last - 1 : 0);  // the first i with bound[i + 1] >= x
    for (int width = last; width > 0; width >>= 1) {
        const I mid = sar<1>(lo + hi);
        const Mask<F> below = gather<F>(bound.data(), min(mid + I(1), I(last))) < x;
        lo = select(below & (lo < hi), mid + I(1), lo);
        hi = select(below, hi, mid);
    }
    index = min(max(lo, I(0)), I(last > 0 ? last - 1 : 0));
    const F a = gather<F>(angles.data(), index), b = gather<F>(angles.data(), min(index + I(1), I(last)));
    fraction = (x - a) / (b - a);
}

/// Along the vertical angles at row h. Beyond the poles the row goes on mirrored, which is right for symmetric lights.
template <class F>
HWY_INLINE F vertical(const IesProfile& p, Int<F> h, Int<F> v, F fraction) {
    using I = Int<F>;
    const int count = static_cast<int>(p.vertical.size()), last = count - 1;
    const bool wrap_low = p.vertical[0] < 1e-7f, wrap_high = p.vertical[last] > kPi - 1e-7f;
    const I row = h * I(count);
    const float* const table = p.intensity.data();
    F a = gather<F>(table, row + select(v > I(0), v - I(1), I(last < 1 ? last : 1)));
    if (!wrap_low) a = select(v > I(0), a, F(0));
    const F b = gather<F>(table, row + v), c = gather<F>(table, row + min(v + I(1), I(last)));
    const Mask<F> inside = v + I(2) < I(count);
    F d = gather<F>(table, row + select(inside, min(v + I(2), I(last)), I(count > 1 ? count - 2 : 0)));
    if (!wrap_high) d = select(inside, d, F(0));
    return cubic(a, b, c, d, fraction);
}

template <class F>
HWY_INLINE F intensity(const IesProfile& p, F h_angle, F v_angle) {
    using I = Int<F>;
    const int h_last = static_cast<int>(p.horizontal.size()) - 1, v_last = static_cast<int>(p.vertical.size()) - 1;
    const Mask<F> covered = (v_angle >= F(p.vertical[0])) & (v_angle < F(p.vertical[v_last])) &
                            (h_angle >= F(p.horizontal[0])) & (h_angle < F(p.horizontal[h_last]));
    if (!any(covered)) return F(0);
    // As Cycles has it: 360 degrees in 32-bit radians are not above this bound, so profiles end at 0 and 360 with zeros beyond.
    const bool wrap = p.horizontal[0] < 1e-7f && p.horizontal[h_last] > kTwoPi - 1e-7f;
    I h, v;
    F h_fraction, v_fraction;
    find(p.horizontal, p.horizontal_bound, h_angle, h, h_fraction);
    find(p.vertical, p.vertical_bound, v_angle, v, v_fraction);
    // The last row equals the first where the profile goes all round.
    const I before = select(h > I(0), h - I(1), I(h_last > 0 ? h_last - 1 : 0));
    const Mask<F> more = h + I(2) < I(h_last + 1);
    const I after = select(more, h + I(2), I(h_last < 1 ? h_last : 1));
    F a = vertical(p, before, v, v_fraction), d = vertical(p, after, v, v_fraction);
    if (!wrap) {
        a = select(h > I(0), a, F(0));
        d = select(more, d, F(0));
    }
    const F b = vertical(p, h, v, v_fraction), c = vertical(p, min(h + I(1), I(h_last)), v, v_fraction);
    return select(covered, second_max(cubic(a, b, c, d, h_fraction), F(0)), F(0));
}
}  // namespace tex_ies

struct TexIes {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        using namespace tex_ies;
        const auto* const prepared = static_cast<const PreparedIes*>(k.statics().prepared.get());
        const Vec3<F> d = normalize(mapped_vector(k, kVectorIn));
        const F strength = k.f(kStrengthIn);
        if (!prepared || !prepared->profile) return k.set(0, strength * F(100));
        k.set(0, strength * intensity(*prepared->profile, atan2(d.x, d.y) + F(kPi), safe_acos(-d.z)));
    }
};
/// The direction in which the light leaves, in the lamp's space. Channels: I 0, columns of object to world 3.
struct LeavingLight {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) { k.set(0, safe_normalize(matrix3(k, 3).transposed(k.v(0)))); }
};
template <class F>
void tex_ies_kernel(const Call<F>& c) { c.template each<TexIes>(); }
template <class F>
void leaving_light(const Call<F>& c) { c.template each<LeavingLight>(); }
ALDER_KERNEL(tex_ies_kernel)
ALDER_KERNEL(leaving_light)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "graph/lowering.h"

namespace alder {
ALDER_KERNEL_EXPORT(tex_ies_kernel)
ALDER_KERNEL_EXPORT(leaving_light)
namespace p = HWY_NAMESPACE::tex_ies;

static std::shared_ptr<const Prepared> prepare_ies(const Statics& s, std::vector<std::string>& errors) {
    auto ies = std::make_shared<PreparedIes>();
    ies->mapping = parse_texture_mapping(s.text[p::kMapping], errors);
    const int source = s.e(p::kMode) == 0 ? p::kIes : p::kFilePath;
    std::string fault;
    ies->profile = load_ies(s.text[source], fault);
    if (!fault.empty()) errors.push_back(s.type->params[source].name + ": " + fault);
    return ies;
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeTexIES";
    n.aliases = {"ies_light"};
    n.system = System::Cycles;
    n.category = "texture";
    n.summary = "the strength of a lamp by direction, from an IES profile";
    n.help = "IES LM-63 files of photometric types A, B and C, in watts; straight down (-Z) is 0 degrees. Without a profile: 100 in every direction.";
    Param ies = image("ies"), path = image("filepath");
    ies.items = {{"text", "Text", ""}};
    n.params = {
        texture_mapping_param(),
        ies.doc("the profile: {\"text\": ...}, {\"file\": NAME}, {\"asset\": ...} or its text as a string"),
        path.alias("filename").doc("the profile's file, with Source External"),
        choice("mode", {{"INTERNAL", "Internal", ""}, {"EXTERNAL", "External", ""}}, "INTERNAL").doc("which of the two is read"),
        vector("Vector", 0, 0, 0).doc("direction of the light in the lamp's space; unlinked: from the lamp to what it lights"),
        f("Strength", 1).range(0, 1000000).doc("multiplies the profile"),
    };
    n.outputs = {{"Fac", Type::Float}};
    n.kernel = tex_ies_kernel_kernel();
    n.cost_ns = 60;
    n.uses = [](const Statics& s, int param) {
        if (param == p::kIes) return s.e(p::kMode) == 0;
        if (param == p::kFilePath) return s.e(p::kMode) == 1;
        return true;
    };
    n.prepare = prepare_ies;
    n.lower = [](Lowering& l, int output) {
        ValueRef direction = l.input(p::kVector);
        if (!l.linked(p::kVector) && l.statics().is_default(p::kVector)) {
            const ValueRef operands[] = {l.global(Global::I), l.global(Global::ObjectToWorldX), l.global(Global::ObjectToWorldY), l.global(Global::ObjectToWorldZ)};
            direction = l.op("leaving_light", leaving_light_kernel(), operands, Type::Vector);
        }
        const ValueRef operands[] = {direction, l.input(p::kStrength)};
        l.result(l.call(operands, output));
    };
    return n;
}
}  // namespace alder
#endif
