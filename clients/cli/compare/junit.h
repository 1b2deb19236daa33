// JUnit XML, as CI systems read it: one suite, one test case for each case and layer.
#pragma once
#include <string>
#include <utility>
#include <vector>

namespace alder::cli {

struct JunitCase {
    std::string name;
    double seconds = 0;
    std::string failure, error, skipped;   ///< texts; at most one is set
    std::vector<std::pair<std::string, std::string>> properties;
    std::vector<std::string> attachments;  ///< files
};

std::string xml_text(const std::string& text);   ///< escaped; what XML cannot hold becomes '?'
std::string junit_xml(const std::string& suite, const std::vector<JunitCase>& cases);

}  // namespace alder::cli
