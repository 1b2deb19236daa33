// Code generation: which ops are live, which only some lanes need, in what order they run and where their values lie.
#include "graph/code.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace alder {
namespace {

constexpr float kRegionMinCost = 6;     ///< ns a point: cheaper branches run for every lane and are blended
constexpr float kCompactMinCost = 10;   ///< ns a point: from here gathering lanes pays (ARCHITECTURE measurements)
constexpr int kMaxRegionDepth = 16;     ///< branches nested deeper run with the branch around them: the executor recurses
constexpr int kL1Bytes = 24 * 1024;

/// A guarded part of the program. Ops of a region are needed only where `guard` is not zero, for one consumer.
struct Region {
    int parent = -1;
    int consumer = -1;   ///< op before which it runs; -1 = the end of the program
    int guard = -1;      ///< channel
    int depth = 0;
    float cost = 0;
};

class Generator {
  public:
    explicit Generator(Built built) : b_(std::move(built)), ir_(b_.ir) {}

    std::shared_ptr<const Code> run() {
        collect_roots();
        mark_live();
        assign_regions();
        dissolve_cheap_regions();
        emit_region(0);
        emit_children(0, -1);
        allocate();
        describe();
        code_->ir = std::make_shared<const Ir>(std::move(b_.ir));
        return code_;
    }

  private:
    void collect_roots() {
        for (const auto& o : b_.outputs)
            for (int i = 0; i < channels(o.type); ++i) roots_.emplace_back(o.ch[i], -1);
        for (const auto& l : b_.lobes)
            for (size_t i = 0; i < l.channels.size(); ++i) roots_.emplace_back(l.channels[i], i < 3 ? -1 : l.guard);
        for (const auto& [c, g] : roots_)
            if (g >= 0) roots_extra_.push_back(g);
        for (int g : roots_extra_) roots_.emplace_back(g, -1);
    }

    bool runs(int channel) const { return ir_.channels[channel].op >= 0 && !ir_.channels[channel].constant; }

    void mark_live() {
        live_.assign(ir_.ops.size(), 0);
        wanted_.assign(ir_.channels.size(), 0);
        const auto want = [&](int c) {
            wanted_[c] = 1;
            if (runs(c)) live_[ir_.channels[c].op] = 1;
        };
        for (const auto& [c, g] : roots_) want(c);
        for (int o = static_cast<int>(ir_.ops.size()) - 1; o >= 0; --o) {
            if (!live_[o]) continue;
            for (int c : ir_.ops[o].in) want(c);
            for (const auto& l : ir_.ops[o].lazy) want(l.guard);
        }
        // Ops whose only use is weighing a lobe run at the end: their operand's closure is then one region, not nine.
        tail_.assign(ir_.ops.size(), 0);
        std::vector<char> used(ir_.ops.size(), 0);
        for (size_t o = 0; o < ir_.ops.size(); ++o)
            if (live_[o])
                for (int c : ir_.ops[o].in)
                    if (runs(c)) used[ir_.channels[c].op] = 1;
        for (size_t o = 0; o < ir_.ops.size(); ++o)
            if (live_[o] && !used[o] && !ir_.ops[o].lazy.empty() && std::string_view(ir_.ops[o].name) == "weigh") tail_[o] = 1;
    }

    int find_region(int parent, int consumer, int guard) {
        if (regions_[parent].depth >= kMaxRegionDepth) return parent;
        const auto [it, fresh] = region_by_key_.try_emplace({parent, consumer, guard}, static_cast<int>(regions_.size()));
        if (fresh) regions_.push_back({parent, consumer, guard, regions_[parent].depth + 1, 0});
        return it->second;
    }

    int common(int a, int b) const {
        if (a < 0) return b;
        while (a != b) {
            if (regions_[a].depth >= regions_[b].depth) a = regions_[a].parent;
            else b = regions_[b].parent;
        }
        return a;
    }

