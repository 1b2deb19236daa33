// Reading the alShaders reference tables (tests/reference/alshaders, or the folder in ALDER_REFERENCE) for tests of parts that a
// graph evaluation cannot reach: helper functions, and the arithmetic around noise that Arnold keeps closed.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>
#include <zlib.h>

#include "nodes/num/vec.h"

namespace alder::test {

/// The cases of a table; none, and a failure, where it cannot be read.
inline nlohmann::json al_cases(const std::string& table) {
    const char* folder = std::getenv("ALDER_REFERENCE");
    const std::string path = (folder ? std::string(folder) : std::string(ALDER_SOURCE_DIR "/tests/reference")) + "/alshaders/" + table + ".json";
    std::string text;
    for (const auto& name : {path, path + ".gz"}) {
        gzFile file = gzopen(name.c_str(), "rb");   // reads plain files too
        if (!file) continue;
        char block[65536];
        for (int n; (n = gzread(file, block, sizeof block)) > 0;) text.append(block, n);
        gzclose(file);
        break;
    }
    const auto json = nlohmann::json::parse(text, nullptr, false);
    if (!json.is_object() || !json.contains("cases") || json["cases"].empty()) {
        ADD_FAILURE() << "no reference table at " << path;
        return nlohmann::json::array();
    }
    return json["cases"];
}
inline double al_number(const nlohmann::json& v) {
    if (v.is_string()) return v == "inf" ? INFINITY : v == "-inf" ? -INFINITY : NAN;
    return v.is_boolean() ? v.get<bool>() : v.get<double>();
}
inline float al_float(const nlohmann::json& v) { return static_cast<float>(al_number(v)); }
inline Vec3f al_vec(const nlohmann::json& v) { return {al_float(v[0]), al_float(v[1]), al_float(v[2])}; }

/// |got - want| over max(|want|, 1e-3); what is not finite must be met by what is not finite.
inline double al_error(double got, double want) {
    if (!std::isfinite(got) || !std::isfinite(want)) return std::isfinite(got) == std::isfinite(want) ? 0 : INFINITY;
    return std::fabs(got - want) / std::max(std::fabs(want), 1e-3);
}

/// Replays a case's calls of closed functions in order, checking that the arguments are those recorded.
class BasisReplay {
  public:
    explicit BasisReplay(const nlohmann::json& calls) : calls_(calls) {}
    /// `size`: of the terms that an argument is a sum of, where they may cancel.
    const nlohmann::json& next(const char* fn, std::vector<float> args, double size = 0) const {
        static const nlohmann::json none = {0, 0, 0};
        if (next_ >= calls_.size()) {
            ADD_FAILURE() << fn << " is called once too often";
            return none;
        }
        const auto& call = calls_[next_++];
        EXPECT_EQ(call["fn"], fn);
        for (size_t i = 0; i < args.size() && i < call["args"].size(); ++i)
            EXPECT_LE(size > 0 ? std::fabs(args[i] - al_number(call["args"][i])) / size : al_error(args[i], al_number(call["args"][i])), 1e-5) << fn << " argument " << i << " of call " << next_ - 1;
        return call["value"];
    }
    bool finished() const { return next_ == calls_.size(); }

  private:
    const nlohmann::json& calls_;
    mutable size_t next_ = 0;
};

}  // namespace alder::test
