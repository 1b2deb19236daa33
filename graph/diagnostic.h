// Diagnostic: one fault of a user's document, as a value. Collected, never thrown; every door prints the same rows.
#pragma once
#include <string>
#include <vector>

namespace alder {

struct Diagnostic {
    std::string pointer;   ///< JSON Pointer (RFC 6901) into the document, e.g. "/nodes/body/params/diffuseColor"
    std::string code;      ///< stable kebab-case kind: unknown-node, unknown-parameter, wrong-type, cycle, unsupported ...
    std::string found;     ///< what was there, in the user's spelling
    std::string expected;  ///< what would have been right
    std::string suggest;   ///< nearest known name, or empty
    std::vector<std::string> path = {};  ///< for cycles: the nodes along it

    /// "/nodes/a/params/b: found X, expected Y (did you mean Z?)"
    std::string line() const;
};

struct Diagnostics {
    std::vector<Diagnostic> errors;
    std::vector<Diagnostic> warnings;
    bool ok() const { return errors.empty(); }
};
inline constexpr size_t kMaxDiagnostics = 100;

}  // namespace alder
