// Where a scene comes from: a scene document, or a container in the asset store.
#include "server/scene_source.h"

#include "render/image/file.h"
#include "render/import/scene_document.h"
#include "server/digest.h"
#include "server/errors.h"

namespace alder {
namespace {

constexpr uint64_t kBufferBytesMost = uint64_t{16} << 30;

/// Messages of importers name the file they read: clients know it by its digest.
void hide_path(const std::string& path, const std::string& name, std::vector<Diagnostic>& list) {
    for (Diagnostic& d : list)
        for (std::string* text : {&d.found, &d.expected})
            for (size_t at; (at = text->find(path)) != std::string::npos;) text->replace(at, path.size(), name);
}

/// Options to read a source with; missing assets are noted in `missing`.
SceneLoadOptions options_for(Engine& engine, bool lenient, std::vector<std::string>& missing) {
    SceneLoadOptions options;
    options.lenient = lenient;
    options.cache = &engine.materials();
    options.read_buffer = [&](const std::string& name, std::vector<uint8_t>& bytes, std::string& error) {
        const std::string path = engine.resolve(name, error, &missing);
        return !path.empty() && read_file(path, kBufferBytesMost, bytes, error);
    };
    options.resolve_image = [&](const nlohmann::json& image, std::string& error) { return engine.resolve(image, error, &missing); };
    return options;
}

}  // namespace

std::shared_ptr<const Scene> load_scene_source(Engine& engine, AssetStore& assets, const nlohmann::json& source, bool lenient, Diagnostics& d, const SceneBefore* before) {
    std::vector<std::string> missing;
    SceneLoadOptions options = options_for(engine, lenient, missing);
    if (before) {
        options.previous = &before->scene;
        options.previous_document = &before->document;
    }
    const auto document = source.find("document");
    std::shared_ptr<const Scene> scene;
    if (const auto it = source.find("container"); it != source.end()) {
        const std::string name = it->get<std::string>(), path = assets.path(digest_hex(name));
        SceneSource inside;
        if (document == source.end()) {
            scene = load_scene(path, options, d);
        } else if (open_scene(path, options, inside, d)) {
            options.read_buffer = inside.read_buffer;
            options.resolve_image = inside.resolve_image;
            scene = scene_from_json(*document, options, d);
        }
        hide_path(path, name, d.errors);
        hide_path(path, name, d.warnings);
    } else {
        scene = scene_from_json(*document, options, d);
    }
    if (!missing.empty()) throw_missing(missing);
    return scene;
}

nlohmann::json document_of_source(Engine& engine, AssetStore& assets, const nlohmann::json& source) {
    if (const auto it = source.find("document"); it != source.end()) return *it;
    std::vector<std::string> missing;
    const std::string name = source.at("container").get<std::string>(), path = assets.path(digest_hex(name));
    SceneSource inside;
    Diagnostics d;
    if (!open_scene(path, options_for(engine, true, missing), inside, d)) {
        hide_path(path, name, d.errors);
        throw problem_from("scene-invalid", d);
    }
    return std::move(inside.document);
}

}  // namespace alder
