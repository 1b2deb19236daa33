// What one node sees of the builder while one of its outputs is built (lowering.h).
#pragma once
#include <fmt/format.h>

#include "graph/builder.h"
#include "graph/builtin_ops.h"

namespace alder {

constexpr int kMaxNestedBump = 2;  ///< a bump inside a bump's height is derived; deeper ones are taken at the centre

/// The Lowering that one node sees while one of its outputs is built.
class NodeLowering final : public Lowering {
  public:
    NodeLowering(Builder& b, int node, int variant, std::map<int, int>* weights, int path_weight)
        : b_(b), node_(node), variant_(variant), statics_(b.statics(node)), weights_(weights), path_weight_(path_weight) {}

    const Statics& statics() const override { return *statics_; }
    bool linked(int param) const override { return statics_->linked[param]; }
    ValueRef input(int param) override { return keep(b_.param_value(node_, param, variant_)); }
    ValueRef displaced_input(int param, int direction, ValueRef width) override {
        if (b_.variants_[variant_].depth >= kMaxNestedBump) return input(param);
        return keep(b_.param_value(node_, param, b_.variant_of(variant_, direction, refs_[width.id].ch[0])));
    }
    bool filters_textures() const override { return b_.filters_textures_; }
    bool fades_noise() const override { return b_.fades_noise_; }
    ValueRef global(Global g) override { return keep(b_.global_value(g, variant_)); }
    ValueRef attribute(const std::string& name, Type type) override {
        IrRef r{type, {}};
        for (int i = 0; i < channels(type); ++i) r.ch[i] = b_.built_.ir.attribute(name, type, i);
        return keep(r);
    }
    ValueRef attribute_or(const std::string& name, Type type, ValueRef fallback) override {
        const int exists = b_.built_.ir.attribute(name + std::string(kExistsSuffix), Type::Float, 0);
        IrRef r{type, {}};
        for (int i = 0; i < channels(type); ++i)
            r.ch[i] = b_.op1("attribute_or", builtin::select(), {exists, b_.built_.ir.attribute(name, type, i), refs_[fallback.id].ch[i]});
        return keep(r);
    }
    ValueRef constant(Type type, double x, double y, double z) override {
        IrRef r{type, {}};
        const double v[3] = {x, y, z};
        for (int i = 0; i < channels(type); ++i) r.ch[i] = b_.built_.ir.literal(v[i]);
        return keep(r);
    }
    ValueRef displaced_global(Global g, int direction, ValueRef width) override {
        if (b_.variants_[variant_].depth >= kMaxNestedBump) return global(g);
        return keep(b_.global_value(g, b_.variant_of(variant_, direction, refs_[width.id].ch[0])));
    }
    ValueRef call(std::span<const ValueRef> params, int output) override {
        std::vector<int> in = flat(params);
        b_.push_globals(*statics_, variant_, in);
        return call_with(std::move(in), output);
    }
    ValueRef call(std::span<const ValueRef> params, std::span<const ValueRef> globals, int output) override {
        std::vector<int> in = flat(params), more = flat(globals);
        in.insert(in.end(), more.begin(), more.end());
        return call_with(std::move(in), output);
    }
    ValueRef call_with(std::vector<int> in, int output) {
        const NodeType& type = *statics_->type;
        int outs = 0, first = 0;
        for (size_t i = 0; i < type.outputs.size(); ++i) {
            if (static_cast<int>(i) == output) first = outs;
            outs += channels(type.outputs[i].type);
        }
        const int op = b_.built_.ir.op(type.kernel, type.name.c_str(), statics_, std::move(in), outs, type.foldable, type.cost_ns, node_);
        IrRef r{type.outputs[output].type, {}};
        for (int i = 0; i < channels(r.type); ++i) r.ch[i] = b_.built_.ir.ops[op].out[first + i];
        return keep(r);
    }
    ValueRef op(const char* name, const Kernel& kernel, std::span<const ValueRef> operands, Type result) override {
        const int op = b_.built_.ir.op(kernel, name, statics_, flat(operands), channels(result), true, 1, node_);
        IrRef r{result, {}};
        for (int i = 0; i < channels(result); ++i) r.ch[i] = b_.built_.ir.ops[op].out[i];
        return keep(r);
    }
    ValueRef convert(ValueRef v, Type to) override { return keep(b_.convert(refs_[v.id], to, statics_->type->system)); }
    void result(ValueRef v) override {
        result_ = refs_[v.id];
        has_result_ = true;
    }
    void pass_closure(int param, ValueRef weight) override {
        const Builder::Place p = b_.behind_groups({node_, param});
        const DocValue& v = b_.at(p.node).params[p.param];
        if (v.kind == DocValue::Default || !weights_) return;
        Ir& ir = b_.built_.ir;
        int w = path_weight_;
        if (weight.valid()) {
            const IrRef f = b_.convert(refs_[weight.id], Type::Float, System::Cycles);
            if (ir.is_constant(f.ch[0]) && ir.guarded(Guard::AllZero, {f.ch[0]})) {
                if (v.kind == DocValue::Link)
                    b_.built_.skipped.emplace_back(b_.target(p.node, v.link), fmt::format("{}.{} has weight 0", b_.built_.name(node_), statics_->type->params[param].name));
                return;
            }
            if (!(ir.is_constant(f.ch[0]) && ir.guarded(Guard::IsOne, {f.ch[0]})))
                w = ir.is_constant(w) && ir.value(w) == 1 ? f.ch[0] : b_.op1("multiply", builtin::multiply(), {w, f.ch[0]});
        }
        if (!b_.links_closure(p)) return b_.emit(p.node, b_.color_of(p.node, p.param), w);
        const auto [it, fresh] = weights_->try_emplace(b_.target(p.node, v.link), w);
        if (!fresh) it->second = b_.op1("add", builtin::add(), {it->second, w});
    }

    void emit(ValueRef color) override {
        if (weights_) b_.emit(node_, b_.convert(refs_[color.id], Type::Color, statics_->type->system), path_weight_);
    }
    void emit_lobes(std::span<const ValueRef> more) override {
        if (weights_ && !b_.collecting_aov_) b_.closure_lobes(node_, path_weight_, b_.filter_, flat(more));
    }

    bool has_result() const { return has_result_; }
    const IrRef& value() const { return result_; }

  private:
    ValueRef keep(IrRef r) {
        refs_.push_back(r);
        return {static_cast<int>(refs_.size()) - 1};
    }
    std::vector<int> flat(std::span<const ValueRef> values) const {
        std::vector<int> in;
        for (ValueRef v : values)
            for (int i = 0; i < channels(refs_[v.id].type); ++i) in.push_back(refs_[v.id].ch[i]);
        return in;
    }

    Builder& b_;
    int node_, variant_;
    std::shared_ptr<const Statics> statics_;
    std::map<int, int>* weights_;
    int path_weight_;
    std::vector<IrRef> refs_;
    IrRef result_;
    bool has_result_ = false;
};

}  // namespace alder
