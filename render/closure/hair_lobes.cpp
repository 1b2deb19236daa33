// Evaluation and sampling of fibre lobes, by kind.
#include "render/closure/hair_lobes.h"

#include "nodes/surface/al_hair_dual.h"
#include "render/closure/hair.h"
#include "render/closure/hair_al.h"
#include "render/closure/hair_huang.h"

namespace alder::closure {
namespace {

/// alHair's dual scattering for one light direction. Shape of the sampler: Kajiya and Kay's.
template <class T>
BsdfEval<T> eval_dual(const Lobe<T>& l, const ShadingView<T>& view, Vec3<T> wi) {
    BsdfEval<T> e = eval_kajiya(l, view, wi);
    e.f_cos = Vec3<T>(T(0));
    const auto limited = [](T x, double lo, double hi) { return std::clamp(double{x}, lo, hi); };
    const auto tables = al_hair::dual_tables({limited(l.p[5], -10, 10), limited(l.p[6], 1e-4, 10), limited(l.p[7], 1e-6, 1e3), limited(l.p[8], 1e-6, 1e3)});
    const Fibre<T> fibre(l.t, view.wo);
    const auto i = fibre.angles(wi);
    const T theta_i = std::atan2(i.sin, i.cos), theta_o = std::atan2(fibre.sin_o, fibre.cos_o);
    const T half = (theta_i + theta_o) / 2, difference = (theta_o - theta_i) / 2;
    const T passed = std::clamp(view.fibres, T(0), T(1e6)), met = std::clamp(view.fibre_variance, T(0), T(1e6));
    const T ahead = std::clamp(l.p[3], T(0), T(1e6)), back = std::clamp(l.p[4], T(0), T(1e6));
    const T direct = 1 - std::min(passed, T(2)) / 2;
    for (int c = 0; c < 3; ++c) {
        const T color = std::clamp(l.p[c], T(0), T(1));
        T f;
        if (l.spec->order == 0) {
            f = direct > 0 ? direct * back * tables->back_scattering(difference, half, T(0), color) : T(0);
        } else {
            f = direct < 1 ? (1 - direct) * std::pow(tables->forward_attenuation(theta_i, color), passed) * ahead *
                                 (tables->forward_scattering(difference, half, std::abs(i.phi), met, color) +
                                  kPi<T> * back * tables->back_scattering(difference, half, met, color))
                           : T(0);
        }
        e.f_cos[c] = std::max(f, T(0)) * i.cos / kPi<T>;
    }
    return e;
}

}  // namespace

template <class T>
BsdfEval<T> eval_hair(const Lobe<T>& l, const ShadingView<T>& view, Vec3<T> wi) {
    switch (l.spec->kind) {
        case LobeKind::HairReflection:
        case LobeKind::HairTransmission: return CyclesHair<T>(l, view).eval(wi, view.unreachable_too);
        case LobeKind::HairChiang: return ChiangHair<T>(l, view).eval(wi);
        case LobeKind::HairOrder: return SingleOrder<T>(l, view).eval(wi);
        case LobeKind::HairHuang: {
            const HuangHair<T> hair(l, view);
            return {hair.f_cos(wi), hair.density(hair.proxy(), wi)};
        }
        case LobeKind::HairKajiya: return eval_kajiya(l, view, wi);
        case LobeKind::HairDual: return eval_dual(l, view, wi);
        default: return AlHairLobe<T>(l, view).eval(wi);
    }
}

template <class T>
BsdfSample<T> sample_hair(const Lobe<T>& l, const ShadingView<T>& view, T u1, T u2, T u3) {
    BsdfSample<T> s;
    switch (l.spec->kind) {
        case LobeKind::HairReflection:
        case LobeKind::HairTransmission: s.wi = CyclesHair<T>(l, view).sample(u1, u2); break;
        case LobeKind::HairChiang: s.wi = ChiangHair<T>(l, view).sample(u1, u2, u3); break;
        case LobeKind::HairOrder: {
            const SingleOrder<T> order(l, view);
            s.wi = order.order.sample(order.fibre, u1, u2, u3);
            break;
        }
        case LobeKind::HairHuang: {
            const HuangHair<T> hair(l, view);
            s.wi = hair.sample(hair.proxy(), u1, u2, u3);
            break;
        }
        case LobeKind::HairKajiya:
        case LobeKind::HairDual:
            s.wi = sample_kajiya(l, view, u1, u2, u3);
            s.is_diffuse = true;
            break;
        default: s.wi = AlHairLobe<T>(l, view).sample(u1, u2, u3); break;
    }
    const BsdfEval<T> e = eval_hair(l, view, s.wi);
    s.is_transmission = dot(view.ng, s.wi) < 0;
    s.pdf = e.pdf;
    s.valid = e.pdf > 0;
    if (s.valid) s.weight = e.f_cos / e.pdf;
    return s;
}

template <class T>
Vec3<T> hair_albedo(const Lobe<T>& l, Vec3<T> wo) {
    const ShadingView<T> view{wo, wo, wo};
    switch (l.spec->kind) {
        case LobeKind::HairChiang: {
            const ChiangHair<T> hair(l, view);
            return hair.path.carried[0] + hair.path.carried[1] + hair.path.carried[2] + hair.path.carried[3];
        }
        case LobeKind::HairOrder: {
            const SingleOrder<T> order(l, view);
            return order.path.carried[order.p];
        }
        case LobeKind::HairHuang: return HuangHair<T>(l, view).albedo();
        case LobeKind::HairKajiya: return Vec3<T>(kPi<T> / 4);
        // Of narrow lobes, seen across the fibre: the Gaussians integrate to 1, cos(phi/2) to 4, and dtheta_i is 2 dtheta_h.
        case LobeKind::HairGlossy: return Vec3<T>(8 / kPi<T>);
        case LobeKind::HairForward:
        case LobeKind::HairGlint: return Vec3<T>(2 / kPi<T>);
        case LobeKind::HairDual: {
            // A typical volume of hair sends back a third of its colour.
            const T share = l.spec->order == 0 ? l.p[4] : view.fibres > 0 ? l.p[3] : T(0);
            return Vec3<T>(std::max(share, T(0)) / 3);
        }
        default: return Vec3<T>(T(1));
    }
}

#define ALDER_INSTANTIATE(T)                                                             \
    template BsdfEval<T> eval_hair(const Lobe<T>&, const ShadingView<T>&, Vec3<T>);      \
    template BsdfSample<T> sample_hair(const Lobe<T>&, const ShadingView<T>&, T, T, T);  \
    template Vec3<T> hair_albedo(const Lobe<T>&, Vec3<T>);
ALDER_INSTANTIATE(float)
ALDER_INSTANTIATE(double)
#undef ALDER_INSTANTIATE

}  // namespace alder::closure
