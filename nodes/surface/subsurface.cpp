// Subsurface Scattering of Blender: light that leaves a body elsewhere than where it entered.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/surface/subsurface.cpp"
#include "hwy/foreach_target.h"

#include "nodes/surface/closure-inl.h"
#include "nodes/surface/cycles_params.h"
#include "nodes/surface/subsurface-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct SubsurfaceScattering {  // Color 0, Scale 3, Radius 4, IOR 7, Roughness 8, Anisotropy 9, Normal 10, Weight 13; N 14, Ng 17, I 20
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const LobeOut<F> deep(k, 0), shallow(k, 1);
        const Vec3<F> color = k.v(0), n = socket_normal(k.v(10), k.v(14));
        const bool skin = k.statics().e(0) == 2;
        emit_subsurface(deep, shallow, allocate(color), reflecting_normal(n, k.v(17), k.v(20)), n, k.v(4) * k.f(3), saturate(color), k.f(7),
                        skin ? F(1) : saturate(k.f(8)), k.f(9));
    }
};
template <class F>
void subsurface_scattering(const Call<F>& c) { c.template each<SubsurfaceScattering>(); }
ALDER_KERNEL(subsurface_scattering)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(subsurface_scattering)

static bool subsurface_uses(const Statics& s, int p) {
    const std::string& name = s.type->params[p].name;
    const int method = s.e(0);
    if (name == "Weight") return false;
    if (name == "Roughness") return method == 1;
    if (name == "IOR" || name == "Anisotropy") return method != 0;
    return true;
}

ALDER_NODE {
    using namespace param;
    NodeType n = cycles_bsdf_node("ShaderNodeSubsurfaceScattering", "subsurface_scattering",
                                  "light that leaves a body elsewhere than where it entered", "BSSRDF");
    n.help = "A random walk inside the object the surface belongs to (Chiang, Kutz and Burley 2016), or Christensen and Burley's profile, "
             "for which other points of the object are probed. Closed meshes are expected.";
    n.params = {choice("falloff",
                       {{"BURLEY", "Christensen-Burley", "burley"}, {"RANDOM_WALK", "Random Walk", "random_walk"},
                        {"RANDOM_WALK_SKIN", "Random Walk (Skin)", "random_walk_skin"}}, "RANDOM_WALK"),
                color("Color", 0.8, 0.8, 0.8),
                f("Scale", 0.05).range(0, 1000).doc("length of one unit of radius"),
                vector("Radius", 1, 0.2, 0.1).range(0, 100).doc("how far light spreads, per channel"),
                f("IOR", 1.4).range(1.01, 3.8).doc("index of refraction inside"),
                f("Roughness", 1).range(0, 1).doc("of the way in; Random Walk only"),
                f("Anisotropy", 0).range(0, 1).doc("of scattering inside, up to 0.9"),
                normal_socket(), weight_socket()};
    n.globals = {Global::N, Global::Ng, Global::I};
    n.kernel = subsurface_scattering_kernel();
    n.uses = subsurface_uses;
    n.lobes = [](const Statics& s) -> std::vector<LobeSpec> {
        std::vector<LobeSpec> lobes(2);
        set_subsurface_specs(lobes[0], lobes[1], s.e(0), s.linked[7]);
        lobes[0].gates = lobes[1].gates = {1};
        return lobes;
    };
    return n;
}

}  // namespace alder
#endif
