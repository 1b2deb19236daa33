// A light's angular distribution as measured by its maker: IES LM-63 files.
#pragma once
#include <memory>
#include <string>
#include <vector>

namespace alder {

/// Intensities over vertical angles (0 straight down, along -Z) and horizontal ones, radians, with the file's symmetries written out
/// to a full turn where it has them. Immutable.
struct IesProfile {
    std::vector<float> horizontal, vertical;  ///< ascending as a rule; files are taken as they are
    std::vector<float> intensity;             ///< [horizontal][vertical], watts
    /// Largest of entries 1 to i: what makes the search for the first angle not below a given one a bisection.
    std::vector<float> horizontal_bound, vertical_bound;
};

/// Reads the text of a file. Null and a sentence where it is none.
std::shared_ptr<const IesProfile> parse_ies(const std::string& text, std::string& fault);
/// The parameter's JSON text: {"text": ...} or {"file": NAME}; null without a fault where none is chosen.
std::shared_ptr<const IesProfile> load_ies(const std::string& json, std::string& fault);

}  // namespace alder
