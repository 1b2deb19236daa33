// The linker's digest of this program (GNU build id): tells two builds of one version apart.
#pragma once
#include <string>

namespace alder {

/// Hexadecimal; "unknown" where the linker left none.
const std::string& build_id();

}  // namespace alder