    void assign_regions() {
        regions_.assign(1, Region());
        region_.assign(ir_.ops.size(), -1);
        const auto use = [&](int channel, int region) {
            if (runs(channel)) region_[ir_.channels[channel].op] = common(region_[ir_.channels[channel].op], region);
        };
        for (const auto& [c, g] : roots_) use(c, g >= 0 ? find_region(0, -1, g) : 0);
        for (int o = static_cast<int>(ir_.ops.size()) - 1; o >= 0; --o) {
            if (!live_[o]) continue;
            const int here = region_[o];
            std::vector<int> guard(ir_.ops[o].in.size(), -1);
            for (const auto& l : ir_.ops[o].lazy) {
                for (int i = l.first; i < l.last; ++i) guard[i] = l.guard;
                use(l.guard, here);
            }
            for (size_t i = 0; i < ir_.ops[o].in.size(); ++i) {
                const int c = ir_.ops[o].in[i];
                if (!runs(c)) continue;
                if (guard[i] < 0 || tail_[o]) use(c, guard[i] >= 0 ? find_region(0, -1, guard[i]) : here);
                else use(c, find_region(here, o, guard[i]));
            }
        }
    }

    void dissolve_cheap_regions() {
        for (size_t o = 0; o < ir_.ops.size(); ++o)
            if (live_[o])
                for (int r = region_[o]; r > 0; r = regions_[r].parent) regions_[r].cost += ir_.ops[o].cost_ns;
        std::vector<int> to(regions_.size());
        for (size_t r = 0; r < regions_.size(); ++r) {
            int k = static_cast<int>(r);
            while (k > 0 && regions_[k].cost < kRegionMinCost) k = regions_[k].parent;
            to[r] = k;
        }
        for (auto& r : region_)
            if (r >= 0) r = to[r];
        // A region inside a dissolved one hangs on the surviving ancestor, but still before its own consumer.
        for (auto& r : regions_)
            if (r.parent >= 0) r.parent = to[r.parent];
        by_region_.assign(regions_.size(), {});
        for (size_t o = 0; o < ir_.ops.size(); ++o)
            if (live_[o]) by_region_[region_[o]].push_back(static_cast<int>(o));
        children_.clear();
        for (size_t r = 1; r < regions_.size(); ++r)
            if (!by_region_[r].empty() || regions_[r].cost >= kRegionMinCost) children_[{regions_[r].parent, regions_[r].consumer}].push_back(static_cast<int>(r));
    }

    void emit_children(int region, int consumer) {
        const auto it = children_.find({region, consumer});
        if (it == children_.end()) {
            if (consumer == -1) emit_tail();
            return;
        }
        for (int child : it->second) {
            const size_t at = code_->instructions.size();
            Instruction begin;
            begin.kind = Instruction::Region;
            begin.op = child;
            code_->instructions.push_back(begin);
            emit_region(child);
            code_->instructions[at].end = static_cast<int>(code_->instructions.size());
            if (code_->instructions[at].end == static_cast<int>(at) + 1) code_->instructions.pop_back();
        }
        if (consumer == -1) emit_tail();
    }
    void emit_tail() {
        for (size_t o = 0; o < ir_.ops.size(); ++o)
            if (live_[o] && tail_[o]) emit_op(static_cast<int>(o));
    }
    void emit_region(int region) {
        for (int o : by_region_[region]) {
            if (tail_[o]) continue;
            if (const auto it = children_.find({region, o}); it != children_.end()) emit_children(region, o);
            emit_op(o);
        }
    }
    void emit_op(int o) {
        Instruction i;
        i.op = o;
        code_->instructions.push_back(std::move(i));
    }

    Slot slot_of(int channel) {
        const IrChannel& c = ir_.channels[channel];
        if (c.constant) {
            const auto [it, fresh] = uniform_.try_emplace(channel, static_cast<int>(code_->uniforms.size()));
            if (fresh) code_->uniforms.push_back(channel);
            return {Slot::Uniform, it->second};
        }
        if (c.kind == ChannelKind::Op) return {Slot::Register, register_[channel]};
        return {Slot::Input, input_slot(c)};
    }

