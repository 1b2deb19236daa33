// Files of the lookdev page, compiled in by server/ui/embed.cmake.
#pragma once
#include <span>
#include <string_view>

namespace alder {

struct UiFile {
    std::string_view name;   ///< as in its address: "app.js", "examples/weathered_paint.graph.json"
    std::string_view content;
};
/// Sorted by name.
std::span<const UiFile> ui_files();

}  // namespace alder
