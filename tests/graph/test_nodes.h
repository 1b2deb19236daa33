// Nodes for tests of the compiler: a probe that counts the points it is run on, a mix with lazy inputs, closures.
#pragma once
#include <nlohmann/json.hpp>

#include "graph/material.h"

namespace alder::test {
/// Points on which TestProbe kernels have run since the last reset (SIMD or scalar float runs; folding runs on one point).
uint64_t& probe_points();

inline std::shared_ptr<const Material> material(const nlohmann::json& j, Diagnostics& d) { return build_material(j, {}, d); }

/// Runs `output` for attribute "x" = xs; one value a point (first channel).
std::vector<float> run(const Material& m, const std::string& output, const std::vector<float>& xs, uint32_t batch = 0);
std::vector<float> run(const Program& p, int reg, const std::vector<float>& xs, uint32_t batch = 0);
}  // namespace alder::test
