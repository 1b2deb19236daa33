// Lowering: the interface by which a node turns itself into IR where the default (one op: parameters + globals -> outputs)
// does not fit: aliases of globals, pass-through, several evaluations of an input (Bump), mixing of closures.
#pragma once
#include "nodes/schema.h"

namespace alder {

/// An SSA value of the IR with channels(type) channels. Cheap handle.
struct ValueRef {
    int id = -1;
    bool valid() const { return id >= 0; }
};

class Lowering {
  public:
    virtual ~Lowering() = default;
    virtual const Statics& statics() const = 0;
    virtual bool linked(int param) const = 0;

    /// The value of a parameter (link converted to the parameter's type, constant, or default global).
    virtual ValueRef input(int param) = 0;
    /// The same, evaluated with the shading point displaced along dPdx (1) or dPdy (2) times `filter_width`: P, Po, uv,
    /// Generated move by their per-pixel change. For bump.
    virtual ValueRef displaced_input(int param, int direction, ValueRef filter_width) = 0;
    /// A global seen from there.
    virtual ValueRef displaced_global(Global g, int direction, ValueRef filter_width) = 0;
    /// Whether image lookups take the mip level of the pixel's footprint, and noise fades where it is too fine for it.
    virtual bool filters_textures() const = 0;
    virtual bool fades_noise() const = 0;
    virtual ValueRef global(Global g) = 0;
    /// Geometry attribute by name.
    virtual ValueRef attribute(const std::string& name, Type type) = 0;
    /// The same, `fallback` (of that type) for geometry that lacks the attribute.
    virtual ValueRef attribute_or(const std::string& name, Type type, ValueRef fallback) = 0;
    virtual ValueRef constant(Type type, double x, double y = 0, double z = 0) = 0;
    /// The node's own kernel run as one op on explicit operands (in the order of OpCall::in); returns output `output`.
    /// Operands replace the parameters; `globals` of the node follow automatically.
    virtual ValueRef call(std::span<const ValueRef> params, int output) = 0;
    /// The same with values of the caller's in place of NodeType::globals, of as many channels.
    virtual ValueRef call(std::span<const ValueRef> params, std::span<const ValueRef> globals, int output) = 0;
    /// Another kernel with its own operand list: for helper ops a node file defines. `name` identifies it (CSE, dump).
    virtual ValueRef op(const char* name, const Kernel& kernel, std::span<const ValueRef> operands, Type result) = 0;
    virtual ValueRef convert(ValueRef v, Type to) = 0;

    /// Value outputs: the result.
    virtual void result(ValueRef v) = 0;

    /// Closure outputs: pass the closure of a Closure parameter on, weighted. Call once per parameter. Factor invalid = 1.
    /// A colour in place of a closure (constant or link) is light emitted.
    virtual void pass_closure(int param, ValueRef weight) = 0;
    /// Closure outputs: light emitted by the node itself.
    virtual void emit(ValueRef color) = 0;
    /// Closure outputs: the node's own lobes, by its kernel. `more` follows the parameters and globals in OpCall::in.
    virtual void emit_lobes(std::span<const ValueRef> more) = 0;
};

}  // namespace alder
