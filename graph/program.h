// Program: the compiled form of what one request needs of a graph. A list of ops over SoA register channels, guarded regions,
// uniform values, and facts that let the renderer skip work. Immutable; executed by Executor (one per thread).
#pragma once
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "nodes/schema.h"

namespace alder {

/// Appended to the name of an attribute: one channel, 1 where the geometry has the attribute and 0 elsewhere.
inline constexpr std::string_view kExistsSuffix = ".exists";

/// A shading global or geometry attribute the program reads. The caller gives one Channel per channel, in this order.
struct ProgramInput {
    bool is_attribute = false;
    Global global = Global::P;
    std::string attribute;  ///< name, if is_attribute
    int channels = 3;
    Type type = Type::Vector;
};

struct ProgramOutput {
    std::string name;
    Type type = Type::Float;
    int register_first = 0;  ///< first register; channels(type) of them
};

/// One lobe of the static set. Registers of its channels in LobeSpec order.
struct ProgramLobe {
    LobeSpec spec;
    int register_first = 0;  ///< registers are contiguous: spec.channels() of them
    std::string node;        ///< who emitted it (explain, statistics)
};

struct ProgramStats {
    int nodes = 0;             ///< nodes of the document
    int live_nodes = 0;        ///< nodes with at least one op left
    int ops = 0;               ///< ops executed a point, at most
    int folded = 0;            ///< values computed at compile time
    int merged = 0;            ///< values shared by common subexpression
    int regions = 0;           ///< lazily evaluated regions
    std::vector<std::string> skipped;  ///< "NODE: reason" for nodes that are never evaluated
    double compile_seconds = 0;
};

/// What the renderer may rely on without evaluating.
struct ProgramFacts {
    bool has_emission = false;
    bool emission_constant = false;   ///< uniform over the surface; value in `emission`
    float emission[3] = {0, 0, 0};
    bool may_be_transparent = false;  ///< some Transparent lobe (or shadow opacity) is not provably zero
    bool spatially_constant = false;  ///< reads no input at all
    bool needs_derivatives = false;   ///< reads Dpdx..Duvdy, PixelFootprint or FootprintArea
};

class Program {
  public:
    virtual ~Program() = default;
    virtual const std::vector<ProgramInput>& inputs() const = 0;
    virtual const std::vector<ProgramLobe>& lobes() const = 0;
    virtual const std::vector<ProgramOutput>& outputs() const = 0;  ///< request.outputs, then .aovs, then displacement
    virtual const ProgramStats& stats() const = 0;
    virtual const ProgramFacts& facts() const = 0;
    virtual uint32_t batch() const = 0;  ///< preferred points per run, 64 ... 512, a multiple of kPadding
    /// Text for people: ops in order, registers, regions, what was skipped and why.
    virtual std::string dump() const = 0;
};

struct ExecStats {
    uint64_t points = 0;
    uint64_t evaluations = 0;  ///< op x point executed
    uint64_t skipped = 0;      ///< op x point not executed because no lane needed it
};

/// Runs programs; owns the register memory. Not thread safe: one per thread. R: float (SIMD) or double.
template <class R>
class Executor {
  public:
    /// scalar: use the scalar float kernels instead of SIMD (R = float only).
    explicit Executor(const EvalContext& context, bool scalar = false);
    ~Executor();
    Executor(Executor&&) noexcept;

    /// Evaluates n <= p.batch() points. `inputs`: one Channel per channel of p.inputs(), readable up to n rounded up to
    /// kPadding (stride 0: 16 copies). Results stay valid until the next run.
    void run(const Program& p, uint32_t n, std::span<const Channel<R>> inputs);
    /// Register of the program last run: stride 0 where the value is the same for all points.
    Channel<R> channel(int reg) const;
    const ExecStats& stats() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};
extern template class Executor<float>;
extern template class Executor<double>;

/// Limits SIMD to one instruction set for the whole process ("scalar" is per Executor). False if this CPU lacks it.
bool choose_isa(std::string_view name);   // "sse4", "avx2", "avx512"; "" = best
const char* current_isa();

}  // namespace alder
