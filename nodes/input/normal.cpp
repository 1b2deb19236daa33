// Normal: a constant direction, and its dot product with a normal (Blender's node).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/input/normal.cpp"
#include "hwy/foreach_target.h"

#include "nodes/input/output_value.h"
#include "nodes/kernel-inl.h"
#include "nodes/math/finite-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Both are normalised without a guard: a zero direction gives NaN, as in Cycles.
struct NormalDirection {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> direction = normalize_any(k.v(3));
        k.set(0, direction);
        k.set(3, dot(direction, normalize_any(k.v(0))));
    }
};
template <class F>
void normal_direction(const Call<F>& c) { c.template each<NormalDirection>(); }
ALDER_KERNEL(normal_direction)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "graph/lowering.h"

namespace alder {
ALDER_KERNEL_EXPORT(normal_direction)

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeNormal";
    n.category = "Vector";
    n.summary = "a constant direction and its dot product with a normal";
    n.help = "Blender keeps the direction on the Normal output; documents give it as Direction or in output_value: {\"Normal\": [x, y, z]}.";
    n.aliases = {"normal"};
    n.params.push_back(vector("Normal", 0, 0, 1).range(-1, 1));
    n.params.push_back(vector("Direction", 0, 0, 1).no_link().range(-1, 1).alias("direction"));
    n.params.push_back(json("output_value").doc("{\"Normal\": [x, y, z]}; goes before Direction"));
    n.outputs = {{"Normal", Type::Vector}, {"Dot", Type::Float}};
    n.kernel = normal_direction_kernel();
    n.cost_ns = 3;
    n.check = [](const Statics& s, const std::vector<const double*>&, std::vector<std::string>& errors) {
        OutputValue(s.text[2], *s.type, s.type->outputs[0], errors);
    };
    n.lower = [](Lowering& l, int output) {
        std::vector<std::string> errors;
        const Statics& s = l.statics();
        const OutputValue given(s.text[2], *s.type, s.type->outputs[0], errors);
        const ValueRef direction = given.given ? l.constant(Type::Vector, given.number[0], given.number[1], given.number[2]) : l.input(1);
        const ValueRef operands[] = {output == 1 ? l.input(0) : l.constant(Type::Vector, 0, 0, 1), direction};
        l.result(l.call(operands, output));
    };
    return n;
}
}  // namespace alder
#endif
