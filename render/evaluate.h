// Evaluation of graph outputs at given points, with no scene: INTERFACES section 2, for `alder eval` and POST /v1/evaluate.
#pragma once
#include <nlohmann/json.hpp>

#include "graph/diagnostic.h"
#include "graph/material.h"
#include "graph/points.h"

namespace alder {

struct EvaluateOptions {
    enum class Precision : uint8_t { Float, Double } precision = Precision::Float;
    bool scalar = false;   ///< scalar float kernels instead of SIMD
    bool stats = false;    ///< fill "stats"
    int repeat = 1;        ///< evaluations, for timing; the median is reported
    int threads = 0;       ///< 0 = all
    std::string pointer_prefix;
    MaterialOptions material;  ///< image and file resolution, limits
    PointOptions points;
    MaterialCache* cache = nullptr;  ///< optional
};

/// The answer; null JSON if the request is wrong (every fault in `d`).
nlohmann::json evaluate_request(const nlohmann::json& request, const EvaluateOptions& options, Diagnostics& d);

}  // namespace alder
