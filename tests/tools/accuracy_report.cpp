// How exactly each node is computed: float against double and SIMD against scalar, the greatest and the mean difference over random
// and over extreme inputs, as a table. `./dev accuracy` builds and runs it.
#include <fmt/format.h>

#include <cstdio>
#include <cstring>

#include "graph/program.h"
#include "tests/nodes/all_graphs.h"

using namespace alder;
using namespace alder::test;

namespace {

/// Differences relative to the greater of 1 and the exact value. Points where one side is no number and the other is are counted.
struct Difference {
    double worst = 0, sum = 0;
    size_t values = 0, odd = 0;
    void add(double a, double b) {
        const bool finite_a = std::isfinite(a), finite_b = std::isfinite(b);
        if (finite_a && finite_b) {
            const double e = std::fabs(a - b) / std::max(1.0, std::fabs(b));
            worst = std::max(worst, e);
            sum += e;
            ++values;
        } else if (finite_a != finite_b || std::isnan(a) != std::isnan(b)) {
            ++odd;
        }
    }
    double mean() const { return values ? sum / static_cast<double>(values) : 0; }
};

struct Row {
    Difference exact, scalar;
    size_t not_finite = 0;   ///< results for finite input that are no finite number
    void add(const Program& p, Values kind) {
        const auto simd = run<float>(p, kind, 512, false, false), one = run<float>(p, kind, 512, true, false);
        const auto real = run<double>(p, kind, 512, false, false);
        for (size_t r = 0; r < simd.size(); ++r)
            for (uint32_t i = 0; i < kPoints; ++i) {
                exact.add(simd[r][i], real[r][i]);
                scalar.add(simd[r][i], one[r][i]);
                not_finite += kind != Values::Adversarial && !std::isfinite(simd[r][i]);
            }
    }
};

}  // namespace

int main(int argc, char** argv) {
    const std::string only = argc > 1 && argv[1][0] != '-' ? argv[1] : "";
    if (argc > 1 && argv[1][0] == '-') return std::fprintf(stderr, "usage: accuracy_report [PART OF A NODE NAME]\n"), 2;
    fmt::print("{} points a setting, {} lanes; differences relative to max(1, |value|); 'odd': a number on one side only\n\n", kPoints, current_isa());
    fmt::print("{:34} | {:^29} | {:^20} | {:^38} | {:^13}\n", "", "random: float - double", "SIMD - scalar", "extreme, finite: float - double", "any: SIMD-sc.");
    fmt::print("{:34} | {:>8} {:>10} {:>9} | {:>10} {:>9} | {:>10} {:>9} {:>6} {:>10} | {:>9} {:>3}\n", "node", "settings", "max", "mean", "max", "mean", "max", "mean", "odd",
               "not finite", "max", "odd");
    int nodes = 0;
    for (const NodeType* type : all_nodes()) {
        if (type->name.find(only) == std::string::npos) continue;
        Row ordinary, extreme, any;
        int settings = 0;
        for (const auto& [label, graph] : graphs(*type)) {
            const auto p = compile(*type, graph);
            if (!p || results(*p).empty()) continue;
            ++settings;
            ordinary.add(*p, Values::Ordinary);
            extreme.add(*p, Values::Extreme);
            any.add(*p, Values::Adversarial);
        }
        if (!settings) continue;
        ++nodes;
        fmt::print("{:34} | {:8} {:10.2g} {:9.2g} | {:10.2g} {:9.2g} | {:10.2g} {:9.2g} {:6} {:10} | {:9.2g} {:3}\n", type->name, settings, ordinary.exact.worst, ordinary.exact.mean(),
                   ordinary.scalar.worst, ordinary.scalar.mean(), extreme.exact.worst, extreme.exact.mean(), extreme.exact.odd, extreme.not_finite, any.scalar.worst, any.scalar.odd);
    }
    if (!nodes) return std::fprintf(stderr, "accuracy_report: no node is named like '%s'\n", only.c_str()), 2;
    return 0;
}
