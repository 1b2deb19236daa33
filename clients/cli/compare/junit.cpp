// JUnit XML.
#include "clients/cli/compare/junit.h"

#include <algorithm>

#include <fmt/format.h>

namespace alder::cli {

std::string xml_text(const std::string& text) {
    std::string out;
    for (const char c : text) switch (c) {
            case '&': out += "&amp;"; break;
            case '<': out += "&lt;"; break;
            case '>': out += "&gt;"; break;
            case '"': out += "&quot;"; break;
            case '\'': out += "&#39;"; break;
            case '\n': out += "&#10;"; break;
            default: out += static_cast<unsigned char>(c) < 0x20 && c != '\t' ? '?' : c;
        }
    return out;
}

std::string junit_xml(const std::string& suite, const std::vector<JunitCase>& cases) {
    const auto count = [&](std::string JunitCase::*text) { return std::count_if(cases.begin(), cases.end(), [&](const JunitCase& c) { return !(c.*text).empty(); }); };
    double seconds = 0;
    for (const JunitCase& c : cases) seconds += c.seconds;
    std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n";
    xml += fmt::format("<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\" time=\"{:.3f}\">\n", xml_text(suite), cases.size(),
                       count(&JunitCase::failure), count(&JunitCase::error), count(&JunitCase::skipped), seconds);
    for (const JunitCase& c : cases) {
        xml += fmt::format(" <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\">\n", xml_text(suite), xml_text(c.name), c.seconds);
        if (!c.properties.empty()) {
            xml += "  <properties>\n";
            for (const auto& [name, value] : c.properties) xml += fmt::format("   <property name=\"{}\" value=\"{}\"/>\n", xml_text(name), xml_text(value));
            xml += "  </properties>\n";
        }
        for (const auto& [tag, text] : {std::pair{"failure", &c.failure}, std::pair{"error", &c.error}, std::pair{"skipped", &c.skipped}})
            if (!text->empty()) xml += fmt::format("  <{} message=\"{}\"/>\n", tag, xml_text(*text));
        if (!c.attachments.empty()) {
            xml += "  <system-out>";
            for (const std::string& file : c.attachments) xml += "[[ATTACHMENT|" + xml_text(file) + "]]\n";
            xml += "</system-out>\n";
        }
        xml += " </testcase>\n";
    }
    return xml + "</testsuite>\n</testsuites>\n";
}

}  // namespace alder::cli
