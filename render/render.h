// Rendering: a Scene and a RenderRequest in, an Image with AOV layers out.
//
//   auto prepared = prepare_scene(scene, images);               // BVH, light tables, programs: reusable over renders
//   Image im = render(*prepared, request, progress);
#pragma once
#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "render/scene.h"

namespace alder {

/// A named set of planes of an image. Planes are float, width x height, row 0 at the top.
struct Layer {
    std::string name;                    ///< "" = beauty (R G B A); else as in API.md section 10
    std::vector<std::string> channels;   ///< "R","G","B" / "X","Y","Z" / "Z" ...; empty name = one channel named as the layer
    bool data = false;                   ///< true: always written as float, not filtered or clamped
    std::vector<std::vector<float>> planes;
};
struct Image {
    int width = 0, height = 0;           ///< of the data window
    int full_width = 0, full_height = 0, crop_x = 0, crop_y = 0;
    std::vector<Layer> layers;           ///< beauty first
    std::vector<std::pair<std::string, std::string>> attributes;   ///< EXR metadata: alder/samples, ...
    const Layer* find(const std::string& name) const;
};

struct RenderRequest {
    int width = 0, height = 0;           ///< 0 = the scene's
    int crop[4] = {0, 0, 0, 0};          ///< x0, y0, x1, y1; all 0 = whole
    int samples = 0;                     ///< 0 = the scene's
    uint64_t sample_offset = 0;
    double seconds = 0;                  ///< > 0: stop with the best image by then
    double target_error = 0;             ///< > 0: stop when the estimated error is below
    uint32_t seed = 0;
    int threads = 0;                     ///< 0 = all
    std::vector<std::string> aovs;       ///< layer names or groups: shading, data, denoise, quality, light_groups, ids; graph AOV names
    const std::atomic<bool>* cancel = nullptr;
};

struct RenderStats {
    double build_seconds = 0, compile_seconds = 0, render_seconds = 0;
    uint64_t camera_rays = 0, bounce_rays = 0, shadow_rays = 0, subsurface_rays = 0;
    uint64_t timed_paths = 0;            ///< paths that were given a time: none where nothing moves
    uint64_t medium_segments = 0, medium_points = 0;  ///< parts of rays within media; points at which volumes were evaluated
    uint64_t media_ignored = 0;                       ///< boundaries crossed within too many media to remember another
    uint64_t shading_points = 0, node_evaluations = 0, node_skipped = 0, nonfinite_samples = 0;
    int samples = 0;                     ///< taken per pixel
    double estimated_error = 0;
    bool complete = true;                ///< false: cancelled or out of time before all samples
    std::vector<std::string> skipped;    ///< "MATERIAL/NODE: reason"
};

class PreparedScene;   ///< BVH, lights, compiled programs of one scene revision; thread safe for concurrent renders
std::shared_ptr<const PreparedScene> prepare_scene(std::shared_ptr<const Scene> scene, const EvalContext& context, Diagnostics& d);
/// Parts of a scene that an edit has left as they were. What is left is taken over from the scene before.
struct SameParts {
    bool instances = false, lights = false, world = false, camera = false, settings = false;
};
/// An edited scene: shares meshes with their BVHs, programs, lights and world with `base` wherever the edit allows it.
std::shared_ptr<const PreparedScene> prepare_edited(const PreparedScene& base, const SameParts& same, std::shared_ptr<const Scene> scene, Diagnostics& d);
/// The same geometry with other materials (by index): shares BVH and meshes; rebuilds lights only where emission changed.
std::shared_ptr<const PreparedScene> with_material(const std::shared_ptr<const PreparedScene>& base, size_t material,
                                                   std::shared_ptr<const Material> graph, Diagnostics& d);
Image render(const PreparedScene& scene, const RenderRequest& request, RenderStats& stats,
             const std::function<void(double fraction)>& progress = {});

}  // namespace alder
