// AOV Output: a colour or value of the material as an image of its own beside the picture (Blender's node). When the document is
// read, its name becomes one of the document's AOVs (graph/upgrade.cpp); the node itself hands its inputs on.
#include "graph/lowering.h"

namespace alder {

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeOutputAOV";
    n.aliases = {"aov_output"};
    n.category = "Output";
    n.summary = "writes a colour or value of the material into an image of its own";
    n.help = "The image has the node's name: its Color, or its Value where only that is linked or set. \"aovs\" of the document does the same without a node.";
    n.params = {
        string("aov_name").doc("name of the image; empty: none"),
        color("Color", 0, 0, 0).doc("what is written"),
        f("Value", 0).range(0, 1).doc("what is written where Color is left alone"),
    };
    n.outputs = {{"Color", Type::Color}, {"Value", Type::Float}};
    n.lower = [](Lowering& l, int output) { l.result(l.input(output == 0 ? 1 : 2)); };
    return n;
}

}  // namespace alder
