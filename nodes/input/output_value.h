// OutputValue: the constant that some Blender nodes (Value, RGB, Normal) keep on an output socket, as documents give it:
// {"Value": 0.5}, {"Color": [r, g, b, a]}.
#pragma once
#include <nlohmann/json.hpp>

#include "nodes/schema.h"

namespace alder {

struct OutputValue {
    bool given = false;
    double number[3] = {0, 0, 0};

    /// Parses the JSON text; "null" or empty is "not given". What is wrong is appended to `errors`.
    OutputValue(const std::string& json_text, const NodeType& node, const Output& output, std::vector<std::string>& errors) {
        const auto v = nlohmann::json::parse(json_text.empty() ? "null" : json_text, nullptr, false);
        if (v.is_null()) return;
        const size_t n = static_cast<size_t>(channels(output.type));
        const auto it = v.is_object() ? v.find(output.name) : v.end();
        bool good = v.is_object() && it != v.end();
        if (good && n == 1) {
            good = it->is_number();
            if (good) number[0] = it->get<double>();
        } else if (good) {
            good = it->is_array() && (it->size() == n || (it->size() == 4 && output.type == Type::Color));
            for (size_t i = 0; good && i < n; ++i) {
                good = (*it)[i].is_number();
                if (good) number[i] = (*it)[i].get<double>();
            }
        }
        given = good;
        if (!good) errors.push_back("output_value of " + node.name + ": expected {\"" + output.name + "\": " + (n == 1 ? "number}" : "[numbers]}"));
    }
};

}  // namespace alder
