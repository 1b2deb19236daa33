// JSON Patch (RFC 6902), one operation at a time, so that a fault has its place.
#pragma once
#include <nlohmann/json.hpp>

namespace alder {

/// False, and the document as it was, where the operation is none or cannot be applied.
bool apply_operation(nlohmann::json& document, const nlohmann::json& operation);

}  // namespace alder