    int input_slot(const IrChannel& c) {
        const bool attribute = c.kind == ChannelKind::Attribute;
        const auto key = std::make_pair(attribute, attribute ? c.attribute : static_cast<int>(c.global));
        auto it = input_.find(key);
        if (it == input_.end()) {
            ProgramInput in;
            in.is_attribute = attribute;
            if (attribute) {
                in.attribute = ir_.attributes[c.attribute].name;
                in.type = ir_.attributes[c.attribute].type;
                in.channels = channels(in.type);
            } else {
                in.global = c.global;
                in.channels = channels(c.global);
                in.type = in.channels == 3 ? Type::Vector : Type::Float;
            }
            it = input_.emplace(key, next_input_).first;
            next_input_ += in.channels;
            code_->inputs.push_back(in);
        }
        return it->second + c.component;
    }

    /// Linear scan over the instruction order. A register is free again after the last instruction that reads it; a value that
    /// is read inside a region but defined outside must outlive the region.
    void allocate() {
        auto& code = code_->instructions;
        std::vector<int> last(ir_.channels.size(), -1), def(ir_.channels.size(), -1);
        std::vector<int> around(code.size() + 1, -1);   // the innermost region around an instruction
        std::vector<int> open;
        for (size_t i = 0; i < code.size(); ++i) {
            while (!open.empty() && code[open.back()].end <= static_cast<int>(i)) open.pop_back();
            if (!open.empty()) around[i] = open.back();
            if (code[i].kind == Instruction::Region) open.push_back(static_cast<int>(i));
        }
        const auto touch = [&](int c, int at) {
            if (!runs(c)) return;
            // Read inside regions that do not contain the definition: alive to the end of the outermost such region.
            for (int r = around[at]; r >= 0 && !(r < def[c] && def[c] < code[r].end); r = around[r]) at = std::max(at, code[r].end - 1);
            last[c] = std::max(last[c], at);
        };
        for (size_t i = 0; i < code.size(); ++i)
            if (code[i].kind == Instruction::Run)
                for (int c : ir_.ops[code[i].op].out) def[c] = static_cast<int>(i);
        for (size_t i = 0; i < code.size(); ++i) {
            if (code[i].kind == Instruction::Region) touch(regions_[code[i].op].guard, code[i].end - 1);  // read again after the region
            else
                for (int c : ir_.ops[code[i].op].in) touch(c, static_cast<int>(i));
        }
        for (const auto& [c, g] : roots_)
            if (runs(c)) last[c] = static_cast<int>(code.size());

        register_.assign(ir_.channels.size(), -1);
        std::vector<int> free;
        std::vector<std::vector<int>> expire(code.size() + 1);
        int live = 0, most = 0;
        for (size_t i = 0; i < code.size(); ++i) {
            if (code[i].kind == Instruction::Run) {
                const IrOp& o = ir_.ops[code[i].op];
                for (int c : o.in) code[i].in.push_back(slot_of(c));
                for (int c : o.out) {
                    if (!wanted_[c] || last[c] < 0) {
                        code[i].out.push_back(-1);
                        continue;
                    }
                    int r;
                    if (free.empty()) {
                        r = code_->registers++;
                    } else {
                        r = free.back();
                        free.pop_back();
                    }
                    register_[c] = r;
                    code[i].out.push_back(r);
                    most = std::max(most, ++live);
                    expire[std::min<size_t>(last[c], code.size())].push_back(r);
                }
            } else {
                code[i].guard = slot_of(regions_[code[i].op].guard);
                code[i].compact = regions_[code[i].op].cost >= kCompactMinCost;
            }
            // Operands free up only after the op has run: kernels may not alias.
            for (int r : expire[i]) {
                free.push_back(r);
                --live;
            }
        }
        for (size_t i = 0; i < code.size(); ++i) {
            if (code[i].kind != Instruction::Region) continue;
            const int begin = static_cast<int>(i), end = code[i].end;
            std::vector<int> ins, outs;
            for (int k = begin + 1; k < end; ++k) {
                if (code[k].kind == Instruction::Region) {
                    const int g = regions_[code[k].op].guard;
                    if (!ir_.channels[g].constant && !(def[g] > begin && def[g] < end)) ins.push_back(g);
                    continue;
                }
                ++code[i].ops_inside;
                for (int c : ir_.ops[code[k].op].in)
                    if (!ir_.channels[c].constant && !(def[c] > begin && def[c] < end)) ins.push_back(c);
                for (int c : ir_.ops[code[k].op].out)
                    if (register_[c] >= 0 && last[c] >= end) outs.push_back(c);
            }
            std::sort(ins.begin(), ins.end());
            ins.erase(std::unique(ins.begin(), ins.end()), ins.end());
            for (int c : ins) code[i].live_in.push_back(slot_of(c));
            for (int c : outs) code[i].live_out.push_back(register_[c]);
            code_->scratch += ins.size();
        }
        const int per_point = std::max(most, 1) * static_cast<int>(sizeof(float));
        uint32_t batch = 64;
        while (batch < 512 && static_cast<int>(batch * 2) * per_point <= kL1Bytes) batch *= 2;
        code_->batch = batch;

        for (size_t k = 0; k < b_.outputs.size(); ++k) {
            ProgramOutput o{b_.output_names[k], b_.outputs[k].type, static_cast<int>(code_->results.size())};
            for (int i = 0; i < channels(o.type); ++i) code_->results.push_back(slot_of(b_.outputs[k].ch[i]));
            code_->outputs.push_back(o);
        }
        for (const auto& l : b_.lobes) {
            ProgramLobe p{l.spec, static_cast<int>(code_->results.size()), l.node};
            for (int c : l.channels) code_->results.push_back(slot_of(c));
            code_->lobes.push_back(p);
        }
    }

