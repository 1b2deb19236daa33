// How much of an octave of noise is left in a pixel. Gradient noise has a wave in about two cells: an octave with less than half a cell a
// pixel is there in full, one with two cells or more averages to its mean, in between it fades with the logarithm of its frequency, as
// octaves follow each other. Norton, Rockwood, Skolmoski, "Clamping: a method of antialiasing textured surfaces by bandwidth limiting in
// object space", SIGGRAPH 1982.
#if defined(ALDER_NODES_NOISE_OCTAVE_FADE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALDER_NODES_NOISE_OCTAVE_FADE_INL_H_
#undef ALDER_NODES_NOISE_OCTAVE_FADE_INL_H_
#else
#define ALDER_NODES_NOISE_OCTAVE_FADE_INL_H_
#endif

#include "nodes/num/math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// `cells`: of the octave's lattice, from pixel to pixel. What is not known (NaN) is not faded.
template <class F>
HWY_INLINE F octave_weight(F cells) {
    const Mask<F> fine = cells > F(0.5f);
    if (!any(fine)) return F(1);
    return select(fine, saturate(mad(F(-0.5f), log2(select(fine, cells, F(1))), F(0.5f))), F(1));
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
