// A suite of pictures to check: which scenes to render, with which settings, and how near their references they must be.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "clients/cli/compare/figures.h"
#include "graph/diagnostic.h"

namespace alder::cli {

struct SuiteCase {
    std::string name;
    std::string scene;             ///< resolved beside the suite; of a case on a preview stage: the graph
    bool is_graph = false;
    std::vector<std::string> arguments;   ///< options of `alder render` or `alder preview`
    std::string reference;
    std::vector<std::pair<std::string, std::vector<Limit>>> layers;
};

struct Suite {
    std::string name;
    std::vector<SuiteCase> cases;
};

/// All faults of the document are in `d`.
Suite read_suite(const nlohmann::json& document, const std::string& path, Diagnostics& d);

/// Shell-like pattern of * ? [..] over a whole name.
bool matches(const std::string& pattern, const std::string& name);

}  // namespace alder::cli
