// Scenes: revisions by identifier, on disk before they are acknowledged.
#include "server/scenes.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <utility>

#include <fmt/format.h>

#include "graph/json_text.h"
#include "render/prepared_scene.h"
#include "server/digest.h"
#include "server/errors.h"
#include "server/http/door.h"
#include "server/scene_source.h"

namespace alder {
namespace {

namespace fs = std::filesystem;
constexpr size_t kLoadedMost = 8;   // scenes held ready to render

bool is_scene_id(const std::string& id) {
    return id.size() == 30 && id.rfind("scn_", 0) == 0 &&
           std::all_of(id.begin() + 4, id.end(), [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z'); });
}

void collect_digests(const nlohmann::json& value, std::vector<std::string>& out) {
    if (value.is_string()) {
        if (const auto& text = value.get_ref<const std::string&>(); !digest_hex(text).empty()) out.push_back(text);
    } else if (value.is_structured()) {
        for (const auto& child : value) collect_digests(child, out);
    }
}

std::vector<std::string> digests_of(const SceneRevision& scene) {
    std::vector<std::string> out;
    collect_digests(scene.source, out);
    for (const auto& [name, graph] : scene.materials) collect_digests(graph, out);
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

void require_assets(const AssetStore& assets, const std::vector<std::string>& digests) {
    std::vector<std::string> missing;
    for (const std::string& digest : digests)
        if (!assets.has(digest_hex(digest))) missing.push_back(digest);
    if (!missing.empty()) throw_missing(missing);
}

std::string revision_etag(uint64_t revision) { return fmt::format("\"{}\"", revision); }

std::shared_ptr<SceneRevision> read_revision(const std::string& id, const std::string& path) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    return revision_from_json(id, nlohmann::json::parse(text.str(), nullptr, false));
}

bool has_emission(const Material& material) {
    Diagnostics d;
    const auto program = material.program({.surface = LobeFilter::Emission}, d);
    return program && program->facts().has_emission;
}

std::string rebuild_class(const Material& before, const Material& after) {
    if (before.digest() == after.digest()) return "none";
    if (before.has_displacement() || after.has_displacement()) return "geometry";
    if (has_emission(before) || has_emission(after)) return "lights";
    return "shading";
}

}  // namespace

nlohmann::json to_json(const SceneRevision& scene) {
    return {{"revision", scene.revision}, {"source", scene.source}, {"materials", scene.materials}};
}

std::shared_ptr<SceneRevision> revision_from_json(const std::string& id, const nlohmann::json& json) {
    if (!json.is_object() || !json.contains("source")) return nullptr;
    auto scene = std::make_shared<SceneRevision>();
    scene->id = id;
    scene->revision = json.value("revision", uint64_t{1});
    scene->etag = revision_etag(scene->revision);
    scene->source = json["source"];
    if (const auto it = json.find("materials"); it != json.end())
        for (const auto& [name, graph] : it->items()) scene->materials[name] = graph;
    scene->assets = digests_of(*scene);
    return scene;
}

size_t LoadedScene::material_index(const std::string& name) const {
    const auto& list = scene->materials;
    return std::find_if(list.begin(), list.end(), [&](const SceneMaterial& m) { return m.name == name; }) - list.begin();
}

SceneStore::SceneStore(std::string folder) : folder_(std::move(folder)) {
    std::error_code code;
    fs::create_directories(folder_, code);
    if (code) error_ = fmt::format("cannot make {}: {}", folder_, code.message());
}

std::string SceneStore::path(const std::string& id) const { return fmt::format("{}/{}.json", folder_, id); }

void SceneStore::keep(const std::shared_ptr<const SceneRevision>& scene) {
    if (!write_durably(path(scene->id), to_json(*scene).dump())) throw Problem{"storage", "the scene could not be written"};
    const std::lock_guard lock(mutex_);
    known_[scene->id] = scene;
}

void SceneStore::remember(const SceneRevision& scene, std::shared_ptr<const LoadedScene> loaded) {
    const std::lock_guard lock(mutex_);
    loaded_.remove_if([&](const Loaded& l) { return l.id == scene.id; });
    loaded_.push_front({scene.id, scene.etag, std::move(loaded)});
    if (loaded_.size() > kLoadedMost) loaded_.pop_back();
}

std::shared_ptr<std::mutex> SceneStore::edit_mutex(const std::string& id) {
    const std::lock_guard lock(mutex_);
    std::erase_if(edits_, [](const auto& row) { return row.second.expired(); });
    auto& slot = edits_[id];
    auto found = slot.lock();
    if (!found) slot = found = std::make_shared<std::mutex>();
    return found;
}

std::shared_ptr<const SceneRevision> SceneStore::create(Engine& engine, AssetStore& assets, nlohmann::json source, bool lenient, Diagnostics& d) {
    auto scene = std::make_shared<SceneRevision>();
    scene->id = "scn_" + http::time_sorted_id();
    scene->etag = revision_etag(scene->revision);
    scene->source = std::move(source);
    scene->assets = digests_of(*scene);
    require_assets(assets, scene->assets);
    auto loaded = std::make_shared<LoadedScene>();
    loaded->scene = load_scene_source(engine, assets, scene->source, lenient, d);
    if (!loaded->scene || !d.ok()) throw problem_from("scene-invalid", d);
    loaded->prepared = prepare_scene(loaded->scene, engine.context(), d);
    if (!loaded->prepared || !d.ok()) throw problem_from("scene-invalid", d);
    keep(scene);
    remember(*scene, std::move(loaded));
    return scene;
}

std::shared_ptr<const SceneRevision> SceneStore::get(const std::string& id) {
    if (is_scene_id(id)) {
        const std::lock_guard lock(mutex_);
        if (const auto it = known_.find(id); it != known_.end()) return it->second;
        if (auto scene = read_revision(id, path(id))) return known_[id] = scene;
    }
    throw Problem{"not-found", fmt::format("there is no scene '{}'", id.substr(0, 64))};
}

void SceneStore::remove(const std::string& id) {
    get(id);
    const std::lock_guard lock(mutex_);
    std::error_code code;
    fs::remove(path(id), code);
    if (code) throw Problem{"storage", "the scene could not be removed"};
    known_.erase(id);
    loaded_.remove_if([&](const Loaded& l) { return l.id == id; });
}

std::shared_ptr<const LoadedScene> SceneStore::load(Engine& engine, AssetStore& assets, const SceneRevision& scene, Diagnostics& d) {
    {
        const std::lock_guard lock(mutex_);
        for (auto it = loaded_.begin(); it != loaded_.end(); ++it)
            if (it->id == scene.id && it->etag == scene.etag) {
                loaded_.splice(loaded_.begin(), loaded_, it);
                return loaded_.front().scene;
            }
    }
    require_assets(assets, scene.assets);
    auto loaded = std::make_shared<LoadedScene>();
    auto whole = load_scene_source(engine, assets, scene.source, true, d);
    if (!whole) throw problem_from("scene-invalid", d);
    if (!scene.materials.empty()) {
        auto edited = std::make_shared<Scene>(*whole);
        for (SceneMaterial& m : edited->materials)
            if (const auto it = scene.materials.find(m.name); it != scene.materials.end())
                m.graph = engine.material(it->second, "/materials/" + pointer_token(m.name), true, d);
        whole = std::move(edited);
    }
    loaded->scene = std::move(whole);
    loaded->prepared = prepare_scene(loaded->scene, engine.context(), d);
    if (!loaded->prepared) throw problem_from("scene-invalid", d);
    remember(scene, loaded);
    return loaded;
}

SceneStore::Edit SceneStore::edit_material(Engine& engine, AssetStore& assets, const std::string& id, const std::string& name, bool lenient,
                                           const std::function<nlohmann::json(const nlohmann::json& current)>& edit, Diagnostics& d) {
    const auto mutex = edit_mutex(id);
    const std::lock_guard lock(*mutex);
    const auto scene = get(id);
    const auto loaded = load(engine, assets, *scene, d);
    const size_t index = loaded->material_index(name);
    if (index == loaded->scene->materials.size()) throw Problem{"not-found", fmt::format("the scene has no material '{}'", name)};
    const auto before = loaded->scene->materials[index].graph;
    nlohmann::json graph = edit(before->document());
    const auto material = engine.material(graph, "", lenient, d);

    auto next = std::make_shared<SceneRevision>(*scene);
    ++next->revision;
    next->etag = revision_etag(next->revision);
    next->materials[name] = graph;
    next->assets = digests_of(*next);
    auto edited = std::make_shared<Scene>(*loaded->scene);
    edited->materials[index].graph = material;
    auto result = std::make_shared<LoadedScene>();
    result->prepared = alder::with_material(loaded->prepared, index, material, d);
    if (!result->prepared || !d.ok()) throw problem_from("graph-invalid", d);
    result->scene = std::move(edited);
    keep(next);
    remember(*next, result);
    std::string rebuild = rebuild_class(*before, *material);
    std::vector<std::string> changed;
    if (rebuild != "none") changed.push_back("materials/" + name);
    return {next, std::move(rebuild), std::move(graph), std::move(changed), loaded, result};
}

namespace {

/// The document with the graphs that were edited since in their places. What the scene says of a material besides stays.
nlohmann::json whole_document(Engine& engine, AssetStore& assets, const SceneRevision& scene) {
    nlohmann::json document = document_of_source(engine, assets, scene.source);
    for (const auto& [name, graph] : scene.materials) {
        nlohmann::json& place = document["materials"][name];
        const nlohmann::json old = std::exchange(place, graph);
        for (const char* own : {"pass_index", "displacement"})
            if (old.is_object() && old.contains(own)) place[own] = old[own];
    }
    return document;
}

/// Names of what differs: members of the document, and of those that hold things by name the things.
std::vector<std::string> differences(const nlohmann::json& a, const nlohmann::json& b) {
    std::vector<std::string> found;
    const auto member = [](const nlohmann::json& j, const std::string& name) { return j.contains(name) ? j[name] : nlohmann::json(); };
    std::set<std::string> sections;
    for (const auto* j : {&a, &b})
        for (const auto& [name, value] : j->items()) sections.insert(name);
    for (const std::string& section : sections) {
        const nlohmann::json x = member(a, section), y = member(b, section);
        if (x == y) continue;
        if (!x.is_object() || !y.is_object() || section == "settings" || section == "world") {
            found.push_back(section);
            continue;
        }
        std::set<std::string> names;
        for (const auto* j : {&x, &y})
            for (const auto& [name, value] : j->items()) names.insert(name);
        for (const std::string& name : names)
            if (member(x, name) != member(y, name)) found.push_back(section + "/" + name);
    }
    return found;
}

bool same_names(const Scene& a, const Scene& b) {
    return std::equal(a.materials.begin(), a.materials.end(), b.materials.begin(), b.materials.end(), [](const SceneMaterial& x, const SceneMaterial& y) { return x.name == y.name; });
}

SameParts same_parts(const std::vector<std::string>& changed, const Scene& before, const Scene& after) {
    bool anything_else = !same_names(before, after);   // instances have materials by place
    SameParts same{true, true, true, true, true};
    for (const std::string& name : changed) {
        const std::string section = name.substr(0, name.find('/'));
        if (section == "instances") same.instances = false;
        else if (section == "lights") same.lights = false;
        else if (section == "world") same.world = false;
        else if (section == "cameras" || section == "camera") same.camera = false;
        else if (section == "settings") same.settings = false;
        else anything_else = anything_else || (section != "materials" && section != "meshes" && section != "curves" && section != "points" && section != "report");
    }
    return anything_else ? SameParts{} : same;
}

std::string rebuild_class(const PreparedScene& before, const PreparedScene& after) {
    if (after.surfaces != before.surfaces) return after.surfaces->meshes() == before.surfaces->meshes() ? "instances" : "geometry";
    if (after.lights != before.lights) return "lights";
    return after.materials == before.materials ? "none" : "shading";
}

}  // namespace

SceneStore::Edit SceneStore::edit_document(Engine& engine, AssetStore& assets, const std::string& id, bool lenient,
                                           const std::function<nlohmann::json(const nlohmann::json& current, const SceneRevision& scene)>& edit, Diagnostics& d) {
    const auto mutex = edit_mutex(id);
    const std::lock_guard lock(*mutex);
    const auto scene = get(id);
    const auto loaded = load(engine, assets, *scene, d);
    const nlohmann::json before = whole_document(engine, assets, *scene);
    nlohmann::json after = edit(before, *scene);
    if (!after.is_object()) throw Problem{"request-invalid", "what is left is not a scene document"};
    Edit result;
    result.changed = differences(before, after);
    auto next = std::make_shared<SceneRevision>(*scene);
    ++next->revision;
    next->etag = revision_etag(next->revision);
    next->source["document"] = std::move(after);
    next->materials.clear();
    next->assets = digests_of(*next);
    require_assets(assets, next->assets);
    auto edited = std::make_shared<LoadedScene>();
    const SceneBefore old{*loaded->scene, before};
    edited->scene = load_scene_source(engine, assets, next->source, lenient, d, &old);
    if (!edited->scene || !d.ok()) throw problem_from("scene-invalid", d);
    edited->prepared = prepare_edited(*loaded->prepared, same_parts(result.changed, *loaded->scene, *edited->scene), edited->scene, d);
    if (!edited->prepared || !d.ok()) throw problem_from("scene-invalid", d);
    keep(next);
    remember(*next, edited);
    result.rebuild = rebuild_class(*loaded->prepared, *edited->prepared);
    result.scene = next;
    result.before = loaded;
    result.after = edited;
    return result;
}

std::shared_ptr<const PreparedScene> SceneStore::with_graph(Engine& engine, AssetStore& assets, const SceneRevision& scene,
                                                            const std::string& name, std::shared_ptr<const Material> material, Diagnostics& d) {
    const auto loaded = load(engine, assets, scene, d);
    const size_t index = loaded->material_index(name);
    if (index == loaded->scene->materials.size()) {
        std::vector<std::string> names;
        for (const auto& m : loaded->scene->materials) names.push_back(m.name);
        d.errors.push_back({"/assign_to", "unknown-value", "\"" + name + "\"", "the name of a material of the scene", nearest_name(name, names)});
        throw problem_from("settings-invalid", d);
    }
    auto prepared = alder::with_material(loaded->prepared, index, std::move(material), d);
    if (!prepared || !d.ok()) throw problem_from("graph-invalid", d);
    return prepared;
}

std::string SceneStore::user_of(const std::string& digest) {
    const std::lock_guard lock(mutex_);
    if (!all_known_) {   // deleting is rare: only then is every stored scene looked at
        std::error_code code;
        for (const auto& entry : fs::directory_iterator(folder_, code)) {
            const std::string id = entry.path().stem().string();
            if (is_scene_id(id) && entry.path().extension() == ".json" && !known_.count(id))
                if (auto scene = read_revision(id, entry.path().string())) known_[id] = scene;
        }
        all_known_ = !code;
    }
    for (const auto& [id, scene] : known_)
        if (std::binary_search(scene->assets.begin(), scene->assets.end(), digest)) return id;
    return {};
}

}  // namespace alder
