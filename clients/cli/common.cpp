// What the subcommands of `alder` share.
#include "clients/cli/common.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>

#include "graph/json_text.h"
#include "nodes/texture/image_store.h"
#include "render/image/file.h"

namespace alder::cli {

void fail(int status, const std::string& sentence) {
    std::fprintf(stderr, "alder: %s\n", sentence.c_str());
    throw Failure{status};
}

void report(const std::string& file, const Diagnostics& d, bool quiet) {
    if (!quiet)
        for (const auto& w : d.warnings) std::fprintf(stderr, "alder: warning: %s: %s\n", file.c_str(), w.line().c_str());
    for (const auto& e : d.errors) std::fprintf(stderr, "alder: %s: %s\n", file.c_str(), e.line().c_str());
    if (!d.ok()) throw Failure{kWrong};
}

std::string read_text(const std::string& path) {
    if (path == "-") return {std::istreambuf_iterator<char>(std::cin), std::istreambuf_iterator<char>()};
    std::error_code code;
    if (std::filesystem::is_directory(path, code)) fail(kWrong, path + ": is a folder");
    std::ifstream file(path, std::ios::binary);
    if (!file) fail(kWrong, path + ": cannot be read");
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

nlohmann::json read_json_file(const std::string& path) {
    Diagnostics d;
    JsonLimits limits;
    limits.string_bytes = size_t{1} << 30;   // the user's own file
    auto json = parse_json(read_text(path), limits, d);
    if (!json) report(path, d);
    return std::move(*json);
}

nlohmann::json read_graph_file(const std::string& path) {
    nlohmann::json json = read_json_file(path);
    if (json.is_object() && json.contains("graph") && !json.contains("nodes")) return json["graph"];
    return json;
}

std::function<std::string(const nlohmann::json&, std::string&)> image_resolver(const std::string& document_path) {
    namespace fs = std::filesystem;
    const fs::path folder = document_path == "-" ? fs::path(".") : fs::path(document_path).parent_path();
    return [folder](const nlohmann::json& image, std::string& error) -> std::string {
        std::string name;
        if (image.is_string())
            name = image.get<std::string>();
        else if (image.is_object() && image.contains("file") && image["file"].is_string())
            name = image["file"].get<std::string>();
        else if (image.is_object() && image.contains("asset")) {
            error = "assets live in a daemon's store; name a file here";
            return {};
        }
        const fs::path path = folder / name;
        std::error_code code;
        if (name.empty() || !fs::is_regular_file(path, code)) {
            error = "'" + path.string() + (name.empty() || fs::exists(path, code) ? "' is not a file" : "': " + std::string(kNoSuchFile));
            return {};
        }
        return path.string();
    };
}

void add_texture_options(CLI::App& command) {
    command.add_option_function<size_t>("--texture-mib", [](size_t mib) { ImageStore::shared().set_budget(mib << 20); }, "memory for textures; what is beyond it is read in tiles")
        ->envname("ALDER_TEXTURE_MIB")->check(CLI::Range(size_t{1}, size_t{1} << 24));
    command.add_option_function<std::string>("--ocio", set_color_configuration, "OpenColorIO configuration with further colour spaces; default: $OCIO");
    set_image_fault_listener([](const std::string& fault) { std::fprintf(stderr, "alder: warning: texture %s\n", fault.c_str()); });
}

void write_bytes(const std::string& path, const void* data, size_t bytes) {
    std::string error;
    if (!write_file(path, {static_cast<const uint8_t*>(data), bytes}, error)) fail(kMachineFailed, error);
}

}  // namespace alder::cli
