// Executor: op at a time over batches. A region counts its active lanes first: none, and it is skipped; few, and they are
// gathered into short batches; most, and it simply runs (ARCHITECTURE: break-even near 85-90 % active).
#include <algorithm>
#include <cassert>
#include <cstring>

#include "graph/code.h"
#include "hwy/aligned_allocator.h"
#include "hwy/targets.h"

namespace alder {
namespace {
constexpr uint32_t padded(uint32_t n) { return (n + kPadding - 1) / kPadding * kPadding; }
constexpr double kGatherBelow = 0.85;  ///< fraction of active lanes from which gathering no longer pays
}  // namespace

template <class R>
struct Executor<R>::Impl {
    EvalContext context;
    bool scalar = false;
    ExecStats stats;
    const Code* code = nullptr;

    hwy::AlignedFreeUniquePtr<R[]> memory;   ///< registers, then scratch
    size_t memory_values = 0;
    size_t scratch_first = 0, scratch_used = 0;
    uint32_t stride = 0;
    std::vector<Channel<R>> registers;       ///< where each register's value lies now
    std::vector<Channel<R>> inputs;
    std::vector<Channel<R>> uniforms;
    std::vector<Channel<R>> operand;
    std::vector<R*> result;

    R* reg_memory(int r) { return memory.get() + static_cast<size_t>(r) * stride; }

    void prepare(const ProgramImpl& p) {
        // Everything is set anew for each run: a program may have been replaced by another at the same address.
        code = &p.code();
        uniforms.resize(code->uniforms.size());
        for (size_t i = 0; i < uniforms.size(); ++i) {
            if constexpr (std::is_same_v<R, float>) uniforms[i] = {p.uniform_f(static_cast<int>(i)), 0};
            else uniforms[i] = {p.uniform_d(static_cast<int>(i)), 0};
        }
        stride = padded(code->batch);
        scratch_first = static_cast<size_t>(code->registers) * stride;
        const size_t need = scratch_first + (code->scratch + 1) * stride;
        if (need > memory_values) {
            memory = hwy::AllocateAligned<R>(need);
            memory_values = need;
            // Padding lanes compute on what lies here: finite values, so that they cost no denormal or NaN assists.
            std::fill_n(memory.get(), need, R(0));
        }
        registers.assign(code->registers, {});
    }

    Channel<R> at(const Slot& s) const {
        switch (s.kind) {
            case Slot::Register: return registers[s.index];
            case Slot::Uniform: return uniforms[s.index];
            default: return inputs[s.index];
        }
    }

    void run_op(const Instruction& in, uint32_t n) {
        const IrOp& op = code->ir->ops[in.op];
        operand.resize(in.in.size());
        bool uniform = op.foldable;
        for (size_t i = 0; i < in.in.size(); ++i) {
            operand[i] = at(in.in[i]);
            uniform &= operand[i].stride == 0;
        }
        // All operands the same for every point: one register's worth is enough.
        const uint32_t count = uniform ? std::min(n, kPadding) : n;
        result.resize(in.out.size());
        for (size_t i = 0; i < in.out.size(); ++i) {
            result[i] = in.out[i] < 0 ? nullptr : reg_memory(in.out[i]);
            if (in.out[i] >= 0) registers[in.out[i]] = {result[i], uniform ? 0u : 1u};
        }
        const OpCall<R> call{operand.data(), result.data(), op.statics.get(), &context, uniform ? kPadding : count};
        if constexpr (std::is_same_v<R, float>) (scalar ? op.kernel.scalar : op.kernel.lanes)(call);
        else op.kernel.f64(call);
        stats.evaluations += uniform ? 1 : n;
    }

    void run(int first, int last, uint32_t n) {
        const auto& list = code->instructions;
        for (int i = first; i < last; ++i) {
            const Instruction& in = list[i];
            if (in.kind == Instruction::Run) {
                run_op(in, n);
                continue;
            }
            region(in, i, n);
            i = in.end - 1;
        }
    }

    void zero_outputs(const Instruction& in, uint32_t n) {
        for (int r : in.live_out) {
            std::fill_n(reg_memory(r), padded(n), R(0));
            registers[r] = {reg_memory(r), 1};
        }
    }

