// Lobes of fibres: evaluation, sampling and albedo, by LobeKind. The lobe's weight is left out everywhere.
#pragma once
#include "render/closure/bsdf.h"

namespace alder::closure {

template <class T>
BsdfEval<T> eval_hair(const Lobe<T>& lobe, const ShadingView<T>& view, Vec3<T> wi);
/// Fills wi, pdf and weight; valid where pdf is positive.
template <class T>
BsdfSample<T> sample_hair(const Lobe<T>& lobe, const ShadingView<T>& view, T u1, T u2, T u3);
template <class T>
Vec3<T> hair_albedo(const Lobe<T>& lobe, Vec3<T> wo);

}  // namespace alder::closure
