// Kernels the compiler itself inserts: conversions between types, guards of lazy regions, displaced shading points.
#pragma once
#include "nodes/schema.h"

namespace alder::builtin {
Kernel luminance_cycles();  ///< r g b -> Cycles' luminance
Kernel mean();              ///< a b c -> (a+b+c)/3
Kernel to_int();            ///< truncation
Kernel to_bool();           ///< != 0
Kernel multiply();          ///< a b -> a*b
Kernel add();               ///< a b -> a+b
Kernel mad();               ///< a b c -> a*b + c
Kernel select();            ///< m a b -> m != 0 ? a : b
Kernel guard_nonzero();     ///< a -> a != 0 (NaN counts as needed)
Kernel guard_positive();    ///< a -> a > 0
Kernel guard_below_one();   ///< a -> a < 1
Kernel guard_switch();      ///< mix threshold index -> alSwitch picks index
}  // namespace alder::builtin
