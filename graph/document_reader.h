// Reading of graph documents, one Reader for each graph: the document's own and those of its groups. Internal to graph/.
#pragma once
#include <map>
#include <unordered_map>

#include "graph/document.h"

namespace alder {

/// The start of a value, as messages show it.
std::string shown_json(const nlohmann::json& v);
/// What a parameter takes, in words.
std::string expected_of(const Param& p);

/// The groups of one document: each definition is read once, however often it is used.
struct GroupTable {
    const nlohmann::json* named = nullptr;                      ///< the document's "groups"
    const nlohmann::json* version = nullptr;                    ///< the document's "blender_version", which holds for its groups too
    std::map<std::string, std::shared_ptr<const DocGroup>> done;  ///< by name; null where the definition has errors
    std::vector<std::string> open;                              ///< names of the definitions being read, outermost first
    size_t depth = 0;                                           ///< graphs inside graphs
};

class Reader {
  public:
    /// `base`: pointer of this graph within the document. `group`: the definition being read, null for the document's own graph.
    Reader(const nlohmann::json& j, std::string base, const MaterialOptions& o, GroupTable& groups, Diagnostics& d, DocGroup* group = nullptr)
        : json_(j), base_(std::move(base)), options_(o), groups_(groups), d_(d), group_(group) {}

    std::shared_ptr<const Document> read();

  private:
    struct Pending {
        std::shared_ptr<DocNode> node;
        const nlohmann::json* source;
        std::string pointer;
        std::string params_at;   ///< pointer of its parameters
    };
    struct GroupEnd {            ///< a NodeGroupInput or NodeGroupOutput, which has its sockets from the interface
        std::string name;
        const nlohmann::json* source;
        std::string pointer;
    };
    using json = nlohmann::json;

    std::string at(const std::string& pointer) const { return options_.pointer_prefix + base_ + pointer; }
    void error(const std::string& pointer, std::string code, std::string found, std::string expected, std::string suggest = {});
    /// A member nobody knows: an error, or with lenient a warning.
    void unknown(const std::string& pointer, std::string code, std::string found, std::string expected, std::string suggest);
    void members(const json& object, const std::string& pointer, std::vector<std::string> known);

    bool read_nodes();
    void declare_nodes();
    void add_node(const std::string& name, const NodeType* type, const json* j, const std::string& pointer, DocNode::Role role = DocNode::Node,
                  std::shared_ptr<const DocGroup> group = nullptr);
    void read_params(Pending& p);
    void read_value(const Param& param, const json& value, const std::string& pointer, DocValue& out);
    /// `preferred`: the output meant where none is named and the node has several.
    bool read_link(const json& value, const std::string& pointer, DocLink& out, int depth = 0, const char* preferred = nullptr);
    void read_outputs();
    void read_output_node(const Pending& p, DocOutputs& out);
    void find_cycles();
    void check_nodes();

    // groups.cpp
    void declare_group(const std::string& name, const json& j, const std::string& pointer);
    std::shared_ptr<const DocGroup> named_group(const std::string& name, const std::string& pointer);
    /// `dated`: the document's version is the group's too and nothing of it has been upgraded yet.
    std::shared_ptr<const DocGroup> read_group(const json& j, const std::string& base, const std::string& name, bool dated);
    bool read_group_graph();
    void read_all_groups();
    void declare_interface();
    void add_group_inputs(const std::vector<Param>& sockets);
    void add_group_output(std::vector<Param> sockets);
    std::vector<Param> declared_sockets(const char* member);
    std::vector<Param> inferred_inputs() const;
    std::vector<Param> inferred_outputs(const json& params);
    bool read_socket(const std::string& id, const json& j, const std::string& pointer, Param& out);
    const json* behind_reroutes(const json* link) const;
    void count_expanded();

    const json& json_;
    std::string base_;
    const MaterialOptions& options_;
    GroupTable& groups_;
    Diagnostics& d_;
    DocGroup* group_;
    std::shared_ptr<Document> document_;
    std::vector<Pending> pending_;
    std::unordered_map<std::string, int> index_;
    std::unordered_map<std::string, const json*> reroutes_;
    std::vector<std::string> declared_bad_;
    std::vector<GroupEnd> group_ends_;
    json output_source_;      ///< a group's "outputs", as parameters of an output node
    size_t links_ = 0;
};

}  // namespace alder
