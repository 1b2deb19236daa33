// Scene files: what a file is, where its buffers and images are.
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>

#include "render/import/asset_folder.h"
#include "render/import/container.h"
#include "render/import/gltf_parts.h"
#include "render/import/scene_parts.h"

namespace alder {

using nlohmann::json;
namespace fs = std::filesystem;

namespace {

constexpr uint64_t kBufferFileLimit = uint64_t(16) << 30;

/// A name beside a document as a path, or empty where it would lead out of the folder.
std::string beside(const fs::path& folder, const std::string& name, std::string& error) {
    const fs::path relative(name);
    if (name.empty() || relative.is_absolute()) {
        error = "\"" + name + "\" is not a name beside the document";
        return {};
    }
    std::error_code ec;
    const fs::path root = fs::weakly_canonical(folder.empty() ? fs::path(".") : folder, ec);
    const fs::path full = fs::weakly_canonical(root / relative, ec);   // links resolved
    const auto [r, f] = std::mismatch(root.begin(), root.end(), full.begin(), full.end());
    if (ec || r != root.end()) {
        error = "\"" + name + "\" leads out of the document's folder";
        return {};
    }
    return full.string();
}

std::string image_name(const json& image, std::string& error) {
    for (const char* key : {"file", "asset"}) {
        if (image.is_object() && image.contains(key) && image[key].is_string()) return image[key].get<std::string>();
    }
    if (image.is_string()) return image.get<std::string>();
    error = "the image has no \"file\"";
    return {};
}

std::string lower_extension(const std::string& name) {
    std::string e = fs::path(name).extension().string();
    std::transform(e.begin(), e.end(), e.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return e;
}

/// Members of the container first; what is not there may come from the caller (assets).
void use_container(std::shared_ptr<const Container> c, const SceneLoadOptions& options, SceneSource& source) {
    source.read_buffer = [c, next = options.read_buffer](const std::string& name, std::vector<uint8_t>& bytes, std::string& error) {
        if (!c->has(name) && next) return next(name, bytes, error);
        return c->read(name, bytes, error);
    };
    source.resolve_image = [c, next = options.resolve_image](const json& image, std::string& error) -> std::string {
        const std::string name = image_name(image, error);
        if (name.empty()) return {};
        if (!c->has(name)) {
            if (next) return next(image, error);
            error = "'" + name + "': " + std::string(kNoSuchFile);
            return {};
        }
        std::vector<uint8_t> bytes;
        return c->read(name, bytes, error) ? store_temporary_asset(bytes, lower_extension(name), error) : std::string();
    };
}

bool parse_document(const std::vector<uint8_t>& bytes, const SceneLoadOptions& options, json& document, Diagnostics& d) {
    JsonLimits limits;
    limits.string_bytes = size_t(std::min<uint64_t>(options.limits.document_bytes, size_t(1) << 30));   // base64
    std::optional<json> j = parse_json({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, limits, d);
    if (!j) return false;
    document = std::move(*j);
    return true;
}

std::string first_bytes(const std::string& path, std::string& error) {
    char magic[4] = {};
    std::ifstream in(path, std::ios::binary);
    if (!in || !in.read(magic, 4)) error = path + ": not there, or too short for a scene";
    return {magic, 4};
}

bool file_error(Diagnostics& d, const std::string& error) {
    add_error(d, "", "unreadable", error, "a scene file that can be read");
    return false;
}

}  // namespace

void use_folder(const std::string& folder, const SceneLoadOptions& options, SceneSource& source) {
    source.read_buffer = options.read_buffer;
    source.resolve_image = options.resolve_image;
    if (!source.read_buffer) {
        source.read_buffer = [folder](const std::string& name, std::vector<uint8_t>& bytes, std::string& error) {
            const std::string path = beside(folder, name, error);
            return !path.empty() && read_file(path, kBufferFileLimit, bytes, error);
        };
    }
    if (!source.resolve_image) {
        source.resolve_image = [folder](const json& image, std::string& error) {
            const std::string name = image_name(image, error);
            const std::string path = name.empty() ? std::string() : beside(folder, name, error);
            std::error_code ec;
            if (path.empty() || fs::exists(path, ec)) return path;
            error = path + ": " + std::string(kNoSuchFile);
            return std::string();
        };
    }
}

bool open_scene(const std::string& path, const SceneLoadOptions& options, SceneSource& source, Diagnostics& d) {
    std::string error;
    if (lower_extension(path) == ".ass") {
        add_error(d, "", "unsupported", path, "a scene document (.json, .alder) or glTF (.glb, .gltf): .ass files go through `alder render` or clients/ass/ass_scene.py");
        return false;
    }
    // What a file is, its first bytes say: assets in a store have no extension.
    const std::string magic = first_bytes(path, error);
    if (!error.empty()) return file_error(d, error);
    std::vector<uint8_t> bytes;
    if (magic.starts_with("PK")) {
        const auto c = Container::open(path, error);
        if (c && c->size("scene.json") > options.limits.document_bytes) error = path + ": scene.json is larger than is accepted";
        if (!error.empty() || !c->read("scene.json", bytes, error)) return file_error(d, error);
        use_container(c, options, source);
        return parse_document(bytes, options, source.document, d);
    }
    const std::string folder = fs::path(path).parent_path().string();
    if (magic == "glTF") {
        return read_file(path, kBufferFileLimit, bytes, error) ? import_glb(bytes, folder, options, source, d) : file_error(d, error);
    }
    if (!read_file(path, options.limits.document_bytes, bytes, error)) return file_error(d, error);
    if (!parse_document(bytes, options, source.document, d)) return false;
    use_folder(folder, options, source);
    const bool gltf = source.document.is_object() && source.document.contains("asset") && !source.document.contains("alder_scene");
    return !gltf || import_gltf(nlohmann::json(source.document), options, source, d);
}

std::shared_ptr<const Scene> load_scene(const std::string& path, const SceneLoadOptions& options, Diagnostics& d) {
    SceneSource source;
    if (!open_scene(path, options, source, d)) return nullptr;
    SceneLoadOptions inner = options;
    inner.read_buffer = source.read_buffer;
    inner.resolve_image = source.resolve_image;
    return scene_from_json(source.document, inner, d);
}

}  // namespace alder
