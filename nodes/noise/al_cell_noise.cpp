// alCellNoise: cellular features (F2 - F1) or randomly coloured chips. alshaders specification, section 4.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/noise/al_cell_noise.cpp"
#include "hwy/foreach_target.h"

#include "nodes/math/remap-inl.h"
#include "nodes/math/remap_params.h"
#include "nodes/noise/cell_chips-inl.h"
#include "nodes/noise/cell_hash-inl.h"
#include "nodes/noise/cellular-inl.h"

#ifndef ALDER_NODES_NOISE_AL_CELL_NOISE_
#define ALDER_NODES_NOISE_AL_CELL_NOISE_
namespace alder {
enum AlCellNoiseParam { kSpace, kFrequency, kMode, kOctaves, kRandomness, kLacunarity, kColor1, kColor2, kSmooth, kRandom, kChip1, kP = kChip1 + 10, kRemap };
constexpr int kMaxOctaves = 64;
}  // namespace alder
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Channels: frequency 0, octaves 1, randomness 2, lacunarity 3, colours 4, 7, smooth 10, random 11,
/// chips 12 + 4 i (colour, probability), P 32, remap 35.
struct CellFeatures {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const int octaves = k.statics().e(kOctaves);
        const Cellular<2, F> c = cellular<2>(k.v(32) * k.f(0), k.f(2), min(octaves, kMaxOctaves), k.f(3));
        const F n = (c.distance[1] - c.distance[0]) / F(octaves);
        k.set(0, lerp(k.v(4), k.v(7), al_remap(k, 35, n)));
    }
};
template <bool smooth>
struct CellChips {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Int<F> id = cellular<1>(k.v(32) * k.f(0), k.f(2)).id[0];
        Vec3<F> color[5];
        F probability[5];
        for (int i = 0; i < 5; ++i) color[i] = k.v(12 + 4 * i), probability[i] = k.f(15 + 4 * i);
        k.set(0, chip_color<smooth>(uint_to_unit<F>(id), color, probability));
    }
};
struct CellRandomChips {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Int<F> id = cellular<1>(k.v(32) * k.f(0), k.f(2)).id[0];
        k.set(0, vcell_noise3(Vec3<F>(to_float<F>(unsigned_divide_by_100<F>(id)), F(0), F(0))));
    }
};
template <class F>
void al_cell_noise(const Call<F>& c) {
    if (c.statics().e(kMode) == 0) return c.template each<CellFeatures>();
    if (c.statics().e(kRandom)) return c.template each<CellRandomChips>();
    if (c.statics().e(kSmooth)) return c.template each<CellChips<true>>();
    c.template each<CellChips<false>>();
}
ALDER_KERNEL(al_cell_noise)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "nodes/noise/pattern_point.h"

namespace alder {
ALDER_KERNEL_EXPORT(al_cell_noise)

static bool cell_noise_uses(const Statics& s, int param) {
    const bool chips = s.e(kMode) == 1, chosen = chips && !s.e(kRandom);
    switch (param) {
        case kSpace: case kP: return pattern_point_uses(s, param, kSpace, kP);
        case kMode: case kFrequency: case kRandomness: return true;
        case kRandom: return chips;
        case kSmooth: return chosen;
        case kOctaves: case kColor1: case kColor2: return !chips;
        case kLacunarity: return !chips && s.e(kOctaves) > 1;
        default: return param < kP ? chosen : !chips;
    }
}
static void lower_cell_noise(Lowering& l, int) { lower_at_pattern_point(l, kSpace, kP); }

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alCellNoise";
    n.system = System::AlShaders;
    n.category = "pattern";
    n.summary = "cellular features or chips";
    n.help = "features: the difference of the distances to the second nearest and the nearest feature point, averaged over the octaves (at most 64), "
             "remapped, between the two colours. chips: each cell one of five colours, by probability, or a colour of its own. The feature points "
             "are ours: Arnold's are not public. Single against double precision, unclamped, median (99 % of points): features 2e-8 (8e-8) out to 1e6; "
             "0.05 (0.3) at frequency 1e5, where the product is rounded before cells are found.";
    n.params = {pattern_space_param("world"),
                f("frequency", 1).range(0, 10).doc("multiplies the point: cells a unit"),
                choice("mode", {"features", "chips"}, "features").doc("what is shown"),
                i("octaves", 1).range(1, 8).no_link().in("Features").doc("number of frequencies averaged"),
                f("randomness", 1).range(0, 1).doc("0 is a regular grid; 1 scatters each feature over its whole cell; 2 is the most"),
                f("lacunarity", 2.121).range(1, 4).in("Features").doc("frequency from one octave to the next"),
                color("color1", 0, 0, 0).in("Features").doc("colour at 0 after the remap"),
                color("color2", 1, 1, 1).in("Features").doc("colour at 1"),
                b("smoothChips", false).no_link().in("Chips").doc("blend from each chip colour to the next"),
                b("randomChips", false).no_link().in("Chips").doc("random colours in place of the five; ids are grouped in hundreds")};
    const double chip[5][3] = {{0.383, 0.318, 0.252}, {0.383, 0.191, 0.01}, {0.635, 0.612, 0.563}, {0.509, 0.361, 0.213}, {0.593, 0.472, 0.248}};
    for (int i = 0; i < 5; ++i) {
        const std::string number = std::to_string(i + 1);
        n.params.push_back(color("chipColor" + number, chip[i][0], chip[i][1], chip[i][2]).in("Chips").doc("colour of a chip"));
        n.params.push_back(f("chipProb" + number, 1).range(0, 1).no_link().in("Chips").doc("how often, relative to the others"));
    }
    n.params.push_back(pattern_point_param());
    add_remap_params(n.params);
    n.outputs = {{"out", Type::Color}};
    n.kernel = al_cell_noise_kernel();
    n.cost_ns = 60;
    n.uses = cell_noise_uses;
    n.lower = lower_cell_noise;
    return n;
}
}  // namespace alder
#endif
