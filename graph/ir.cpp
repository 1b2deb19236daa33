#include "graph/ir.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace alder {
namespace {

uint64_t mix(uint64_t h, uint64_t v) {
    h ^= v + 0x9e3779b97f4a7c15ull + (h << 6) + (h >> 2);
    return h * 0xff51afd7ed558ccdull;
}

uint64_t hash_statics(const Statics* s) {
    if (!s) return 0;
    uint64_t h = mix(1, reinterpret_cast<uint64_t>(s->type));
    for (int e : s->enums) h = mix(h, static_cast<uint64_t>(e));
    for (const auto& t : s->text)
        if (!t.empty()) h = mix(h, std::hash<std::string>()(t));
    for (bool l : s->linked) h = mix(h, l);
    h = mix(h, s->lobes.size());
    return h;
}

}  // namespace

bool same_statics(const Statics* a, const Statics* b) {
    if (a == b) return true;
    if (!a || !b || a->type != b->type || a->enums != b->enums || a->text != b->text || a->linked != b->linked) return false;
    if (a->lobes.size() != b->lobes.size() || a->lobe_offset != b->lobe_offset) return false;  // linked or not decides layouts
    return true;
}

int Ir::add_channel(IrChannel c, double v) {
    channels.push_back(c);
    values.f.push_back(static_cast<float>(v));
    values.d.push_back(v);
    return static_cast<int>(channels.size()) - 1;
}

int Ir::leaf(double v) {
    IrChannel c;
    c.kind = ChannelKind::Constant;
    c.constant = true;
    return add_channel(c, static_cast<float>(v));  // double runs start from the same float inputs: differences are rounding
}

int Ir::literal(double v) {
    const auto [it, fresh] = literal_by_bits_.try_emplace(std::bit_cast<uint64_t>(v), 0);
    if (fresh) it->second = leaf(v);
    return it->second;
}

int Ir::global(Global g, int component) {
    const auto [it, fresh] = global_by_key_.try_emplace(static_cast<uint32_t>(g) * 4u + component, 0);
    if (fresh) {
        IrChannel c;
        c.kind = ChannelKind::Global;
        c.global = g;
        c.component = static_cast<uint8_t>(component);
        it->second = add_channel(c, 0);
    }
    return it->second;
}

int Ir::attribute(const std::string& name, Type type, int component) {
    int index = -1;
    for (size_t i = 0; i < attributes.size(); ++i)
        if (attributes[i].name == name && attributes[i].type == type) index = static_cast<int>(i);
    if (index < 0) {
        index = static_cast<int>(attributes.size());
        attributes.push_back({name, type});
    }
    const uint32_t key = 0x80000000u | (static_cast<uint32_t>(index) * 4u + component);
    const auto [it, fresh] = global_by_key_.try_emplace(key, 0);
    if (fresh) {
        IrChannel c;
        c.kind = ChannelKind::Attribute;
        c.attribute = index;
        c.component = static_cast<uint8_t>(component);
        it->second = add_channel(c, 0);
    }
    return it->second;
}

// Constants enter the hash by value, so that two nodes with equal parameters meet. Not where the op folds: there only the same
// channels meet (see op()), and thousands of nodes with equal constants would queue up under one hash.
uint64_t Ir::hash_of(const Kernel& k, const Statics* s, const std::vector<int>& in, bool folds) const {
    uint64_t h = mix(reinterpret_cast<uint64_t>(k.lanes), hash_statics(s));
    if (folds) {
        for (int c : in) h = mix(h, static_cast<uint64_t>(c));
        return h;
    }
    for (int c : in) h = mix(h, channels[c].constant ? std::bit_cast<uint64_t>(values.d[c]) | 1ull << 63 : static_cast<uint64_t>(c));
    return h;
}

bool Ir::same_op(const IrOp& o, const Kernel& k, const Statics* s, const std::vector<int>& in, bool& by_value) const {
    if (o.kernel.lanes != k.lanes || o.in.size() != in.size()) return false;
    by_value = false;
    for (size_t i = 0; i < in.size(); ++i) {
        if (o.in[i] == in[i]) continue;
        if (!channels[in[i]].constant || !channels[o.in[i]].constant) return false;
        if (std::bit_cast<uint64_t>(values.d[in[i]]) != std::bit_cast<uint64_t>(values.d[o.in[i]])) return false;
        by_value = true;
    }
    return same_statics(o.statics.get(), s);
}

