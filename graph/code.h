// Code: the executable structure of a program, shared by all programs that differ in constants only.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "graph/builder.h"
#include "graph/program.h"

namespace alder {

/// Where a channel lives at run time.
struct Slot {
    enum Kind : uint8_t { None, Register, Uniform, Input } kind = None;
    int index = -1;
};

struct Instruction {
    enum Kind : uint8_t { Run, Region } kind = Run;
    // Run
    int op = -1;                     ///< index into Ir::ops
    std::vector<Slot> in;
    std::vector<int> out;            ///< register or -1 (not wanted)
    // Region: executes the instructions [this+1, end) for lanes where guard != 0
    Slot guard;
    int end = 0;
    std::vector<Slot> live_in;       ///< registers and inputs read inside and defined outside
    std::vector<int> live_out;       ///< registers defined inside and read after it: zero in the lanes left out
    int ops_inside = 0;
    bool compact = true;             ///< costly enough to gather the active lanes
};

/// What became of a node of the document, for people.
struct NodeFate {
    std::string name;     ///< "group/node" inside a group
    enum Kind : uint8_t { Live, Merged, Folded, PassedOn, Pruned, NotAsked, Group } kind = Live;
    std::string reason;   ///< why nothing of it runs; empty where it does
    std::string type;
    int parent = -1;      ///< the group node around it
};
struct NodeLink {
    int from, to;         ///< indices into Code::nodes
    std::string param;
};

struct Code {
    std::shared_ptr<const Ir> ir;    ///< structure; its values are those of the first compile
    std::vector<Instruction> instructions;
    std::vector<int> uniforms;       ///< constant channels read at run time, in uniform-slot order
    std::vector<ProgramInput> inputs;
    std::vector<Slot> results;       ///< by ProgramLobe/ProgramOutput::register_first
    std::vector<ProgramLobe> lobes;
    std::vector<ProgramOutput> outputs;
    std::map<std::pair<int, int>, std::pair<int, int>> leaves;  ///< (node, param) -> first leaf channel, count
    std::set<std::pair<int, int>> asked;     ///< (node, param) whose being zero or default the structure relies on
    std::vector<NodeFate> nodes;
    std::vector<NodeLink> links;     ///< of the document, those into what was never asked for too
    int registers = 0;
    size_t scratch = 0;              ///< batches of scratch that nested regions need at most
    uint32_t batch = 256;
    ProgramStats stats;
    std::vector<int> emission_channels;  ///< weights of the emission lobes, if all are constant
};

/// Dead code, lazy regions, schedule, registers.
std::shared_ptr<const Code> generate_code(Built built);

/// Code and the values of its constants.
class ProgramImpl final : public Program {
  public:
    ProgramImpl(std::shared_ptr<const Code> code, IrValues values);

    const std::vector<ProgramInput>& inputs() const override { return code_->inputs; }
    const std::vector<ProgramLobe>& lobes() const override { return code_->lobes; }
    const std::vector<ProgramOutput>& outputs() const override { return code_->outputs; }
    const ProgramStats& stats() const override { return code_->stats; }
    const ProgramFacts& facts() const override { return facts_; }
    uint32_t batch() const override { return code_->batch; }
    std::string dump() const override;

    const Code& code() const { return *code_; }
    /// kPadding copies of each uniform.
    const float* uniform_f(int slot) const { return uniform_f_.data() + static_cast<size_t>(slot) * kPadding; }
    const double* uniform_d(int slot) const { return uniform_d_.data() + static_cast<size_t>(slot) * kPadding; }

    /// The same code with parameter (node, param) set to `number`; null if a guard fails.
    std::shared_ptr<const ProgramImpl> with_constant(int node, int param, const std::array<double, 16>& number) const;

  private:
    std::shared_ptr<const Code> code_;
    IrValues values_;
    std::vector<float> uniform_f_;
    std::vector<double> uniform_d_;
    ProgramFacts facts_;
};

}  // namespace alder
