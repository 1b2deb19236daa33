// What the parts of the glTF importer share. Internal to render/import.
#pragma once
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "render/import/gltf.h"
#include "render/import/json_reader.h"

namespace alder {

/// Readers for files beside a document: see scene_file.cpp.
void use_folder(const std::string& folder, const SceneLoadOptions& options, SceneSource& source);

class GltfFile {
  public:
    GltfFile(const nlohmann::json& j, std::span<const uint8_t> bin, const SceneSource& files, const SceneLoadOptions& options, Diagnostics& d)
        : json(j), bin_(bin), read_file_(files.read_buffer), options(options), d(d) {}

    const nlohmann::json& json;

    /// Element `index` of a top-level array ("accessors"), or null and an error at the place that refers to it.
    const nlohmann::json* element(const char* array, int index, const std::string& referrer);
    /// A reader of it; lenient, as glTF allows members that nobody knows.
    JsonReader reader(const nlohmann::json& j, const std::string& pointer) { return JsonReader(j, pointer, d, true); }
    /// Bytes of a buffer view, or nothing and an error.
    bool view(int index, const std::string& referrer, std::span<const uint8_t>& bytes, size_t& stride);
    /// Accessor as floats, `channels` an element (a VEC4 of colours may be asked for as 4 and come back from a VEC3 with 1).
    bool floats(int accessor, const std::string& referrer, int channels, size_t count, std::vector<float>& out, bool pad_with_one = false);
    bool indices(int accessor, const std::string& referrer, size_t limit, std::vector<uint32_t>& out);
    /// Number of elements of an accessor; 0 and an error where there is none.
    size_t count(int accessor, const std::string& referrer);
    /// A "data:" URI decoded, or a file beside the document.
    bool uri(const std::string& text, const std::string& pointer, std::vector<uint8_t>& bytes);

  private:
    struct Accessor {
        size_t count = 0, components = 1, component_bytes = 4, stride = 0;
        int component_type = 5126;
        bool normalized = false;
        std::span<const uint8_t> bytes;   ///< from the first element; empty: zeros
        const nlohmann::json* json = nullptr;
        std::string pointer;
    };
    bool open(int index, const std::string& referrer, Accessor& a);
    bool charge(uint64_t bytes, const std::string& pointer);
    bool sparse(const Accessor& a, std::vector<double>& values);
    bool values(const Accessor& a, std::vector<double>& out);
    std::span<const uint8_t> buffer(int index, const std::string& referrer);

    std::span<const uint8_t> bin_;
    BufferReader read_file_;
    std::map<int, std::vector<uint8_t>> buffers_;
    uint64_t bytes_in_ = 0, bytes_out_ = 0;

  public:
    const SceneLoadOptions& options;
    Diagnostics& d;
};

/// Names as keys: unique, never empty.
class GltfNames {
  public:
    std::string take(const std::string& wanted, const std::string& otherwise);

  private:
    std::set<std::string> used_;
};

/// An image of the file: bytes in it, or a file beside it.
struct GltfImage {
    std::vector<uint8_t> bytes;
    std::string extension, file;
};

/// Turns meshes into members of a scene document; arrays go to `buffer`.
class GltfMeshes {
  public:
    /// Material of a triangle: index in the file (-1 none), and whether vertex colours tint it.
    using MaterialKey = std::pair<int, bool>;
    GltfMeshes(GltfFile& file, std::vector<uint8_t>& buffer) : file_(file), buffer_(buffer) {}

    struct Result {
        nlohmann::json mesh;                  ///< null where nothing of it can be rendered
        std::vector<MaterialKey> materials;   ///< by face_material
        std::array<Vec3f, 2> bounds{Vec3f(0), Vec3f(0)};
    };
    bool convert(int index, const std::string& referrer, Result& out);
    nlohmann::json store(const void* data, size_t numbers, int channels, const char* type);

  private:
    struct Build;
    bool primitive(const nlohmann::json& j, const std::string& pointer, Build& b, Result& out);
    GltfFile& file_;
    std::vector<uint8_t>& buffer_;
};

/// The graph of a material of the file. `images` receives what its textures name.
nlohmann::json gltf_material(GltfFile& file, int index, bool vertex_color, std::map<std::string, GltfImage>& images, std::map<int, std::string>& image_names);

inline constexpr const char* kGltfColorAttribute = "Color";
/// Blender's names for the file's TEXCOORD_n.
std::string gltf_uv_name(int set);

}  // namespace alder
