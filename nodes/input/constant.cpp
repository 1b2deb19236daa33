// Value and RGB: a constant number or colour (Blender's nodes, which keep it on their output socket).
#include <nlohmann/json.hpp>

#include "graph/lowering.h"
#include "nodes/input/output_value.h"
#include "nodes/schema.h"

namespace alder {

// The constant is a parameter named like the output ("Value", "Color"), or stands in output_value: {"Value": 0.5}.
enum { kConstant, kOutputValue };

static NodeType constant_node(const char* name, const char* cycles, Param constant, Output output, const char* summary) {
    NodeType n;
    n.name = name;
    n.category = "Input";
    n.summary = summary;
    n.help = "Blender keeps the constant on the output socket; documents give it under the socket's name or in output_value.";
    n.aliases = {cycles};
    n.params.push_back(std::move(constant.no_link()));
    n.params.push_back(param::json("output_value").doc("{\"" + output.name + "\": constant}; goes before the parameter of that name"));
    n.outputs = {std::move(output)};
    n.check = [](const Statics& s, const std::vector<const double*>&, std::vector<std::string>& errors) {
        OutputValue(s.text[kOutputValue], *s.type, s.type->outputs[0], errors);
    };
    n.uses = [](const Statics& s, int param) {
        std::vector<std::string> errors;
        return param == kOutputValue || !OutputValue(s.text[kOutputValue], *s.type, s.type->outputs[0], errors).given;
    };
    n.lower = [](Lowering& l, int) {
        std::vector<std::string> errors;
        const NodeType& type = *l.statics().type;
        const OutputValue given(l.statics().text[kOutputValue], type, type.outputs[0], errors);
        l.result(given.given ? l.constant(type.outputs[0].type, given.number[0], given.number[1], given.number[2]) : l.input(kConstant));
    };
    return n;
}

ALDER_NODE { return constant_node("ShaderNodeValue", "value", param::f("Value", 0).alias("value"), {"Value", Type::Float}, "a constant number"); }
ALDER_NODE { return constant_node("ShaderNodeRGB", "color", param::color("Color", 0.5, 0.5, 0.5).alias("value"), {"Color", Type::Color}, "a constant colour"); }

}  // namespace alder
