#include "tests/graph/test_nodes.h"

#include "graph/lowering.h"

#include <algorithm>

namespace alder::test {
namespace {

template <class R>
void probe(const OpCall<R>& c) {
    for (uint32_t i = 0; i < c.n; ++i) c.out[0][i] = c.in[0].p[i * c.in[0].stride] * R(2);
    probe_points() += c.n;
}
template <class R>
void mix(const OpCall<R>& c) {
    for (uint32_t i = 0; i < c.n; ++i) {
        const R f = c.in[0].p[i * c.in[0].stride], a = c.in[1].p[i * c.in[1].stride], b = c.in[2].p[i * c.in[2].stride];
        c.out[0][i] = (1 - f) * a + f * b;
    }
}
template <class R>
void lobe(const OpCall<R>& c) {
    for (int ch = 0; ch < 7; ++ch)
        if (c.out[ch])
            for (uint32_t i = 0; i < c.n; ++i)
                c.out[ch][i] = ch < 3 ? c.in[ch].p[i * c.in[ch].stride] : ch == 6 ? c.in[3].p[i * c.in[3].stride] : R(ch == 5);
}
template <class R>
void divide(const OpCall<R>& c) {
    for (uint32_t i = 0; i < c.n; ++i) c.out[0][i] = R(1) / c.in[0].p[i * c.in[0].stride];
}

#define ALDER_TEST_KERNEL(f) Kernel{f<float>, f<float>, f<double>}

ALDER_NODE {
    NodeType n;
    n.name = "TestProbe";
    n.system = System::AlShaders;
    n.params = {param::f("input", 0)};
    n.outputs = {{"out", Type::Float}};
    n.kernel = ALDER_TEST_KERNEL(probe);
    n.cost_ns = 100;
    return n;
}
ALDER_NODE {
    NodeType n;
    n.name = "TestReciprocal";
    n.system = System::AlShaders;
    n.params = {param::f("input", 1)};
    n.outputs = {{"out", Type::Float}};
    n.kernel = ALDER_TEST_KERNEL(divide);
    n.cost_ns = 100;
    return n;
}
ALDER_NODE {
    NodeType n;
    n.name = "TestMix";
    n.system = System::AlShaders;
    n.params = {param::f("mix", 0.5), param::f("a", 0), param::f("b", 1)};
    n.outputs = {{"out", Type::Float}};
    n.kernel = ALDER_TEST_KERNEL(mix);
    n.lazy = [](const Statics&) {
        return std::vector<LazyRule>{{1, 0, LazyRule::NeededIfBelowOne}, {2, 0, LazyRule::NeededIfPositive}};
    };
    return n;
}
ALDER_NODE {
    NodeType n;
    n.name = "TestDiffuse";
    n.params = {param::color("color", 0.8, 0.8, 0.8), param::f("sigma", 0)};
    n.outputs = {{"bsdf", Type::Closure}};
    n.kernel = ALDER_TEST_KERNEL(lobe);
    n.cost_ns = 20;
    n.lobes = [](const Statics&) {
        LobeSpec s{LobeKind::OrenNayar};
        s.gates = {0};
        return std::vector<LobeSpec>{s};
    };
    n.closure_aovs = {{"sigma_aov", 1}};
    return n;
}
ALDER_NODE {
    NodeType n;
    n.name = "TestMixClosure";
    n.params = {param::f("mix", 0.5), param::closure("a"), param::closure("b")};
    n.outputs = {{"bsdf", Type::Closure}};
    n.kernel = ALDER_TEST_KERNEL(mix);
    n.lower = [](Lowering& l, int) {
        const ValueRef one = l.constant(Type::Float, 1), zero = l.constant(Type::Float, 0);
        const ValueRef m = l.input(0);
        const ValueRef a[] = {m, one, zero};
        l.pass_closure(1, l.op("test_mix", l.statics().type->kernel, a, Type::Float));
        l.pass_closure(2, m);
    };
    return n;
}

}  // namespace

uint64_t& probe_points() {
    static uint64_t n = 0;
    return n;
}

std::vector<float> run(const Program& p, int reg, const std::vector<float>& xs, uint32_t batch) {
    if (batch == 0 || batch > p.batch()) batch = p.batch();
    const EvalContext context;
    Executor<float> x(context);
    std::vector<float> padded = xs, out;
    padded.resize(xs.size() + 2 * kPadding, 0.5f);
    for (uint32_t i = 0; i < xs.size(); i += batch) {
        const uint32_t n = std::min<uint32_t>(batch, static_cast<uint32_t>(xs.size()) - i);
        std::vector<Channel<float>> in;
        for (const auto& input : p.inputs())
            for (int c = 0; c < input.channels; ++c) in.push_back({padded.data() + i, 1});
        x.run(p, n, in);
        const Channel<float> c = x.channel(reg);
        for (uint32_t k = 0; k < n; ++k) out.push_back(c.p[k * c.stride]);
    }
    return out;
}

std::vector<float> run(const Material& m, const std::string& output, const std::vector<float>& xs, uint32_t batch) {
    Diagnostics d;
    const auto p = m.program({.outputs = {output}}, d);
    return p ? run(*p, p->outputs()[0].register_first, xs, batch) : std::vector<float>();
}

}  // namespace alder::test
