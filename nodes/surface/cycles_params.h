// What the declarations of Cycles' closure nodes have in common.
#pragma once
#include "nodes/schema.h"

namespace alder {

inline Param normal_socket(const char* name = "Normal") {
    return param::vector(name, 0, 0, 0).unlinked(Global::N).doc("shading normal, world space; unlinked: the surface's own");
}
inline Param tangent_socket() {
    return param::vector("Tangent", 0, 0, 0).unlinked(Global::Tangent).doc("direction of the first width, world space; unlinked: around the object's Z axis");
}
/// Blender's hidden socket; Cycles has no counterpart.
inline Param weight_socket() { return param::f("Weight", 0).doc("has no effect").no_link(); }

/// A node with one output named as Blender names it; Cycles' own name is an alias.
inline NodeType cycles_bsdf_node(const char* name, const char* alias, const char* summary, const char* output = "BSDF") {
    NodeType n;
    n.name = name;
    n.system = System::Cycles;
    n.category = "surface";
    n.summary = summary;
    n.aliases = {alias};
    n.outputs = {{output, Type::Closure}};
    n.cost_ns = 10;
    return n;
}

}  // namespace alder
