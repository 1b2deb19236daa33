// Reports: diagnostics and the compiled form of a graph as JSON, for every door that answers with them.
#pragma once
#include <nlohmann/json.hpp>

#include "graph/diagnostic.h"
#include "graph/material.h"

namespace alder {

/// {"pointer", "code", "found", "expected", "suggest", "path"}, empty members left out.
nlohmann::json to_json(const Diagnostic& d);
/// At most kMaxDiagnostics of them.
nlohmann::json to_json(const std::vector<Diagnostic>& list);

/// What an editor shows while one types: {"ok", "errors", "warnings", "compiled"}. `compiled` is there where the graph is
/// right: nodes, live nodes, what was pruned and why, instructions, closures, what it reads of the scene.
/// `material` is the result of building the document, null where it has errors; `d` what was found on the way.
nlohmann::json graph_report(const Material* material, Diagnostics d);

/// All that the document defines: surface, displacement, AOVs.
ProgramRequest everything(const Material& material);

/// "diffuse", "ggx_glass": what a lobe is called in reports.
const char* closure_name(const LobeSpec& spec);

/// Graphviz text: the network coloured by what became of each node, and below it the instructions.
std::string program_dot(const Program& program);

}  // namespace alder