    void describe() {
        auto& s = code_->stats;
        const size_t count = b_.nodes.size();
        const auto stands_for_others = [&](size_t n) {  // a group that is written out, and the ends of its wires inside
            return b_.nodes[n].inside >= 0 || b_.nodes[n].node->role == DocNode::GroupInput || b_.nodes[n].node->role == DocNode::GroupOutput;
        };
        s.folded = ir_.folded;
        s.merged = ir_.merged;
        std::vector<char> live_node(count, 0);
        for (const auto& i : code_->instructions) {
            if (i.kind == Instruction::Region) {
                ++s.regions;
                continue;
            }
            ++s.ops;
            if (ir_.ops[i.op].node >= 0) live_node[ir_.ops[i.op].node] = 1;
        }
        s.live_nodes = static_cast<int>(std::count(live_node.begin(), live_node.end(), 1));
        std::unordered_map<int, const std::string*> reason;  // the first given
        for (const auto& [node, why] : b_.skipped) reason.try_emplace(node, &why);
        std::unordered_map<int, int> merged(ir_.merges.begin(), ir_.merges.end());
        std::unordered_map<int, int> own;                    // node -> one of its ops
        for (size_t o = 0; o < ir_.ops.size(); ++o)
            if (ir_.ops[o].node >= 0) own.try_emplace(ir_.ops[o].node, static_cast<int>(o));
        for (size_t n = 0; n < count; ++n) {
            const int node = static_cast<int>(n);
            NodeFate fate{b_.name(node), NodeFate::Live, "", b_.nodes[n].node->type->name, b_.nodes[n].parent};
            const auto op = own.find(node);
            const auto given = reason.find(node);
            const auto into = merged.find(node);
            if (stands_for_others(n)) {
                fate.kind = NodeFate::Group;
            } else if (live_node[n]) {
                fate.kind = NodeFate::Live;
            } else if (b_.touched.count(node) == 0) {
                fate.kind = given != reason.end() ? NodeFate::Pruned : NodeFate::NotAsked;
                fate.reason = given != reason.end() ? *given->second : "nothing asked for needs it";
            } else if (op != own.end() && !ir_.ops[op->second].folded) {
                fate.kind = NodeFate::Pruned;
                fate.reason = given != reason.end() ? *given->second : "what reads it turned out not to need it";
            } else if (op != own.end()) {
                fate.kind = NodeFate::Folded;
                fate.reason = "folded to a constant:";
                for (size_t i = 0; i < ir_.ops[op->second].out.size() && i < 4; ++i) fate.reason += fmt::format(" {:g}", ir_.values.f[ir_.ops[op->second].out[i]]);
            } else if (into != merged.end()) {
                fate.kind = NodeFate::Merged;
                fate.reason = "merged: computes what " + b_.name(into->second) + " computes";
            } else {
                fate.kind = NodeFate::PassedOn;
                fate.reason = "passes a value of the point, a constant or its input on: nothing to compute";
            }
            if (fate.kind != NodeFate::Group) ++s.nodes;
            if (fate.kind != NodeFate::Group && fate.kind != NodeFate::Live) s.skipped.push_back(fate.name + ": " + fate.reason);
            const auto& params = b_.nodes[n].node->params;
            for (size_t p = 0; p < params.size(); ++p)
                if (params[p].kind == DocValue::Link)
                    code_->links.push_back({b_.nodes[n].base + params[p].link.node, node, b_.nodes[n].node->type->params[p].name});
            code_->nodes.push_back(std::move(fate));
        }
        code_->leaves = b_.leaves;
        code_->asked = b_.asked;
        bool constant = true;
        for (const auto& l : b_.lobes)
            if (l.spec.kind == LobeKind::Emission)
                for (int i = 0; i < 3; ++i) {
                    constant &= ir_.channels[l.channels[i]].constant;
                    code_->emission_channels.push_back(l.channels[i]);
                }
        if (!constant) code_->emission_channels.clear();
    }

