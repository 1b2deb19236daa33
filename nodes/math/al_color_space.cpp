// alColorSpace: sRGB, Cineon or LogC values to linear. alshaders specification, section 2.
// Curves: IEC 61966-2-1 (sRGB); Kodak, "Conversion of 10-bit Log Film Data to 8-bit Linear", 1995 (Cineon); ARRI LogC, EI 800.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/math/al_color_space.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct FromSrgb {
    template <class F>
    static HWY_INLINE F linear(F c) {
        const F curve = pow((max(c, F(0)) + F(0.055)) / F(1.055), F(2.4));
        return select(c > F(1), c, select(c <= F(0.04045), c / F(12.92), curve));
    }
};
struct FromCineon {
    template <class F>
    static HWY_INLINE F linear(F c) {
        // Reference white 685 and black 95 of 1023; 0.002 density a step, gamma 0.6.
        constexpr double kStep = 0.002 / 0.6;
        constexpr double kBlack = 0.0107977516232771;   // 10^((95 - 685)·0.002/0.6)
        constexpr double kGain = 1.0 / (1.0 - kBlack);
        return max(F(0), pow(F(10), (F(1023) * c - F(685)) * F(kStep)) * F(kGain) - (F(kGain) - F(1)));
    }
};
struct FromLogC {
    template <class F>
    static HWY_INLINE F linear(F c) {
        const F curve = (pow(F(10), (c - F(0.385537)) / F(0.2471896)) - F(0.052272)) / F(5.555556);
        return select(c > F(0.1496582), curve, (c - F(0.092809)) / F(5.367655));
    }
};
template <class Curve>
struct AlColorSpace {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        for (int i = 0; i < 3; ++i) k.set(i, Curve::linear(k.f(i)));
    }
};
template <class F>
void al_color_space(const Call<F>& c) {
    switch (c.statics().e(1)) {
        case 1: return c.template each<AlColorSpace<FromCineon>>();
        case 2: return c.template each<AlColorSpace<FromLogC>>();
        default: return c.template each<AlColorSpace<FromSrgb>>();
    }
}
ALDER_KERNEL(al_color_space)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(al_color_space)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alColorSpace";
    n.system = System::AlShaders;
    n.category = "color";
    n.summary = "sRGB, Cineon or LogC values to linear";
    n.help = "sRGB leaves values above 1; Cineon (white 685, black 95) never goes below 0.";
    n.params = {color("input", 0, 0, 0).doc("encoded colour"),
                choice("sourceSpace", {"sRGB", "Cineon", "LogC"}, "sRGB").doc("how the input is encoded")};
    n.outputs = {{"out", Type::Color}};
    n.kernel = al_color_space_kernel();
    n.cost_ns = 8;
    return n;
}
}  // namespace alder
#endif
