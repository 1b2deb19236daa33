// Blend modes of alLayerColor, in the order of its enum.
#pragma once

#define ALDER_BLEND_MODES(X)                                                                                              \
    X(Normal, "Normal") X(Lighten, "Lighten") X(Darken, "Darken") X(Multiply, "Multiply") X(Average, "Average") X(Add, "Add") \
    X(Subtract, "Subtract") X(Difference, "Difference") X(Negation, "Negation") X(Exclusion, "Exclusion") X(Screen, "Screen") \
    X(Overlay, "Overlay") X(SoftLight, "Soft Light") X(HardLight, "Hard Light") X(ColorDodge, "Color Dodge")                \
    X(ColorBurn, "Color Burn") X(LinearDodge, "Linear Dodge") X(LinearBurn, "Linear Burn") X(LinearLight, "Linear Light")    \
    X(VividLight, "Vivid Light") X(PinLight, "Pin Light") X(HardMix, "Hard Mix") X(Reflect, "Reflect") X(Glow, "Glow")       \
    X(Phoenix, "Phoenix")

namespace alder {
enum class BlendMode {
#define ALDER_BLEND_ENUM(name, label) name,
    ALDER_BLEND_MODES(ALDER_BLEND_ENUM)
#undef ALDER_BLEND_ENUM
};
}  // namespace alder
