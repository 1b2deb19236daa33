// White Noise Texture: a random number and a random colour for every coordinate, by hashing its bits. No two neighbours agree.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/texture/tex_white_noise.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"
#include "nodes/noise/hash-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

namespace tex_white_noise {
enum Parameter { kDimensions, kVector, kW };
enum Channel { kVectorIn = 0, kWIn = 3 };
enum Out { kValueOut, kColorOut };
}  // namespace tex_white_noise

template <int D>
struct TexWhiteNoise {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        using namespace tex_white_noise;
        if constexpr (D == 1) {
            emit(k, k.f(kWIn));
        } else {
            const Vec3<F> v = k.v(kVectorIn);
            if constexpr (D == 2) emit(k, v.x, v.y);
            if constexpr (D == 3) emit(k, v.x, v.y, v.z);
            if constexpr (D == 4) emit(k, v.x, v.y, v.z, k.f(kWIn));
        }
    }
    template <class F, class... Coordinates>
    static HWY_INLINE void emit(const Lanes<F>& k, Coordinates... c) {
        using namespace tex_white_noise;
        if (k.wants(kColorOut + 1) || k.wants(kColorOut + 2)) {
            const Vec3<F> color = hash_to_vec3<F>(c...);
            k.set(kValueOut, color.x);  // red is the value
            k.set(kColorOut, color);
        } else {
            const F value = hash_to_float<F>(c...);
            k.set(kValueOut, value);
            k.set(kColorOut, value);
        }
    }
};
template <class F>
void tex_white_noise_kernel(const Call<F>& c) {
    switch (c.statics().e(tex_white_noise::kDimensions)) {
        case 0: return c.template each<TexWhiteNoise<1>>();
        case 1: return c.template each<TexWhiteNoise<2>>();
        case 2: return c.template each<TexWhiteNoise<3>>();
        default: return c.template each<TexWhiteNoise<4>>();
    }
}
ALDER_KERNEL(tex_white_noise_kernel)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(tex_white_noise_kernel)

ALDER_NODE {
    using namespace param;
    namespace p = HWY_NAMESPACE::tex_white_noise;
    NodeType n;
    n.name = "ShaderNodeTexWhiteNoise";
    n.aliases = {"white_noise_texture"};
    n.system = System::Cycles;
    n.category = "texture";
    n.summary = "a random number and colour for every coordinate";
    n.help = "Jenkins' lookup3 hash of the coordinates' 32-bit floats: the least change gives another number.";
    n.params = {
        choice("noise_dimensions", {{"1D", "1D", "1D"}, {"2D", "2D", "2D"}, {"3D", "3D", "3D"}, {"4D", "4D", "4D"}}, "3D")
            .alias("dimensions").doc("which coordinates are read: W; Vector's x, y; Vector; Vector and W"),
        vector("Vector", 0, 0, 0).range(-10000, 10000).doc("what is hashed"),
        f("W").range(-10000, 10000).doc("coordinate of 1D, fourth coordinate of 4D"),
    };
    n.outputs = {{"Value", Type::Float}, {"Color", Type::Color}};
    n.kernel = tex_white_noise_kernel_kernel();
    n.cost_ns = 4;
    n.uses = [](const Statics& s, int param) {
        const int dimensions = s.e(p::kDimensions) + 1;
        return param == p::kVector ? dimensions > 1 : param == p::kW ? dimensions == 1 || dimensions == 4 : true;
    };
    return n;
}
}  // namespace alder
#endif
