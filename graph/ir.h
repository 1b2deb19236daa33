// IR: what a graph becomes before it is a program. Scalar channels in SSA form, hash-consed on insertion, folded on insertion.
//
// A value of a graph (a colour, a float) is one to three channel numbers, so that broadcasting, taking a component, and
// splitting or joining vectors cost nothing. An op runs a kernel on operand channels and defines result channels. An op whose
// operands are all constant is run at once by its own scalar and double kernels, and remembers how, so that after a changed
// parameter the constants can be computed again without building (Ir::recompute). Decisions taken because of a constant are
// kept as guards: as long as they hold, the structure is right for the new value too.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "nodes/schema.h"

namespace alder {

enum class ChannelKind : uint8_t { Constant, Global, Attribute, Op };

struct IrChannel {
    ChannelKind kind = ChannelKind::Constant;
    bool constant = false;      ///< value known at compile time (kind Constant, or the result of a folded op)
    Global global = Global::P;
    uint8_t component = 0;      ///< of the global or attribute
    int attribute = -1;         ///< index into Ir::attributes
    int op = -1, out = -1;      ///< kind Op: who defines it
};

struct IrAttribute {
    std::string name;
    Type type;
};

/// Operand channels [first, last) of an op that are needed only where channel `guard` is not zero.
struct LazyUse {
    int first, last;
    int guard;
};

struct IrOp {
    Kernel kernel;
    const char* name = "";
    std::shared_ptr<const Statics> statics;
    std::vector<int> in;       ///< channels
    std::vector<int> out;      ///< channels
    std::vector<LazyUse> lazy;
    int node = -1;             ///< index of the document node it came from; -1 = none
    float cost_ns = 1;
    bool foldable = true;
    bool folded = false;
};

struct Guard {
    enum Kind : uint8_t { NonZero, Positive, BelowOne, IsOne, AllZero, SwitchIndex, SameBits } kind;
    std::vector<int> channels;  ///< SwitchIndex: mix, threshold; SameBits: two; AllZero: 1-3; else one
    int index = 0;
    bool outcome = false;
};

/// The constant values of an IR, apart from its structure: replaced as a whole when a parameter changes.
struct IrValues {
    std::vector<float> f;
    std::vector<double> d;
};

class Ir {
  public:
    std::vector<IrChannel> channels;
    std::vector<IrOp> ops;
    std::vector<IrAttribute> attributes;
    std::vector<Guard> guards;
    IrValues values;
    int folded = 0, merged = 0;
    std::vector<std::pair<int, int>> merges;   ///< (node, the node whose op it shares)

    /// A fresh constant leaf (a parameter's component); never shared, so that an edit reaches just its users.
    int leaf(double v);
    /// A constant of our own making; shared by value.
    int literal(double v);
    int global(Global g, int component);
    int attribute(const std::string& name, Type type, int component);
    /// Finds or adds an op; folds it if it can. Returns its index. `in` is taken by value on purpose.
    int op(const Kernel& kernel, const char* name, std::shared_ptr<const Statics> statics, std::vector<int> in, int outs,
           bool foldable, float cost_ns, int node);

    bool is_constant(int channel) const { return channels[channel].constant; }
    float value(int channel) const { return values.f[channel]; }

    /// Evaluates a predicate on constants and remembers the outcome as a guard. All channels must be constant.
    bool guarded(Guard::Kind kind, std::vector<int> chans, int index = 0);
    static bool holds(const Guard& g, const IrValues& v);

    /// Constants after `changed` leaves got the values in `v` (already stored there): runs the folded ops that depend on
    /// them. False if a guard no longer holds.
    bool recompute(IrValues& v, const std::vector<int>& changed) const;

  private:
    std::unordered_multimap<uint64_t, int> op_by_hash_;
    std::unordered_map<uint64_t, int> literal_by_bits_;
    std::unordered_map<uint32_t, int> global_by_key_;
    uint64_t hash_of(const Kernel& k, const Statics* s, const std::vector<int>& in, bool folds) const;
    bool same_op(const IrOp& o, const Kernel& k, const Statics* s, const std::vector<int>& in, bool& by_value) const;
    void run_folded(const IrOp& o, IrValues& v) const;
    int add_channel(IrChannel c, double v);
};

/// Equality of compile-time parameters (what CSE may merge).
bool same_statics(const Statics* a, const Statics* b);

}  // namespace alder
