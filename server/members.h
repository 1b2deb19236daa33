// Members: reads the members of one JSON object of a request, collecting every fault with its pointer instead of stopping.
#pragma once
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "graph/diagnostic.h"

namespace alder {

class Members {
  public:
    /// `object` may be anything; that it is not an object becomes the one fault.
    Members(const nlohmann::json& object, std::string pointer, Diagnostics& d);

    /// The member, or null where it is absent. Marks the name as known. JSON null counts as absent.
    const nlohmann::json* find(const std::string& name);
    const nlohmann::json* require(const std::string& name, const char* what);
    // Each leaves `out` alone where the member is absent or wrong; true where it was read.
    bool number(const std::string& name, double& out, double low, double high);
    bool integer(const std::string& name, int64_t& out, int64_t low, int64_t high);
    bool boolean(const std::string& name, bool& out);
    bool text(const std::string& name, std::string& out);
    bool choice(const std::string& name, std::string& out, std::initializer_list<const char*> choices);
    bool texts(const std::string& name, std::vector<std::string>& out, size_t most);
    /// Unknown members are errors, or warnings where `lenient`.
    void finish(bool lenient);

    std::string pointer(const std::string& name) const;
    void fault(const std::string& name, const char* code, std::string found, std::string expected, std::string suggest = {});

  private:
    const nlohmann::json* object_;
    std::string pointer_;
    Diagnostics& d_;
    std::vector<std::string> known_;
};

/// A value as it may be quoted in a message: cut to a readable length.
std::string brief(const nlohmann::json& value);

}  // namespace alder
