// Programs for people: what the optimiser made of a network, as text and as a Graphviz drawing.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "graph/code.h"
#include "graph/report.h"

namespace alder {
namespace {

constexpr size_t kMostOperands = 24;   ///< shown of one instruction

struct FateWords {
    const char* title;
    const char* color;
};
FateWords words(NodeFate::Kind kind) {
    switch (kind) {
        case NodeFate::Live: return {"run", "palegreen"};
        case NodeFate::Merged: return {"merged with an equal node", "khaki"};
        case NodeFate::Folded: return {"folded to constants", "lightblue"};
        case NodeFate::PassedOn: return {"nothing to compute", "lightcyan"};
        case NodeFate::Pruned: return {"switched off", "lightsalmon"};
        case NodeFate::NotAsked: return {"never asked for", "lightgray"};
        case NodeFate::Group: return {"groups written out", "white"};
    }
    return {"?", "white"};
}

/// Operands as text.
class Naming {
  public:
    Naming(const Code& code, const std::vector<float>& uniforms) : code_(code), uniforms_(uniforms) {
        for (const auto& in : code.inputs)
            for (int c = 0; c < in.channels; ++c) {
                const char* global = in.is_attribute ? nullptr : global_name(in.global);
                const std::string name = in.is_attribute ? "attribute:" + in.attribute : global ? global : fmt::format("global{}", static_cast<int>(in.global));
                inputs_.push_back(in.channels == 1 ? name : name + "." + (in.type == Type::Color ? "rgb" : "xyz")[c]);
            }
    }
    std::string operator()(const Slot& x) const {
        switch (x.kind) {
            case Slot::Register: return fmt::format("r{}", x.index);
            case Slot::Uniform: return fmt::format("{:g}", uniforms_[static_cast<size_t>(x.index) * kPadding]);
            case Slot::Input: return inputs_[x.index];
            case Slot::None: break;
        }
        return "-";
    }
    /// Neighbours that are components of one value are written once: P.xyz.
    std::string list(const std::vector<Slot>& slots) const {
        std::string s;
        for (size_t i = 0; i < slots.size(); ++i) {
            if (i == kMostOperands) return s + fmt::format(", and {} more", slots.size() - i);
            std::string one = (*this)(slots[i]);
            if (slots[i].kind == Slot::Input && i + 2 < slots.size() && one.ends_with(".x") && slots[i + 2].kind == Slot::Input && slots[i + 2].index == slots[i].index + 2) {
                one += "yz";
                i += 2;
            }
            s += (s.empty() ? "" : ", ") + one;
        }
        return s;
    }

