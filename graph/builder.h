// Builder: Document -> IR for one request. Demand driven: starts at what was asked for and pulls inputs, so that what a
// constant switches off is never built. Folding and merging happen on insertion (ir.h).
#pragma once
#include <map>
#include <set>
#include <unordered_map>

#include "graph/document.h"
#include "graph/ir.h"
#include "graph/lowering.h"

namespace alder {

/// A value of the graph: its type and channels.
struct IrRef {
    Type type = Type::Float;
    std::array<int, 3> ch{-1, -1, -1};
};

struct BuiltLobe {
    LobeSpec spec;
    std::vector<int> channels;  ///< LobeSpec order, weight already multiplied by the path's mixing weight
    int guard = -1;             ///< channel that is zero where the whole closure is not needed, or -1
    std::string node;
};

/// A node of the document where it is used: a node inside a group stands once for each use of the group that something asks for.
struct PlacedNode {
    const DocNode* node = nullptr;
    int base = 0;       ///< added to the node numbers in its links
    int parent = -1;    ///< the group node around it
    int inside = -1;    ///< of a group node that is written out: its first node
};

/// The closure op's own uses are lazy under the mixing weight.
struct Built {
    Ir ir;
    std::vector<PlacedNode> nodes;   ///< those of the document first, by the same number
    std::vector<BuiltLobe> lobes;
    std::vector<IrRef> outputs;
    std::vector<std::string> output_names;
    std::vector<std::pair<int, int>> lazy_roots;             ///< (channel, guard): needed only where guard != 0
    std::map<std::pair<int, int>, std::pair<int, int>> leaves;  ///< (node, param) -> first leaf channel, count
    std::set<std::pair<int, int>> asked;                     ///< (node, param): lobes() or uses() looked at its constant
    std::vector<std::pair<int, std::string>> skipped;        ///< (node, reason)
    std::vector<std::pair<std::string, std::shared_ptr<const Prepared>>> resources;  ///< (pointer of the node, its tables): with files behind them
    std::set<int> touched;                                   ///< nodes whose value was asked for

    /// "node", or "group/node" inside a group.
    std::string name(int node) const { return (nodes[node].parent >= 0 ? name(nodes[node].parent) + "/" : "") + nodes[node].node->name; }
};

class Builder {
  public:
    Builder(const Document& document, Built& built, Diagnostics& d, const MaterialOptions& options)
        : document_(document), built_(built), d_(d), options_(options) {
        for (const auto& n : document.nodes) built_.nodes.push_back({n.get()});
    }

    void build(const ProgramRequest& request);

  private:
    friend class NodeLowering;
    /// Where the shading point stands: at the hit (0), or displaced for a bump derivative.
    struct Variant {
        int parent = 0;
        int direction = 0;      ///< 1 = x, 2 = y
        int width = -1;         ///< channel: filter width
        int depth = 0;
    };

    const DocNode& at(int node) const { return *built_.nodes[node].node; }
    /// The number of the node that a link of `node` names.
    int target(int node, const DocLink& link) const { return built_.nodes[node].base + link.node; }
    int expand(int node);
    /// Where a closure is really written: parameter of a node. Follows links through groups' inputs and outputs.
    struct Place {
        int node, param;
    };
    Place behind_groups(Place p);
    bool links_closure(Place p) const;

    IrRef node_output(int node, int output, int variant);
    IrRef param_value(int node, int param, int variant);
    /// The value that a link of `node` gives; -1: one of the document's outputs.
    IrRef link_value(int node, const DocLink& link, System consumer, Type to, int variant);
    IrRef constant_param(int node, int param);
    IrRef global_value(Global g, int variant);
    IrRef convert(IrRef v, Type to, System system);
    IrRef run_kernel(int node, int output, int variant);
    /// Appends the channels of the globals that the node reads.
    void push_globals(const Statics& s, int variant, std::vector<int>& in);
    std::vector<int> kernel_operands(int node, const Statics& s, int variant, uint64_t lobes, std::vector<LazyUse>& lazy);
    int lazy_guard(const LazyRule& rule, IrRef selector, IrRef second, bool& needed, bool& always);
    std::shared_ptr<const Statics> statics(int node);
    std::string pointer_to(int node, const std::string& param = {}) const;
    Diagnostic prepare_fault(int node, const std::string& text) const;
    int variant_of(int parent, int direction, int width);
    int op1(const char* name, const Kernel& kernel, std::vector<int> in);

    void closure(const DocLink& link, int weight, LobeFilter filter);
    void emit(int node, IrRef color, int weight);
    IrRef color_of(int node, int param);
    IrRef emission_of(const DocLink& link);
    void closure_lobes(int node, int weight, LobeFilter filter, const std::vector<int>& more = {});
    void closure_aov(const DocLink& link, const std::string& name, int weight, IrRef& sum, bool& found);

    const Document& document_;
    Built& built_;
    Diagnostics& d_;
    const MaterialOptions& options_;
    std::vector<Variant> variants_{1};
    std::map<std::tuple<int, int, int>, IrRef> memo_;
    struct NodeStatics {
        std::shared_ptr<Statics> statics;
        std::vector<char> asked;
        int node;   ///< the first that asked
    };
    std::unordered_map<const DocNode*, NodeStatics> statics_;   ///< shared by all uses of a group: its tables are baked once
    bool filters_textures_ = false, fades_noise_ = false;
    LobeFilter filter_ = LobeFilter::None;  ///< of the closures being built
    bool in_volume_ = false;                ///< they are a volume's
    // While an alder AOV is collected along the closure tree instead of lobes:
    bool collecting_aov_ = false;
    std::string aov_name_;
    IrRef aov_sum_;
    bool aov_found_ = false;
};

}  // namespace alder
