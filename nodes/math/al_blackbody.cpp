// alBlackbody: colour of a glowing body, from Planck's law. alshaders specification, section 2.
// Colour matching functions: CIE 1931 2-degree observer, 380 ... 780 nm by 5 nm.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/math/al_blackbody.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/math/finite-inl.h"

#ifndef ALDER_NODES_MATH_AL_BLACKBODY_
#define ALDER_NODES_MATH_AL_BLACKBODY_
namespace alder {
constexpr int kMaxKelvin = 15000;
/// Rec.709 chromaticity by whole kelvin, before x + y + z = 1 is scaled.
struct BlackbodyTable : Prepared {
    std::vector<float> rgb[3];
};
}  // namespace alder
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct AlBlackbody {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const BlackbodyTable& table = static_cast<const BlackbodyTable&>(*k.statics().prepared);
        const F temperature = max(F(0), k.f(0)), strength = k.f(1), physical = k.f(2), exposure = k.f(3);   // NaN is 0 too
        const Int<F> kelvin = to_int(min(temperature, F(kMaxKelvin)));
        // Stefan and Boltzmann: T^4·5.67e-8·2^exposure. The exposure goes under the fourth power, so that nothing overflows early.
        const F power = finite_or_limit(sqr(sqr(temperature * exp2(F(0.25) * exposure))) * F(5.67e-8));
        const F scale = finite_or_limit(select(physical > F(0), lerp(F(1), power, physical), F(1)) * strength);
        for (int i = 0; i < 3; ++i) k.set(i, gather<F>(table.rgb[i].data(), kelvin) * scale);
    }
};
template <class F>
void al_blackbody(const Call<F>& c) { c.template each<AlBlackbody>(); }
ALDER_KERNEL(al_blackbody)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(al_blackbody)

static const double kMatching[81][3] = {
    {0.0014, 0.0000, 0.0065}, {0.0022, 0.0001, 0.0105}, {0.0042, 0.0001, 0.0201}, {0.0076, 0.0002, 0.0362}, {0.0143, 0.0004, 0.0679},
    {0.0232, 0.0006, 0.1102}, {0.0435, 0.0012, 0.2074}, {0.0776, 0.0022, 0.3713}, {0.1344, 0.0040, 0.6456}, {0.2148, 0.0073, 1.0391},
    {0.2839, 0.0116, 1.3856}, {0.3285, 0.0168, 1.6230}, {0.3483, 0.0230, 1.7471}, {0.3481, 0.0298, 1.7826}, {0.3362, 0.0380, 1.7721},
    {0.3187, 0.0480, 1.7441}, {0.2908, 0.0600, 1.6692}, {0.2511, 0.0739, 1.5281}, {0.1954, 0.0910, 1.2876}, {0.1421, 0.1126, 1.0419},
    {0.0956, 0.1390, 0.8130}, {0.0580, 0.1693, 0.6162}, {0.0320, 0.2080, 0.4652}, {0.0147, 0.2586, 0.3533}, {0.0049, 0.3230, 0.2720},
    {0.0024, 0.4073, 0.2123}, {0.0093, 0.5030, 0.1582}, {0.0291, 0.6082, 0.1117}, {0.0633, 0.7100, 0.0782}, {0.1096, 0.7932, 0.0573},
    {0.1655, 0.8620, 0.0422}, {0.2257, 0.9149, 0.0298}, {0.2904, 0.9540, 0.0203}, {0.3597, 0.9803, 0.0134}, {0.4334, 0.9950, 0.0087},
    {0.5121, 1.0000, 0.0057}, {0.5945, 0.9950, 0.0039}, {0.6784, 0.9786, 0.0027}, {0.7621, 0.9520, 0.0021}, {0.8425, 0.9154, 0.0018},
    {0.9163, 0.8700, 0.0017}, {0.9786, 0.8163, 0.0014}, {1.0263, 0.7570, 0.0011}, {1.0567, 0.6949, 0.0010}, {1.0622, 0.6310, 0.0008},
    {1.0456, 0.5668, 0.0006}, {1.0026, 0.5030, 0.0003}, {0.9384, 0.4412, 0.0002}, {0.8544, 0.3810, 0.0002}, {0.7514, 0.3210, 0.0001},
    {0.6424, 0.2650, 0.0000}, {0.5419, 0.2170, 0.0000}, {0.4479, 0.1750, 0.0000}, {0.3608, 0.1382, 0.0000}, {0.2835, 0.1070, 0.0000},
    {0.2187, 0.0816, 0.0000}, {0.1649, 0.0610, 0.0000}, {0.1212, 0.0446, 0.0000}, {0.0874, 0.0320, 0.0000}, {0.0636, 0.0232, 0.0000},
    {0.0468, 0.0170, 0.0000}, {0.0329, 0.0119, 0.0000}, {0.0227, 0.0082, 0.0000}, {0.0158, 0.0057, 0.0000}, {0.0114, 0.0041, 0.0000},
    {0.0081, 0.0029, 0.0000}, {0.0058, 0.0021, 0.0000}, {0.0041, 0.0015, 0.0000}, {0.0029, 0.0010, 0.0000}, {0.0020, 0.0007, 0.0000},
    {0.0014, 0.0005, 0.0000}, {0.0010, 0.0004, 0.0000}, {0.0007, 0.0002, 0.0000}, {0.0005, 0.0002, 0.0000}, {0.0003, 0.0001, 0.0000},
    {0.0002, 0.0001, 0.0000}, {0.0002, 0.0001, 0.0000}, {0.0001, 0.0000, 0.0000}, {0.0001, 0.0000, 0.0000}, {0.0001, 0.0000, 0.0000},
    {0.0000, 0.0000, 0.0000},
};