  private:
    const Code& code_;
    const std::vector<float>& uniforms_;
    std::vector<std::string> inputs_;
};

std::string registers_text(const std::vector<int>& out) {
    std::string s;
    for (int r : out)
        if (r >= 0) s += fmt::format("{}r{}", s.empty() ? "" : " ", r);
    return s;
}

/// A quoted string of the dot language.
std::string quoted(const std::string& text) {
    std::string s = "\"";
    for (char c : text) {
        if (c == '\n') {
            s += "\\n";
            continue;
        }
        if (c == '"' || c == '\\') s += '\\';
        s += c;
    }
    return s + "\"";
}

}  // namespace

std::string ProgramImpl::dump() const {
    const Code& code = *code_;
    const Ir& ir = *code.ir;
    const ProgramStats& st = code.stats;
    std::string s = fmt::format("{} nodes, {} live; {} ops, {} registers, batches of {}; {} values folded, {} shared, {} lazy regions\n", st.nodes, st.live_nodes,
                                st.ops, code.registers, code.batch, st.folded, st.merged, st.regions);
    const Naming name(code, uniform_f_);

    s += "\nnodes\n";
    for (int kind = NodeFate::Live; kind <= NodeFate::Group; ++kind) {
        std::string list;
        for (const auto& n : code.nodes) {
            if (n.kind != kind) continue;
            if (n.reason.empty()) list += (list.empty() ? "    " : ", ") + n.name;
            else list += fmt::format("    {}: {}\n", n.name, n.reason);
        }
        if (list.empty()) continue;
        if (list.back() != '\n') list += '\n';
        s += fmt::format("  {}\n{}", words(static_cast<NodeFate::Kind>(kind)).title, list);
    }

    s += "\nvarying, one value a point\n";
    for (const auto& in : code.inputs)
        s += fmt::format("  {}\n", in.is_attribute ? fmt::format("attribute:{} ({})", in.attribute, type_name(in.type)) : global_name(in.global) ? global_name(in.global) : "an internal global");
    if (code.inputs.empty()) s += "  nothing: every point gives the same\n";
    s += fmt::format("uniform, the same for all points: {} constants, written as numbers below\n", code.uniforms.size());

    s += "\nprogram\n";
    std::vector<int> ends;
    for (size_t i = 0; i < code.instructions.size(); ++i) {
        while (!ends.empty() && ends.back() == static_cast<int>(i)) ends.pop_back();
        const Instruction& in = code.instructions[i];
        s += std::string(2 + 2 * ends.size(), ' ');
        if (in.kind == Instruction::Region) {
            s += fmt::format("only where {} != 0{}:\n", name(in.guard), in.compact ? " (points gathered)" : "");
            ends.push_back(in.end);
            continue;
        }
        const IrOp& op = ir.ops[in.op];
        s += fmt::format("{} = {}({}){}\n", registers_text(in.out), op.name, name.list(in.in), op.node >= 0 ? "  # " + code.nodes[op.node].name : "");
    }
    if (code.instructions.empty()) s += "  nothing to run\n";

    s += "\nresults\n";
    const auto results = [&](int first, int count) {
        std::vector<Slot> list(code.results.begin() + first, code.results.begin() + first + count);
        return name.list(list);
    };
    for (const auto& o : code.outputs) s += fmt::format("  {} = {}\n", o.name, results(o.register_first, channels(o.type)));
    for (const auto& l : code.lobes) s += fmt::format("  lobe {} of {}: {}\n", closure_name(l.spec), l.node, results(l.register_first, l.spec.channels()));
    if (code.outputs.empty() && code.lobes.empty()) s += "  none: every lobe is switched off\n";
    return s;
}

std::string program_dot(const Program& program) {
    const Code& code = static_cast<const ProgramImpl&>(program).code();
    const Ir& ir = *code.ir;
    std::string s = "digraph alder {\n  rankdir=LR;\n  node [shape=box, style=filled, fontname=\"sans-serif\"];\n";

    s += "  subgraph cluster_network {\n    label=\"network\";\n";
    for (size_t n = 0; n < code.nodes.size(); ++n) {
        const NodeFate& node = code.nodes[n];
        s += fmt::format("    n{} [label={}, fillcolor={}, tooltip={}];\n", n, quoted(node.name + "\n" + node.type), words(node.kind).color,
                         quoted(node.reason.empty() ? words(node.kind).title : node.reason));
    }
    for (const auto& l : code.links) s += fmt::format("    n{} -> n{} [label={}];\n", l.from, l.to, quoted(l.param));
    for (size_t n = 0; n < code.nodes.size(); ++n) {
        const NodeFate& node = code.nodes[n];
        if (node.parent < 0 || node.kind != NodeFate::Group) continue;
        if (node.type == "NodeGroupInput") s += fmt::format("    n{} -> n{} [style=dashed];\n", node.parent, n);
        if (node.type == "NodeGroupOutput") s += fmt::format("    n{} -> n{} [style=dashed];\n", n, node.parent);
    }
    s += "  }\n  subgraph cluster_fates {\n    label=\"what became of a node\";\n";
    for (int kind = NodeFate::Live; kind <= NodeFate::Group; ++kind) {
        const FateWords w = words(static_cast<NodeFate::Kind>(kind));
        s += fmt::format("    f{} [label={}, fillcolor={}];\n", kind, quoted(w.title), w.color);
    }

    s += "  }\n  subgraph cluster_program {\n    label=\"program\";\n";
    std::map<int, size_t> writer;   // register -> the instruction whose value it holds
    std::vector<int> ends;
    std::string edges;
    for (size_t i = 0; i < code.instructions.size(); ++i) {
        while (!ends.empty() && ends.back() == static_cast<int>(i)) {
            ends.pop_back();
            s += "    }\n";
        }
        const Instruction& in = code.instructions[i];
        const auto edge = [&](const Slot& slot, const char* style) {
            if (const auto it = slot.kind == Slot::Register ? writer.find(slot.index) : writer.end(); it != writer.end())
                edges += fmt::format("    i{} -> i{} [label=\"r{}\"{}];\n", it->second, i, slot.index, style);
        };
        if (in.kind == Instruction::Region) {
            s += fmt::format("    subgraph cluster_region{} {{\n    label=\"lazy region\"; style=dashed;\n    i{} [label=\"where != 0\", shape=diamond];\n", i, i);
            edge(in.guard, ", style=dashed");
            ends.push_back(in.end);
            continue;
        }
        const IrOp& op = ir.ops[in.op];
        s += fmt::format("    i{} [label={}, fillcolor=white];\n", i, quoted(fmt::format("{}\n{}", op.name, registers_text(in.out))));
        std::vector<int> seen;
        for (const Slot& slot : in.in) {
            if (slot.kind != Slot::Register || std::find(seen.begin(), seen.end(), slot.index) != seen.end()) continue;
            seen.push_back(slot.index);
            edge(slot, "");
        }
        if (op.node >= 0) edges += fmt::format("    n{} -> i{} [style=dotted, arrowhead=none, constraint=false];\n", op.node, i);
        for (int r : in.out)
            if (r >= 0) writer[r] = i;
    }
    for (size_t k = 0; k < ends.size(); ++k) s += "    }\n";
    return s + edges + "  }\n}\n";
}

}  // namespace alder
