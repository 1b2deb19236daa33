// Scene files for the subcommands: Arnold's .ass goes through its importer first, which is a Python program of the standard library.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "clients/cli/ci/child.h"
#include "clients/cli/common.h"

namespace alder::cli {
namespace {

namespace fs = std::filesystem;

/// $ALDER_ASS_IMPORTER, beside an installed program, or in the source tree that the program was built from.
std::string importer() {
    if (const char* named = std::getenv("ALDER_ASS_IMPORTER"); named && *named) return named;
    std::error_code code;
    const fs::path program = fs::read_symlink("/proc/self/exe", code);
    for (const fs::path& place : {program.parent_path() / "../share/alder/ass/ass_scene.py", fs::path(ALDER_SOURCE_DIR) / "clients/ass/ass_scene.py"})
        if (fs::is_regular_file(place, code)) return place.string();
    fail(kWrong, ".ass files need the importer ass_scene.py: name it in ALDER_ASS_IMPORTER");
}

}  // namespace

SceneFile::SceneFile(const std::string& path) : path_(path) {
    if (fs::path(path).extension() != ".ass" && !path.ends_with(".ass.gz")) return;
    std::string name = (fs::temp_directory_path() / "alder-ass-XXXXXX").string();
    if (!mkdtemp(name.data())) fail(kMachineFailed, "no temporary folder can be made");
    folder_ = name;
    path_ = (fs::path(folder_) / "scene.alder").string();
    const ChildResult child = run_program("python3", {importer(), path, "-o", path_, "--quiet"});
    if (child.status == 0) return;
    std::error_code code;
    fs::remove_all(folder_, code);
    const size_t colon = child.errors.find("ass_scene: ");
    std::string why = colon == std::string::npos ? child.errors : child.errors.substr(colon + 11);
    while (!why.empty() && why.back() == '\n') why.pop_back();
    if (const size_t line = why.rfind('\n'); line != std::string::npos) why = why.substr(line + 1);
    fail(child.status == kWrong ? kWrong : kMachineFailed, why.find(path) == std::string::npos ? path + ": " + why : why);
}

SceneFile::~SceneFile() {
    std::error_code code;
    if (!folder_.empty()) fs::remove_all(folder_, code);
}

}  // namespace alder::cli