void Ir::run_folded(const IrOp& o, IrValues& v) const {
    thread_local std::vector<Channel<float>> in_f;
    thread_local std::vector<Channel<double>> in_d;
    thread_local std::vector<float*> out_f;
    thread_local std::vector<double*> out_d;
    in_f.resize(o.in.size());
    in_d.resize(o.in.size());
    out_f.resize(o.out.size());
    out_d.resize(o.out.size());
    for (size_t i = 0; i < o.in.size(); ++i) {
        in_f[i] = {&v.f[o.in[i]], 0};
        in_d[i] = {&v.d[o.in[i]], 0};
    }
    for (size_t i = 0; i < o.out.size(); ++i) {
        out_f[i] = &v.f[o.out[i]];
        out_d[i] = &v.d[o.out[i]];
    }
    static const EvalContext context;
    o.kernel.scalar({in_f.data(), out_f.data(), o.statics.get(), &context, 1});
    o.kernel.f64({in_d.data(), out_d.data(), o.statics.get(), &context, 1});
}

int Ir::op(const Kernel& kernel, const char* name, std::shared_ptr<const Statics> statics, std::vector<int> in, int outs,
           bool foldable, float cost_ns, int node) {
    const bool folds = foldable && std::all_of(in.begin(), in.end(), [&](int c) { return channels[c].constant; });
    const uint64_t h = hash_of(kernel, statics.get(), in, folds);
    const auto [first, last] = op_by_hash_.equal_range(h);
    for (auto it = first; it != last; ++it) {
        bool by_value = false;
        const IrOp& o = ops[it->second];
        if (static_cast<int>(o.out.size()) != outs || !same_op(o, kernel, statics.get(), in, by_value)) continue;
        if (by_value && !o.folded)
            for (size_t i = 0; i < in.size(); ++i)
                if (o.in[i] != in[i]) guards.push_back({Guard::SameBits, {o.in[i], in[i]}, 0, true});
        // A folded op met by value would tie two parameters together for nothing: compute it again instead.
        if (by_value && o.folded) continue;
        ++merged;
        if (node >= 0 && o.node >= 0 && o.node != node) merges.emplace_back(node, o.node);
        return it->second;
    }
    IrOp o;
    o.kernel = kernel;
    o.name = name;
    o.statics = std::move(statics);
    o.in = std::move(in);
    o.node = node;
    o.cost_ns = cost_ns;
    o.foldable = foldable;
    o.folded = folds;
    const int index = static_cast<int>(ops.size());
    for (int i = 0; i < outs; ++i) {
        IrChannel c;
        c.kind = ChannelKind::Op;
        c.constant = o.folded;
        c.op = index;
        c.out = i;
        o.out.push_back(add_channel(c, 0));
    }
    if (o.folded) {
        run_folded(o, values);
        ++folded;
    }
    ops.push_back(std::move(o));
    op_by_hash_.emplace(h, index);
    return index;
}

bool Ir::holds(const Guard& g, const IrValues& v) {
    const auto at = [&](int i) { return v.f[g.channels[i]]; };
    bool now = false;
    switch (g.kind) {
        case Guard::NonZero: now = at(0) != 0; break;
        case Guard::Positive: now = at(0) > 0; break;
        case Guard::BelowOne: now = at(0) < 1; break;
        case Guard::IsOne: now = at(0) == 1; break;
        case Guard::AllZero:
            now = std::all_of(g.channels.begin(), g.channels.end(), [&](int c) { return v.f[c] == 0; });
            break;
        case Guard::SwitchIndex: {
            // alSwitch: round by threshold, clamp to the inputs (alshaders specification, section 2).
            float i = std::floor(at(0));
            if (at(0) - i >= at(1)) i += 1;
            now = (std::isnan(i) ? 0 : static_cast<int>(std::clamp(i, 0.0f, 7.0f))) == g.index;
            break;
        }
        case Guard::SameBits:
            now = std::bit_cast<uint64_t>(v.d[g.channels[0]]) == std::bit_cast<uint64_t>(v.d[g.channels[1]]);
            break;
    }
    return now == g.outcome;
}

bool Ir::guarded(Guard::Kind kind, std::vector<int> chans, int index) {
    Guard g{kind, std::move(chans), index, true};
    g.outcome = holds(g, values);
    guards.push_back(g);
    return g.outcome;
}

bool Ir::recompute(IrValues& v, const std::vector<int>& changed) const {
    std::vector<char> dirty(channels.size(), 0);
    for (int c : changed) dirty[c] = 1;
    for (const auto& o : ops) {
        if (!o.folded || std::none_of(o.in.begin(), o.in.end(), [&](int c) { return dirty[c]; })) continue;
        run_folded(o, v);
        for (int c : o.out) dirty[c] = 1;
    }
    for (const auto& g : guards)
        if (std::any_of(g.channels.begin(), g.channels.end(), [&](int c) { return dirty[c]; }) && !holds(g, v)) return false;
    return true;
}

}  // namespace alder
