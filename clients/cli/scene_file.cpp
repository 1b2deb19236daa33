// Scene files for the subcommands: Arnold's .ass and the .xml of Cycles' stand-alone program go through their importers first, which
// are Python programs of the standard library.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>

#include "clients/cli/ci/child.h"
#include "clients/cli/common.h"

namespace alder::cli {
namespace {

namespace fs = std::filesystem;

/// Named by a variable, beside an installed program, or in the source tree that the program was built from.
std::string importer(const char* variable, const fs::path& script) {
    if (const char* named = std::getenv(variable); named && *named) return named;
    std::error_code code;
    const fs::path program = fs::read_symlink("/proc/self/exe", code);
    for (const fs::path& place : {program.parent_path() / "../share/alder" / script, fs::path(ALDER_SOURCE_DIR) / "clients" / script})
        if (fs::is_regular_file(place, code)) return place.string();
    fail(kWrong, fmt::format("the importer {} is not beside the program: name it in {}", script.filename().string(), variable));
}

}  // namespace

SceneFile::SceneFile(const std::string& path) : path_(path) {
    const bool ass = fs::path(path).extension() == ".ass" || path.ends_with(".ass.gz"), xml = fs::path(path).extension() == ".xml";
    if (!ass && !xml) return;
    const std::string script = ass ? importer("ALDER_ASS_IMPORTER", "ass/ass_scene.py") : importer("ALDER_XML_IMPORTER", "cycles_xml/cycles_scene.py");
    std::string name = (fs::temp_directory_path() / "alder-ass-XXXXXX").string();
    if (!mkdtemp(name.data())) fail(kMachineFailed, "no temporary folder can be made");
    folder_ = name;
    path_ = (fs::path(folder_) / "scene.alder").string();
    std::vector<std::string> arguments{script, path, "-o", path_, "--quiet"};
    std::error_code code;
    if (xml) arguments.insert(arguments.end(), {"--alder", fs::read_symlink("/proc/self/exe", code).string()});
    const ChildResult child = run_program("python3", arguments);
    if (child.status == 0) return;
    fs::remove_all(folder_, code);
    const std::string prefix = fs::path(script).stem().string() + ": ";
    const size_t colon = child.errors.find(prefix);
    std::string why = colon == std::string::npos ? child.errors : child.errors.substr(colon + prefix.size());
    while (!why.empty() && why.back() == '\n') why.pop_back();
    if (const size_t line = why.rfind('\n'); line != std::string::npos) why = why.substr(line + 1);
    fail(child.status == kWrong ? kWrong : kMachineFailed, why.find(path) == std::string::npos ? path + ": " + why : why);
}

SceneFile::~SceneFile() {
    std::error_code code;
    if (!folder_.empty()) fs::remove_all(folder_, code);
}

}  // namespace alder::cli
