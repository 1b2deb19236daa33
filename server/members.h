// Members: reads the members of one JSON object of a request, collecting every fault with its pointer instead of stopping.
//
// The same code that reads a body describes it: on an object made by describing(), nothing is read; each call writes down what
// it would accept, as JSON Schema. The schemas of /v1/openapi.json come from there, so they cannot differ from the checks.
#pragma once
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "graph/diagnostic.h"

namespace alder {

class Members {
  public:
    /// `object` may be anything; that it is not an object becomes the one fault.
    Members(const nlohmann::json& object, std::string pointer, Diagnostics& d);
    /// The schema of the object that `read` reads.
    static nlohmann::json describing(const std::function<void(Members&)>& read);
    bool describes() const { return schema_ != nullptr; }

    /// The member, or null where it is absent. Marks the name as known. JSON null counts as absent. `schema`: what the caller
    /// accepts; none: anything.
    const nlohmann::json* find(const std::string& name, const nlohmann::json& schema = nullptr);
    const nlohmann::json* require(const std::string& name, const char* what, const nlohmann::json& schema = nullptr);
    /// An object whose members `read` reads. True where it is there.
    bool object(const std::string& name, const std::function<void(Members&)>& read);
    // Each leaves `out` alone where the member is absent or wrong; true where it was read.
    bool number(const std::string& name, double& out, double low, double high);
    bool integer(const std::string& name, int64_t& out, int64_t low, int64_t high);
    bool boolean(const std::string& name, bool& out);
    bool text(const std::string& name, std::string& out);
    bool choice(const std::string& name, std::string& out, const std::vector<std::string>& choices);
    bool texts(const std::string& name, std::vector<std::string>& out, size_t most);
    /// Unknown members are errors, or warnings where `lenient`.
    void finish(bool lenient);

    std::string pointer(const std::string& name) const;
    void fault(const std::string& name, const char* code, std::string found, std::string expected, std::string suggest = {});

  private:
    Members(nlohmann::json& schema, Diagnostics& d) : object_(nullptr), schema_(&schema), d_(d) {}
    void describe(const std::string& name, nlohmann::json schema);

    const nlohmann::json* object_;
    nlohmann::json* schema_ = nullptr;
    std::string pointer_;
    Diagnostics& d_;
    std::vector<std::string> known_;
};

/// A value as it may be quoted in a message: cut to a readable length.
std::string brief(const nlohmann::json& value);
/// Whether it is a whole number from `low` to `high`, written as one or as 16.0.
bool whole_number(const nlohmann::json& value, int64_t low, int64_t high, int64_t& out);

}  // namespace alder
