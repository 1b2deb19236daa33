// The node catalogue as JSON: what /v1/nodes and `alder nodes --json` answer, and what user interfaces are built from.
#pragma once
#include <nlohmann/json.hpp>

#include "nodes/schema.h"

namespace alder {

nlohmann::json node_json(const NodeType& type);
/// {"items": [every node], "next": null}: a list as the service gives it.
nlohmann::json nodes_json();
/// The same, with name, system, category and summary only.
nlohmann::json nodes_summary_json();

}  // namespace alder
