// alPattern: sine, square or saw bands across one axis. alshaders specification, section 4.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/texture/al_pattern.cpp"
#include "hwy/foreach_target.h"

#include "nodes/math/remap-inl.h"
#include "nodes/math/remap_params.h"

#ifndef ALDER_NODES_TEXTURE_AL_PATTERN_
#define ALDER_NODES_TEXTURE_AL_PATTERN_
namespace alder {
enum AlPatternParam { kSpace, kAxis, kShape, kFrequency, kOffset, kColor1, kColor2, kP, kRemap };
}
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct Sine {
    template <class F>
    static HWY_INLINE F wave(F x) { return sin(x); }   // -1 ... 1: the default clamp cuts its lower half
};
struct Square {
    template <class F>
    static HWY_INLINE F wave(F x) { return select(sin(x) > F(0), F(1), F(0)); }
};
struct Saw {
    template <class F>
    static HWY_INLINE F wave(F x) {
        const F r = fmod(F(0.25) * x, F(1));
        return select(r < F(0), r + F(1), r);
    }
};
/// Channels: frequency 0, offset 1, colours 2, 5, P 8, remap 11.
template <class Shape>
struct AlPattern {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const F x = k.f(8 + k.statics().e(kAxis)) * k.f(0) + k.f(1);
        k.set(0, lerp(k.v(2), k.v(5), al_remap(k, 11, Shape::wave(x))));
    }
};
template <class F>
void al_pattern(const Call<F>& c) {
    switch (c.statics().e(kShape)) {
        case 1: return c.template each<AlPattern<Square>>();
        case 2: return c.template each<AlPattern<Saw>>();
        default: return c.template each<AlPattern<Sine>>();
    }
}
ALDER_KERNEL(al_pattern)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "nodes/noise/pattern_point.h"

namespace alder {
ALDER_KERNEL_EXPORT(al_pattern)

static bool pattern_uses(const Statics& s, int param) { return pattern_point_uses(s, param, kSpace, kP); }
static void lower_pattern(Lowering& l, int) { lower_at_pattern_point(l, kSpace, kP); }

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alPattern";
    n.system = System::AlShaders;
    n.category = "pattern";
    n.summary = "sine, square or saw bands";
    n.help = "The sine runs from -1 to 1, so that the default clamp cuts its lower half; the saw has a period of 4.";
    n.params = {pattern_space_param("world"), choice("axis", {"X", "Y", "Z"}, "X").doc("coordinate the bands run across"),
                choice("shape", {"sine", "square", "saw"}, "sine").doc("profile of a band"),
                f("frequency", 5).range(0, 100).doc("multiplies the coordinate"), f("offset", 0).range(0, 10).doc("added to the coordinate"),
                color("color1", 0, 0, 0).doc("colour at 0 after the remap"), color("color2", 1, 1, 1).doc("colour at 1"), pattern_point_param()};
    add_remap_params(n.params);
    n.outputs = {{"out", Type::Color}};
    n.kernel = al_pattern_kernel();
    n.cost_ns = 5;
    n.uses = pattern_uses;
    n.lower = lower_pattern;
    return n;
}
}  // namespace alder
#endif
