// The blend modes that Mix and Mix (Legacy) offer, in Blender's order.
#pragma once
#include "nodes/schema.h"

// Identifier, label, Cycles' name, implementation (color-inl.h).
#define ALDER_BLEND_MODES(X)                                     \
    X(MIX, "Mix", "mix", BlendMix)                               \
    X(DARKEN, "Darken", "darken", BlendDarken)                   \
    X(MULTIPLY, "Multiply", "multiply", BlendMultiply)           \
    X(BURN, "Color Burn", "burn", BlendBurn)                     \
    X(LIGHTEN, "Lighten", "lighten", BlendLighten)               \
    X(SCREEN, "Screen", "screen", BlendScreen)                   \
    X(DODGE, "Color Dodge", "dodge", BlendDodge)                 \
    X(ADD, "Add", "add", BlendAdd)                               \
    X(OVERLAY, "Overlay", "overlay", BlendOverlay)               \
    X(SOFT_LIGHT, "Soft Light", "soft_light", BlendSoftLight)    \
    X(LINEAR_LIGHT, "Linear Light", "linear_light", BlendLinearLight) \
    X(DIFFERENCE, "Difference", "difference", BlendDifference)   \
    X(EXCLUSION, "Exclusion", "exclusion", BlendExclusion)       \
    X(SUBTRACT, "Subtract", "subtract", BlendSubtract)           \
    X(DIVIDE, "Divide", "divide", BlendDivide)                   \
    X(HUE, "Hue", "hue", BlendHue)                               \
    X(SATURATION, "Saturation", "saturation", BlendSaturation)   \
    X(COLOR, "Color", "color", BlendColor)                       \
    X(VALUE, "Value", "value", BlendValue)

namespace alder {
inline Param blend_type_param() {
#define X(ID, label, cycles, Op) {#ID, label, cycles},
    return param::choice("blend_type", std::vector<Item>{ALDER_BLEND_MODES(X)}, "MIX");
#undef X
}
}  // namespace alder
