// Document: a validated graph document. Types, names and links are resolved; values are still what the user wrote.
// Immutable; nodes are shared between documents that differ in one parameter.
#pragma once
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "graph/material.h"

namespace alder {

struct DocLink {
    int node = -1;       ///< index into Document::nodes
    int output = 0;
    int component = -1;  ///< 0..2, or -1 for the whole value; 3 = alpha of a constant 1
};

struct DocValue {
    enum Kind : uint8_t { Default, Constant, Link, Attribute } kind = Default;
    std::array<double, 16> number{};  ///< numeric constants
    int item = 0;                     ///< Enum
    std::string text;                 ///< String, structures as JSON text; Attribute: its name
    DocLink link;
};

struct DocNode {
    std::string name;
    const NodeType* type = nullptr;
    std::vector<DocValue> params;     ///< by parameter index
};

struct DocOutputs {
    DocLink surface, displacement, volume;
    std::vector<std::pair<std::string, DocLink>> aovs;
};

class Document {
  public:
    std::vector<std::shared_ptr<const DocNode>> nodes;
    DocOutputs outputs;
    std::string digest;
    bool upgraded = false;  ///< read from a document of an older Blender: nodes and parameters are not those that it names

    int node_index(const std::string& name) const;
    /// "NODE.OUTPUT" split at the last dot that makes a known output, or "NODE". False if there is none.
    bool find_output(const std::string& text, DocLink& link) const;
    /// A link to a closure output; what else may stand in a closure parameter is a colour.
    bool is_closure(const DocValue& v) const {
        return v.kind == DocValue::Link && nodes[v.link.node]->type->outputs[v.link.output].type == Type::Closure;
    }
};

/// Reads and checks everything. Null if there are errors.
std::shared_ptr<const Document> read_document(const nlohmann::json& json, const MaterialOptions& options, Diagnostics& d);

/// One constant of one parameter: parses `value` for parameter `param` of `type`. False + diagnostics if it does not fit.
bool read_constant(const Param& param, const nlohmann::json& value, const std::string& pointer, const MaterialOptions& options,
                   DocValue& out, Diagnostics& d);

/// Nodes of the two systems' catalogues that this version does not have: the one list of what is missing.
bool is_known_but_unavailable(const std::string& type);
std::vector<std::string> unavailable_nodes();

/// What the node itself refuses (NodeType::check): features declared but not there.
void check_node(const DocNode& node, const std::string& pointer, Diagnostics& d);

/// Compile-time values of a node: enums, texts, which parameters are linked. Lobes and prepared tables come later.
Statics make_statics(const DocNode& node);

}  // namespace alder
