// Files that a node's prepared tables could not read. The node can be used all the same and shows it (an image is magenta), so this is
// a warning, or an error where the request is strict.
#pragma once
#include <string>
#include <vector>

namespace alder {

/// A second base of what NodeType::prepare returns.
struct ResourceFaults {
    struct Fault {
        std::string parameter, file, reason;
    };
    std::vector<Fault> faults;
    /// What has shown only while the node was evaluated: a file in tiles that breaks off in the middle.
    virtual std::vector<Fault> late_faults() const { return {}; }
    virtual ~ResourceFaults() = default;
};

}  // namespace alder