    Built b_;
    Ir& ir_;
    std::shared_ptr<Code> code_ = std::make_shared<Code>();
    std::vector<std::pair<int, int>> roots_;  ///< (channel, guard or -1)
    std::vector<int> roots_extra_;
    std::vector<char> live_, wanted_, tail_;
    std::vector<Region> regions_;
    std::map<std::tuple<int, int, int>, int> region_by_key_;  ///< (parent, consumer, guard)
    std::vector<int> region_;                 ///< by op
    std::vector<std::vector<int>> by_region_;
    std::map<std::pair<int, int>, std::vector<int>> children_;  ///< (parent region, consumer) -> regions
    std::map<int, int> uniform_;
    std::map<std::pair<bool, int>, int> input_;
    int next_input_ = 0;
    std::vector<int> register_;
};

}  // namespace

std::shared_ptr<const Code> generate_code(Built built) { return Generator(std::move(built)).run(); }

ProgramImpl::ProgramImpl(std::shared_ptr<const Code> code, IrValues values) : code_(std::move(code)), values_(std::move(values)) {
    uniform_f_.resize(code_->uniforms.size() * kPadding);
    uniform_d_.resize(code_->uniforms.size() * kPadding);
    for (size_t i = 0; i < code_->uniforms.size(); ++i) {
        std::fill_n(uniform_f_.begin() + i * kPadding, kPadding, values_.f[code_->uniforms[i]]);
        std::fill_n(uniform_d_.begin() + i * kPadding, kPadding, values_.d[code_->uniforms[i]]);
    }
    for (const auto& l : code_->lobes) {
        facts_.has_emission |= l.spec.kind == LobeKind::Emission;
        facts_.may_be_transparent |= l.spec.kind == LobeKind::Transparent || l.spec.kind == LobeKind::Holdout;
    }
    if (!code_->emission_channels.empty()) {
        facts_.emission_constant = true;
        for (size_t i = 0; i < code_->emission_channels.size(); ++i) facts_.emission[i % 3] += values_.f[code_->emission_channels[i]];
    }
    facts_.spatially_constant = code_->inputs.empty();
    for (const auto& in : code_->inputs)
        if (!in.is_attribute)
            facts_.needs_derivatives |= (in.global >= Global::Dpdx && in.global <= Global::Dgendy) || in.global == Global::PixelFootprint || in.global == Global::FootprintArea;
}

std::shared_ptr<const ProgramImpl> ProgramImpl::with_constant(int node, int param, const std::array<double, 16>& number) const {
    const auto it = code_->leaves.find({node, param});
    if (it == code_->leaves.end()) return std::make_shared<ProgramImpl>(*this);  // nothing here reads it
    IrValues v = values_;
    std::vector<int> changed;
    for (int i = 0; i < it->second.second; ++i) {
        const int c = it->second.first + i;
        changed.push_back(c);
        v.f[c] = static_cast<float>(number[i]);
        v.d[c] = v.f[c];
    }
    if (!code_->ir->recompute(v, changed)) return nullptr;
    return std::make_shared<ProgramImpl>(code_, std::move(v));
}

}  // namespace alder
