// Brick Texture: rows of bricks between mortar, every brick with a tint of its own between two colours. Follows Cycles' SVM.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/texture/tex_brick.cpp"
#include "hwy/foreach_target.h"

#include "nodes/texture/texture_mapping-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

namespace tex_brick {
enum Channel {
    kVectorIn = 0, kColor1In = 3, kColor2In = 6, kMortarIn = 9, kScaleIn = 12, kMortarSizeIn, kMortarSmoothIn, kBiasIn, kBrickWidthIn,
    kRowHeightIn, kOffsetFrequencyIn, kSquashFrequencyIn, kOffsetIn, kSquashIn
};

/// A random number in [0, 1] of a brick: Blender's old integer noise.
template <class F>
HWY_INLINE F brick_tint(Int<F> n) {
    using I = Int<F>;
    n = (n + I(1013)) & I(0x7fffffff);
    n = shr<13>(n) ^ n;
    const I m = (n * (n * n * I(60493) + I(19990303)) + I(1376312589)) & I(0x7fffffff);
    return F(0.5f) * (to_float<F>(m) / F(1073741824.0f));
}
/// Whether a row is one of every `frequency`.
template <class F>
HWY_INLINE Mask<F> is_every(F row, F frequency) { return row - frequency * floor(row / frequency) == F(0); }
}  // namespace tex_brick

struct TexBrick {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        using namespace tex_brick;
        using I = Int<F>;
        const Vec3<F> p = mapped_vector(k, kVectorIn) * k.f(kScaleIn);
        const F row_height = k.f(kRowHeightIn), mortar_size = k.f(kMortarSizeIn), smooth = k.f(kMortarSmoothIn);
        F width = k.f(kBrickWidthIn), offset(0);

        const I row_number = to_int(floor(p.y / row_height));
        const F row = to_float<F>(row_number);
        const F offset_frequency = k.f(kOffsetFrequencyIn), squash_frequency = k.f(kSquashFrequencyIn);
        const Mask<F> varied = (offset_frequency != F(0)) & (squash_frequency != F(0));
        if (any(varied)) {
            width = select(varied & is_every(row, squash_frequency), width * k.f(kSquashIn), width);
            offset = select(varied & is_every(row, offset_frequency), width * k.f(kOffsetIn), offset);
        }
        const F along = p.x + offset;
        const I brick_number = to_int(floor(along / width));
        // Rounded twice, as Cycles has it: what is left of a large coordinate shows it.
        const F x = along - width * to_float<F>(brick_number);
        const F y = p.y - row_height * row;
        const F tint = min(max(F(0), brick_tint<F>(shl<16>(row_number) + (brick_number & I(0xffff))) + k.f(kBiasIn)), F(1));

        // Mortar: 1 at the brick's border, 0 from mortar_size inwards, between them smooth.
        const F inside = min(min(x, y), min(width - x, row_height - y));
        const F t = (F(1) - inside / mortar_size) / select(smooth == F(0), F(1), smooth);
        F mortar = t * t * F(3) - F(2) * (t * t) * t;
        mortar = select(t <= F(0), F(0), select(t >= F(1), F(1), mortar));
        mortar = select(smooth == F(0), F(1), mortar);
        mortar = select(inside >= mortar_size, F(0), mortar);

        k.set(3, mortar);
        if (k.wants(0) || k.wants(1) || k.wants(2)) {
            const Vec3<F> brick = k.v(kColor1In) * (F(1) - tint) + k.v(kColor2In) * tint;
            const Vec3<F> face = select<F>(mortar != F(1), brick, k.v(kColor1In));
            k.set(0, face * (F(1) - mortar) + k.v(kMortarIn) * mortar);
        }
    }
};
template <class F>
void tex_brick_kernel(const Call<F>& c) { c.template each<TexBrick>(); }
ALDER_KERNEL(tex_brick_kernel)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(tex_brick_kernel)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeTexBrick";
    n.aliases = {"brick_texture"};
    n.system = System::Cycles;
    n.category = "texture";
    n.summary = "rows of bricks and mortar";
    n.help = "Bricks in the x, y plane. Every offset_frequency-th row is shifted by offset brick widths, in every squash_frequency-th row bricks are "
             "squash times as wide. Each brick's colour lies between Color1 and Color2 by a random number and Bias.";
    n.params = {
        texture_mapping_param(),
        vector("Vector", 0, 0, 0).range(-10000, 10000).unlinked(Global::Generated).doc("where the bricks are read; unlinked: generated coordinates"),
        color("Color1", 0.8, 0.8, 0.8).doc("one end of the bricks' colours"),
        color("Color2", 0.2, 0.2, 0.2).doc("the other end"),
        color("Mortar", 0, 0, 0).doc("colour between the bricks"),
        f("Scale", 5).range(-1000, 1000).doc("bricks' frequency"),
        f("Mortar Size", 0.02).range(0, 0.125).doc("half the width of the mortar"),
        f("Mortar Smooth", 0.1).range(0, 1).doc("how softly mortar turns into brick; 0 is sharp"),
        f("Bias", 0).range(-1, 1).doc("added to the random number: -1 gives Color1, 1 gives Color2"),
        f("Brick Width", 0.5).range(0.01, 100).doc("before Scale"),
        f("Row Height", 0.25).range(0.01, 100).doc("before Scale"),
        i("offset_frequency", 2).limit(1, 99).range(1, 99).no_link().doc("every which row is shifted"),
        i("squash_frequency", 2).limit(1, 99).range(1, 99).no_link().doc("every which row is squashed"),
        f("offset", 0.5).limit(0, 1).range(0, 1).no_link().doc("shift of such a row, in brick widths"),
        f("squash", 1).limit(0, 99).range(0, 99).no_link().doc("width of the bricks of such a row, relative"),
        color_mapping_param(),
    };
    n.outputs = {{"Color", Type::Color}, {"Fac", Type::Float}};
    n.kernel = tex_brick_kernel_kernel();
    n.cost_ns = 6;
    n.prepare = prepare_texture_mapping;
    return n;
}
}  // namespace alder
#endif