    void region(const Instruction& in, int index, uint32_t n) {
        const Channel<R> guard = at(in.guard);
        if (guard.stride == 0) {
            if (guard.p[0] != R(0)) return run(index + 1, in.end, n);
            stats.skipped += static_cast<uint64_t>(in.ops_inside) * n;
            return zero_outputs(in, n);
        }
        uint32_t lanes[512];
        uint32_t active = 0;
        for (uint32_t k = 0; k < n; ++k) {
            lanes[active] = k;
            active += guard.p[k] != R(0);
        }
        if (active == 0) {
            stats.skipped += static_cast<uint64_t>(in.ops_inside) * n;
            return zero_outputs(in, n);
        }
        if (active == n || !in.compact || active > kGatherBelow * n) {
            run(index + 1, in.end, n);
            // Lanes that did not ask for it still see zero, so that a NaN computed there in vain goes nowhere.
            if (active < n)
                for (int r : in.live_out) {
                    if (registers[r].stride == 0) continue;
                    R* p = reg_memory(r);
                    for (uint32_t k = 0; k < n; ++k)
                        if (guard.p[k] == R(0)) p[k] = R(0);
                }
            return;
        }
        stats.skipped += static_cast<uint64_t>(in.ops_inside) * (n - active);
        const size_t scratch_before = scratch_used;
        std::vector<Channel<R>> saved(in.live_in.size());
        const uint32_t full = padded(active);
        for (size_t k = 0; k < in.live_in.size(); ++k) {
            const Slot& s = in.live_in[k];
            saved[k] = at(s);
            if (saved[k].stride == 0) continue;
            R* p = memory.get() + scratch_first + scratch_used;
            scratch_used += stride;
            for (uint32_t j = 0; j < active; ++j) p[j] = saved[k].p[lanes[j]];
            for (uint32_t j = active; j < full; ++j) p[j] = p[0];
            (s.kind == Slot::Register ? registers[s.index] : inputs[s.index]) = {p, 1};
        }
        run(index + 1, in.end, active);
        for (size_t k = 0; k < in.live_in.size(); ++k) {
            const Slot& s = in.live_in[k];
            (s.kind == Slot::Register ? registers[s.index] : inputs[s.index]) = saved[k];
        }
        for (int r : in.live_out) {
            R* p = reg_memory(r);
            const Channel<R> c = registers[r];
            if (c.stride == 0) {
                const R v = c.p[0];
                std::fill_n(p, padded(n), R(0));
                for (uint32_t j = 0; j < active; ++j) p[lanes[j]] = v;
            } else {
                // Scatter in place from the back: lanes[j] >= j.
                uint32_t k = n;
                for (uint32_t j = active; j-- > 0;) {
                    while (--k > lanes[j]) p[k] = R(0);
                    p[k] = p[j];
                }
                while (k-- > 0) p[k] = R(0);
            }
            registers[r] = {p, 1};
        }
        scratch_used = scratch_before;
    }
};

template <class R>
Executor<R>::Executor(const EvalContext& context, bool scalar) : impl_(std::make_unique<Impl>()) {
    impl_->context = context;
    impl_->scalar = scalar;
}
template <class R>
Executor<R>::~Executor() = default;
template <class R>
Executor<R>::Executor(Executor&&) noexcept = default;

template <class R>
void Executor<R>::run(const Program& p, uint32_t n, std::span<const Channel<R>> inputs) {
    Impl& x = *impl_;
    assert(n <= p.batch() && n <= 512);
    x.prepare(static_cast<const ProgramImpl&>(p));
    x.inputs.assign(inputs.begin(), inputs.end());
    x.scratch_used = 0;
    x.stats.points += n;
    if (n > 0) x.run(0, static_cast<int>(x.code->instructions.size()), n);
}

template <class R>
Channel<R> Executor<R>::channel(int reg) const {
    return impl_->at(impl_->code->results[reg]);
}

template <class R>
const ExecStats& Executor<R>::stats() const { return impl_->stats; }

template class Executor<float>;
template class Executor<double>;

bool choose_isa(std::string_view name) {
    int64_t targets = HWY_AVX3 | HWY_AVX2 | HWY_SSE4;
    if (name == "avx2") targets = HWY_AVX2 | HWY_SSE4;
    else if (name == "sse4" || name == "scalar") targets = HWY_SSE4;
    else if (!name.empty() && name != "avx512") return false;
    hwy::SetSupportedTargetsForTest(0);
    const int64_t have = hwy::SupportedTargets();
    if (name == "avx512" && !(have & HWY_AVX3)) return false;
    if (name == "avx2" && !(have & HWY_AVX2)) return false;
    hwy::SetSupportedTargetsForTest(have & targets);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    return true;
}

const char* current_isa() {
    const int64_t have = hwy::SupportedTargets();
    return have & HWY_AVX3 ? "avx512" : have & HWY_AVX2 ? "avx2" : "sse4";
}

}  // namespace alder
