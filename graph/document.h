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

struct DocGroup;
struct DocNode {
    enum Role : uint8_t { Node, Group, GroupInput, GroupOutput };
    std::string name;
    const NodeType* type = nullptr;   ///< of groups: their interface (DocGroup)
    std::vector<DocValue> params;     ///< by parameter index
    Role role = Node;
    std::shared_ptr<const DocGroup> group = nullptr;  ///< role Group: what it stands for
};

/// A group: a graph with sockets, read once and used by any number of nodes. Its nodes' links are indices among themselves.
struct DocGroup {
    std::string pointer;              ///< of its graph within the document
    NodeType type;                    ///< as its users see it: inputs are parameters, outputs outputs
    NodeType input, output;           ///< of the nodes that stand for its inputs and outputs inside
    std::vector<std::shared_ptr<const DocNode>> nodes;
    int output_node = -1;
    size_t expanded = 0;              ///< nodes, those of the groups inside included
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
    size_t expanded = 0;   ///< nodes when every group is written out
    bool upgraded = false;  ///< read from a document of an older Blender: nodes and parameters are not those that it names

    int node_index(const std::string& name) const;
    /// "NODE.OUTPUT" split at the last dot that makes a known output, or "NODE". False if there is none.
    bool find_output(const std::string& text, DocLink& link) const;
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