/// XYZ to the RGB of three primaries, the white having Y = 1.
static std::array<double, 9> xyz_to_rec709() {
    const double x[3] = {0.64, 0.30, 0.15}, y[3] = {0.33, 0.60, 0.06}, white[2] = {0.3127, 0.3291};
    double m[3][3];   // columns: XYZ of the primaries at Y = 1
    for (int i = 0; i < 3; ++i) m[0][i] = x[i] / y[i], m[1][i] = 1, m[2][i] = (1 - x[i] - y[i]) / y[i];
    const auto cofactor = [&](int r, int c) {
        const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
        return m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
    };
    const double det = m[0][0] * cofactor(0, 0) + m[0][1] * cofactor(0, 1) + m[0][2] * cofactor(0, 2);
    const double w[3] = {white[0] / white[1], 1, (1 - white[0] - white[1]) / white[1]};
    std::array<double, 9> out;
    for (int i = 0; i < 3; ++i) {
        double luminance = 0;   // of primary i in the white
        for (int j = 0; j < 3; ++j) luminance += cofactor(j, i) / det * w[j];
        for (int j = 0; j < 3; ++j) out[3 * i + j] = cofactor(j, i) / det / luminance;
    }
    return out;
}

static std::shared_ptr<const BlackbodyTable> build_table() {
    auto table = std::make_shared<BlackbodyTable>();
    const auto to_rgb = xyz_to_rec709();
    for (auto& channel : table->rgb) channel.resize(kMaxKelvin + 1);
    for (int kelvin = 0; kelvin <= kMaxKelvin; ++kelvin) {
        float xyz[3] = {0, 0, 0};   // in float, as in the original: below some 100 kelvin they vanish
        for (int i = 0; i < 81; ++i) {
            const double metres = (380 + 5 * i) * 1e-9;
            const float radiance = static_cast<float>(3.74183e-16 * std::pow(metres, -5) / (std::exp(1.4388e-2 / (metres * kelvin)) - 1));
            for (int j = 0; j < 3; ++j) xyz[j] += radiance * static_cast<float>(kMatching[i][j]);
        }
        const float sum = xyz[0] + xyz[1] + xyz[2];
        for (int i = 0; i < 3; ++i) {
            const double c = to_rgb[3 * i] * (xyz[0] / sum) + to_rgb[3 * i + 1] * (xyz[1] / sum) + to_rgb[3 * i + 2] * (xyz[2] / sum);
            table->rgb[i][kelvin] = c > 0 ? static_cast<float>(c) : 0;   // NaN where the sums vanish: 0
        }
    }
    return table;
}
static std::shared_ptr<const Prepared> shared_table(const Statics&, std::vector<std::string>&) {
    static const auto table = build_table();   // 15 ms, once a process, when the first such node is compiled
    return table;
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alBlackbody";
    n.system = System::AlShaders;
    n.category = "color";
    n.summary = "Planck spectrum at a temperature turned into Rec.709 chromaticity, optionally scaled by radiant power";
    n.help = "The chromaticity (x + y + z = 1) is stepped in whole kelvin up to 15000; temperatures below 0 count as 0.";
    n.params = {f("temperature", 1000).range(273, 16000).doc("kelvin"), f("strength", 1).range(0, 10).doc("multiplies the result"),
                f("physicalIntensity", 1).range(0, 1).in("Advanced").doc("0 is chromaticity alone, 1 radiant power after Stefan and Boltzmann"),
                f("physicalExposure", -20).range(-30, 0).in("Advanced").doc("radiant power is multiplied by 2^physicalExposure")};
    n.outputs = {{"out", Type::Color}};
    n.kernel = al_blackbody_kernel();
    n.cost_ns = 3;
    n.prepare = shared_table;
    return n;
}
}  // namespace alder
#endif
