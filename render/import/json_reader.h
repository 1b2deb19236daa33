// Reading an object of a JSON document member by member: every fault becomes a Diagnostic with its JSON Pointer, reading goes
// on, and what nobody asked for is an unknown member.
#pragma once
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "graph/diagnostic.h"
#include "graph/json_text.h"
#include "nodes/num/vec.h"
#include "render/scene.h"

namespace alder {

/// Adds an error unless there are kMaxDiagnostics already.
void add_error(Diagnostics& d, std::string pointer, std::string code, std::string found, std::string expected, std::string suggest = {});
void add_warning(Diagnostics& d, std::string pointer, std::string code, std::string found, std::string expected);
/// "a string", "an array of 3", "12.5": what was found, for messages.
std::string describe(const nlohmann::json& j);

class JsonReader {
  public:
    JsonReader(const nlohmann::json& j, std::string pointer, Diagnostics& d, bool lenient);

    bool ok() const { return object_ != nullptr; }   ///< false: not an object (already reported)
    const std::string& pointer() const { return pointer_; }
    std::string pointer_to(std::string_view key) const { return pointer_ + "/" + pointer_token(key); }
    Diagnostics& diagnostics() const { return *d_; }
    bool lenient() const { return lenient_; }

    /// The member, or null where it is absent. It then counts as known.
    const nlohmann::json* member(const char* key);
    /// Like member(), but absence is an error.
    const nlohmann::json* required(const char* key, const char* expected);

    // Each leaves `out` as it is where the member is absent or wrong; wrong is reported.
    void number(const char* key, float& out, double lo = -3e38, double hi = 3e38);
    void degrees(const char* key, float& out_radians, double lo, double hi);
    void integer(const char* key, int& out, int64_t lo, int64_t hi);
    void integer(const char* key, uint32_t& out, int64_t lo, int64_t hi);
    void boolean(const char* key, bool& out);
    void text(const char* key, std::string& out);
    void vector(const char* key, Vec3f& out);
    void numbers(const char* key, std::span<float> out);
    /// Index of the member's text among `names`; `out` unchanged where absent.
    void choice(const char* key, std::span<const char* const> names, int& out);
    void transform(const char* key, Transform& out);   ///< 16 (row major) or 12 numbers

    /// Reports members that were not asked for: errors, or warnings if lenient.
    void finish();

  private:
    bool read_number(const nlohmann::json& j, const std::string& pointer, double lo, double hi, double& out);
    const nlohmann::json* object_ = nullptr;
    std::string pointer_;
    Diagnostics* d_;
    bool lenient_;
    std::vector<std::string> known_;
};

}  // namespace alder
