// Runs this program again as a child: a render that crashes or runs out of memory ends a case of a suite, not the suite.
#pragma once
#include <string>
#include <vector>

namespace alder::cli {

struct ChildResult {
    int status = 0;          ///< exit status, or 128 + the signal
    double seconds = 0;
    std::string errors;      ///< what it wrote to stderr, the last 4 KiB
};
/// `arguments` without the program's name.
ChildResult run_self(const std::vector<std::string>& arguments);
/// Any program, found through PATH.
ChildResult run_program(const std::string& program, const std::vector<std::string>& arguments);

}  // namespace alder::cli
