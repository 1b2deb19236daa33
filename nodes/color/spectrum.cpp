// Blackbody and Wavelength: the colour of a glowing body, and of light of one wavelength (Blender's nodes).
// Blackbody: Cycles' fit in Rec.709, per band of temperature a/T + b T + c for red and green, a cubic for blue.
// Wavelength: CIE 1931 2 degree observer at 5 nm, to linear sRGB (IEC 61966-2-1), divided by 2.52 so that no component exceeds 1.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/color/spectrum.cpp"
#include "hwy/foreach_target.h"

#include "nodes/color/blackbody-inl.h"
#include "nodes/math/cycles-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct Blackbody {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> c = blackbody_rec709(k.f(0));
        for (int i = 0; i < 3; ++i) k.set(i, second_max(c[i], F(0)));
    }
};
struct Wavelength {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        using I = Int<F>;
        const F position = (k.f(0) - F(380)) * F(0.2);
        const I whole = to_int(position), i = min(max(whole, I(0)), I(kObserverSamples - 2));
        const F t = position - to_float<F>(i);
        const Mask<F> outside = (whole < I(0)) | (whole >= I(kObserverSamples - 1));
        Vec3<F> xyz;
        for (int c = 0; c < 3; ++c) {
            const F a = gather<F>(kObserver, i + i + i + I(c)), b = gather<F>(kObserver, i + i + i + I(c + 3));
            xyz[c] = select(outside, F(0), fused(t, b - a, a));
        }
        for (int c = 0; c < 3; ++c)
            k.set(c, second_max((F(kXyzToRgb[c][0]) * xyz.x + F(kXyzToRgb[c][1]) * xyz.y + F(kXyzToRgb[c][2]) * xyz.z) * F(1 / 2.52), F(0)));
    }
};
template <class F>
void blackbody(const Call<F>& c) { c.template each<Blackbody>(); }
template <class F>
void wavelength(const Call<F>& c) { c.template each<Wavelength>(); }
ALDER_KERNEL(blackbody)
ALDER_KERNEL(wavelength)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(blackbody)
ALDER_KERNEL_EXPORT(wavelength)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeBlackbody";
    n.category = "Converter";
    n.summary = "the colour of a body that glows at a temperature";
    n.help = "Kelvin, limited to 800 ... 12000. Luminance is not that of a black body: it is about 1 throughout.";
    n.aliases = {"blackbody"};
    n.params.push_back(f("Temperature", 1500).range(800, 12000).doc("kelvin"));
    n.outputs = {{"Color", Type::Color}};
    n.kernel = blackbody_kernel();
    n.cost_ns = 5;
    return n;
}
ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeWavelength";
    n.category = "Converter";
    n.summary = "the colour of light of one wavelength";
    n.help = "Nanometres; black outside 380 ... 780.";
    n.aliases = {"wavelength"};
    n.params.push_back(f("Wavelength", 500).range(380, 780).doc("nanometres"));
    n.outputs = {{"Color", Type::Color}};
    n.kernel = wavelength_kernel();
    n.cost_ns = 5;
    return n;
}
}  // namespace alder
#endif
