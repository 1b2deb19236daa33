// The parts of a scene document and what they share while being read. Internal to render/import.
#pragma once
#include <map>
#include <string>

#include "render/import/arrays.h"
#include "render/import/json_reader.h"
#include "render/import/scene_document.h"

namespace alder {

inline constexpr int kSceneVersion = 1;

// Names of enums in documents, in the order of the C++ enums.
inline constexpr const char* kDomainNames[] = {"point", "corner", "face", "mesh", "curve"};
inline constexpr const char* kCurveFormNames[] = {"round", "ribbon", "linear"};
/// Members of the document, and of an instance, that hold a shape.
inline constexpr const char* kShapeMembers[] = {"meshes", "curves", "points"};
inline constexpr const char* kInstanceMembers[] = {"mesh", "curves", "points"};
inline constexpr int kMostMotionSteps = 129;   ///< Embree's limit
inline constexpr const char* kLightNames[] = {"point", "spot", "sun", "area"};
inline constexpr const char* kShapeNames[] = {"rectangle", "ellipse"};
inline constexpr const char* kCameraNames[] = {"perspective", "orthographic", "panoramic"};
inline constexpr const char* kPanoramaNames[] = {"equirectangular", "fisheye_equidistant", "fisheye_equisolid", "mirror_ball"};
inline constexpr const char* kDisplacementNames[] = {"bump", "displacement", "both"};
inline constexpr const char* kFilterNames[] = {"box", "gaussian", "blackman_harris"};
struct VisibilityName {
    const char* name;
    RayVisibility bit;
};
inline constexpr VisibilityName kVisibilityNames[] = {
    {"camera", kVisibleCamera}, {"diffuse", kVisibleDiffuse}, {"glossy", kVisibleGlossy},
    {"transmission", kVisibleTransmission}, {"shadow", kVisibleShadow}, {"volume", kVisibleVolume}};
inline constexpr int kMaxLightGroup = 8;

struct SceneReading {
    const SceneLoadOptions& options;
    Diagnostics& d;
    ArrayReader arrays;
    Scene scene;
    std::map<std::string, uint32_t> material_index;
    std::map<std::string, uint32_t> shape_index[3];   ///< by Shape, then name: index into Scene::meshes
    std::vector<uint32_t> mesh_slots;   ///< per mesh: materials its faces need

    SceneReading(const SceneLoadOptions& o, Diagnostics& diagnostics)
        : options(o), d(diagnostics), arrays(o.read_buffer, o.limits.array_bytes, diagnostics) {}
    JsonReader object(const nlohmann::json& j, const std::string& pointer) { return JsonReader(j, pointer, d, options.lenient); }
    /// What a document may say and this version cannot do: an error, or a warning if lenient. True if it was said.
    bool unsupported(JsonReader& r, const char* key, const char* what);
};

/// Attributes, texture space and motion: what meshes, curves and points have in common. Counts of everything must be there.
class ShapeReading {
  public:
    ShapeReading(SceneReading& s, JsonReader& r, Mesh& m) : s_(s), r_(r), m_(m) {}
    void positions();
    void extras();
    std::vector<Vec3f> vectors(JsonReader& r, const char* key, size_t count);

  protected:
    void attributes(const nlohmann::json& j, const std::string& pointer);
    void motion(const nlohmann::json& j, const std::string& pointer);
    SceneReading& s_;
    JsonReader& r_;
    Mesh& m_;
};
std::shared_ptr<const Mesh> read_curves(SceneReading& s, const std::string& name, const nlohmann::json& j, const std::string& pointer);
std::shared_ptr<const Mesh> read_points(SceneReading& s, const std::string& name, const nlohmann::json& j, const std::string& pointer);
/// Null where the mesh is wrong. `slots`: 1 + largest material index of its faces.
std::shared_ptr<const Mesh> read_mesh(SceneReading& s, const std::string& name, const nlohmann::json& j, const std::string& pointer, uint32_t& slots);
void read_instances(SceneReading& s, const nlohmann::json& j, const std::string& pointer);
void read_lights(SceneReading& s, const nlohmann::json& j, const std::string& pointer);
void read_cameras(SceneReading& s, JsonReader& top);
void read_settings(SceneReading& s, const nlohmann::json& j, const std::string& pointer);
void read_world(SceneReading& s, const nlohmann::json& j, const std::string& pointer);
std::shared_ptr<const Material> read_graph(SceneReading& s, const nlohmann::json& j, const std::string& pointer);

}  // namespace alder
