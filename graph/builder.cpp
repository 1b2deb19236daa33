// Document -> IR for one request: inputs are pulled by what needs them (builder.h).
#include "graph/builder.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/builtin_ops.h"
#include "graph/json_text.h"
#include "graph/node_lowering.h"
#include "nodes/resource_faults.h"

namespace alder {
namespace {

LobeFilter group_of(const LobeSpec& s) {
    if (s.shadow_only) return LobeFilter::Shadow;
    switch (s.kind) {
        case LobeKind::Emission: return LobeFilter::Emission;
        case LobeKind::Transparent:
        case LobeKind::Holdout: return LobeFilter::Transparency;
        case LobeKind::Interior: return LobeFilter::Scatter | LobeFilter::Shadow;
        default: return LobeFilter::Scatter;
    }
}

}  // namespace

std::string Builder::pointer_to(int node, const std::string& param) const {
    const int parent = built_.nodes[node].parent;
    return options_.pointer_prefix + (parent < 0 ? "" : at(parent).group->pointer) + "/nodes/" + pointer_token(at(node).name) +
           (param.empty() ? "" : "/params/" + pointer_token(param));
}

/// "PARAMETER: SENTENCE", "PARAMETER.MEMBER: FOUND\nEXPECTED\nSUGGESTION", or a sentence about the node.
Diagnostic Builder::prepare_fault(int node, const std::string& text) const {
    const DocNode& n = at(node);
    const auto colon = text.find(':');
    std::string name = colon == std::string::npos ? std::string() : text.substr(0, colon), member;
    if (const auto dot = name.find('.'); dot != std::string::npos) {
        member = "/" + pointer_token(name.substr(dot + 1));
        name.resize(dot);
    }
    const int param = n.type->param_index(name);
    if (param < 0) return {pointer_to(node), "invalid-value", text, "a usable " + n.type->name, ""};
    Diagnostic d{pointer_to(node, n.type->params[param].name) + member, "invalid-value", text.substr(colon + 2), "a usable " + n.type->name, ""};
    if (const auto line = d.found.find('\n'); line != std::string::npos) {
        const auto second = d.found.find('\n', line + 1);
        d.expected = d.found.substr(line + 1, second - line - 1);
        if (second != std::string::npos) d.suggest = d.found.substr(second + 1);
        d.found.resize(line);
    }
    return d;
}

std::shared_ptr<const Statics> Builder::statics(int node) {
    const DocNode& n = at(node);
    NodeStatics& slot = statics_[&n];
    if (slot.statics) return slot.statics;
    auto s = std::make_shared<Statics>(make_statics(n));
    slot.asked.assign(n.type->params.size(), 0);
    slot.node = node;
    s->asked = &slot.asked;
    if (n.type->lobes) {
        s->lobes = n.type->lobes(*s);
        int offset = 0;
        for (const auto& l : s->lobes) {
            s->lobe_offset.push_back(offset);
            offset += l.channels();
        }
    }
    if (n.type->prepare) {
        std::vector<std::string> errors;
        s->prepared = n.type->prepare(*s, errors);
        for (LobeSpec& l : s->lobes) l.prepared = s->prepared;
        for (const auto& e : errors) {
            if (d_.errors.size() < kMaxDiagnostics) d_.errors.push_back(prepare_fault(node, e));
        }
        if (const auto* resources = dynamic_cast<const ResourceFaults*>(s->prepared.get())) {
            built_.resources.emplace_back(pointer_to(node), s->prepared);
            for (const auto& f : resources->faults) {
                auto& list = options_.strict ? d_.errors : d_.warnings;
                const std::string shown = options_.strict ? "a file that can be read" : "a file that can be read; it is rendered magenta";
                if (list.size() < kMaxDiagnostics) list.push_back({pointer_to(node, f.parameter), "asset-unreadable", f.file + ": " + f.reason, shown, ""});
            }
        }
    }
    slot.statics = s;
    return s;
}

/// Writes a group out: its nodes get numbers of their own. Nothing is copied, and nothing inside is built before it is asked for.
int Builder::expand(int node) {
    if (built_.nodes[node].inside >= 0) return built_.nodes[node].inside;
    const int first = static_cast<int>(built_.nodes.size());
    for (const auto& n : at(node).group->nodes) built_.nodes.push_back({n.get(), first, node});
    return built_.nodes[node].inside = first;
}

bool Builder::links_closure(Place p) const {
    const DocValue& v = at(p.node).params[p.param];
    return v.kind == DocValue::Link && at(target(p.node, v.link)).type->outputs[v.link.output].type == Type::Closure;
}

Builder::Place Builder::behind_groups(Place p) {
    while (links_closure(p)) {
        const DocLink& link = at(p.node).params[p.param].link;
        const int to = target(p.node, link);
        const int socket = link.output;  // sockets of an interface have one number on both sides
        if (at(to).role == DocNode::Group) {
            built_.touched.insert(to);
            p = {expand(to) + at(to).group->output_node, socket};
        } else if (at(to).role == DocNode::GroupInput) {
            p = {built_.nodes[to].parent, socket};
        } else {
            break;
        }
    }
    return p;
}

int Builder::variant_of(int parent, int direction, int width) {
    for (size_t i = 1; i < variants_.size(); ++i)
        if (variants_[i].parent == parent && variants_[i].direction == direction && variants_[i].width == width) return static_cast<int>(i);
    variants_.push_back({parent, direction, width, variants_[parent].depth + 1});
    return static_cast<int>(variants_.size()) - 1;
}

int Builder::op1(const char* name, const Kernel& kernel, std::vector<int> in) {
    return built_.ir.ops[built_.ir.op(kernel, name, nullptr, std::move(in), 1, true, 0.3f, -1)].out[0];
}

IrRef Builder::global_value(Global g, int variant) {
    const int n = channels(g);
    IrRef r{n == 3 ? Type::Vector : Type::Float, {}};
    for (int i = 0; i < n; ++i) r.ch[i] = built_.ir.global(g, i);
    if (variant == 0) return r;
    Global dx, dy;
    switch (g) {
        case Global::P: dx = Global::Dpdx, dy = Global::Dpdy; break;
        case Global::Po: dx = Global::Dpodx, dy = Global::Dpody; break;
        case Global::Uv: dx = Global::Duvdx, dy = Global::Duvdy; break;
        case Global::Generated: dx = Global::Dgendx, dy = Global::Dgendy; break;
        default: return r;
    }
    const Variant v = variants_[variant];
    r = global_value(g, v.parent);
    for (int i = 0; i < n; ++i)
        r.ch[i] = op1("displace", builtin::mad(), {built_.ir.global(v.direction == 1 ? dx : dy, i), v.width, r.ch[i]});
    return r;
}

IrRef Builder::convert(IrRef v, Type to, System system) {
    if (v.type == to || to == Type::Closure) return v;
    IrRef r{to, v.ch};
    const int from_channels = channels(v.type), to_channels = channels(to);
    if (to_channels == 3) {
        if (from_channels == 1) r.ch = {v.ch[0], v.ch[0], v.ch[0]};
        return r;
    }
    int c = v.ch[0];
    if (from_channels == 3)
        c = system == System::Cycles && v.type == Type::Color ? op1("luminance", builtin::luminance_cycles(), {v.ch[0], v.ch[1], v.ch[2]})
                                                              : op1("mean", builtin::mean(), {v.ch[0], v.ch[1], v.ch[2]});
    if (to == Type::Int && v.type != Type::Bool) c = op1("to_int", builtin::to_int(), {c});
    if (to == Type::Bool) c = op1("to_bool", builtin::to_bool(), {c});
    r.ch = {c, -1, -1};
    return r;
}

IrRef Builder::constant_param(int node, int param) {
    const DocNode& n = at(node);
    const Param& p = n.type->params[param];
    const auto& number = n.params[param].kind == DocValue::Constant ? n.params[param].number : p.number;
    IrRef r{p.type, {}};
    const auto [it, fresh] = built_.leaves.try_emplace({node, param}, std::pair(0, channels(p.type)));
    for (int i = 0; i < channels(p.type); ++i) {
        const int c = fresh ? built_.ir.leaf(number[i]) : it->second.first + i;
        if (fresh && i == 0) it->second.first = c;
        r.ch[i] = c;
    }
    return r;
}

IrRef Builder::param_value(int node, int param, int variant) {
    const DocNode& n = at(node);
    const Param& p = n.type->params[param];
    const DocValue& v = n.params[param];
    switch (v.kind) {
        case DocValue::Link: return link_value(node, v.link, n.type->system, p.type, variant);
        case DocValue::Attribute: {
            IrRef r{p.type, {}};
            for (int i = 0; i < channels(p.type); ++i) r.ch[i] = built_.ir.attribute(v.text, p.type, i);
            return r;
        }
        case DocValue::Default:
            if (p.has_default_global) return convert(global_value(p.default_global, variant), p.type, n.type->system);
            [[fallthrough]];
        case DocValue::Constant:
            // Blender's hidden vector sockets: a constant that is written out is the socket's value only where no global stands in.
            return constant_param(node, param);
    }
    return {};
}

IrRef Builder::link_value(int node, const DocLink& link, System consumer, Type to, int variant) {
    IrRef r = node_output(node < 0 ? link.node : target(node, link), link.output, variant);
    if (link.component >= 0) {
        IrRef one{Type::Float, {}};
        one.ch[0] = channels(r.type) == 1 ? r.ch[0] : link.component < 3 ? r.ch[link.component] : built_.ir.literal(1);
        r = one;
    }
    return convert(r, to, consumer);
}

IrRef Builder::node_output(int node, int output, int variant) {
    const auto key = std::make_tuple(node, output, variant);
    if (const auto it = memo_.find(key); it != memo_.end()) return it->second;
    built_.touched.insert(node);
    const NodeType& type = *at(node).type;
    IrRef r;
    if (at(node).role == DocNode::Group) {
        r = param_value(expand(node) + at(node).group->output_node, output, variant);
    } else if (at(node).role == DocNode::GroupInput) {
        r = param_value(built_.nodes[node].parent, output, variant);
    } else if (type.lower && type.outputs[output].type != Type::Closure) {
        NodeLowering lowering(*this, node, variant, nullptr, -1);
        type.lower(lowering, output);
        r = lowering.has_result() ? convert(lowering.value(), type.outputs[output].type, type.system) : run_kernel(node, output, variant);
    } else {
        r = run_kernel(node, output, variant);
    }
    memo_[key] = r;
    return r;
}

int Builder::lazy_guard(const LazyRule& rule, IrRef selector, IrRef second, bool& needed, bool& always) {
    Ir& ir = built_.ir;
    const int s = selector.ch[0];
    const bool constant = ir.is_constant(s) && (rule.second < 0 || ir.is_constant(second.ch[0]));
    needed = always = false;
    switch (rule.when) {
        case LazyRule::NeededIfNonZero:
            if (constant) return needed = always = ir.guarded(Guard::NonZero, {s}), -1;
            needed = true;
            return op1("guard", builtin::guard_nonzero(), {s});
        case LazyRule::NeededIfPositive:
            if (constant) return needed = always = ir.guarded(Guard::Positive, {s}), -1;
            needed = true;
            return op1("guard", builtin::guard_positive(), {s});
        case LazyRule::NeededIfBelowOne:
            if (constant) return needed = always = ir.guarded(Guard::BelowOne, {s}), -1;
            needed = true;
            return op1("guard", builtin::guard_below_one(), {s});
        case LazyRule::NeededIfIndex:
            if (constant) return needed = always = ir.guarded(Guard::SwitchIndex, {s, second.ch[0]}, rule.index), -1;
            needed = true;
            return op1("guard", builtin::guard_switch(), {s, second.ch[0], ir.literal(rule.index)});
    }
    return -1;
}

std::vector<int> Builder::kernel_operands(int node, const Statics& s, int variant, uint64_t lobes, std::vector<LazyUse>& lazy) {
    const DocNode& n = at(node);
    const NodeType& type = *n.type;
    std::vector<LazyRule> rules;
    if (type.lazy) rules = type.lazy(s);
    const auto skip = [&](size_t i, const std::string& why) {
        if (n.params[i].kind == DocValue::Link)
            built_.skipped.emplace_back(target(node, n.params[i].link), fmt::format("{}.{}: {}", built_.name(node), type.params[i].name, why));
    };
    std::vector<int> in;
    for (size_t i = 0; i < type.params.size(); ++i) {
        const Param& p = type.params[i];
        const int count = channels(p.type);
        if (count == 0) continue;
        IrRef r;
        int guard = -1;
        if ((type.uses && !type.uses(s, static_cast<int>(i))) || (p.link_only && !s.linked[i] && !p.has_default_global)) {
            skip(i, "has no effect with these settings");
            r = constant_param(node, static_cast<int>(i));
        } else if (type.lobes && (p.only_lobes & lobes) == 0) {
            skip(i, "only feeds lobes that are not there");
            r = constant_param(node, static_cast<int>(i));
        } else {
            bool wanted = true;
            for (const auto& rule : rules) {
                if (rule.param != static_cast<int>(i)) continue;
                const IrRef selector = param_value(node, rule.selector, variant);
                const IrRef second = rule.second >= 0 ? param_value(node, rule.second, variant) : IrRef();
                bool needed, always;
                const int g = lazy_guard(rule, selector, second, needed, always);
                if (!needed) wanted = false;
                else if (!always) guard = guard < 0 ? g : op1("and", builtin::multiply(), {guard, g});
            }
            if (!wanted) skip(i, fmt::format("not selected"));
            r = wanted ? param_value(node, static_cast<int>(i), variant) : constant_param(node, static_cast<int>(i));
            if (!wanted) guard = -1;
        }
        if (guard >= 0) lazy.push_back({static_cast<int>(in.size()), static_cast<int>(in.size()) + count, guard});
        for (int k = 0; k < count; ++k) in.push_back(r.ch[k]);
    }
    push_globals(s, variant, in);
    return in;
}

void Builder::push_globals(const Statics& s, int variant, std::vector<int>& in) {
    const NodeType& type = *s.type;
    for (size_t i = 0; i < type.globals.size(); ++i) {
        const Global g = type.globals[i];
        const bool used = !type.uses_global || type.uses_global(s, static_cast<int>(i));
        const IrRef r = used ? global_value(g, variant) : IrRef();
        for (int k = 0; k < channels(g); ++k) in.push_back(used ? r.ch[k] : built_.ir.literal(0));
    }
}

IrRef Builder::run_kernel(int node, int output, int variant) {
    const auto s = statics(node);
    const NodeType& type = *s->type;
    std::vector<LazyUse> lazy;
    std::vector<int> in = kernel_operands(node, *s, variant, ~uint64_t{0}, lazy);
    int outs = 0, first = 0;
    for (size_t i = 0; i < type.outputs.size(); ++i) {
        if (static_cast<int>(i) == output) first = outs;
        outs += channels(type.outputs[i].type);
    }
    const size_t before = built_.ir.ops.size();
    const int op = built_.ir.op(type.kernel, type.name.c_str(), s, std::move(in), outs, type.foldable, type.cost_ns, node);
    if (built_.ir.ops.size() > before) built_.ir.ops[op].lazy = std::move(lazy);
    IrRef r{type.outputs[output].type, {}};
    for (int i = 0; i < channels(r.type); ++i) r.ch[i] = built_.ir.ops[op].out[first + i];
    return r;
}

void Builder::closure_lobes(int node, int weight, LobeFilter filter, const std::vector<int>& more) {
    Ir& ir = built_.ir;
    const auto s = statics(node);
    const NodeType& type = *s->type;
    const std::string name = built_.name(node);
    built_.touched.insert(node);
    uint64_t kept = 0;
    for (size_t i = 0; i < s->lobes.size(); ++i) {
        const LobeSpec& spec = s->lobes[i];
        if (!has(filter, group_of(spec))) continue;
        // A volume's closures mean nothing on a surface and the other way round, but for light that either emits.
        if (in_volume_ ? !spec.is_volume() && spec.kind != LobeKind::Emission : spec.is_volume()) continue;
        bool dead = false;
        for (int pass = 0; pass < 2 && !dead; ++pass)  // constants first: they may spare building a network
            for (int gate : spec.gates) {
                if ((pass == 0) == s->linked[gate] || dead) continue;
                const IrRef v = param_value(node, gate, 0);
                std::vector<int> ch(v.ch.begin(), v.ch.begin() + channels(v.type));
                if (std::all_of(ch.begin(), ch.end(), [&](int c) { return ir.is_constant(c); })) dead = ir.guarded(Guard::AllZero, ch);
            }
        if (!dead) kept |= uint64_t{1} << i;
    }
    if (kept == 0) return;
    std::vector<LazyUse> lazy;
    std::vector<int> in = kernel_operands(node, *s, 0, kept, lazy);
    in.insert(in.end(), more.begin(), more.end());
    const int outs = s->lobes.empty() ? 0 : s->lobe_offset.back() + s->lobes.back().channels();
    const size_t before = ir.ops.size();
    const int op = ir.op(type.kernel, type.name.c_str(), s, std::move(in), outs, type.foldable, type.cost_ns, node);
    if (ir.ops.size() > before) ir.ops[op].lazy = std::move(lazy);

    const bool one = ir.is_constant(weight) && ir.guarded(Guard::IsOne, {weight});
    const int guard = one || ir.is_constant(weight) || ir.ops[op].folded ? -1 : op1("guard", builtin::guard_nonzero(), {weight});
    for (size_t i = 0; i < s->lobes.size(); ++i) {
        if (!(kept >> i & 1)) continue;
        BuiltLobe lobe{s->lobes[i], {}, guard, name};
        for (int c = 0; c < s->lobes[i].channels(); ++c) {
            int ch = ir.ops[op].out[s->lobe_offset[i] + c];
            if (c < 3 && !one) {
                const size_t count = ir.ops.size();
                const int m = ir.op(builtin::multiply(), "weigh", nullptr, {ch, weight}, 1, true, 0.3f, -1);
                if (guard >= 0 && ir.ops.size() > count) ir.ops[m].lazy.push_back({0, 1, guard});
                ch = ir.ops[m].out[0];
            }
            lobe.channels.push_back(ch);
        }
        const std::vector<int> w(lobe.channels.begin(), lobe.channels.begin() + 3);
        if (std::all_of(w.begin(), w.end(), [&](int c) { return ir.is_constant(c); }) && ir.guarded(Guard::AllZero, w)) continue;
        built_.lobes.push_back(std::move(lobe));
    }
}

/// A colour that stands where a closure is expected.
IrRef Builder::color_of(int node, int param) {
    const DocNode& n = at(node);
    const DocValue& v = n.params[param];
    if (v.kind == DocValue::Link) return link_value(node, v.link, n.type->system, Type::Color, 0);
    IrRef r{Type::Color, {}};
    for (int i = 0; i < 3; ++i)
        r.ch[i] = v.kind == DocValue::Attribute ? built_.ir.attribute(v.text, Type::Color, i) : built_.ir.literal(v.number[i]);
    return r;
}

/// An emission lobe of the node's own.
void Builder::emit(int node, IrRef color, int weight) {
    Ir& ir = built_.ir;
    if (!has(filter_, LobeFilter::Emission) || collecting_aov_) return;
    const bool one = ir.is_constant(weight) && ir.guarded(Guard::IsOne, {weight});
    BuiltLobe lobe{LobeSpec{LobeKind::Emission, LobeLabel::Emission}, {}, -1, built_.name(node)};
    for (int i = 0; i < 3; ++i) lobe.channels.push_back(one ? color.ch[i] : op1("weigh", builtin::multiply(), {color.ch[i], weight}));
    for (int i = 3; i < lobe.spec.channels(); ++i) lobe.channels.push_back(ir.literal(0));
    const std::vector<int> w(lobe.channels.begin(), lobe.channels.begin() + 3);
    if (std::all_of(w.begin(), w.end(), [&](int c) { return ir.is_constant(c); }) && ir.guarded(Guard::AllZero, w)) return;
    built_.lobes.push_back(std::move(lobe));
}

/// A closure asked for as a value: the light it emits.
IrRef Builder::emission_of(const DocLink& link) {
    const size_t before = built_.lobes.size();
    closure(link, built_.ir.literal(1), LobeFilter::Emission);
    IrRef sum{Type::Color, {built_.ir.literal(0), built_.ir.literal(0), built_.ir.literal(0)}};
    for (size_t k = before; k < built_.lobes.size(); ++k)
        for (int i = 0; i < 3; ++i) sum.ch[i] = op1("add", builtin::add(), {sum.ch[i], built_.lobes[k].channels[i]});
    built_.lobes.resize(before);
    return sum;
}

/// All closures below `link`: parents before children, so that a closure reached on several ways is emitted once with the
/// sum of its weights.
void Builder::closure(const DocLink& link, int weight, LobeFilter filter) {
    filter_ = filter;
    int root = link.node, output = link.output;
    if (at(root).role == DocNode::Group) {
        built_.touched.insert(root);
        const Place p = behind_groups({expand(root) + at(root).group->output_node, link.output});
        const DocValue& v = at(p.node).params[p.param];
        if (v.kind == DocValue::Default) return;
        if (!links_closure(p)) return emit(p.node, color_of(p.node, p.param), weight);
        root = target(p.node, v.link);
        output = v.link.output;
    }
    std::vector<int> order;
    std::map<int, char> state;
    std::vector<std::pair<int, size_t>> stack{{root, 0}};
    state[root] = 1;
    while (!stack.empty()) {
        auto& [node, param] = stack.back();
        const DocNode& n = at(node);
        Place p{node, 0};
        for (; param < n.params.size(); ++param)
            if (n.type->params[param].type == Type::Closure && links_closure(p = behind_groups({node, static_cast<int>(param)}))) break;
        if (param == n.params.size()) {
            order.push_back(node);
            stack.pop_back();
            continue;
        }
        ++param;
        const int to = target(p.node, at(p.node).params[p.param].link);
        if (!state[to]) {
            state[to] = 1;
            stack.emplace_back(to, 0);
        }
    }
    std::map<int, int> weights{{root, weight}};
    for (auto it = order.rbegin(); it != order.rend(); ++it) {
        const auto w = weights.find(*it);
        if (w == weights.end()) continue;
        const NodeType& type = *at(*it).type;
        if (collecting_aov_) {
            for (const auto& [aov, param] : type.closure_aovs) {
                if (aov != aov_name_) continue;
                const IrRef v = convert(param_value(*it, param, 0), Type::Color, type.system);
                for (int i = 0; i < 3; ++i) {
                    const int m = op1("multiply", builtin::multiply(), {v.ch[i], w->second});
                    aov_sum_.ch[i] = aov_found_ ? op1("add", builtin::add(), {aov_sum_.ch[i], m}) : m;
                }
                aov_found_ = true;
            }
        }
        if (type.lower) {
            built_.touched.insert(*it);
            NodeLowering lowering(*this, *it, 0, &weights, w->second);
            type.lower(lowering, *it == root ? output : 0);
        } else if (type.lobes && !collecting_aov_) {
            closure_lobes(*it, w->second, filter);
        }
    }
}

void Builder::build(const ProgramRequest& request) {
    filters_textures_ = request.filter_textures;
    fades_noise_ = request.fade_noise;
    const auto add = [&](const std::string& name, IrRef r) {
        built_.outputs.push_back(r);
        built_.output_names.push_back(name);
    };
    for (const auto& text : request.outputs) {
        DocLink link;
        if (!document_.find_output(text, link)) {
            std::vector<std::string> names;
            for (const auto& n : document_.nodes)
                for (const auto& o : n->type->outputs) names.push_back(n->name + "." + o.name);
            d_.errors.push_back({"/outputs", "unknown-output", text, "NODE.OUTPUT of the graph", nearest_name(text, names)});
            continue;
        }
        if (document_.nodes[link.node]->type->outputs[link.output].type == Type::Closure) {
            add(text, emission_of(link));
            continue;
        }
        add(text, node_output(link.node, link.output, 0));
    }
    for (const auto& name : request.aovs) {
        const auto it = std::find_if(document_.outputs.aovs.begin(), document_.outputs.aovs.end(), [&](auto& a) { return a.first == name; });
        if (it != document_.outputs.aovs.end()) {
            const auto& link = it->second;
            const auto& node = *document_.nodes[link.node];
            add(name, link_value(-1, link, node.type->system, link.component >= 0 ? Type::Float : node.type->outputs[link.output].type, 0));
            continue;
        }
        collecting_aov_ = true;
        aov_name_ = name;
        aov_found_ = false;
        aov_sum_ = {Type::Color, {}};
        if (document_.outputs.surface.node >= 0) closure(document_.outputs.surface, built_.ir.literal(1), LobeFilter::None);
        collecting_aov_ = false;
        if (!aov_found_)
            for (int i = 0; i < 3; ++i) aov_sum_.ch[i] = built_.ir.literal(0);
        add(name, aov_sum_);
    }
    if (request.displacement && document_.outputs.displacement.node >= 0) {
        const auto& link = document_.outputs.displacement;
        add("displacement", link_value(-1, link, document_.nodes[link.node]->type->system, Type::Vector, 0));
    }
    if (request.surface != LobeFilter::None && document_.outputs.surface.node >= 0)
        closure(document_.outputs.surface, built_.ir.literal(1), request.surface);
    if (request.volume && document_.outputs.volume.node >= 0) {
        in_volume_ = true;
        closure(document_.outputs.volume, built_.ir.literal(1), LobeFilter::Scatter | LobeFilter::Emission);
    }
    for (auto& [n, s] : statics_) {
        if (s.statics) s.statics->asked = nullptr;
        for (size_t i = 0; i < s.asked.size(); ++i)
            if (s.asked[i]) built_.asked.insert({s.node, static_cast<int>(i)});
    }
}

}  // namespace alder
